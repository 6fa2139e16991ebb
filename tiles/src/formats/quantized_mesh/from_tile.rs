//! A tile of ours becomes a quantized-mesh: its finest surface, completed to the whole square, in the format's numbers.

use std::sync::Arc;

use glam::DVec3;
use terrain_codec::address::{Rectangle, Side, TileAddress};
use terrain_codec::ellipsoid::to_earth_centred;

use super::measured::{Measured, Point};
use super::square::{self, CompletedSquare};
use super::{EXTENT, QuantizedMesh, Vertex, across_and_along, bounds, geodetic};
use crate::outside::Outside;
use crate::shading::{FinestSurface, oct_encode};

impl QuantizedMesh {
    /// A finest surface, completed to its whole square by what is `outside`. Where the data end in it, `surface_at` is asked for those of
    /// the tiles [around](TileAddress::around) it: along its sides it has the points that these measured.
    ///
    /// # Errors
    /// Those of `surface_at`.
    pub fn from_tile<E>(
        own: &FinestSurface,
        surface_at: impl Fn(TileAddress) -> Result<Option<Arc<FinestSurface>>, E>,
        outside: &Outside,
    ) -> Result<Self, E> {
        Self::completed(Measured::of(own), own.tile.address, surface_at, outside)
    }

    /// What is `outside` over the square of `address`, where nothing is measured; along its sides, what the tiles around it have there.
    ///
    /// # Errors
    /// Those of `surface_at`.
    pub fn unmeasured<E>(
        address: TileAddress,
        surface_at: impl Fn(TileAddress) -> Result<Option<Arc<FinestSurface>>, E>,
        outside: &Outside,
    ) -> Result<Self, E> {
        Self::completed(Measured::nothing(), address, surface_at, outside)
    }

    fn completed<E>(
        own: Measured,
        address: TileAddress,
        surface_at: impl Fn(TileAddress) -> Result<Option<Arc<FinestSurface>>, E>,
        outside: &Outside,
    ) -> Result<Self, E> {
        let around = || {
            let mut around = Vec::new();
            for other in address.around() {
                if let Some(surface) = surface_at(other)? {
                    let offsets = offsets_from(address, other);
                    around.extend(offsets.map(|offset| (offset, Measured::of(&surface))));
                }
            }
            Ok(around)
        };
        let rectangle = address.into();
        let surface = square::complete(own, around, rectangle, outside)?;
        Ok(Self::from_surface(rectangle, surface, outside))
    }

    pub(super) fn from_surface(rectangle: Rectangle, surface: CompletedSquare, outside: &Outside) -> Self {
        let surface = number_by_first_use(surface);
        let scale = HeightScale::over(surface.points.iter().map(|point| point.height));
        let vertices: Vec<Vertex> = surface
            .points
            .iter()
            .map(|point| Vertex {
                u: point.u,
                v: point.v,
                height: scale.round(point.height),
            })
            .collect();
        let heights = scale.ends();
        let positions: Vec<DVec3> = vertices
            .iter()
            .map(|vertex| to_earth_centred(geodetic(rectangle, heights, *vertex)))
            .collect();
        let (sphere_center, sphere_radius) = bounds::sphere(&positions);
        let normal = |point: &Point| {
            point
                .normal
                .unwrap_or_else(|| outside.normal(rectangle, [point.u, point.v], EXTENT))
        };
        let normals: Vec<DVec3> = surface.points.iter().map(normal).collect();
        Self {
            center: sphere_center,
            heights,
            sphere_center,
            sphere_radius,
            horizon_occlusion_point: bounds::horizon_occlusion_point(sphere_center, &positions),
            edges: edge_lists(&vertices, &surface.triangles),
            vertices,
            triangles: surface.triangles,
            normals: Some(normals.into_iter().map(oct_encode).collect()),
            water_mask: None,
            measured_triangles: Some(surface.measured),
        }
    }
}

/// How many tiles east and north of one another is, if it is around it; each way if it is on both sides, as the roots are.
fn offsets_from(address: TileAddress, other: TileAddress) -> impl Iterator<Item = [i64; 2]> {
    let columns = 2_i64 << address.zoom;
    let north = i64::from(other.y) - i64::from(address.y);
    let apart = i64::from(other.x) - i64::from(address.x);
    let easts = (-1..=1).filter(move |east| (apart - east).rem_euclid(columns) == 0);
    easts.map(move |east| [east, north])
}

/// Renumbers the vertices in the order in which the triangles use them, which is what high-water-mark coding wants;
/// those that no triangle uses go.
fn number_by_first_use(surface: CompletedSquare) -> CompletedSquare {
    let mut numbers = vec![u32::MAX; surface.points.len()];
    let mut points = Vec::with_capacity(surface.points.len());
    let mut number = |old: u32| {
        let slot = &mut numbers[old as usize];
        if *slot == u32::MAX {
            *slot = points.len() as u32;
            points.push(surface.points[old as usize]);
        }
        *slot
    };
    let triangles = surface
        .triangles
        .iter()
        .map(|triangle| triangle.map(&mut number))
        .collect();
    CompletedSquare {
        points,
        triangles,
        measured: surface.measured,
    }
}

/// How metres become 0…[`EXTENT`]: in whole steps of a power of two, counted from height 0. Tiles with one step agree
/// bit for bit where they share a vertex, and exactly with the source when the step divides its own; tiles with
/// different steps differ by half the larger one at most.
struct HeightScale {
    /// Metres.
    step: f64,
    /// The lowest height in steps from 0.
    lowest: f64,
    /// The highest height in steps from 0.
    highest: f64,
}

impl HeightScale {
    /// Below a thousandth of a millimetre a finer step is of no use.
    const SMALLEST_EXPONENT: i32 = -20;

    /// The smallest step in which the range fits. Both ends are then exact in the header's `f32`, too, whose 24 bits
    /// hold any count of steps below 2^24.
    fn over(heights: impl Iterator<Item = f64>) -> Self {
        let (lowest, highest) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
            (low.min(h), high.max(h))
        });
        let mut step = f64::from(Self::SMALLEST_EXPONENT).exp2();
        loop {
            let scale = Self {
                step,
                lowest: (lowest / step).floor(),
                highest: (highest / step).ceil(),
            };
            let fits = scale.highest - scale.lowest <= f64::from(EXTENT);
            let exact = scale.lowest.abs() + f64::from(EXTENT) < f64::from(1 << 24);
            // Not a number and infinity never fit; they end here.
            if (fits && exact) || step > f64::from(1 << 24) {
                return scale;
            }
            step *= 2.0;
        }
    }

    fn round(&self, height: f64) -> u16 {
        (height / self.step - self.lowest).round() as u16
    }

    /// What 0 and [`EXTENT`] stand for; the same where all heights are one.
    fn ends(&self) -> [f32; 2] {
        let span = if self.highest > self.lowest {
            f64::from(EXTENT)
        } else {
            0.0
        };
        [self.lowest, self.lowest + span].map(|steps| (steps * self.step) as f32)
    }
}

/// The vertices on each side. Where measured ground ends at a fill, two are at one place; the one that belongs to the
/// part before it comes first, so that a skirt follows the step.
fn edge_lists(vertices: &[Vertex], triangles: &[[u32; 3]]) -> [Vec<u32>; 4] {
    Side::ALL.map(|side| {
        let place = |index: u32| across_and_along(side, vertices[index as usize]);
        let on_side = |index: u32| place(index).0 == 0;
        let mut rank = vec![1_u8; vertices.len()];
        let directed = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        for (start, end) in directed.filter(|&(a, b)| on_side(a) && on_side(b)) {
            // Counter-clockwise triangles run against the clock on the tile's border; walls run nowhere.
            if place(start).1 > place(end).1 {
                rank[start as usize] = 0;
                if rank[end as usize] != 0 {
                    rank[end as usize] = 2;
                }
            }
        }
        let mut list: Vec<u32> = (0..vertices.len() as u32).filter(|&index| on_side(index)).collect();
        list.sort_by_key(|&index| (place(index).1, rank[index as usize]));
        list
    })
}
