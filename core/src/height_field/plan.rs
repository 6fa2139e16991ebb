//! The map between a mesh's plan coordinates and a grid's, as a pair of bicubic polynomials over a rectangle: exact
//! where the map is affine, and as close as makes no difference for a map projection over one tile.

use glam::DVec2;

/// Nodes along each axis of the rectangle.
const NODES: usize = 4;
/// Cells or plan units by which a map may differ from an affine one and still be taken for it.
const AFFINE: f64 = 1e-8;

/// Both directions of the map.
#[derive(Clone, Debug)]
pub struct PlanMap {
    to_grid: Bicubic,
    to_plan: Bicubic,
    handedness: f64,
}

impl PlanMap {
    /// Fits the map over the plan rectangle `low … high`, given the exact functions in both directions.
    pub fn fit(low: DVec2, high: DVec2, grid: impl Fn(DVec2) -> DVec2, plan: impl Fn(DVec2) -> DVec2) -> Self {
        let to_grid = Bicubic::fit(low, high, grid);
        let corners = [low, DVec2::new(high.x, low.y), DVec2::new(low.x, high.y), high].map(|p| to_grid.at(p));
        let (grid_low, grid_high) = corners
            .iter()
            .fold((corners[0], corners[0]), |(low, high), &p| (low.min(p), high.max(p)));
        let (across, down) = (corners[1] - corners[0], corners[2] - corners[0]);
        Self {
            handedness: across.perp_dot(down).signum(),
            to_grid,
            to_plan: Bicubic::fit(grid_low, grid_high, plan),
        }
    }

    /// 1 where the grid turns the same way as the plan, −1 where it is its mirror image.
    #[must_use]
    pub fn handedness(&self) -> f64 {
        self.handedness
    }

    /// Whether columns and rows follow from a plan position by a few products, so that they need not be kept beside it.
    pub(crate) fn is_affine(&self) -> bool {
        self.to_grid.affine.is_some()
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

/// Interpolates a map at 4 × 4 nodes of a rectangle.
#[derive(Clone, Debug)]
struct Bicubic {
    low: DVec2,
    step: DVec2,
    nodes: [[DVec2; NODES]; NODES],
    /// The same map as an origin and the images of both unit steps, where that is all there is to it.
    affine: Option<[DVec2; 3]>,
}

impl Bicubic {
    fn fit(low: DVec2, high: DVec2, map: impl Fn(DVec2) -> DVec2) -> Self {
        let step = (high - low).max(DVec2::splat(f64::MIN_POSITIVE)) / (NODES - 1) as f64;
        let place = |i: usize, j: usize| low + step * DVec2::new(i as f64, j as f64);
        let nodes = std::array::from_fn(|j| std::array::from_fn(|i| map(place(i, j))));
        let mut fitted = Self {
            low,
            step,
            nodes,
            affine: None,
        };
        let affine = fitted.through_corners();
        let at = |p: DVec2| affine[0] + affine[1] * p.x + affine[2] * p.y;
        let strays = |i: usize, j: usize| (nodes[j][i] - at(place(i, j))).abs().max_element();
        if (0..NODES * NODES).all(|node| strays(node % NODES, node / NODES) <= AFFINE) {
            fitted.affine = Some(affine);
        }
        fitted
    }

    fn through_corners(&self) -> [DVec2; 3] {
        let last = NODES - 1;
        let across = (self.nodes[0][last] - self.nodes[0][0]) / (self.step.x * last as f64);
        let down = (self.nodes[last][0] - self.nodes[0][0]) / (self.step.y * last as f64);
        [self.nodes[0][0] - across * self.low.x - down * self.low.y, across, down]
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
        let (across, down) = (lagrange(place.x), lagrange(place.y));
        let mut sum = DVec2::ZERO;
        for (row, weight) in self.nodes.iter().zip(down) {
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
