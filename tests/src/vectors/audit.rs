//! Which levels and closed sets are not consistent, found by plain means: a surface is consistent where every star is
//! the one that its collapse had when the log was made (Surface Partitions §2.2).

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};
use terrain_core::levels::dag::CollapseDag;

use super::input;

/// Triangles by their index in the mesh, each from its smallest corner on.
type Triangles = BTreeMap<u32, [u32; 3]>;

/// What each collapse of a log met and left.
pub(super) struct Audit {
    finest: Triangles,
    collapses: Vec<[u32; 2]>,
    star_before: Vec<Triangles>,
    star_after: Vec<Triangles>,
}

impl Audit {
    pub(super) fn new(triangles: &[[u32; 3]], collapses: &[[u32; 2]]) -> Self {
        let mut audit = Self {
            finest: (0..).zip(triangles.iter().copied().map(input::from_smallest)).collect(),
            collapses: collapses.to_vec(),
            star_before: Vec::new(),
            star_after: Vec::new(),
        };
        let mut surface = audit.finest.clone();
        for &[blue, red] in collapses {
            audit.star_before.push(star(&surface, &[blue, red]));
            surface = collapsed(&surface, blue, red);
            audit.star_after.push(star(&surface, &[red]));
        }
        audit
    }

    /// For each level that is not consistent the collapses of lower levels that meet another star.
    pub(super) fn bad_levels(&self, levels: &[u32], top_level: u32) -> Value {
        let bad = (1..=top_level).map(|level| {
            let mut surface = self.finest.clone();
            let mut faults = Vec::new();
            for (index, &[blue, red]) in self
                .collapses
                .iter()
                .enumerate()
                .filter(|&(index, _)| levels[index] < level)
            {
                if star(&surface, &[blue, red]) != self.star_before[index] {
                    faults.push(format!("collapse {index}: edge star differs"));
                }
                surface = collapsed(&surface, blue, red);
            }
            (level.to_string(), faults)
        });
        where_there_are_faults(bad)
    }

    /// For each closed set that is not consistent the collapses that could be performed or split and meet another star.
    pub(super) fn bad_sets(&self, dag: &CollapseDag, closed_sets: &[u32]) -> Value {
        where_there_are_faults(
            closed_sets
                .iter()
                .map(|&set| (self.name(set), self.faults_of_set(dag, set))),
        )
    }

    fn faults_of_set(&self, dag: &CollapseDag, set: u32) -> Vec<String> {
        let is_in = |collapse: u32| set & 1 << collapse != 0;
        let surface = self.members(set).fold(self.finest.clone(), |surface, index| {
            let [blue, red] = self.collapses[index as usize];
            collapsed(&surface, blue, red)
        });
        let fault = |index: u32| {
            let [blue, red] = self.collapses[index as usize];
            let (before, after) = (&self.star_before[index as usize], &self.star_after[index as usize]);
            if !is_in(index) {
                let possible = dag.constraints(index).iter().all(|&needed| is_in(needed));
                (possible && star(&surface, &[blue, red]) != *before)
                    .then(|| format!("collapse {index}: edge star is not the one of simplification"))
            } else {
                let possible = !dag.split_constraints(index).iter().any(|&resting| is_in(resting));
                (possible && star(&surface, &[red]) != *after)
                    .then(|| format!("split {index}: star of {red} is not the one left by the collapse"))
            }
        };
        (0..self.collapses.len() as u32).filter_map(fault).collect()
    }

    fn members(&self, set: u32) -> impl Iterator<Item = u32> + use<> {
        (0..self.collapses.len() as u32).filter(move |collapse| set & 1 << collapse != 0)
    }

    /// A set as the vectors write it: `()`, `(0,)`, `(0, 2)`.
    fn name(&self, set: u32) -> String {
        let members: Vec<String> = self.members(set).map(|collapse| collapse.to_string()).collect();
        match members.as_slice() {
            [only] => format!("({only},)"),
            _ => format!("({})", members.join(", ")),
        }
    }
}

fn where_there_are_faults(found: impl Iterator<Item = (String, Vec<String>)>) -> Value {
    let bad = found.filter(|(_, faults)| !faults.is_empty());
    Value::Object(bad.map(|(name, faults)| (name, json!(faults))).collect::<Map<_, _>>())
}

/// The triangles at one of `ends`.
fn star(surface: &Triangles, ends: &[u32]) -> Triangles {
    let is_near = |corners: &[u32; 3]| corners.iter().any(|corner| ends.contains(corner));
    let near = surface.iter().filter(|(_, corners)| is_near(corners));
    near.map(|(&index, &corners)| (index, corners)).collect()
}

fn collapsed(surface: &Triangles, blue: u32, red: u32) -> Triangles {
    let kept = surface
        .iter()
        .filter(|(_, corners)| !(corners.contains(&blue) && corners.contains(&red)));
    let moved = |corner| if corner == blue { red } else { corner };
    kept.map(|(&index, &corners)| (index, input::from_smallest(corners.map(moved))))
        .collect()
}
