//! What is drawn of models that are refined for a view, measured again: how many pixels it is off, seen from the eye.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use glam::DVec3;
use tempfile::TempDir;
use terrain_codec::{LevelLimits, spm};
use terrain_core::levels::view_error::View;
use terrain_core::levels::view_refinement::ViewRefinement;
use terrain_core::space::hausdorff::SurfaceTree;
use terrain_core::{Mesh, SurfacePartition};
use terrain_ingest::Progress;
use terrain_ingest::polygonal_model::{self, Options, Target};
use terrain_tests::{shared_data, workspace};

const LIMITS: LevelLimits = LevelLimits {
    levels: 256,
    vertices: 1 << 20,
    triangles: 1 << 21,
};
const FOCAL_LENGTH: f64 = 800.0;
/// How often a triangle is cut in four to tell what is off from what is near.
const PARTS: u32 = 4;

/// A torus of 8,000 triangles with bumps of two sizes.
fn bumpy_torus() -> String {
    let (columns, rows) = (110, 36);
    let mut text = String::new();
    for vertex in 0..columns * rows {
        let [u, v] = [
            f64::from(vertex % columns) / f64::from(columns),
            f64::from(vertex / columns) / f64::from(rows),
        ]
        .map(|share| share * TAU);
        let thickness = 0.4 + 0.03 * (5.0 * u + 3.0 * v).sin() + 0.004 * (31.0 * u).sin() * (17.0 * v).cos();
        let out = 1.0 + thickness * v.cos();
        writeln!(text, "v {} {} {}", out * u.cos(), out * u.sin(), thickness * v.sin()).unwrap();
    }
    let vertex = |column: i32, row: i32| row % rows * columns + column % columns + 1;
    for (column, row) in (0..columns * rows).map(|cell| (cell % columns, cell / columns)) {
        let [a, b, c, d] = [
            vertex(column, row),
            vertex(column + 1, row),
            vertex(column + 1, row + 1),
            vertex(column, row + 1),
        ];
        writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
    }
    text
}

/// All levels of a model, as a client has them.
fn levels_of(model: &Path) -> SurfacePartition {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("levels.spm");
    let options = Options {
        target: Target::Coarsest,
        keep_vertices: false,
        lod: None,
    };
    polygonal_model::run(model, &options, &output, &Progress::silent()).unwrap();
    read(&output)
}

fn read(path: &Path) -> SurfacePartition {
    spm::decode(&fs::read(path).unwrap(), &LIMITS).unwrap().in_units()
}

/// What somebody at a place sees of how far one surface is off another.
struct Seen<'a> {
    surface: &'a SurfaceTree,
    eye: DVec3,
    /// What may be off wherever it is seen from.
    anywhere: f64,
}

impl Seen<'_> {
    /// The most pixels that some of the triangles is off.
    fn pixels_off(&self, mesh: &Mesh) -> f64 {
        let triangles = mesh
            .triangles
            .iter()
            .map(|triangle| triangle.map(|corner| mesh.positions[corner as usize]));
        triangles.fold(0.0, |most, triangle| self.most(triangle, most, PARTS))
    }

    /// The same for one triangle and what is known of others; one that may be more is looked at in parts, as what is off may be far from
    /// what is near.
    fn most(&self, triangle: [DVec3; 3], known: f64, parts: u32) -> f64 {
        let off = (self.surface.bound(&[triangle], 0.0) - self.anywhere).max(0.0);
        let pixels = off * FOCAL_LENGTH / nearest(triangle, self.eye).max(0.0);
        if pixels <= known || off == 0.0 {
            return known;
        }
        if parts == 0 {
            return pixels;
        }
        let [a, b, c] = triangle;
        let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
        let quarters = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
        quarters
            .into_iter()
            .fold(known, |most, quarter| self.most(quarter, most, parts - 1))
    }
}

/// How near a triangle comes to the eye, at least.
fn nearest(triangle: [DVec3; 3], eye: DVec3) -> f64 {
    let middle = triangle.iter().sum::<DVec3>() / 3.0;
    let radius = triangle
        .map(|corner| corner.distance(middle))
        .into_iter()
        .fold(0.0, f64::max);
    eye.distance(middle) - radius
}

#[test]
fn no_part_of_a_refined_model_is_farther_off_than_the_view_allows() {
    let folder = TempDir::new().unwrap();
    let torus = folder.path().join("torus.obj");
    fs::write(&torus, bumpy_torus()).unwrap();
    let mut models = vec![
        ("bumpy torus", levels_of(&torus)),
        ("open torus", read(&workspace().join("codec/golden/open_torus.spm"))),
    ];
    models.extend(shared_data("meshes/fandisk.obj").map(|path| ("fandisk", levels_of(&path))));
    let mut random = fastrand::Rng::with_seed(5);
    for (name, partition) in models {
        let finest = partition.lod(partition.levels.len() - 1);
        let model = SurfaceTree::new(&finest);
        let (low, high) = finest.bounds();
        let mut refinement = ViewRefinement::new(&partition).unwrap();
        let (mut drawn, mut levels) = (0, 0);
        for _ in 0..6 {
            let mut share = || random.f64() * 2.4 - 0.7;
            let eye = low + (high - low) * DVec3::new(share(), share(), share());
            let within = 0.5 + 6.0 * random.f64();
            let view = View {
                eye,
                focal_length: FOCAL_LENGTH,
                frustum: Vec::new(),
            };
            refinement.refine(&view, within);
            let mesh = refinement.surface().mesh();
            drawn += mesh.triangles.len();
            let is_enough = |error: f64| view.screen_error(error, nearest_of(&finest, eye)) <= within;
            let level = partition.levels.iter().find(|level| is_enough(level.error));
            levels += level.or(partition.levels.last()).unwrap().triangle_end;
            let anywhere = partition.levels.last().unwrap().error;
            let seen = |surface| Seen { surface, eye, anywhere };
            let off = seen(&SurfaceTree::new(&mesh))
                .pixels_off(&finest)
                .max(seen(&model).pixels_off(&mesh));
            println!(
                "{name}: {} triangles, {within:.2} px allowed, {off:.2} px off",
                mesh.triangles.len()
            );
            assert!(off <= within, "{name}: {off} pixels where {within} are allowed");
        }
        println!(
            "{name}: {:.2} of the triangles of levels",
            drawn as f64 / f64::from(levels)
        );
    }
}

fn nearest_of(mesh: &Mesh, eye: DVec3) -> f64 {
    let triangles = mesh
        .triangles
        .iter()
        .map(|triangle| triangle.map(|corner| mesh.positions[corner as usize]));
    triangles
        .map(|triangle| nearest(triangle, eye))
        .fold(f64::INFINITY, f64::min)
}
