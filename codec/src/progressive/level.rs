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

use glam::DVec3;

use super::range_coder::{Coder, Probability};
use super::ring::Ring;
use super::split::{Split, SplitModel};
use super::surface::GrowingSurface;

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

/// Knows the splits; of a decoder, it knows nothing, and the bits tell.
pub(super) trait SplitSource {
    /// Whether a vertex splits now.
    fn splits(&self, vertex: u32) -> bool;
    /// How it does.
    fn split(&self, vertex: u32, ring: &Ring) -> Split;
    /// That split was made.
    fn performed(&mut self, vertex: u32);
}

/// For a decoder.
pub(super) struct Unknown;

impl SplitSource for Unknown {
    fn splits(&self, _: u32) -> bool {
        false
    }

    fn split(&self, _: u32, _: &Ring) -> Split {
        Split::default()
    }

    fn performed(&mut self, _: u32) {}
}

/// Why a level ends before it has all its splits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// There are no more bytes. What was split before is a surface.
    Exhausted,
    /// The bits make no surface.
    NotASurface,
}

/// The state that encoder and decoder share.
#[derive(Debug)]
pub(super) struct LevelCoder {
    pub(super) surface: GrowingSurface,
    /// For each vertex its representative, itself where there is none.
    pub(super) representatives: Vec<u32>,
    /// Where each vertex was when it was made.
    pub(super) made_at: Vec<DVec3>,
    /// Where its representative went then; its own place where there is none.
    pub(super) blue_positions: Vec<DVec3>,
    bounds: [DVec3; 2],
    splits: SplitModel,
    answers: [[[[Probability; VALENCES]; 2]; 2]; 3],
    /// Vertices to ask in this round.
    round: Vec<u32>,
    /// Those to ask in the next.
    queue: Vec<u32>,
    ring: Ring,
}

impl LevelCoder {
    pub(super) fn new(surface: GrowingSurface, splits: SplitModel, bounds: [DVec3; 2]) -> Self {
        let positions: Vec<DVec3> = surface.vertices.iter().map(|vertex| vertex.position).collect();
        Self {
            representatives: (0..positions.len() as u32).collect(),
            made_at: positions.clone(),
            blue_positions: positions,
            surface,
            bounds,
            splits,
            answers: Default::default(),
            round: Vec::new(),
            queue: Vec::new(),
            ring: Ring::default(),
        }
    }

    /// Codes as many splits.
    pub(super) fn code<C: Coder>(
        &mut self,
        coder: &mut C,
        stage: Stage,
        count: usize,
        source: &mut impl SplitSource,
    ) -> Result<(), Fault> {
        let end = self.surface.vertices.len() + count;
        self.queue.clear();
        self.queue.extend(0..self.surface.vertices.len() as u32);
        self.surface
            .vertices
            .iter_mut()
            .for_each(|vertex| vertex.is_queued = true);
        let mut is_asked_again = false;
        while self.surface.vertices.len() < end {
            if coder.is_exhausted() {
                return Err(Fault::Exhausted);
            }
            if self.queue.is_empty() {
                return Err(Fault::NotASurface);
            }
            std::mem::swap(&mut self.round, &mut self.queue);
            self.queue.clear();
            for asked in 0..self.round.len() {
                self.ask(coder, stage, self.round[asked], is_asked_again, source)?;
                if self.surface.vertices.len() == end {
                    break;
                }
            }
            is_asked_again = true;
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
        source: &mut impl SplitSource,
    ) -> Result<(), Fault> {
        let asked = &mut self.surface.vertices[vertex as usize];
        asked.is_queued = false;
        let (valence, is_closed) = (asked.valence, asked.is_closed);
        if !(2..=MAX_VALENCE).contains(&valence) || (stage == Stage::Boundary && is_closed) {
            return Ok(());
        }
        let answers = &mut self.answers[stage as usize][usize::from(is_closed)][usize::from(is_asked_again)];
        let answer = &mut answers[(valence as usize).min(VALENCES - 1)];
        if coder.bit(answer, source.splits(vertex)) {
            self.split(coder, stage, vertex, source)?;
        }
        Ok(())
    }

    fn split<C: Coder>(
        &mut self,
        coder: &mut C,
        stage: Stage,
        vertex: u32,
        source: &mut impl SplitSource,
    ) -> Result<(), Fault> {
        self.surface.walk(vertex, &mut self.ring);
        let told = source.split(vertex, &self.ring);
        let mut red = self.surface.vertices[vertex as usize];
        let (blue, cuts) = self
            .splits
            .code(coder, &mut red, &mut self.ring, stage == Stage::Base, told);
        if coder.is_exhausted() {
            return Err(Fault::Exhausted);
        }
        if !self.surface.can_split(&self.ring, cuts) || !self.is_inside(blue.position) || !self.is_inside(red.position)
        {
            return Err(Fault::NotASurface);
        }
        self.surface.vertices[vertex as usize] = red;
        self.note(stage, vertex, red.position, blue.position);
        self.surface.split(vertex, &self.ring, cuts, blue);
        self.enqueue(vertex);
        source.performed(vertex);
        Ok(())
    }

    fn is_inside(&self, position: DVec3) -> bool {
        let [low, high] = self.bounds;
        position.cmpge(low).all() && position.cmple(high).all()
    }

    fn note(&mut self, stage: Stage, vertex: u32, red: DVec3, blue: DVec3) {
        let number = self.made_at.len() as u32;
        let is_base = stage == Stage::Base;
        self.made_at.push(blue);
        self.representatives.push(if is_base { number } else { vertex });
        self.blue_positions.push(if is_base { blue } else { red });
    }

    /// Queues the vertex that split, the new one and all around the two that wait for nothing yet.
    fn enqueue(&mut self, vertex: u32) {
        let blue = self.surface.vertices.len() as u32 - 1;
        let neighbours = self.ring.spokes.iter().map(|spoke| spoke.vertex);
        for around in [blue, vertex].into_iter().chain(neighbours) {
            let is_queued = &mut self.surface.vertices[around as usize].is_queued;
            if !std::mem::replace(is_queued, true) {
                self.queue.push(around);
            }
        }
    }
}
