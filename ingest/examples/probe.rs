//! temporary
#![allow(clippy::unwrap_used, missing_docs)]
use std::path::PathBuf;
use terrain_ingest::{Progress, ReadOptions, raster};
fn main() {
    for path in std::env::args().skip(1) {
        let started = std::time::Instant::now();
        let options = ReadOptions {
            progress: Progress::on_standard_error(),
            ..Default::default()
        };
        match raster::read(&[PathBuf::from(&path)], &options) {
            Ok(g) => {
                let (mut lo, mut hi, mut voids) = (f32::INFINITY, f32::NEG_INFINITY, 0);
                for h in &g.heights {
                    if h.is_nan() {
                        voids += 1
                    } else {
                        lo = lo.min(*h);
                        hi = hi.max(*h);
                    }
                }
                let c = glam::DVec2::new(g.columns as f64 / 2.0, g.rows as f64 / 2.0);
                println!(
                    "OK {path} {}x{} {} geo={} {lo}..{hi} voids {voids} b{:?} cell {} {} rt {:.1e} {:.2}s",
                    g.columns,
                    g.rows,
                    g.georeference.crs_name(),
                    g.georeference.is_geographic(),
                    g.georeference.geographic_bounds(),
                    g.georeference.cell_metres(c),
                    g.vertical_datum,
                    (g.georeference.grid(g.georeference.geographic(c)) - c).length(),
                    started.elapsed().as_secs_f64()
                );
            }
            Err(e) => println!("ERR {e} {:.2}s", started.elapsed().as_secs_f64()),
        }
    }
}
