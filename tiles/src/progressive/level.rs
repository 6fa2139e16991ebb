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

/// Why a vertex is to be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum News {
    /// It is not.
    None,
    /// A star next to it, or its own, changed.
    Near,
    /// The level begins.
    Level,
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
    news: Vec<News>,
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
            news: Vec::new(),
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
        let end = self.surface.positions.len() + count;
        self.news.clear();
        self.news.resize(self.surface.positions.len(), News::Level);
        while self.surface.positions.len() < end {
            if self.ask_all(coder, stage, end, source)? == 0 {
                return Err(Fault);
            }
        }
        Ok(())
    }

    /// Asks every vertex that is to be asked; tells how many were.
    fn ask_all<C: Coder>(
        &mut self,
        coder: &mut C,
        stage: Stage,
        end: usize,
        source: &mut impl Source,
    ) -> Result<usize, Fault> {
        let mut asked = 0;
        for vertex in 0..self.news.len() as u32 {
            let news = std::mem::replace(&mut self.news[vertex as usize], News::None);
            if news == News::None || !self.can_split(stage, vertex) {
                continue;
            }
            asked += 1;
            let is_closed = usize::from(self.surface.is_closed(vertex));
            let is_asked_again = usize::from(news == News::Near);
            let valence = (self.surface.valence(vertex) as usize).min(VALENCES - 1);
            let answer = &mut self.answers[stage as usize][is_closed][is_asked_again][valence];
            if coder.bit(answer, source.splits(vertex)) {
                self.split(coder, stage, vertex, source)?;
            }
            if coder.is_exhausted() {
                return Err(Fault);
            }
            if self.surface.positions.len() == end {
                break;
            }
        }
        Ok(asked)
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
        self.news.push(News::Near);
        self.news[vertex as usize] = News::Near;
        for &neighbour in &self.ring.vertices {
            self.news[neighbour as usize] = News::Near;
        }
    }
}
