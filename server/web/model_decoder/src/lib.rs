//! Progressive models for browsers: `terrain_codec::spm` and the refinement from view to view as WebAssembly, their arrays as JavaScript
//! has them. What calls it is `progressive_model.ts` of the page. Tiles have a module of their own, which pages of terrain load alone.

use glam::{DVec3, DVec4, Vec4Swizzles};
use terrain_codec::{LevelLimits, spm};
use terrain_core::SurfacePartition;
use terrain_core::levels::view_error::{HalfSpace, View};
use terrain_core::levels::view_refinement::ViewRefinement;
use wasm_bindgen::JsError;
use wasm_bindgen::prelude::wasm_bindgen;

/// A model in its own units: all of its levels, and what is drawn of it for a view.
#[derive(Debug)]
#[wasm_bindgen]
pub struct Model {
    partition: SurfacePartition,
    refinement: Option<ViewRefinement>,
    places: Vec<u32>,
    vertices: Vec<u32>,
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
            places: Vec::new(),
            vertices: Vec::new(),
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

    /// Splits and collapses until the picture is within so many pixels, and tells how many that were. `eye` is a place in the model's units,
    /// of `frustum` each four numbers are a unit normal to its inside and an offset, `focal_length` is in pixels.
    /// The first view begins with the coarsest level.
    ///
    /// # Errors
    /// Where the surface is no 2-manifold on which its collapses can be performed.
    pub fn refine(&mut self, eye: &[f64], frustum: &[f64], focal_length: f64, within: f64) -> Result<usize, JsError> {
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
        [self.places, self.vertices] = refinement.take_undrawn();
        Ok(changes.splits + changes.collapses)
    }

    /// How many triangles are drawn.
    #[must_use]
    pub fn drawn_triangles(&self) -> usize {
        self.refinement
            .as_ref()
            .map_or(0, |drawn| drawn.surface().triangles().len())
    }

    /// Which of them are to be drawn anew since the view before, growing; the first time all.
    #[must_use]
    pub fn changed_places(&self) -> Vec<u32> {
        self.places.clone()
    }

    /// Three corners for each of these.
    #[must_use]
    pub fn changed_corners(&self) -> Vec<u32> {
        let Some(surface) = self.refinement.as_ref().map(ViewRefinement::surface) else {
            return Vec::new();
        };
        let corners = |&place: &u32| surface.corners(surface.triangles()[place as usize]);
        self.places.iter().flat_map(corners).collect()
    }

    /// Which vertices have moved since the view before, growing; the first time all.
    #[must_use]
    pub fn moved_vertices(&self) -> Vec<u32> {
        self.vertices.clone()
    }

    /// Three coordinates for each of these.
    #[must_use]
    pub fn moved_positions(&self) -> Vec<f64> {
        let Some(surface) = self.refinement.as_ref().map(ViewRefinement::surface) else {
            return Vec::new();
        };
        let position = |&vertex: &u32| surface.position(vertex).to_array();
        self.vertices.iter().flat_map(position).collect()
    }
}
