//! Triangles that are flat in space, on the grid: below the straight interpolation of their corners' heights by the sagitta.

use glam::DVec2;

/// A mesh vertex over the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPoint {
    /// Column and row.
    pub grid: DVec2,
    /// Metres.
    pub height: f64,
}

/// A triangle that is flat in space, on the grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flat {
    pub(crate) origin: GridPoint,
    /// Metres a column and a row, at the origin.
    pub(crate) slope: DVec2,
    curvature: DVec2,
}

/// Over the longest side of a triangle, in the units of its corners.
pub(crate) fn altitude([a, b, c]: [DVec2; 3]) -> f64 {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    (b - a).perp_dot(c - a).abs() / longest.max(f64::MIN_POSITIVE)
}

impl Flat {
    /// None where the corners are on one line.
    pub(crate) fn through([a, b, c]: [GridPoint; 3], curvature: DVec2) -> Option<Self> {
        let (to_b, to_c) = (b.grid - a.grid, c.grid - a.grid);
        let area = to_b.perp_dot(to_c);
        let rise_to = |to: DVec2, height: f64| height - a.height - curvature.dot(to * to);
        let (rise_b, rise_c) = (rise_to(to_b, b.height), rise_to(to_c, c.height));
        (area != 0.0).then(|| Self {
            origin: a,
            slope: (rise_b * -to_c.perp() + rise_c * to_b.perp()) / area,
            curvature,
        })
    }

    #[inline]
    pub(crate) fn height(&self, at: DVec2) -> f64 {
        let offset = at - self.origin.grid;
        self.origin.height + (self.slope + self.curvature * offset).dot(offset)
    }
}
