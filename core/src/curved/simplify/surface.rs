//! The surface while it is simplified: half-edges, the curve of each, and what each patch stands for.

use glam::{DVec3, Vec3Swizzles};
use smallvec::SmallVec;

use super::cover::{Cover, FLAT, Part, Parts};
use super::plan::{Made, Plan, Side};
use super::shared_curves::{CurveUse, Frame, RecordedPatch, levels_of};
use crate::curved::levels::CurvedLevels;
use crate::curved::model::{CurvedModel, Input};
use crate::curved::patch::{CENTRE, CubicPatch};
use crate::curved::patterns::Ring;
use crate::topology::half_edges::{HalfEdges, NONE, edges_of, next, previous};

pub(super) struct Surface {
    pub(super) topology: HalfEdges,
    pub(super) frame: Frame,
    /// Of each half-edge.
    curve_of: Vec<CurveUse>,
    /// Of each place for a patch: where it stands among all patches.
    log_of: Vec<u32>,
    /// Of each place: what its patch stands for.
    pub(super) covers: Vec<Cover>,
    pub(super) parts: Parts,
    /// All patches that ever were.
    log: Vec<RecordedPatch>,
    pub(super) patch_count: usize,
    pub(super) level: u32,
}

impl Surface {
    pub(super) fn new(model: CurvedModel) -> Self {
        let CurvedModel {
            patches,
            topology,
            is_crease,
            input,
        } = model;
        let mut surface = Self {
            frame: Frame {
                positions: vec![DVec3::ZERO; topology.vertex_slots() as usize],
                ..Frame::default()
            },
            curve_of: vec![CurveUse::new(0, false); is_crease.len()],
            log_of: (0..patches.len() as u32).collect(),
            covers: Vec::with_capacity(patches.len()),
            parts: Parts::default(),
            log: Vec::with_capacity(3 * patches.len()),
            patch_count: patches.len(),
            level: 0,
            topology,
        };
        surface.take_curves(&patches, &is_crease);
        surface.parts.corners.clone_from(&surface.frame.positions);
        for (slot, patch) in (0..).zip(&patches) {
            surface.take_patch(slot, patch, &input);
        }
        surface
    }

    fn take_curves(&mut self, patches: &[CubicPatch], is_crease: &[bool]) {
        for edge in 0..is_crease.len() as u32 {
            let twin = self.topology.twin(edge);
            let [start, first, second, _] = patches[edge as usize / 3].curve(edge as usize % 3);
            self.frame.positions[self.topology.origin(edge) as usize] = start;
            if twin < edge {
                continue;
            }
            let curve = self.frame.add([first, second], is_crease[edge as usize]);
            self.curve_of[edge as usize] = curve;
            if twin != NONE {
                self.curve_of[twin as usize] = curve.reversed();
            }
        }
    }

    /// A model whose patches do not quite agree on what they share is not left without a word.
    fn take_patch(&mut self, slot: u32, given: &CubicPatch, input: &Input) {
        let corners = self.topology.triangles()[slot as usize];
        let curves = edges_of(slot).map(|edge| self.curve_of[edge as usize]);
        let centre = given.points[CENTRE];
        let own = self.frame.patch(corners, curves, centre);
        let (part, error) = match input {
            Input::Triangles => (FLAT, own.deviation(&own.flat())),
            Input::Near(deviations) => {
                let error = deviations[slot as usize];
                self.parts.curved.push(Part { points: *given, error });
                (slot, own.deviation(given) + error)
            }
        };
        self.covers.push(Cover::whole(part, corners));
        self.log.push(RecordedPatch {
            centre,
            error,
            corners,
            curves,
            born: 0,
            died: u32::MAX,
        });
    }

    pub(super) fn curve(&self, edge: u32) -> CurveUse {
        self.curve_of[edge as usize]
    }

    pub(super) fn is_crease(&self, edge: u32) -> bool {
        self.frame.is_crease[self.curve(edge).curve()]
    }

    pub(super) fn position(&self, vertex: u32) -> DVec3 {
        self.frame.positions[vertex as usize]
    }

    pub(super) fn error(&self, slot: u32) -> f64 {
        self.log[self.log_of[slot as usize] as usize].error
    }

    /// All four control points along a half-edge.
    pub(super) fn points_along(&self, edge: u32) -> [DVec3; 4] {
        let [first, second] = self.frame.inner(self.curve(edge));
        let [from, to] = [self.topology.origin(edge), self.topology.end(edge)].map(|end| self.position(end));
        [from, first, second, to]
    }

    /// The patch whose first curve is that of a half-edge.
    pub(super) fn patch_at(&self, edge: u32) -> CubicPatch {
        let edges = [edge, next(edge), previous(edge)];
        let centre = self.log[self.log_of[edge as usize / 3] as usize].centre;
        let corners = edges.map(|edge| self.topology.origin(edge));
        self.frame.patch(corners, edges.map(|edge| self.curve(edge)), centre)
    }

    pub(super) fn ring(&self, vertex: u32) -> Ring {
        let leaving: SmallVec<[u32; 8]> = self.topology.leaving(vertex).collect();
        let mut ring = Ring::new(leaving);
        for index in 0..ring.leaving.len() {
            let edge = ring.leaving[index];
            let [from, to, ..] = self.points_along(edge);
            ring.push(self.topology.end(edge), to - from, self.is_crease(edge));
        }
        if let Some(&last) = ring.leaving.last()
            && self.topology.is_boundary(vertex)
        {
            let before = previous(last);
            let [.., from, to] = self.points_along(before);
            ring.push(self.topology.origin(before), from - to, self.is_crease(before));
        }
        ring
    }

    pub(super) fn are_joined(&self, a: u32, b: u32) -> bool {
        self.topology.edge_between(a, b).is_some() || self.topology.edge_between(b, a).is_some()
    }

    /// Swaps and merges; the places of new patches.
    pub(super) fn perform(&mut self, plan: &Plan, made: Vec<Made>) -> SmallVec<[u32; 8]> {
        for curve in &plan.curves {
            self.frame.add(curve.inner, curve.is_crease);
        }
        for side in &plan.sides {
            side.slots.iter().for_each(|&slot| self.bury(slot));
            if let Some(edge) = side.flip {
                self.topology.flip(edge);
            }
        }
        for &(vertex, red) in &plan.removed {
            self.topology.collapse(vertex, red);
        }
        let mut placed = SmallVec::new();
        let mut made = made.into_iter();
        for side in &plan.sides {
            let of_side: SmallVec<[Made; 2]> = made.by_ref().take(side.targets.len()).collect();
            self.place(side, of_side, &mut placed);
        }
        self.patch_count += placed.len();
        self.patch_count -= plan.sides.iter().map(|side| side.slots.len()).sum::<usize>();
        placed
    }

    fn bury(&mut self, slot: u32) {
        self.log[self.log_of[slot as usize] as usize].died = self.level;
        self.covers[slot as usize] = Cover::default();
    }

    /// Puts what a side made to the places that are left of it.
    fn place(&mut self, side: &Side, made: SmallVec<[Made; 2]>, placed: &mut SmallVec<[u32; 8]>) {
        let slots = side.slots.iter().copied();
        let left: SmallVec<[u32; 4]> = slots.filter(|&slot| self.topology.corners(slot).is_some()).collect();
        assert_eq!(
            left.len(),
            made.len(),
            "a side leaves a place for each patch that it makes"
        );
        for (target, made) in side.targets.iter().zip(made) {
            let turn = |&slot: &u32| {
                let corners = self.topology.triangles()[slot as usize];
                let turned = |turn: &u32| (0..3).all(|i| corners[(i + *turn as usize) % 3] == target.corners[i]);
                (0..3).find(turned).map(|turn| (slot, turn))
            };
            let found = left.iter().find_map(turn);
            let (slot, turn) = found.expect("the topology has the corners that the plan says");
            self.place_one(slot, turn, target.curves, made);
            placed.push(slot);
        }
    }

    /// Corner 0 of what was made is corner `turn` of the place.
    fn place_one(&mut self, slot: u32, turn: u32, curves: [CurveUse; 3], made: Made) {
        for (corner, curve) in (0..).zip(curves) {
            self.curve_of[(3 * slot + (corner + turn) % 3) as usize] = curve;
        }
        self.log_of[slot as usize] = self.log.len() as u32;
        self.log.push(RecordedPatch {
            centre: made.centre,
            error: made.error,
            corners: self.topology.triangles()[slot as usize],
            curves: edges_of(slot).map(|edge| self.curve(edge)),
            born: self.level,
            died: u32::MAX,
        });
        let mut cover = made.cover;
        for place in &mut cover.places {
            place.at = turned(place.at, turn);
        }
        self.covers[slot as usize] = cover;
    }

    pub(super) fn into_levels(mut self) -> CurvedLevels {
        let levels = self.level + 1;
        self.log
            .iter_mut()
            .for_each(|patch| patch.died = patch.died.min(levels));
        levels_of(&self.frame, &self.log, levels)
    }
}

/// The same place where corner 0 becomes corner `turn`.
fn turned(at: DVec3, turn: u32) -> DVec3 {
    match turn {
        0 => at,
        1 => at.zxy(),
        _ => at.yzx(),
    }
}
