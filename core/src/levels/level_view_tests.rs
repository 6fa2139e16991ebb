#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::levels::collapse_list::{ListedCollapse, to_log};
use crate::levels::replay::{Batch, Demand, Replay};

/// A fan around vertex 0 whose rim falls into vertex 1 one by one; each time vertex 1 rises by one. Raw levels 1 to 5,
/// merged in twos from the finest on.
fn fan() -> (Mesh, Replay, SurfacePartition) {
    let rim = |vertex: u32| DVec3::new((f64::from(vertex) * 0.5).cos(), (f64::from(vertex) * 0.5).sin(), 0.0);
    let positions: Vec<DVec3> = [DVec3::ZERO].into_iter().chain((1..8).map(rim)).collect();
    let mesh = Mesh {
        triangles: (1..7).map(|vertex| [0, vertex, vertex + 1]).collect(),
        positions,
    };
    let collapse = |blue: u32| ListedCollapse {
        blue,
        red: 1,
        moved_to: Some(mesh.positions[1] + DVec3::Z * f64::from(blue - 1)),
    };
    let list: Vec<ListedCollapse> = (2..6).map(collapse).collect();
    let log = to_log(&list, &mesh.positions, 1.0).unwrap();
    let replay = Replay::run(&mesh, &log, Demand::Consistent, |_| ()).unwrap();
    assert_eq!(replay.collapse_levels, [1, 2, 3, 4]);
    let batches = [1, 3, 5].map(|first_level| Batch {
        first_level,
        error: 0.0,
    });
    let partition = SurfacePartition::from_replay(&mesh, &replay, &batches).unwrap();
    (mesh, replay, partition)
}

fn height_of_red(view: &LevelView) -> f64 {
    view.positions()[1].z
}

#[test]
fn any_level_is_reached_from_any_other() {
    let (.., partition) = fan();
    for from in 0..3 {
        for to in 0..3 {
            let mut view = LevelView::new(&partition);
            view.set_level(from);
            let changed = view.set_level(to);
            let ends = [from, to].map(|level| partition.levels[level].vertex_end as usize);
            assert_eq!(changed.len(), ends[0].abs_diff(ends[1]));
            assert_eq!(view.mesh(), partition.lod(to), "from {from} to {to}");
            assert_eq!(height_of_red(&view), [4.0, 2.0, 0.0][to]);
        }
    }
}

#[test]
fn roots_are_found_through_chains_and_only_as_far_as_the_level_asks() {
    let partition = SurfacePartition {
        positions: vec![DVec3::ZERO; 4],
        blue_positions: vec![DVec3::ZERO; 4],
        representatives: vec![0, 0, 1, 2],
        triangles: Vec::new(),
        levels: (1..5)
            .map(|vertex_end| crate::levels::partition::Level {
                vertex_end,
                triangle_end: 0,
                error: 0.0,
            })
            .collect(),
    };
    let mut view = LevelView::new(&partition);
    for level in [0, 3, 1, 2, 0] {
        view.set_level(level);
        for vertex in [3, 2, 3, 0, 1] {
            assert_eq!(
                view.root(vertex),
                vertex.min(level as u32),
                "vertex {vertex} at level {level}"
            );
        }
    }
}

#[test]
fn other_attributes_follow_the_level() {
    let (mesh, replay, partition) = fan();
    let mut colours = Attribute::new((0..mesh.positions.len() as u32).collect());
    for blue in 2..6 {
        colours.collapse(blue, 1, 100 + blue);
    }
    assert_eq!(
        colours.blue[2..6],
        [1, 102, 103, 104],
        "each blue vertex keeps what the red one had"
    );
    let mut colours = colours.sorted(&replay.vertex_order());
    let mut view = LevelView::new(&partition);
    assert_eq!(colours.red[1], 105);
    let order = replay.vertex_order();
    for (level, colour) in [(1, 103), (2, 1), (1, 103), (0, 105), (2, 1)] {
        let coarser = level < view.level();
        let changed = view.set_level(level);
        if coarser {
            colours.redo(&partition.representatives, changed);
        } else {
            colours.undo(&partition.representatives, changed);
        }
        assert_eq!(colours.red[1], colour, "at level {level}");
    }
    assert_eq!(colours.red, order, "at the finest level each vertex has its own");
}
