//! What one selection has found out about nodes, each asked for once and numbered as it is met.

use rustc_hash::FxHashMap;

use smallvec::SmallVec;

use crate::selection::camera::{Camera, Sight};
use crate::selection::hierarchy::{Hierarchy, Level};
use crate::selection::oriented_box::OrientedBox;

/// How many levels finer than its coarsest a node was drawn, beyond its finest where its children were drawn.
pub(super) type Before<N> = FxHashMap<N, usize>;

/// A node that was met.
pub(super) struct Seen<'a, N> {
    pub(super) node: N,
    pub(super) levels: &'a [Level],
    pub(super) parent: Option<usize>,
    pub(super) depth: usize,
    /// Of the eye from the nearest point of its box.
    pub(super) distance: f64,
    /// The level that it was drawn at; the number of its levels if it was refined; 0 if it was not drawn.
    before: usize,
    bounds: OrientedBox,
    children: Option<SmallVec<[usize; 4]>>,
    is_visible: Option<bool>,
}

/// The nodes that were met.
pub(super) struct Scene<'a, H: Hierarchy> {
    hierarchy: &'a H,
    camera: &'a Camera,
    sight: Sight<'a>,
    before: Before<H::Node>,
    numbers: FxHashMap<H::Node, usize>,
    pub(super) seen: Vec<Seen<'a, H::Node>>,
    pub(super) roots: Vec<usize>,
}

impl<'a, H: Hierarchy> Scene<'a, H> {
    pub(super) fn new(hierarchy: &'a H, camera: &'a Camera, before: Before<H::Node>) -> Self {
        let mut scene = Self {
            hierarchy,
            camera,
            sight: camera.sight(),
            before,
            numbers: FxHashMap::default(),
            seen: Vec::new(),
            roots: Vec::new(),
        };
        scene.roots = hierarchy.roots().map(|root| scene.meet(root, None)).collect();
        scene
    }

    fn meet(&mut self, node: H::Node, parent: Option<usize>) -> usize {
        let bounds = self.hierarchy.bounds(node);
        self.numbers.insert(node, self.seen.len());
        self.seen.push(Seen {
            node,
            levels: self.hierarchy.levels(node),
            parent,
            depth: parent.map_or(0, |parent| self.seen[parent].depth + 1),
            distance: bounds.distance(self.camera.eye),
            before: self.before.get(&node).copied().unwrap_or(0),
            bounds,
            children: None,
            is_visible: None,
        });
        self.seen.len() - 1
    }

    fn number(&mut self, node: H::Node) -> usize {
        if let Some(&number) = self.numbers.get(&node) {
            return number;
        }
        let parent = self.hierarchy.parent(node).map(|parent| self.number(parent));
        self.meet(node, parent)
    }

    pub(super) fn children(&mut self, number: usize) -> SmallVec<[usize; 4]> {
        if let Some(children) = &self.seen[number].children {
            return children.clone();
        }
        let (hierarchy, node) = (self.hierarchy, self.seen[number].node);
        let child = |child| match self.numbers.get(&child) {
            Some(&known) => known,
            None => self.meet(child, Some(number)),
        };
        let children: SmallVec<[usize; 4]> = hierarchy.children(node).map(child).collect();
        self.seen[number].children = Some(children.clone());
        children
    }

    pub(super) fn neighbours(&mut self, number: usize) -> [Option<usize>; 4] {
        let across = self.hierarchy.neighbours(self.seen[number].node);
        across.map(|near| near.map(|near| self.number(near)))
    }

    pub(super) fn is_visible(&mut self, number: usize) -> bool {
        let seen = &mut self.seen[number];
        *seen.is_visible.get_or_insert_with(|| self.sight.sees(&seen.bounds))
    }

    /// Error of a level on the screen, pixels.
    pub(super) fn pixels(&self, number: usize, error: f64) -> f64 {
        self.camera.pixels(error, self.seen[number].distance)
    }

    /// The coarsest level whose error on the screen is at most `tolerance` pixels, or at most `keep` of that where a finer
    /// one was drawn before; none if none is good enough.
    pub(super) fn level_needed(&self, number: usize, tolerance: f64, keep: f64) -> Option<usize> {
        let seen = &self.seen[number];
        seen.levels.iter().enumerate().position(|(index, level)| {
            let share = if index < seen.before { keep } else { 1.0 };
            self.pixels(number, level.error) <= tolerance * share
        })
    }

    /// What refining a node makes better on the screen: its error there × its area there, cubic pixels; infinite where the
    /// eye is in its box.
    pub(super) fn gain(&self, number: usize) -> f64 {
        let seen = &self.seen[number];
        if seen.distance == 0.0 {
            return f64::INFINITY;
        }
        let radian = self.camera.pixels_per_radian;
        let area = seen.bounds.solid_angle(self.camera.eye) * radian * radian;
        seen.levels.last().map_or(0.0, |level| self.pixels(number, level.error)) * area
    }
}
