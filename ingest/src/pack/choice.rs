//! Which part of an archive goes into a pack.

use terrain_tiles::address::TileAddress;
use terrain_tiles::archive::Reader;

use super::unusable::Unusable;

/// Which tiles go into a pack.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// West, south, east, north in degrees that they must meet; east may exceed 180.
    pub bbox: Option<[f64; 4]>,
    /// The finest zoom.
    pub max_zoom: Option<u8>,
    /// Metres: no zoom finer than the first whose certified error is within it.
    pub max_error: Option<f64>,
}

impl Choice {
    /// Whether a box in degrees meets what is asked for by more than its side.
    pub(super) fn meets(&self, [left, low, right, high]: [f64; 4]) -> bool {
        let Some([west, south, east, north]) = self.bbox else {
            return true;
        };
        let is_across = [-360.0, 0.0, 360.0]
            .iter()
            .any(|turn| left + turn < east && right + turn > west);
        is_across && low < north && high > south
    }

    /// The tiles of `archive` that it means, of any zoom.
    pub(super) fn tiles<'a>(&'a self, archive: &'a Reader) -> impl Iterator<Item = TileAddress> + 'a {
        archive.addresses().filter(|address| {
            let (west, south, side) = (address.west(), address.south(), address.degrees());
            self.meets([west, south, west + side, south + side])
        })
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
        let Some([west, south, east, north]) = self.bbox else {
            return Ok(whole);
        };
        let common = |turn: f64| {
            let [west, east] = [(west + turn).max(whole[0]), (east + turn).min(whole[2])];
            let [south, north] = [south.max(whole[1]), north.min(whole[3])];
            (west < east && south < north).then_some([west, south, east, north])
        };
        let found = [0.0, 360.0, -360.0].into_iter().find_map(common);
        found.ok_or_else(|| Unusable("the archive has nothing in that box".to_owned()))
    }
}
