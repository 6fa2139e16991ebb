//! Which posts of the raster are a tile's.

use glam::DVec2;
use terrain_codec::address::TileAddress;

use super::source::{Block, Patch, Source};

/// A tile's square in longitudes and latitudes of the raster.
pub(super) struct Square {
    low: DVec2,
    high: DVec2,
}

impl Square {
    pub(super) fn new(source: &Source, address: TileAddress) -> Self {
        let low = DVec2::new(address.west() + turn(source, address), address.south());
        Self {
            low,
            high: low + address.degrees(),
        }
    }

    pub(super) fn holds(&self, place: DVec2) -> bool {
        place.cmpgt(self.low).all() && place.cmplt(self.high).all()
    }

    /// Whether the post of a patch is in the square, or on its sides and the corner of a whole cell that reaches into
    /// the square.
    pub(super) fn has_post(&self, source: &Source, patch: &Patch, (column, row): (usize, usize)) -> bool {
        let place = source.geographic(column, row);
        let on_side = || place.cmpge(self.low).all() && place.cmple(self.high).all();
        let post = DVec2::new(column as f64, row as f64);
        let reaches_in = || {
            let mut steps = patch.towards_cells(column, row);
            steps.any(|step| self.holds(source.georeference.geographic(post + step)))
        };
        self.holds(place) || (on_side() && reaches_in())
    }

    /// The posts that may be in the square; none where the raster does not reach it.
    pub(super) fn posts(&self, source: &Source) -> Option<Block> {
        const STEPS: u32 = 32;
        let [west, south, east, north] = source.georeference.geographic_bounds();
        let (low, high) = (
            self.low.max(DVec2::new(west, south)),
            self.high.min(DVec2::new(east, north)),
        );
        if !low.cmple(high).all() {
            return None;
        }
        let part = |i: u32| f64::from(i) / f64::from(STEPS);
        let points = (0..=STEPS).flat_map(|y| (0..=STEPS).map(move |x| DVec2::new(part(x), part(y))));
        let places = points.map(|at| source.georeference.grid(low + (high - low) * at));
        let around = places
            .map(|place| (place, place))
            .reduce(|(low, high), (a, b)| (low.min(a), high.max(b)));
        let (first, last) = around?;
        // What lies between the points may bend a little further.
        let slack = 3.0 + (last - first) / f64::from(STEPS);
        Some(Block::between(first - slack, last + slack, source.size()))
    }
}

/// What to add to the longitudes of a tile to have those of the raster, which never jump but may exceed 180°.
pub(super) fn turn(source: &Source, address: TileAddress) -> f64 {
    let [west, _, east, _] = source.georeference.geographic_bounds();
    let middle = address.west() + address.degrees() / 2.0;
    (((west + east) / 2.0 - middle) / 360.0).round() * 360.0
}
