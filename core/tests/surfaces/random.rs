//! Grids, and collapses of random edges, for tests and benchmarks.

use glam::DVec3;
use terrain_core::levels::collapse_log::{Band, Collapse, CollapseLog};
use terrain_core::mesh::{Mesh, plan_orientation};
use terrain_core::topology::connectivity::{Connectivity, EdgeStar};

/// A square grid of `side` times `side` vertices, one unit apart.
pub(crate) fn grid(side: u32) -> Mesh {
    let at = |row: u32, column: u32| row * side + column;
    let squares = (0..side - 1).flat_map(|row| (0..side - 1).map(move |column| (row, column)));
    let halves = |(row, column)| {
        let [a, b, c, d] = [
            at(row, column),
            at(row, column + 1),
            at(row + 1, column + 1),
            at(row + 1, column),
        ];
        [[a, b, c], [a, c, d]]
    };
    Mesh {
        positions: (0..side * side)
            .map(|vertex| DVec3::new(f64::from(vertex % side), f64::from(vertex / side), 0.0))
            .collect(),
        triangles: squares.flat_map(halves).collect(),
    }
}

/// A mesh while random edges of it collapse, so that it stays a height field.
struct RandomCollapses<'a> {
    random: &'a mut fastrand::Rng,
    connectivity: Connectivity,
    star: EdgeStar,
    positions: Vec<DVec3>,
    log: CollapseLog,
    moves: bool,
}

/// A log of at most `wanted` collapses of random edges of `mesh`; about half of them move the red vertex, if `moves`.
pub(crate) fn random_log(mesh: &Mesh, wanted: usize, moves: bool, random: &mut fastrand::Rng) -> CollapseLog {
    let mut vertices: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    random.shuffle(&mut vertices);
    log_in_order(mesh, vertices, wanted, moves, random)
}

/// The same, with blue vertices tried in the order of `vertices`, again and again.
pub(crate) fn log_in_order(
    mesh: &Mesh,
    mut vertices: Vec<u32>,
    wanted: usize,
    moves: bool,
    random: &mut fastrand::Rng,
) -> CollapseLog {
    let mut collapses = RandomCollapses {
        random,
        connectivity: Connectivity::new(mesh),
        star: EdgeStar::default(),
        positions: mesh.positions.clone(),
        log: CollapseLog::default(),
        moves,
    };
    let mut before = usize::MAX;
    while collapses.log.collapses.len() != before {
        before = collapses.log.collapses.len();
        let full = |done: &RandomCollapses| done.log.collapses.len() == wanted;
        vertices.retain(|&blue| full(&collapses) || !collapses.try_vertex(blue));
    }
    collapses.log.bands.push(Band {
        end: collapses.log.collapses.len(),
        error: 1.0,
    });
    collapses.log
}

impl RandomCollapses<'_> {
    fn try_vertex(&mut self, blue: u32) -> bool {
        let around = self
            .connectivity
            .star(blue)
            .flat_map(|triangle| self.connectivity.corners(triangle));
        let neighbours: Vec<u32> = around.filter(|&vertex| vertex != blue).collect();
        let Some(&red) = self.random.choice(&neighbours) else {
            return false;
        };
        let red_before = self.positions[red as usize];
        let red_after = match self.moves && self.random.bool() {
            true => red_before.lerp(self.positions[blue as usize], 0.25),
            false => red_before,
        };
        self.star.gather(&self.connectivity, blue, red);
        let is_valid = self.star.link_condition().is_ok() && self.stays_upright(blue, red, red_after);
        if is_valid {
            self.connectivity.collapse(&self.star, &mut Vec::new());
            self.positions[red as usize] = red_after;
            self.log.collapses.push(Collapse {
                blue,
                red,
                red_before,
                red_after,
                closes_hole: false,
            });
        }
        is_valid
    }

    fn stays_upright(&self, blue: u32, red: u32, red_after: DVec3) -> bool {
        let is_end = |vertex: u32| vertex == blue || vertex == red;
        let place = |vertex: u32| match is_end(vertex) {
            true => red_after,
            false => self.positions[vertex as usize],
        };
        let around = self.connectivity.star(blue).chain(self.connectivity.star(red));
        let mut corners = around.map(|triangle| self.connectivity.corners(triangle));
        corners.all(|triangle| {
            let is_removed = triangle.iter().filter(|&&vertex| is_end(vertex)).count() == 2;
            let [a, b, c] = triangle.map(place);
            is_removed || plan_orientation(a, b, c) > 0.0
        })
    }
}
