//! All collapses of a partition, taken from its arrays, and those that the encoder adds to come down to a tiny base.
//!
//! ```text
//! from the last vertex to the first beyond level 0:    collapse it into its representative again
//! as long as there is any:                             collapse edges whose stars do not touch, the flattest first,
//!                                                      and those that change the outline after all others
//! ```

use glam::DVec3;
use terrain_core::levels::dag::{CollapseDag, DagBuilder};
use terrain_core::levels::replay::Step;
use terrain_core::topology::connectivity::{Connectivity, EdgeStar};
use terrain_core::{Collapse, Mesh, SurfacePartition};

use super::flatness::{Flatness, Neighbourhood};
use super::ring::Side;

/// Stands for no collapse.
pub(super) const NONE: u32 = u32::MAX;

/// A collapse as its split will need it, by the partition's vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Undo {
    pub(super) blue: u32,
    pub(super) side: Side,
    /// The vertices at the cuts, where there are such.
    pub(super) cuts: [Option<u32>; 2],
    pub(super) red_before: DVec3,
    /// The collapse into `red` before this one.
    pub(super) earlier: u32,
    /// Level of the vertex that it removed.
    pub(super) level: u32,
}

/// All collapses, finest first, and what is left.
pub(super) struct Collapses {
    pub(super) undos: Vec<Undo>,
    pub(super) dag: CollapseDag,
    /// For each vertex the last collapse into it.
    pub(super) last_into: Vec<u32>,
    /// Triangles that were never removed.
    pub(super) base_triangles: Vec<[u32; 3]>,
    /// Whether each vertex was never removed.
    pub(super) is_base: Vec<bool>,
}

/// The vertex whose collapse into its representative leaves no surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NotASplit(pub(super) usize);

/// Finds all collapses of a valid partition.
pub(super) fn unravel(partition: &SurfacePartition, is_height_field: bool) -> Result<Collapses, NotASplit> {
    let mut unraveller = Unraveller::new(partition);
    unraveller.collapse_levels()?;
    for may_move_outline in [false, true] {
        let flatness = Flatness {
            positions: &partition.positions,
            is_height_field,
            may_move_outline,
        };
        while unraveller.collapse_flattest(&flatness) > 0 {}
    }
    Ok(unraveller.finish())
}

struct Unraveller<'a> {
    partition: &'a SurfacePartition,
    connectivity: Connectivity,
    is_triangle: Vec<bool>,
    is_vertex: Vec<bool>,
    undos: Vec<Undo>,
    dag: DagBuilder,
    last_into: Vec<u32>,
    star: EdgeStar,
    moved: Vec<u32>,
}

impl<'a> Unraveller<'a> {
    fn new(partition: &'a SurfacePartition) -> Self {
        let count = partition.positions.len();
        Self {
            partition,
            connectivity: Connectivity::new(&Mesh {
                positions: partition.positions.clone(),
                triangles: partition.triangles.clone(),
            }),
            is_triangle: vec![true; partition.triangles.len()],
            is_vertex: vec![true; count],
            undos: Vec::with_capacity(count),
            dag: DagBuilder::new(count),
            last_into: vec![NONE; count],
            star: EdgeStar::default(),
            moved: Vec::new(),
        }
    }

    fn collapse_levels(&mut self) -> Result<(), NotASplit> {
        let levels = &self.partition.levels;
        for level in (1..levels.len()).rev() {
            for blue in (levels[level - 1].vertex_end..levels[level].vertex_end).rev() {
                let red = self.partition.representatives[blue as usize];
                self.star.gather(&self.connectivity, blue, red);
                let red_before = self.partition.blue_positions[blue as usize];
                self.perform(blue, red, red_before, level as u32)
                    .ok_or(NotASplit(blue as usize))?;
            }
        }
        Ok(())
    }

    /// Collapses edges, those first that change the surface least, and none of which the triangles of the blue vertex are no
    /// longer what they were; tells how many.
    fn collapse_flattest(&mut self, flatness: &Flatness) -> usize {
        let mut candidates = self.candidates(flatness);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut is_touched = vec![false; self.is_vertex.len()];
        let mut around = Neighbourhood::default();
        let mut count = 0;
        for (_, blue, red) in candidates {
            around.gather(&self.connectivity, blue);
            if is_touched[blue as usize] || around.neighbours().any(|vertex| is_touched[vertex as usize]) {
                continue;
            }
            self.star.gather(&self.connectivity, blue, red);
            let red_position = self.partition.positions[red as usize];
            if self.star.link_condition().is_ok() && self.perform(blue, red, red_position, 0).is_some() {
                is_touched[red as usize] = true;
                count += 1;
            }
        }
        count
    }

    /// For each vertex the cheapest collapse that is allowed: its cost, blue, red.
    fn candidates(&mut self, flatness: &Flatness) -> Vec<(f64, u32, u32)> {
        let mut candidates = Vec::new();
        let [mut around_blue, mut around_red] = [Neighbourhood::default(), Neighbourhood::default()];
        let mut costs = Vec::new();
        for blue in (0..self.is_vertex.len() as u32).filter(|&vertex| self.is_vertex[vertex as usize]) {
            around_blue.gather(&self.connectivity, blue);
            if !around_blue.is_disk() {
                continue;
            }
            costs.clear();
            let cost = |&red: &u32| Some((flatness.cost(&self.connectivity, &around_blue, blue, red)?, red));
            costs.extend(around_blue.neighbours().filter_map(|red| cost(&red)));
            costs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let allowed = costs.iter().find(|&&(_, red)| {
                self.star.gather(&self.connectivity, blue, red);
                around_red.gather(&self.connectivity, red);
                around_red.is_disk() && around_red.may_grow(&around_blue) && self.star.link_condition().is_ok()
            });
            candidates.extend(allowed.map(|&(cost, red)| (cost, blue, red)));
        }
        candidates
    }

    /// Performs the collapse whose star was gathered, if it is one of a surface.
    fn perform(&mut self, blue: u32, red: u32, red_before: DVec3, level: u32) -> Option<()> {
        let (side, cuts) = self.opening(blue, red)?;
        let collapse = Collapse {
            blue,
            red,
            red_before,
            red_after: red_before,
            closes_hole: side.opens_hole(),
        };
        self.connectivity.collapse(&self.star, &mut self.moved);
        let index = self.undos.len() as u32;
        self.dag.add(&Step {
            index,
            collapse,
            level,
            star: &self.star,
            moved: &self.moved,
        });
        for &triangle in self.star.removed() {
            self.is_triangle[triangle as usize] = false;
        }
        self.is_vertex[blue as usize] = false;
        let earlier = std::mem::replace(&mut self.last_into[red as usize], index);
        self.undos.push(Undo {
            blue,
            side,
            cuts,
            red_before,
            earlier,
            level,
        });
        Some(())
    }

    /// Where the split will open the star: the corners across the edge, that of (red, x, blue) first.
    fn opening(&self, blue: u32, red: u32) -> Option<(Side, [Option<u32>; 2])> {
        let mut cuts = [None; 2];
        for &triangle in self.star.removed() {
            let corners = self.connectivity.corners(triangle);
            let at = corners.iter().position(|&corner| corner == red)?;
            let [after, before] = [corners[(at + 1) % 3], corners[(at + 2) % 3]];
            let (place, third) = if before == blue { (0, after) } else { (1, before) };
            if cuts[place].replace(third).is_some() {
                return None;
            }
        }
        let mut ends = [Neighbourhood::default(), Neighbourhood::default()];
        ends[0].gather(&self.connectivity, blue);
        ends[1].gather(&self.connectivity, red);
        if !ends.iter().all(Neighbourhood::is_disk) {
            return None;
        }
        let [blue_is_open, red_is_open] = ends.each_ref().map(Neighbourhood::is_open);
        if let Some(third) = self.third_of_hole(blue, red) {
            return match cuts {
                [Some(first), None] => Some((Side::HoleSecond, [Some(first), Some(third)])),
                [None, Some(second)] => Some((Side::HoleFirst, [Some(third), Some(second)])),
                _ => None,
            };
        }
        let side = match cuts {
            [Some(_), Some(_)] if blue_is_open && red_is_open => return None,
            [Some(_), Some(_)] if blue_is_open => Side::Outer,
            [Some(_), Some(_)] => Side::Inner,
            [None, Some(_)] => Side::Front,
            [Some(_), None] => Side::Back,
            [None, None] => return None,
        };
        Some((side, if side == Side::Outer { [cuts[1], cuts[0]] } else { cuts }))
    }

    /// The third vertex of the hole of three vertices beside an edge, if there is one.
    fn third_of_hole(&self, blue: u32, red: u32) -> Option<u32> {
        let &[beside] = self.star.removed() else { return None };
        let ends = self.connectivity.along_boundary(blue)?;
        let third = ends.into_iter().find(|&end| end != red)?;
        let is_between = |corner: u32, ends: [u32; 2]| {
            self.connectivity.along_boundary(corner) == Some([ends[0].min(ends[1]), ends[0].max(ends[1])])
        };
        let is_hole = !self.connectivity.corners(beside).contains(&third)
            && is_between(red, [blue, third])
            && is_between(third, [blue, red]);
        is_hole.then_some(third)
    }

    fn finish(self) -> Collapses {
        let triangles = (0..).zip(&self.is_triangle).filter(|(_, is_triangle)| **is_triangle);
        Collapses {
            base_triangles: triangles
                .map(|(triangle, _)| self.connectivity.corners(triangle))
                .collect(),
            is_base: self.is_vertex,
            undos: self.undos,
            dag: self.dag.finish(),
            last_into: self.last_into,
        }
    }
}
