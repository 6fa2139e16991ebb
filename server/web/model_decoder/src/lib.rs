//! Progressive models for browsers: `terrain_codec::spm` and the refinement from view to view as WebAssembly, their arrays as JavaScript
//! has them. What calls it is `progressive_model.ts` of the page. Tiles have a module of their own, which pages of terrain load alone.

use glam::{DVec3, DVec4, Vec4Swizzles};
use terrain_codec::{LevelLimits, spm};
use terrain_core::SurfacePartition;
use terrain_core::levels::view_error::View;
use terrain_core::levels::view_refinement::ViewRefinement;
use terrain_core::selection::camera::HalfSpace;
use wasm_bindgen::JsError;
use wasm_bindgen::prelude::wasm_bindgen;

/// A model in its own units: all of its levels, and what is drawn of it for a view.
#[derive(Debug)]
#[wasm_bindgen]
pub struct Model {
    partition: SurfacePartition,
    refinement: Option<ViewRefinement>,
}

/// What a view changes in what is drawn; the first one changes all.
#[derive(Debug)]
#[wasm_bindgen(getter_with_clone)]
pub struct Redrawn {
    /// How many triangles are drawn.
    pub triangles: usize,
    /// Which of them are to be drawn anew, growing.
    pub places: Vec<u32>,
    /// Three corners for each of these.
    pub corners: Vec<u32>,
    /// Which vertices have moved, growing.
    pub vertices: Vec<u32>,
    /// Three coordinates for each of these.
    pub positions: Vec<f64>,
    /// How many splits and collapses that took.
    pub changes: usize,
}

#[wasm_bindgen]
impl Model {
    /// Decodes a whole file.
    ///
    /// # Errors
    /// When the bytes are none, or exceed the limits.
    pub fn decode(bytes: &[u8], levels: usize, vertices: usize, triangles: usize) -> Result<Model, JsError> {
        let limits = LevelLimits {
            levels,
            vertices,
            triangles,
        };
        Ok(Self {
            partition: spm::decode(bytes, &limits)?.in_units(),
            refinement: None,
        })
    }

    /// Three numbers a level: vertices and triangles of it and all before it, and its certified error.
    #[must_use]
    pub fn levels(&self) -> Vec<f64> {
        let levels = self.partition.levels.iter();
        let numbers =
            levels.flat_map(|level| [f64::from(level.vertex_end), f64::from(level.triangle_end), level.error]);
        numbers.collect()
    }

    /// Three coordinates for each vertex as stored, then for where its representative goes when it comes in.
    #[must_use]
    pub fn positions(&self) -> Vec<f64> {
        let positions = self.partition.positions.iter().chain(&self.partition.blue_positions);
        positions.flat_map(|position| position.to_array()).collect()
    }

    /// Vertex that each one is drawn at until its level comes in; itself in level 0.
    #[must_use]
    pub fn representatives(&self) -> Vec<u32> {
        self.partition.representatives.clone()
    }

    /// Three corners a triangle, in the numbering of the finest surface.
    #[must_use]
    pub fn corners(&self) -> Vec<u32> {
        self.partition.triangles.as_flattened().to_vec()
    }

    /// Splits and collapses until the picture is within so many pixels. `eye` is a place in the model's units, of `frustum` each four numbers
    /// are a normal to its inside and an offset, `focal_length` is in pixels. The first view begins with the coarsest level.
    ///
    /// # Errors
    /// Where the surface is no 2-manifold on which its collapses can be performed.
    pub fn refine(&mut self, eye: &[f64], frustum: &[f64], focal_length: f64, within: f64) -> Result<Redrawn, JsError> {
        let half_space = |numbers: &[f64]| {
            let plane = DVec4::from_slice(numbers);
            HalfSpace {
                normal: plane.xyz(),
                offset: plane.w,
            }
        };
        let view = View {
            eye: DVec3::from_slice(eye),
            focal_length,
            frustum: frustum.chunks_exact(4).map(half_space).collect(),
        };
        let refinement = match &mut self.refinement {
            Some(refinement) => refinement,
            none => none.insert(ViewRefinement::new(&self.partition)?),
        };
        let changes = refinement.refine(&view, within);
        let [places, vertices] = refinement.take_undrawn();
        let surface = refinement.surface();
        let drawn = surface.triangles();
        let corners = places.iter().flat_map(|&place| surface.corners(drawn[place as usize]));
        let positions = vertices.iter().flat_map(|&vertex| surface.position(vertex).to_array());
        Ok(Redrawn {
            triangles: drawn.len(),
            corners: corners.collect(),
            positions: positions.collect(),
            places,
            vertices,
            changes: changes.splits + changes.collapses,
        })
    }
}
