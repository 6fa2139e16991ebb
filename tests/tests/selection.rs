//! The recorded cases of the selection: their answers, and what every answer has to be like.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::collections::BTreeSet;

use terrain_codec::address::{Side, TileAddress};
use terrain_core::selection::hierarchy::Hierarchy;
use terrain_core::selection::select::{Selection, select};
use terrain_tests::selection::{Answer, Case, Cases, pyramid, random};
use terrain_tiles::pyramid::Pyramid;

/// A case and what is selected.
struct Answered<'a> {
    case: &'a Case,
    pyramid: &'a Pyramid,
    selection: Selection<TileAddress>,
    drawn: BTreeSet<TileAddress>,
}

fn visit(cases: &Cases, mut check: impl FnMut(&Answered)) {
    let pyramids: Vec<Pyramid> = cases.pyramids.iter().map(|tiles| pyramid(tiles)).collect();
    for case in &cases.cases {
        let pyramid = &pyramids[case.pyramid];
        let selection = case.selection(pyramid);
        let drawn = selection.choices.iter().map(|choice| choice.node).collect();
        check(&Answered {
            case,
            pyramid,
            selection,
            drawn,
        });
    }
}

impl Answered<'_> {
    fn is_loaded(&self, tile: TileAddress) -> bool {
        self.case.loaded().is_none_or(|loaded| loaded.contains(&tile))
    }

    /// Whether a finer tile is directly across a side of another, where this one has something to show.
    fn touches(&self, fine: TileAddress, coarse: TileAddress, side: Side) -> bool {
        let back = Side::ALL[(side as usize + 2) % 4];
        let beside = fine.neighbour(back);
        let child = beside.and_then(|beside| ancestors(beside).find(|above| above.parent() == Some(coarse)));
        child.is_some_and(|child| self.pyramid.contains(child)) && ancestors(fine).all(|above| above != coarse)
    }

    fn is_refined(&self, tile: TileAddress) -> bool {
        self.drawn
            .iter()
            .any(|&drawn| ancestors(drawn).any(|above| above == tile))
    }
}

fn ancestors(tile: TileAddress) -> impl Iterator<Item = TileAddress> {
    std::iter::successors(tile.parent(), |tile| tile.parent())
}

fn recorded() -> Cases {
    serde_json::from_str(&std::fs::read_to_string(Cases::path()).unwrap()).unwrap()
}

/// Others than those on record.
fn random_cases() -> Cases {
    random::cases(60, 20, 4711)
}

#[test]
fn recorded_cases_are_answered_as_recorded() {
    let mut count = 0;
    visit(&recorded(), |answered| {
        assert_eq!(Answer::from(&answered.selection), answered.case.answer, "case {count}");
        count += 1;
    });
    assert!(count >= 300, "{count}");
}

#[test]
fn recorded_cases_have_all_that_makes_a_selection_hard() {
    let (mut fine, mut loading, mut over_budget, mut followed, mut deep) = (0, 0, 0, 0, 0);
    visit(&recorded(), |answered| {
        let Selection { choices, requests, .. } = &answered.selection;
        fine += usize::from(choices.iter().any(|choice| choice.fine_sides.contains(&true)));
        loading += usize::from(!requests.is_empty());
        over_budget += usize::from(answered.selection.tolerance > answered.case.demand().tolerance);
        deep += usize::from(choices.iter().any(|choice| choice.node.zoom > 4));
        let demand = answered.case.demand();
        let camera = answered.case.camera();
        let afresh = select(answered.pyramid, &camera, &demand, |tile| answered.is_loaded(tile), &[]);
        followed += usize::from(afresh != answered.selection);
    });
    let counts = [fine, loading, over_budget, followed, deep];
    assert!(counts.iter().all(|&count| count >= 15), "{counts:?}");
}

#[test]
fn what_is_drawn_is_loaded_and_covers_each_place_once() {
    visit(&random_cases(), |answered| {
        assert!(answered.drawn.iter().all(|&tile| answered.is_loaded(tile)));
        assert_eq!(answered.drawn.len(), answered.selection.choices.len());
        for &tile in &answered.drawn {
            assert!(
                ancestors(tile).all(|above| !answered.drawn.contains(&above)),
                "{tile} is drawn twice"
            );
        }
        let mut waiting: Vec<_> = answered
            .pyramid
            .roots()
            .filter(|&root| answered.is_loaded(root))
            .collect();
        while let Some(tile) = waiting.pop() {
            if !answered.drawn.contains(&tile) {
                let children: Vec<_> = answered.pyramid.children(tile).collect();
                assert!(!children.is_empty(), "nothing is drawn at {tile}");
                waiting.extend(children);
            }
        }
    });
}

#[test]
fn a_side_is_fine_if_and_only_if_finer_tiles_are_across() {
    let mut finer = 0;
    visit(&random_cases(), |answered| {
        for choice in &answered.selection.choices {
            for side in Side::ALL {
                let across = choice.node.neighbour(side);
                let is_finer = across.is_some_and(|across| answered.is_refined(across));
                assert_eq!(
                    choice.fine_sides[side as usize], is_finer,
                    "{side:?} of {}",
                    choice.node
                );
                finer += usize::from(is_finer);
                let too_fine =
                    |tile: &TileAddress| tile.zoom > choice.node.zoom + 1 && answered.touches(*tile, choice.node, side);
                assert!(!answered.drawn.iter().any(too_fine), "{side:?} of {}", choice.node);
            }
            let finest = answered.pyramid.levels(choice.node).len() - 1;
            assert!(choice.level == finest || choice.fine_sides == [false; 4]);
        }
    });
    assert!(finer > 1000, "{finer}");
}

#[test]
fn what_is_in_sight_keeps_the_tolerance_once_all_is_loaded() {
    let mut seen = 0;
    visit(&random_cases(), |answered| {
        if answered.case.loaded().is_some() {
            return;
        }
        assert_eq!(answered.selection.requests, []);
        let camera = answered.case.camera();
        for choice in &answered.selection.choices {
            let bounds = answered.pyramid.bounds(choice.node);
            let error = answered.pyramid.levels(choice.node)[choice.level].error;
            let pixels = camera.pixels(error, bounds.distance(camera.eye));
            let is_deepest = answered.pyramid.children(choice.node).next().is_none();
            assert!(
                pixels <= answered.selection.tolerance || is_deepest || !camera.sight().sees(&bounds),
                "{}: {pixels}",
                choice.node
            );
            seen += usize::from(!is_deepest && camera.sight().sees(&bounds));
        }
    });
    assert!(seen > 300, "{seen}");
}

#[test]
fn budgets_are_kept_and_used() {
    let (mut raised, mut used) = (0, 0);
    visit(&random_cases(), |answered| {
        let demand = answered.case.demand();
        let (mut triangles, mut bytes) = (0, 0);
        let camera = answered.case.camera();
        for choice in &answered.selection.choices {
            let level = answered.pyramid.levels(choice.node)[choice.level];
            bytes += level.bytes;
            if camera.sight().sees(&answered.pyramid.bounds(choice.node)) {
                triangles += level.triangles;
            }
        }
        let is_within = triangles <= demand.triangles && bytes <= demand.bytes;
        let coarsest = answered
            .selection
            .choices
            .iter()
            .all(|choice| choice.node.zoom == 0 && choice.level == 0);
        assert!(is_within || (answered.selection.tolerance.is_infinite() && coarsest));
        if answered.selection.tolerance > demand.tolerance {
            raised += 1;
            used += usize::from(2 * triangles > demand.triangles || 2 * bytes > demand.bytes);
        }
    });
    assert!(raised > 100 && 2 * used > raised, "{used} of {raised}");
}

#[test]
fn loading_what_is_asked_for_one_by_one_ends_with_the_whole_picture() {
    visit(&random::cases(20, 6, 99), |answered| {
        let (pyramid, camera, demand) = (answered.pyramid, answered.case.camera(), answered.case.demand());
        let whole = select(pyramid, &camera, &demand, |_| true, &[]);
        let mut loaded = BTreeSet::new();
        let mut selection = select(pyramid, &camera, &demand, |tile| loaded.contains(&tile), &[]);
        while let Some(&next) = selection.requests.first() {
            let is_next = next.parent().is_none_or(|parent| loaded.contains(&parent));
            assert!(is_next, "{next} before its parent");
            loaded.insert(next);
            selection = select(pyramid, &camera, &demand, |tile| loaded.contains(&tile), &[]);
        }
        assert_eq!(selection, whole);
    });
}

#[test]
fn a_picture_stays_where_it_is_until_it_is_much_too_fine() {
    let mut kept = 0;
    visit(&random_cases(), |answered| {
        let (camera, demand) = (answered.case.camera(), answered.case.demand());
        if demand.keep == 1.0 || answered.case.loaded().is_some() {
            return;
        }
        let selected = |tolerance: f64, before: &[_]| {
            let demand = terrain_core::selection::select::Demand {
                tolerance,
                triangles: u64::MAX,
                bytes: u64::MAX,
                ..demand
            };
            select(answered.pyramid, &camera, &demand, |_| true, before)
        };
        let fine = selected(demand.tolerance, &[]);
        let [slightly, much] =
            [0.99, 0.49].map(|share| selected(demand.tolerance / demand.keep * share, &fine.choices));
        assert_eq!(slightly.choices, fine.choices);
        let afresh = selected(demand.tolerance / demand.keep * 0.99, &[]);
        kept += usize::from(afresh.choices != fine.choices);
        assert!(much.choices.len() >= fine.choices.len());
    });
    assert!(kept > 20, "{kept}");
}
