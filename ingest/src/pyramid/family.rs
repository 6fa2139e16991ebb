//! What a parent takes of its children.

use std::collections::HashMap;

use anyhow::{Result, bail};
use glam::{DVec2, DVec3};
use terrain_codec::filled::Filled;
use terrain_codec::tile::{Lineage, Tile};
use terrain_core::{Mesh, mesh};

use crate::lattice::{Lattice, Square};
use crate::leaf;
use crate::node::Finest;

/// A child's part of its parent.
pub(super) struct Child {
    pub(super) square: Square,
    pub(super) coarsest: Mesh,
    /// Edges of it along breaklines, by their ends.
    pub(super) breaklines: Vec<[[i64; 2]; 2]>,
    pub(super) filled: Filled,
    pub(super) lineage: Lineage,
}

impl Child {
    /// What the parent takes of a tile.
    pub(super) fn of(square: Square, tile: &Tile) -> Self {
        Self {
            square,
            coarsest: tile.surface(tile.coarsest()),
            breaklines: tile.breaklines.clone(),
            filled: tile.filled.clone(),
            lineage: tile.lineage,
        }
    }
}

/// The finest mesh of the parent, and what is claimed of it so far.
///
/// # Errors
/// When the children do not meet.
pub(super) fn finest(lattice: Lattice, family: &[Child]) -> Result<Finest> {
    let largest = |value: fn(&Lineage) -> f32| {
        let values = family.iter().map(|child| f64::from(value(&child.lineage)));
        values.fold(0.0, f64::max)
    };
    Ok(Finest {
        mesh: welded(lattice, family)?,
        breaklines: breaklines(lattice, family),
        outline_strayed: largest(|lineage| lineage.outline_strayed),
        error: Some(largest(|lineage| lineage.coarsest_measured)),
    })
}

/// Where the parent's ground was not measured.
pub(super) fn filled(family: &[Child]) -> Filled {
    let mut filled = Filled::default();
    for child in family {
        let quarter = [child.square.x, child.square.y].map(|at| at.rem_euclid(2) as usize);
        filled.take_over(&child.filled, quarter);
    }
    filled
}

/// The edges along breaklines of a family, in the parent's coordinates.
fn breaklines(lattice: Lattice, family: &[Child]) -> Vec<[DVec2; 2]> {
    let of_child = |child: &Child| {
        let place = |[x, y]: [i64; 2]| {
            let at = DVec3::new(x as f64, y as f64, 0.0);
            lattice.in_parent(child.square, at).truncate()
        };
        child.breaklines.iter().map(|edge| edge.map(place)).collect::<Vec<_>>()
    };
    family.iter().flat_map(of_child).collect()
}

/// The coarsest meshes of a family as one, in the parent's coordinates.
fn welded(lattice: Lattice, family: &[Child]) -> Result<Mesh> {
    let mut mesh = Mesh::default();
    let mut numbers: HashMap<[i64; 2], u32> = HashMap::new();
    for child in family {
        let extent = lattice.extent(child.square.zoom);
        let mut number = Vec::with_capacity(child.coarsest.positions.len());
        for &position in &child.coarsest.positions {
            let at = lattice.in_parent(child.square, position);
            let own = mesh.positions.len() as u32;
            let is_shared = leaf::is_on_side(position, extent);
            let found = if is_shared {
                *numbers.entry([at.x as i64, at.y as i64]).or_insert(own)
            } else {
                own
            };
            if found == own {
                mesh.positions.push(at);
            } else if mesh.positions[found as usize] != at {
                bail!(
                    "tile {}: its side does not meet its neighbour's",
                    child.square.address()
                );
            }
            number.push(found);
        }
        let triangles = child.coarsest.triangles.iter();
        mesh.triangles
            .extend(triangles.map(|corners| corners.map(|corner| number[corner as usize])));
    }
    mesh::separate_fans(&mut mesh, |_| false);
    Ok(mesh)
}
