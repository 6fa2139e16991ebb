//! The map between a mesh's plan coordinates and a grid's, as bicubic patches over a rectangle: exact where the map is affine,
//! and as close as makes no difference for a map projection over one tile. Around a pole no patches are close: the map itself is asked
//! there.

use std::fmt;
use std::sync::Arc;

use glam::DVec2;

/// Nodes of a patch along each axis.
const NODES: usize = 4;
/// Nodes along each axis of the whole rectangle, at most.
const MOST_NODES: usize = 49;
/// Cells, or as much of the plan, by which patches may differ from the map between their nodes.
const CLOSE: f64 = 1e-4;
/// Cells or plan units by which a map may differ from an affine one and still be taken for it.
const AFFINE: f64 = 1e-8;

/// Both directions of the map.
#[derive(Clone, Debug)]
pub struct PlanMap<'a> {
    to_grid: Map<'a>,
    to_plan: Map<'a>,
    handedness: f64,
}

/// A map that can be asked from any thread.
type Exact<'a> = dyn Fn(DVec2) -> DVec2 + Send + Sync + 'a;

/// One direction of the map.
#[derive(Clone)]
enum Map<'a> {
    Patches(Bicubic),
    Exact(Arc<Exact<'a>>),
}

impl<'a> PlanMap<'a> {
    /// Fits the map over the plan rectangle `low … high`, given the exact functions in both directions.
    pub fn fit(
        low: DVec2,
        high: DVec2,
        grid: impl Fn(DVec2) -> DVec2 + Send + Sync + 'a,
        plan: impl Fn(DVec2) -> DVec2 + Send + Sync + 'a,
    ) -> Self {
        let (to_grid, is_close) = Bicubic::fit(low, high, CLOSE, &grid);
        let (grid_low, grid_high) = to_grid.extent();
        let units_in_a_cell = (high - low) / (grid_high - grid_low).max(DVec2::splat(f64::MIN_POSITIVE));
        let close = CLOSE * units_in_a_cell.max_element();
        let (to_plan, is_plan_close) = Bicubic::fit(grid_low, grid_high, close, &plan);
        Self {
            handedness: to_grid.area().signum(),
            to_plan: Map::of(to_plan, is_plan_close, plan),
            to_grid: Map::of(to_grid, is_close, grid),
        }
    }

    /// 1 where the grid turns the same way as the plan, −1 where it is its mirror image.
    #[must_use]
    pub fn handedness(&self) -> f64 {
        self.handedness
    }

    /// Whether columns and rows follow from a plan position by a few products, so that they need not be kept beside it.
    pub(crate) fn is_affine(&self) -> bool {
        matches!(&self.to_grid, Map::Patches(patches) if patches.affine.is_some())
    }

    /// Column and row under a plan position.
    #[must_use]
    pub fn grid(&self, plan: DVec2) -> DVec2 {
        self.to_grid.at(plan)
    }

    /// Plan position over a column and row.
    #[must_use]
    pub fn plan(&self, grid: DVec2) -> DVec2 {
        self.to_plan.at(grid)
    }
}

impl<'a> Map<'a> {
    fn of(patches: Bicubic, is_close: bool, exact: impl Fn(DVec2) -> DVec2 + Send + Sync + 'a) -> Self {
        if is_close {
            Self::Patches(patches)
        } else {
            Self::Exact(Arc::new(exact))
        }
    }

    #[inline]
    fn at(&self, point: DVec2) -> DVec2 {
        match self {
            Self::Patches(patches) => patches.at(point),
            Self::Exact(exact) => exact(point),
        }
    }
}

impl fmt::Debug for Map<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Patches(patches) => patches.fmt(f),
            Self::Exact(_) => f.write_str("Exact"),
        }
    }
}

/// Interpolates a map between nodes of a rectangle: in each mesh of four by the sixteen around it.
#[derive(Clone, Debug)]
struct Bicubic {
    low: DVec2,
    step: DVec2,
    /// Nodes along each axis.
    count: usize,
    /// Row by row.
    nodes: Vec<DVec2>,
    /// The same map as an origin and the images of both unit steps, where that is all there is to it.
    affine: Option<[DVec2; 3]>,
}

impl Bicubic {
    /// With as many nodes as make it that close, if that can be, and whether it is.
    fn fit(low: DVec2, high: DVec2, close: f64, map: impl Fn(DVec2) -> DVec2) -> (Self, bool) {
        let mut count = NODES;
        loop {
            let fitted = Self::through(low, high, count, &map);
            let is_close = fitted.affine.is_some() || fitted.differs(&map) <= close;
            if is_close || count == MOST_NODES {
                return (fitted, is_close);
            }
            count = 2 * count - 1;
        }
    }

    fn through(low: DVec2, high: DVec2, count: usize, map: impl Fn(DVec2) -> DVec2) -> Self {
        let step = (high - low).max(DVec2::splat(f64::MIN_POSITIVE)) / (count - 1) as f64;
        let mut fitted = Self {
            low,
            step,
            count,
            nodes: Vec::new(),
            affine: None,
        };
        fitted.nodes = (0..count * count).map(|node| map(fitted.place(node))).collect();
        let affine = fitted.through_corners();
        let at = |p: DVec2| affine[0] + affine[1] * p.x + affine[2] * p.y;
        let strays = |node: usize| (fitted.nodes[node] - at(fitted.place(node))).abs().max_element();
        if (0..fitted.nodes.len()).all(|node| strays(node) <= AFFINE) {
            fitted.affine = Some(affine);
        }
        fitted
    }

    fn place(&self, node: usize) -> DVec2 {
        self.low + self.step * DVec2::new((node % self.count) as f64, (node / self.count) as f64)
    }

    fn node(&self, across: usize, down: usize) -> DVec2 {
        self.nodes[down * self.count + across]
    }

    /// Lowest and highest coordinates of the nodes.
    fn extent(&self) -> (DVec2, DVec2) {
        let nowhere = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let nodes = self.nodes.iter();
        nodes.fold(nowhere, |(low, high), &node| (low.min(node), high.max(node)))
    }

    /// Twice the area of the image, negative where it is mirrored.
    fn area(&self) -> f64 {
        let last = self.count - 1;
        let meshes = (0..last * last).map(|mesh| {
            let (across, down) = (mesh % last, mesh / last);
            let diagonal = self.node(across + 1, down + 1) - self.node(across, down);
            diagonal.perp_dot(self.node(across, down + 1) - self.node(across + 1, down))
        });
        meshes.sum()
    }

    /// Largest difference from the map in the middle between four nodes.
    fn differs(&self, map: impl Fn(DVec2) -> DVec2) -> f64 {
        let inside = (0..self.nodes.len()).filter(|node| node % self.count + 1 < self.count);
        let middles = inside
            .take((self.count - 1) * (self.count - 1))
            .map(|node| self.place(node) + self.step / 2.0);
        let difference = |at: DVec2| (self.between_nodes(at) - map(at)).abs().max_element();
        middles.map(difference).fold(0.0, f64::max)
    }

    fn through_corners(&self) -> [DVec2; 3] {
        let last = self.count - 1;
        let first = self.node(0, 0);
        let across = (self.node(last, 0) - first) / (self.step.x * last as f64);
        let down = (self.node(0, last) - first) / (self.step.y * last as f64);
        [first - across * self.low.x - down * self.low.y, across, down]
    }

    #[inline]
    fn at(&self, point: DVec2) -> DVec2 {
        match self.affine {
            Some([origin, across, down]) => origin + across * point.x + down * point.y,
            None => self.between_nodes(point),
        }
    }

    fn between_nodes(&self, point: DVec2) -> DVec2 {
        let place = (point - self.low) / self.step;
        let [first_across, first_down] =
            [place.x, place.y].map(|at| (at.max(1.0) as usize - 1).min(self.count - NODES));
        let (across, down) = (
            lagrange(place.x - first_across as f64),
            lagrange(place.y - first_down as f64),
        );
        let mut sum = DVec2::ZERO;
        for (row, weight) in down.into_iter().enumerate() {
            let first = (first_down + row) * self.count + first_across;
            let row = &self.nodes[first..first + NODES];
            sum += weight * (row[0] * across[0] + row[1] * across[1] + row[2] * across[2] + row[3] * across[3]);
        }
        sum
    }
}

/// Weights of the cubic through the nodes 0, 1, 2, 3.
fn lagrange(x: f64) -> [f64; NODES] {
    let (a, b, c, d) = (x, x - 1.0, x - 2.0, x - 3.0);
    [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0]
}

#[cfg(test)]
#[path = "plan_tests.rs"]
mod tests;
