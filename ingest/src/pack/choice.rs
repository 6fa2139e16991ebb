//! Which part of an archive goes into a pack.

use std::collections::BTreeSet;

use terrain_codec::address::TileAddress;
use terrain_tiles::archive::Reader;

use super::area::Area;
use super::unusable::Unusable;

/// Which tiles go into a pack.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// West, south, east, north in degrees that they must meet; east may exceed 180.
    pub bbox: Option<[f64; 4]>,
    /// Polygons that they must touch.
    pub area: Option<Area>,
    /// The finest zoom.
    pub max_zoom: Option<u8>,
    /// Metres: no zoom finer than the first whose certified error is within it.
    pub max_error: Option<f64>,
}

impl Choice {
    /// Whether a box in degrees meets what is asked for: `bbox` by more than its side.
    pub(super) fn meets(&self, [left, low, right, high]: [f64; 4]) -> bool {
        let is_in_box = |turn: f64| {
            self.bbox.is_none_or(|[west, south, east, north]| {
                left + turn < east && right + turn > west && low < north && high > south
            })
        };
        let touches = |turn: f64| {
            let turned = [left + turn, low, right + turn, high];
            self.area.as_ref().is_none_or(|area| area.touches(turned))
        };
        TURNS.into_iter().any(is_in_box) && TURNS.into_iter().any(touches)
    }

    /// The tiles of `archive` that it means, of any zoom.
    pub(super) fn tiles(&self, archive: &Reader) -> BTreeSet<TileAddress> {
        let mut met = BTreeSet::new();
        // Coarse zooms come first, and what does not meet a tile does not meet those below it.
        for address in archive.addresses() {
            let (west, south, side) = (address.west(), address.south(), address.degrees());
            let may_meet = address.parent().is_none_or(|parent| met.contains(&parent));
            if may_meet && self.meets([west, south, west + side, south + side]) {
                met.insert(address);
            }
        }
        met
    }

    /// The finest zoom of those up to `finest`, of which `error` tells the certified error.
    pub(super) fn finest_zoom(&self, finest: u8, error: impl Fn(u8) -> f64) -> Result<u8, Unusable> {
        let finest = self.max_zoom.unwrap_or(finest).min(finest);
        let Some(asked) = self.max_error else {
            return Ok(finest);
        };
        let found = (0..=finest).find(|&zoom| error(zoom) <= asked);
        found.ok_or_else(|| {
            let least = (error(finest) * 100.0).ceil() / 100.0;
            Unusable(format!(
                "the error of zoom {finest} is {least:.2} m, no finer zoom of this part is within {asked} m"
            ))
        })
    }

    /// West, south, east, north of what is both in `whole` and asked for.
    pub(super) fn bounds(&self, whole: [f64; 4]) -> Result<[f64; 4], Unusable> {
        let area = self.area.as_ref().map(Area::bounds);
        let mut wanted = self.bbox.into_iter().chain(area);
        let common = wanted.try_fold(whole, common);
        common.ok_or_else(|| Unusable("the archive has nothing there".to_owned()))
    }
}

/// Degrees from a longitude to the same one turn away.
const TURNS: [f64; 3] = [0.0, 360.0, -360.0];

/// What two boxes have in common, in longitudes of the first.
fn common(one: [f64; 4], [west, south, east, north]: [f64; 4]) -> Option<[f64; 4]> {
    TURNS.into_iter().find_map(|turn| {
        let [west, east] = [(west + turn).max(one[0]), (east + turn).min(one[2])];
        let [south, north] = [south.max(one[1]), north.min(one[3])];
        (west < east && south < north).then_some([west, south, east, north])
    })
}
