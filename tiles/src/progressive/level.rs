//! One level in bits: which vertices split, in which order, and how.
//!
//! ```text
//! while splits of the level are left:
//!     for each vertex there is, by growing index, whose star changed since it was asked (all, at first):
//!         does it split now?
//!         if so: code the split, perform it; ask it, the new vertex and their neighbours again
//! ```
//! A vertex splits as soon as all splits that must come before have been made, so that "no" is the answer until its star
//! changes.

use glam::DVec3;

use super::range_coder::{Coder, Probability};
use super::split::{Space, Split, SplitModel};
use super::surface::{Ring, Surface, are_possible};

/// Valences that have statistics of their own.
const VALENCES: usize = 12;
/// Vertices of more neighbours are never split: the work a split takes must not grow with the surface.
pub(super) const MAX_VALENCE: usize = 1024;

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
    /// The split of a vertex, if it splits now.
    fn split(&mut self, vertex: u32, ring: &Ring) -> Option<Split>;
    /// That split was made.
    fn performed(&mut self, vertex: u32);
}

/// For a decoder.
pub(super) struct Unknown;

impl Source for Unknown {
    fn split(&mut self, _: u32, _: &Ring) -> Option<Split> {
        None
    }

    fn performed(&mut self, _: u32) {}
}

/// Why the bits make no surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// No vertex is left to be asked.
    TooFewSplits,
    /// A star cannot be cut so.
    Cuts,
    /// A coordinate is out of range.
    Position,
    /// The bytes ended before.
    Exhausted,
}

/// The state that encoder and decoder share.
#[derive(Debug)]
pub(super) struct LevelCoder {
    pub(super) surface: Surface,
    /// For each vertex its representative, and where that was before: itself and its place where there is none.
    pub(super) representatives: Vec<u32>,
    pub(super) stored: Vec<DVec3>,
    pub(super) blue_positions: Vec<DVec3>,
    low: DVec3,
    high: DVec3,
    splits: SplitModel,
    flags: [[[[Probability; VALENCES]; 2]; 2]; 3],
    is_to_ask: Vec<bool>,
    was_asked: Vec<bool>,
    ring: Ring,
}

impl LevelCoder {
    pub(super) fn new(surface: Surface, space: Space, [low, high]: [DVec3; 2]) -> Self {
        let count = surface.positions.len();
        Self {
            representatives: (0..count as u32).collect(),
            stored: surface.positions.clone(),
            blue_positions: surface.positions.clone(),
            splits: SplitModel::new(space, count),
            surface,
            low,
            high,
            flags: Default::default(),
            is_to_ask: Vec::new(),
            was_asked: Vec::new(),
            ring: Ring::default(),
        }
    }

    /// Codes as many splits.
    pub(super) fn code<C: Coder>(
        &mut self,
        coder: &mut C,
        is_exhausted: impl Fn(&C) -> bool,
        stage: Stage,
        count: usize,
        source: &mut impl Source,
    ) -> Result<(), Fault> {
        let end = self.surface.positions.len() + count;
        self.is_to_ask.clear();
        self.is_to_ask.resize(self.surface.positions.len(), true);
        self.was_asked.clear();
        self.was_asked.resize(self.surface.positions.len(), false);
        while self.surface.positions.len() < end {
            let mut is_anyone_asked = false;
            for vertex in 0..self.surface.positions.len() as u32 {
                if !std::mem::take(&mut self.is_to_ask[vertex as usize]) {
                    continue;
                }
                is_anyone_asked = true;
                if self.ask(coder, stage, vertex, source)? && self.surface.positions.len() == end {
                    break;
                }
                if is_exhausted(coder) {
                    return Err(Fault::Exhausted);
                }
            }
            if !is_anyone_asked {
                return Err(Fault::TooFewSplits);
            }
        }
        Ok(())
    }

    fn ask<C: Coder>(&mut self, coder: &mut C, stage: Stage, vertex: u32, source: &mut impl Source) -> Result<bool, Fault> {
        let mut ring = std::mem::take(&mut self.ring);
        self.surface.walk(vertex, &mut ring);
        let can_split = (2..=MAX_VALENCE).contains(&ring.vertices.len()) && !(stage == Stage::Boundary && ring.is_closed());
        let split = source.split(vertex, &ring);
        let asked = std::mem::replace(&mut self.was_asked[vertex as usize], true);
        let valence = ring.vertices.len().min(VALENCES - 1);
        let flag = &mut self.flags[stage as usize][usize::from(ring.is_closed())][usize::from(asked)][valence];
        let splits = can_split && coder.bit(flag, split.is_some());
        let result = if splits {
            self.split(coder, stage, vertex, &ring, split.unwrap_or_default())
        } else {
            Ok(())
        };
        if splits {
            source.performed(vertex);
        }
        self.ring = ring;
        result.map(|()| splits)
    }

    fn split<C: Coder>(&mut self, coder: &mut C, stage: Stage, vertex: u32, ring: &Ring, split: Split) -> Result<(), Fault> {
        let split = self.splits.code(coder, &self.surface, vertex, ring, stage == Stage::Base, split);
        if !are_possible(split.cuts, ring) {
            return Err(Fault::Cuts);
        }
        let is_inside = |position: DVec3| position.cmpge(self.low).all() && position.cmple(self.high).all();
        if !is_inside(split.blue) || !is_inside(split.red) {
            return Err(Fault::Position);
        }
        self.surface.split(vertex, ring, split.cuts, split.blue);
        self.surface.positions[vertex as usize] = split.red;
        let blue = self.stored.len() as u32;
        self.stored.push(split.blue);
        let is_base = stage == Stage::Base;
        self.representatives.push(if is_base { blue } else { vertex });
        self.blue_positions.push(if is_base { split.blue } else { split.red });
        self.is_to_ask.push(true);
        self.was_asked.push(false);
        self.is_to_ask[vertex as usize] = true;
        for &neighbour in &ring.vertices {
            self.is_to_ask[neighbour as usize] = true;
        }
        Ok(())
    }
}
