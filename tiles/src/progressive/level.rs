//! One level in bits: which vertices split, in which order, and how.
//!
//! ```text
//! queue ← all vertices
//! while splits of the level are left:
//!     take a vertex from the queue: does it split now?
//!     if so: code the split, perform it; queue it, the new vertex and their neighbours, where they are not in it
//! ```
//! A vertex splits as soon as all splits that must come before have been made, so that "no" is the answer until its star
//! changes.

use std::collections::VecDeque;

use glam::DVec3;

use super::range_coder::{Coder, Probability};
use super::split::{Place, Split, SplitModel};
use super::surface::{Ring, Surface, are_possible};

/// Valences that have statistics of their own.
const VALENCES: usize = 12;
/// Vertices of more neighbours are never split: the work a split takes must not grow with the surface.
const MAX_VALENCE: u32 = 1024;

/// Which part of the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Makes the surface of the coarsest level; vertices stay where they are.
    Base,
    /// Any level after it.
    Level,
    /// A level after it in which only vertices of the boundary split.
    Boundary,
}

/// Knows the splits, or is none the wiser and lets the bits tell.
pub(super) trait Source {
    /// Whether a vertex splits now.
    fn splits(&self, vertex: u32) -> bool;
    /// How it does.
    fn split(&self, vertex: u32, ring: &Ring) -> Split;
    /// That split was made.
    fn performed(&mut self, vertex: u32);
}

/// For a decoder.
pub(super) struct Unknown;

impl Source for Unknown {
    fn splits(&self, _: u32) -> bool {
        false
    }

    fn split(&self, _: u32, _: &Ring) -> Split {
        Split::default()
    }

    fn performed(&mut self, _: u32) {}
}

/// The bits make no surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fault;

/// The state that encoder and decoder share.
#[derive(Debug)]
pub(super) struct LevelCoder {
    pub(super) surface: Surface,
    /// For each vertex its representative, itself where there is none.
    pub(super) representatives: Vec<u32>,
    /// Where each vertex was when it was made.
    pub(super) made_at: Vec<DVec3>,
    /// Where its representative went then; its own place where there is none.
    pub(super) blue_positions: Vec<DVec3>,
    bounds: [DVec3; 2],
    splits: SplitModel,
    answers: [[[[Probability; VALENCES]; 2]; 2]; 3],
    queue: VecDeque<u32>,
    is_queued: Vec<bool>,
    ring: Ring,
}

impl LevelCoder {
    pub(super) fn new(surface: Surface, splits: SplitModel, bounds: [DVec3; 2]) -> Self {
        let count = surface.positions.len();
        Self {
            representatives: (0..count as u32).collect(),
            made_at: surface.positions.clone(),
            blue_positions: surface.positions.clone(),
            surface,
            bounds,
            splits,
            answers: Default::default(),
            queue: VecDeque::new(),
            is_queued: Vec::new(),
            ring: Ring::default(),
        }
    }

    /// Codes as many splits.
    pub(super) fn code<C: Coder>(
        &mut self,
        coder: &mut C,
        stage: Stage,
        count: usize,
        source: &mut impl Source,
    ) -> Result<(), Fault> {
        let vertices = self.surface.positions.len();
        self.queue.clear();
        self.queue.extend(0..vertices as u32);
        self.is_queued.clear();
        self.is_queued.resize(vertices, true);
        let mut asked = 0;
        while self.surface.positions.len() < vertices + count {
            let vertex = self.queue.pop_front().ok_or(Fault)?;
            self.is_queued[vertex as usize] = false;
            asked += 1;
            if self.can_split(stage, vertex) {
                self.ask(coder, stage, vertex, asked > vertices, source)?;
            }
        }
        Ok(())
    }

    /// Codes whether a vertex splits, and how.
    fn ask<C: Coder>(
        &mut self,
        coder: &mut C,
        stage: Stage,
        vertex: u32,
        is_asked_again: bool,
        source: &mut impl Source,
    ) -> Result<(), Fault> {
        let is_closed = self.surface.is_closed(vertex);
        let valence = (self.surface.valence(vertex) as usize).min(VALENCES - 1);
        let answers = &mut self.answers[stage as usize][usize::from(is_closed)][usize::from(is_asked_again)];
        if coder.bit(&mut answers[valence], source.splits(vertex)) {
            self.split(coder, stage, vertex, source)?;
        }
        if coder.is_exhausted() { Err(Fault) } else { Ok(()) }
    }

    fn can_split(&self, stage: Stage, vertex: u32) -> bool {
        (2..=MAX_VALENCE).contains(&self.surface.valence(vertex))
            && (stage != Stage::Boundary || !self.surface.is_closed(vertex))
    }

    fn split<C: Coder>(
        &mut self,
        coder: &mut C,
        stage: Stage,
        vertex: u32,
        source: &mut impl Source,
    ) -> Result<(), Fault> {
        self.surface.walk(vertex, &mut self.ring);
        let place = Place {
            surface: &self.surface,
            vertex,
            ring: &self.ring,
            is_still: stage == Stage::Base,
        };
        let split = self.splits.code(coder, place, source.split(vertex, &self.ring));
        if !are_possible(split.cuts, &self.ring) || !self.is_inside(split.blue) || !self.is_inside(split.red) {
            return Err(Fault);
        }
        self.surface.split(vertex, &self.ring, split.cuts, split.blue);
        self.surface.positions[vertex as usize] = split.red;
        self.note(stage, vertex, split);
        source.performed(vertex);
        Ok(())
    }

    fn is_inside(&self, position: DVec3) -> bool {
        let [low, high] = self.bounds;
        position.cmpge(low).all() && position.cmple(high).all()
    }

    fn note(&mut self, stage: Stage, vertex: u32, split: Split) {
        let blue = self.made_at.len() as u32;
        let is_base = stage == Stage::Base;
        self.made_at.push(split.blue);
        self.representatives.push(if is_base { blue } else { vertex });
        self.blue_positions.push(if is_base { split.blue } else { split.red });
        self.is_queued.push(true);
        self.queue.push_back(blue);
        for neighbour in std::iter::once(vertex).chain(self.ring.vertices.iter().copied()) {
            if !std::mem::replace(&mut self.is_queued[neighbour as usize], true) {
                self.queue.push_back(neighbour);
            }
        }
    }
}
