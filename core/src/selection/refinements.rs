//! Which nodes give way to their children.

use crate::selection::hierarchy::Hierarchy;
use crate::selection::scene::Scene;

/// Nodes to be refined, by their numbers in a scene.
#[derive(Default)]
pub(super) struct Refinements {
    by_depth: Vec<Vec<usize>>,
    /// Of each node that is to be refined, what that gains, or what those gain that need it.
    gains: Vec<Option<f64>>,
}

impl Refinements {
    /// The visible nodes that are too coarse at their finest, and what their neighbours need so that whoever is refined has
    /// its neighbours of the same depth beside it.
    pub(super) fn wanted<H: Hierarchy>(scene: &mut Scene<H>, tolerance: f64, keep: f64) -> Self {
        let mut wanted = Self::default();
        let mut waiting = scene.roots.clone();
        while let Some(number) = waiting.pop() {
            if scene.level_needed(number, tolerance, keep).is_some() || !scene.is_visible(number) {
                continue;
            }
            let children = scene.children(number);
            if !children.is_empty() {
                wanted.raise(number, scene.seen[number].depth, scene.gain(number));
                waiting.extend(children);
            }
        }
        wanted.close(scene);
        wanted
    }

    fn raise(&mut self, number: usize, depth: usize, gain: f64) {
        if self.gains.len() <= number {
            self.gains.resize(number + 1, None);
        }
        if self.by_depth.len() <= depth {
            self.by_depth.resize(depth + 1, Vec::new());
        }
        if self.gains[number].is_none() {
            self.by_depth[depth].push(number);
        }
        let known = self.gains[number].unwrap_or(gain);
        self.gains[number] = Some(known.max(gain));
    }

    /// From the deepest on, for those that are added need others above them.
    fn close<H: Hierarchy>(&mut self, scene: &mut Scene<H>) {
        for depth in (1..self.by_depth.len()).rev() {
            for number in self.by_depth[depth].clone() {
                let gain = self.gains[number].unwrap_or(0.0);
                for parent in beside(scene, number).filter_map(|near| scene.seen[near].parent) {
                    self.raise(parent, depth - 1, gain);
                }
            }
        }
    }

    pub(super) fn contains(&self, number: usize) -> bool {
        self.gain(number).is_some()
    }

    pub(super) fn gain(&self, number: usize) -> Option<f64> {
        self.gains.get(number).copied().flatten()
    }

    /// Coarse before fine.
    pub(super) fn iter(&self) -> impl Iterator<Item = usize> {
        self.by_depth.iter().flatten().copied()
    }

    /// Those that what is loaded permits: all children are there, and all neighbours beside them are on the map.
    pub(super) fn allowed<H: Hierarchy>(
        &self,
        scene: &mut Scene<H>,
        is_loaded: &impl Fn(H::Node) -> bool,
    ) -> Refinements {
        let mut allowed = Self::default();
        for number in self.iter() {
            let children = scene.children(number);
            let are_loaded = children.iter().all(|&child| is_loaded(scene.seen[child].node));
            let mut parents = beside(scene, number).filter_map(|near| scene.seen[near].parent);
            if are_loaded && parents.all(|parent| allowed.contains(parent)) {
                allowed.raise(number, scene.seen[number].depth, self.gains[number].unwrap_or(0.0));
            }
        }
        allowed
    }
}

/// A node and its neighbours.
fn beside<H: Hierarchy>(scene: &mut Scene<H>, number: usize) -> impl Iterator<Item = usize> + use<H> {
    let across = scene.neighbours(number);
    [Some(number)].into_iter().chain(across).flatten()
}
