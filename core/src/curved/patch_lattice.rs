//! The triangles that a patch becomes: a lattice over its domain whose places along each side are those at which the edge is
//! cut, so that it meets whatever is across.
//!
//! ```text
//!  a lattice of 4 steps whose sides have 4, 1 and 2 pieces      places of a side that are one point draw no triangle
//!          ●                     ●
//!         ● ●                   ╱│╲
//!        ●   ●        ▶        ● │ ╲
//!       ●     ●               ╱ ╲● ╲╲
//!      ● ● ● ● ●             ●─●─●─●─●
//! ```

use glam::DVec3;

use crate::curved::edge_cuts::EdgeCuts;

/// A vertex of a patch's lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// The corner with this number.
    Corner(usize),
    /// A cut of the boundary curve with this number, counted in the canonical direction from 1 on.
    Edge(usize, u32),
    /// Whole-numbered barycentric coordinates, none 0.
    Inside([u32; 3]),
}

/// The lattice of a patch.
pub(crate) struct PatchLattice<'a> {
    /// Steps along each side of the domain, no fewer than any edge has pieces.
    pub(crate) steps: u32,
    /// Where the boundary curves are cut, and whether the canonical direction of each is not the patch's.
    pub(crate) sides: [(&'a EdgeCuts, bool); 3],
}

impl PatchLattice<'_> {
    /// Triangles, counter-clockwise.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [Place; 3]> {
        self.triangles_at().map(|(_, places)| places)
    }

    /// The same, and where their corners are in the lattice.
    pub(crate) fn triangles_at(&self) -> impl Iterator<Item = ([[u32; 3]; 3], [Place; 3])> {
        let steps = self.steps;
        let rows = (0..steps).flat_map(move |i| (0..steps - i).map(move |j| [i, j, steps - 1 - i - j]));
        let both = rows.flat_map(|[i, j, k]| {
            let upright = [[i + 1, j, k], [i, j + 1, k], [i, j, k + 1]];
            let turned = (k > 0).then(|| [[i, j + 1, k], [i + 1, j, k], [i + 1, j + 1, k.saturating_sub(1)]]);
            [Some(upright), turned.map(|[a, b, c]| [c, a, b])]
        });
        let both = both.flatten().map(|three| (three, three.map(|at| self.place(at))));
        both.filter(|(_, [a, b, c])| a != b && b != c && c != a)
    }

    /// The vertex at whole-numbered barycentric coordinates.
    pub(crate) fn place(&self, at: [u32; 3]) -> Place {
        let side = match at {
            [_, _, 0] => (0, at[1]),
            [0, _, _] => (1, at[2]),
            [_, 0, _] => (2, at[0]),
            _ => return Place::Inside(at),
        };
        self.on_side(side)
    }

    fn on_side(&self, (curve, slot): (usize, u32)) -> Place {
        let (cuts, is_reversed) = self.sides[curve];
        let slot = if is_reversed { self.steps - slot } else { slot };
        let cut = cuts.nearest(slot, self.steps);
        let is_last = cut == cuts.pieces();
        if cut == 0 || is_last {
            return Place::Corner((curve + usize::from(is_last != is_reversed)) % 3);
        }
        Place::Edge(curve, cut)
    }

    /// Barycentric coordinates in the patch.
    pub(crate) fn domain(&self, place: Place) -> DVec3 {
        match place {
            Place::Corner(corner) => DVec3::AXES[corner],
            Place::Edge(curve, cut) => {
                let (cuts, is_reversed) = self.sides[curve];
                let t = cuts.parameters[cut as usize];
                let t = if is_reversed { 1.0 - t } else { t };
                DVec3::AXES[curve].lerp(DVec3::AXES[(curve + 1) % 3], t)
            }
            Place::Inside(at) => DVec3::from_array(at.map(f64::from)) / f64::from(self.steps),
        }
    }

    /// All vertices, each once: corners, then cuts, then those inside.
    pub(crate) fn places(&self) -> impl Iterator<Item = Place> {
        let corners = (0..3).map(Place::Corner);
        let edges = (0..3).flat_map(|curve| (1..self.sides[curve].0.pieces()).map(move |cut| Place::Edge(curve, cut)));
        corners.chain(edges).chain(self.inside().map(Place::Inside))
    }

    /// Those inside, in the order of [`PatchLattice::number_inside`].
    pub(crate) fn inside(&self) -> impl Iterator<Item = [u32; 3]> + use<> {
        let steps = self.steps;
        let rows = 1..steps.saturating_sub(1);
        rows.flat_map(move |i| (1..steps - i).map(move |j| [i, j, steps - i - j]))
    }

    /// Which of those inside this one is.
    pub(crate) fn number_inside(&self, [i, j, _]: [u32; 3]) -> u32 {
        (i - 1) * (self.steps - 1) - (i - 1) * i / 2 + j - 1
    }

    pub(crate) fn count_inside(&self) -> u32 {
        self.steps.saturating_sub(1) * self.steps.saturating_sub(2) / 2
    }

    /// The two places that a place was midway between in the lattice of half the steps; none if it was there.
    pub(crate) fn parents(&self, at: [u32; 3]) -> Option<[Place; 2]> {
        let odd = [0, 1, 2].map(|axis| at[axis] % 2);
        let step = match odd {
            [1, 1, 0] => [1, -1, 0],
            [0, 1, 1] => [0, 1, -1],
            [1, 0, 1] => [1, 0, -1],
            _ => return None,
        };
        let moved = |sign: i32| [0, 1, 2].map(|axis| at[axis].wrapping_add_signed(sign * step[axis]));
        Some([1, -1].map(|sign| self.place(moved(sign))))
    }
}

/// The sides that a triangle of a lattice touches.
pub(crate) fn sides_of(triangle: [[u32; 3]; 3]) -> impl Iterator<Item = usize> {
    let is_on = move |side: &usize| triangle.iter().any(|at| at[(side + 2) % 3] == 0);
    (0..3).filter(is_on)
}

#[cfg(test)]
#[path = "patch_lattice_tests.rs"]
mod tests;
