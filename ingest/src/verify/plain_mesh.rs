//! A single mesh of a whole raster, in the raster's own reference system and metres of height: planes are planes in
//! that system, heights differ along its third axis.

use std::path::Path;

use anyhow::{Context, Result};
use glam::DVec2;
use rayon::prelude::*;
use rstar::primitives::Line;

use super::breaklines::{Chains, Lines, Near, PlanEdge, Stretch};
use super::deviation::{Worst, along_edges, visit_posts};
use super::drawing::{Drawing, no_surface};
use super::mesh_file::{self, Claim};
use super::report::{MeshReport, ROUNDING, Violation};
use super::source::{Block, Post, Source};
use super::space::{Foot, Raster, Space};
use super::surface::Surface;

/// Cells by which edges along a breakline may stray from it in plan: a 64th, and what rounding to 256ths comes to.
const LINES_STRAY: f64 = 1.0 / 64.0 + 2.0 / 256.0;
/// Cells that a part of a line reaches at least from where it begins for an edge to be asked for.
const LEAST_LINE: f64 = 2.0 / 256.0;

/// Measures the mesh at `path`, a `.ply` or `.obj` file, against the raster that it was made from. What it claims is
/// taken from its comments, or from `claim` where it says nothing. The raster's share of memory is at most some
/// `memory` bytes.
///
/// # Errors
/// When the file is no readable triangle mesh, there is no claim to hold it to, or samples cannot be read.
pub fn mesh(path: &Path, source: Source, claim: Option<Claim>, memory: u64) -> Result<MeshReport> {
    let claim = mesh_file::read_claim(path)?.or(claim);
    let claim = claim.with_context(|| format!("{}: claims no error; pass --max-error", path.display()))?;
    check(&mesh_file::read(path)?, &source, &claim, super::block_side(memory))
}

fn check(mesh: &Drawing, source: &Source, claim: &Claim, block_side: usize) -> Result<MeshReport> {
    let mut report = MeshReport {
        bound: claim.bound.clone(),
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
        claimed: claim.error,
        measured_at_samples: 0.0,
        measured_between_samples: 0.0,
        violation_count: 0,
        violations: Vec::new(),
    };
    let mut violations = Vec::new();
    if !["surface", "samples"].contains(&claim.bound.as_str()) {
        violations.push(Violation::new(format!("bound “{}” is unknown", claim.bound)));
    }
    match no_surface(mesh) {
        Some(fault) => violations.push(Violation::new(format!("is no surface: {fault}"))),
        None => violations.extend(measure(mesh, source, claim, block_side, &mut report)?),
    }
    report.set_violations(violations);
    Ok(report)
}

/// What is found in a block, and in blocks one after the other.
#[derive(Clone, Default)]
struct Found {
    at_samples: Worst,
    along_edges: Worst,
    left_out: Posts,
    invented: Posts,
}

/// How many, and the first.
#[derive(Clone, Copy, Default)]
struct Posts {
    count: usize,
    first: Option<(usize, usize)>,
}

impl Posts {
    fn add(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            first: self.first.or(other.first),
        }
    }
}

impl Found {
    fn add(self, other: Self) -> Self {
        Self {
            at_samples: self.at_samples.max(other.at_samples),
            along_edges: self.along_edges.max(other.along_edges),
            left_out: self.left_out.add(other.left_out),
            invented: self.invented.add(other.invented),
        }
    }
}

fn measure(
    mesh: &Drawing,
    source: &Source,
    claim: &Claim,
    block_side: usize,
    report: &mut MeshReport,
) -> Result<Vec<Violation>> {
    let surface = in_grid(mesh, source);
    let is_wanted = |block: &Block| source.may_hold(block) || surface.over(block).next().is_some();
    let blocks = source.blocks(&source.whole(), block_side, is_wanted);
    let found = blocks.par_iter().map(|block| in_block(source, &surface, block));
    let found = found.try_reduce(Found::default, |a, b| Ok(a.add(b)))?;
    let anywhere = found.at_samples.max(found.along_edges);
    report.measured_at_samples = found.at_samples.figure;
    report.measured_between_samples = anywhere.figure;
    let crs = |place: DVec2| source.georeference.crs_coordinates(place);
    let told = |posts: Posts, what: &str| {
        let (column, row) = posts.first?;
        let place = crs(DVec2::new(column as f64, row as f64));
        Some(Violation::new(format!("{} {what}, the first", posts.count)).at(place))
    };
    let left_out = told(found.left_out, "samples that no triangle covers");
    let invented = told(found.invented, "voids that a triangle covers");
    let mut violations: Vec<_> = left_out.into_iter().chain(invented).collect();
    let promised = if claim.bound == "samples" {
        found.at_samples
    } else {
        anywhere
    };
    if promised.figure > claim.error + ROUNDING || claim.error.is_nan() {
        let violation = Violation::new("vertical error").at(crs(promised.place));
        violations.push(violation.figures(claim.error, promised.figure));
    }
    let lines = farthest_line(source, &surface)?;
    if lines.figure > LINES_STRAY {
        let violation = Violation::new("breakline: no chain of edges is along it, in cells").at(crs(lines.place));
        violations.push(violation.figures(LINES_STRAY, lines.figure));
    }
    Ok(violations)
}

/// How far lines are from chains of edges, in cells.
fn farthest_line(source: &Source, surface: &Surface) -> Result<Worst> {
    let stretches = Lines::new(source).stretches(source, &source.whole(), 0.0, |_| true)?;
    let part = |at: glam::DVec3| [at.x, at.y, 0.0];
    let edge = |ends: [u32; 2]| PlanEdge {
        ends,
        parts: vec![Line::new(
            part(surface.positions[ends[0] as usize]),
            part(surface.positions[ends[1] as usize]),
        )],
    };
    let edges: Vec<PlanEdge> = surface.edges().map(edge).collect();
    let stretches: Vec<_> = stretches.iter().map(|line| line.placed(|at| at.extend(0.0))).collect();
    let chains = Chains::near(&Near::to(&stretches), &edges, LINES_STRAY);
    let mut worst = Worst::default();
    for piece in stretches.iter().flat_map(Stretch::pieces) {
        if piece.iter().any(|at| at.distance(piece[0]) > LEAST_LINE) {
            let (cells, index) = chains.farthest(piece);
            worst.meet(cells, piece[index].truncate());
        }
    }
    Ok(worst)
}

fn in_block(source: &Source, surface: &Surface, block: &Block) -> Result<Found> {
    let patch = source.patch(block)?;
    let posts = patch.posts();
    let mut covered = vec![false; posts.len()];
    let mut at_samples = Worst::default();
    visit_posts(
        &Raster,
        &patch,
        &Raster.verticals(&posts),
        surface,
        |(column, row), index, deviation| {
            covered[index] = true;
            if patch.post(column, row) == Post::Surface {
                at_samples.meet(deviation, DVec2::new(column as f64, row as f64));
            }
        },
    );
    let wrong = |what: Post, should_be: bool| {
        let is_wrong = |&(&(column, row), covered): &(&(usize, usize), &bool)| {
            patch.post(column, row) == what && *covered != should_be
        };
        let mut wrong = posts.iter().zip(&covered).filter(is_wrong);
        let first = wrong.next().map(|(&post, _)| post);
        Posts {
            count: wrong.count() + usize::from(first.is_some()),
            first,
        }
    };
    Ok(Found {
        at_samples,
        along_edges: along_edges(&Raster, &patch, surface, at_samples),
        left_out: wrong(Post::Surface, true),
        invented: wrong(Post::Void, false),
    })
}

fn in_grid(mesh: &Drawing, source: &Source) -> Surface {
    let to_grid = source.georeference.affine().inverse();
    let positions = mesh
        .positions
        .iter()
        .map(|p| to_grid.transform_point2(p.truncate()).extend(p.z));
    let positions: Vec<_> = positions.collect();
    let foot = |p: &glam::DVec3| Foot {
        grid: p.truncate(),
        height: p.z,
    };
    let feet = positions.iter().map(foot).collect();
    Surface::new(&Raster, positions, feet, mesh.triangles.clone())
}

#[cfg(test)]
#[path = "plain_mesh_tests.rs"]
mod tests;
