//! The selection itself.
//!
//! ```text
//! want:    from the roots down, refine what is visible and too coarse at its finest
//! close:   whoever is refined needs its neighbours on the map at its own depth, so their parents are refined too
//! allow:   from the roots down, refine what is wanted, has its children loaded and its neighbours on the map
//! draw:    the leaves; a side is fine where the neighbour is refined, which needs the finest level
//! fit:     if that is more than the budget, all of it again for a larger tolerance
//! request: children of what is wanted, where it gains most; coarse ones before finer ones that need them
//! ```
//!
//! Hence drawn neighbours are at most one depth apart and meet vertex to vertex whatever has been loaded so far, and there is
//! no hole below a root that is loaded.

use rustc_hash::FxHashMap;

use crate::selection::camera::Camera;
use crate::selection::hierarchy::Hierarchy;
use crate::selection::refinements::Refinements;
use crate::selection::scene::{Before, Scene};

/// Tolerances that are tried for a budget, each by this factor larger than the one before.
const STEP: f64 = 1.25;
/// So many of them; the next one is infinite.
const STEPS: u32 = 64;

/// How well a picture has to look, and what it may cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Largest error on the screen, pixels.
    pub tolerance: f64,
    /// What was drawn finer before stays until a coarser level errs by at most this share of the tolerance: above 0, at
    /// most 1.
    pub keep: f64,
    /// Most triangles of the nodes in sight.
    pub triangles: u64,
    /// Most bytes of all nodes.
    pub bytes: u64,
}

/// A node to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice<N> {
    /// Which.
    pub node: N,
    /// Index of its level, 0 the coarsest.
    pub level: usize,
    /// Which of its four sides are fine; if one is, the level is the finest.
    pub fine_sides: [bool; 4],
}

/// What to draw now, and what to load.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection<N> {
    /// Cover what the roots cover, each place once; in the order of a walk down from the roots.
    pub choices: Vec<Choice<N>>,
    /// Nodes that are not loaded, most urgent first.
    pub requests: Vec<N>,
    /// The tolerance that the budget permits, pixels: what is in sight errs by no more once the requests are loaded, but where
    /// nothing finer exists.
    pub tolerance: f64,
}

/// Chooses nodes and levels for a camera. `before` are the choices of the picture before.
#[must_use]
pub fn select<H: Hierarchy>(
    hierarchy: &H,
    camera: &Camera,
    demand: &Demand,
    is_loaded: impl Fn(H::Node) -> bool,
    before: &[Choice<H::Node>],
) -> Selection<H::Node> {
    let scene = Scene::new(hierarchy, camera, levels_before(hierarchy, before));
    let mut selector = Selector {
        scene,
        demand,
        is_loaded,
    };
    selector.fit()
}

/// The level that each node was drawn at, and of those above them the number of their levels.
fn levels_before<H: Hierarchy>(hierarchy: &H, choices: &[Choice<H::Node>]) -> Before<H::Node> {
    let mut before = FxHashMap::default();
    for choice in choices {
        before.insert(choice.node, choice.level);
        let mut above = hierarchy.parent(choice.node);
        while let Some(node) = above.filter(|node| !before.contains_key(node)) {
            before.insert(node, hierarchy.levels(node).len());
            above = hierarchy.parent(node);
        }
    }
    before
}

struct Selector<'a, H: Hierarchy, L> {
    scene: Scene<'a, H>,
    demand: &'a Demand,
    is_loaded: L,
}

impl<H: Hierarchy, L: Fn(H::Node) -> bool> Selector<'_, H, L> {
    /// What the budget permits when all is loaded is asked for; of what is loaded, what it permits now is drawn.
    fn fit(&mut self) -> Selection<H::Node> {
        let (step, (tolerance, wanted, finished)) = self.least_affordable(0, |selector, tolerance| {
            let wanted = selector.wanted(tolerance);
            let drawn = selector.draw(&wanted, tolerance);
            (selector.is_affordable(&drawn), (tolerance, wanted, drawn))
        });
        let allowed = wanted.allowed(&mut self.scene, &self.is_loaded);
        let drawn = if wanted.iter().all(|number| allowed.contains(number)) {
            finished
        } else {
            self.drawn_now(step)
        };
        let is_there = |&(number, _): &(usize, Choice<H::Node>)| (self.is_loaded)(self.scene.seen[number].node);
        Selection {
            choices: drawn.into_iter().filter(is_there).map(|(_, choice)| choice).collect(),
            requests: self.requests(&wanted),
            tolerance,
        }
    }

    /// What the budget permits of what is loaded, for a tolerance from a step on.
    fn drawn_now(&mut self, step: u32) -> Vec<(usize, Choice<H::Node>)> {
        let drawn = self.least_affordable(step, |selector, tolerance| {
            let wanted = selector.wanted(tolerance);
            let allowed = wanted.allowed(&mut selector.scene, &selector.is_loaded);
            let drawn = selector.draw(&allowed, tolerance);
            (selector.is_affordable(&drawn), drawn)
        });
        drawn.1
    }

    fn wanted(&mut self, tolerance: f64) -> Refinements {
        Refinements::wanted(&mut self.scene, tolerance, self.demand.keep)
    }

    /// What is made of the least tolerance tried, from a step on, that is within the budget; if none is, of an infinite one.
    fn least_affordable<T>(&mut self, first: u32, make: impl Fn(&mut Self, f64) -> (bool, T)) -> (u32, T) {
        let (is_affordable, made) = make(self, self.tolerance(first));
        if is_affordable {
            return (first, made);
        }
        let (mut too_fine, mut coarse, mut best) = (first, STEPS, None);
        while coarse - too_fine > 1 {
            let middle = u32::midpoint(too_fine, coarse);
            let (is_affordable, made) = make(self, self.tolerance(middle));
            if is_affordable {
                (coarse, best) = (middle, Some(made));
            } else {
                too_fine = middle;
            }
        }
        (coarse, best.unwrap_or_else(|| make(self, f64::INFINITY).1))
    }

    fn tolerance(&self, step: u32) -> f64 {
        match step {
            STEPS => f64::INFINITY,
            _ => (0..step).fold(self.demand.tolerance, |tolerance, _| tolerance * STEP),
        }
    }

    /// The leaves below refinements, with their numbers.
    fn draw(&mut self, refined: &Refinements, tolerance: f64) -> Vec<(usize, Choice<H::Node>)> {
        let fine_sides = self.fine_sides(refined);
        let mut drawn = Vec::new();
        let mut waiting: Vec<usize> = self.scene.roots.iter().rev().copied().collect();
        while let Some(number) = waiting.pop() {
            if refined.contains(number) {
                waiting.extend(self.scene.children(number).into_iter().rev());
            } else {
                let sides = fine_sides.get(number).copied().unwrap_or_default();
                drawn.push((number, self.choice(number, sides, tolerance)));
            }
        }
        drawn
    }

    /// Of each node, the sides that have a refined one across.
    fn fine_sides(&mut self, refined: &Refinements) -> Vec<[bool; 4]> {
        let mut fine = Vec::new();
        for number in refined.iter() {
            for (side, near) in self.scene.neighbours(number).into_iter().enumerate() {
                if let Some(near) = near {
                    fine.resize(fine.len().max(near + 1), [false; 4]);
                    fine[near][(side + 2) % 4] = true;
                }
            }
        }
        fine
    }

    fn choice(&self, number: usize, fine_sides: [bool; 4], tolerance: f64) -> Choice<H::Node> {
        let seen = &self.scene.seen[number];
        let finest = seen.levels.len().saturating_sub(1);
        let level = if fine_sides.contains(&true) {
            finest
        } else {
            let needed = self.scene.level_needed(number, tolerance, self.demand.keep);
            needed.unwrap_or(finest)
        };
        Choice {
            node: seen.node,
            level,
            fine_sides,
        }
    }

    fn is_affordable(&mut self, drawn: &[(usize, Choice<H::Node>)]) -> bool {
        let (mut triangles, mut bytes) = (0, 0);
        for &(number, choice) in drawn {
            let level = self.scene.seen[number].levels[choice.level];
            bytes += level.bytes;
            if self.scene.is_visible(number) {
                triangles += level.triangles;
            }
        }
        triangles <= self.demand.triangles && bytes <= self.demand.bytes
    }

    fn requests(&mut self, wanted: &Refinements) -> Vec<H::Node> {
        let mut missing: Vec<(f64, usize)> = Vec::new();
        for &root in &self.scene.roots {
            missing.push((f64::INFINITY, root));
        }
        for number in wanted.iter() {
            let gain = wanted.gain(number).unwrap_or(0.0);
            missing.extend(self.scene.children(number).into_iter().map(|child| (gain, child)));
        }
        let seen = &self.scene.seen;
        missing.retain(|&(_, number)| !(self.is_loaded)(seen[number].node));
        missing.sort_by(|&(a, first), &(b, second)| {
            let order = |number: usize| (seen[number].depth, seen[number].node);
            b.total_cmp(&a).then_with(|| order(first).cmp(&order(second)))
        });
        missing.into_iter().map(|(_, number)| seen[number].node).collect()
    }
}
