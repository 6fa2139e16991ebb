//! What an archive says of itself that holds nothing.

use terrain_tiles::metadata::{Asked, FORMAT, Metadata, Source, VERSION};
use terrain_tiles::outside::Outside;
use terrain_tiles::water::Water;

/// One zoom over a degree at 0° N, 0° E.
pub(crate) fn metadata() -> Metadata {
    Metadata {
        format: FORMAT.to_owned(),
        version: VERSION,
        scheme: "geographic-tms".to_owned(),
        bounds: [0.0, 0.0, 1.0, 1.0],
        heights: [0.0, 0.0],
        min_zoom: 0,
        max_zoom: 0,
        bound: "surface".to_owned(),
        max_error: 1.0,
        asked: Asked::default(),
        plan: String::new(),
        source: Source {
            files: Vec::new(),
            crs: "EPSG:4326".to_owned(),
            vertical_datum: "unspecified".to_owned(),
            heights_above: String::new(),
            geoid: None,
            samples: [2, 2],
            heights: None,
        },
        generator: "test".to_owned(),
        outside: Outside::default(),
        water: Water::default(),
        zooms: Vec::new(),
    }
}
