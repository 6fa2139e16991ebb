//! The farthest of many places from something, without asking for each: none is farther than another by more than they are apart.

use anyhow::Result;
use glam::{DVec2, DVec3};

use super::deviation::Worst;

/// A place of the raster.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) grid: DVec2,
    /// The point of the ellipsoid there, in Earth-centred metres.
    pub(super) on_ellipsoid: DVec3,
}

/// What places may be far from.
pub(super) trait Far {
    /// Metres from it of a point of the ellipsoid; no two differ by more than they are apart.
    fn distance(&mut self, on_ellipsoid: DVec3) -> Result<f64>;

    /// Adds those of a few places that count.
    fn add(&mut self, places: &[Place], worst: &mut Worst) -> Result<()>;
}

/// The farthest of `places` that count.
pub(super) fn farthest(places: Vec<Place>, from: &mut impl Far) -> Result<Worst> {
    /// So many are looked at one by one, and no bound is asked of more than these.
    const FEW: usize = 8;
    const MANY: usize = 4096;
    let mut worst = Worst::default();
    let mut waiting = vec![places];
    while let Some(places) = waiting.pop() {
        if places.len() <= FEW {
            from.add(&places, &mut worst)?;
            continue;
        }
        let middle = places[places.len() / 2];
        let reach = || {
            let apart = places
                .iter()
                .map(|place| place.on_ellipsoid.distance(middle.on_ellipsoid));
            apart.fold(0.0, f64::max)
        };
        if places.len() > MANY || from.distance(middle.on_ellipsoid)? + reach() > worst.figure {
            waiting.extend(halves(places));
        }
    }
    Ok(worst)
}

/// Places on both sides of a line across the longer way through them.
fn halves(mut places: Vec<Place>) -> [Vec<Place>; 2] {
    let grid = places.iter().map(|place| place.grid);
    let low = grid.clone().fold(DVec2::INFINITY, DVec2::min);
    let size = grid.fold(DVec2::NEG_INFINITY, DVec2::max) - low;
    let axis = usize::from(size.y >= size.x);
    let middle = places.len() / 2;
    places.select_nth_unstable_by(middle, |a, b| a.grid[axis].total_cmp(&b.grid[axis]));
    let other = places.split_off(middle);
    [places, other]
}

#[cfg(test)]
#[path = "farthest_tests.rs"]
mod tests;
