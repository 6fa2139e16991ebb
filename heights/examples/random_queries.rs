//! Random queries a second of one thread, from a warm cache: `cargo run --release -p terrain-heights --example random_queries -- ARCHIVE
//! WEST SOUTH EAST NORTH`

use std::env;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

use terrain_heights::{Heights, Place};

const QUERIES: usize = 2_000_000;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [archive, sides @ ..] = arguments.as_slice() else {
        return Err("ARCHIVE WEST SOUTH EAST NORTH".into());
    };
    let sides: Vec<f64> = sides.iter().map(|side| side.parse()).collect::<Result<_, _>>()?;
    let [west, south, east, north] = sides[..] else {
        return Err("WEST SOUTH EAST NORTH are four numbers".into());
    };
    let heights = Heights::open(Path::new(archive), 1 << 30)?;
    let mut random = fastrand::Rng::with_seed(1);
    let places: Vec<[f64; 2]> = std::iter::repeat_with(|| {
        [
            west + random.f64() * (east - west),
            south + random.f64() * (north - south),
        ]
    })
    .take(QUERIES)
    .collect();
    for round in ["cold", "warm", "warm", "warm"] {
        let started = Instant::now();
        let mut measured = 0;
        for &[longitude, latitude] in &places {
            measured += usize::from(matches!(heights.at(longitude, latitude, u8::MAX)?, Place::Measured(..)));
        }
        let rate = QUERIES as f64 / started.elapsed().as_secs_f64();
        println!("{round}: {rate:.0} queries a second, {measured} of {QUERIES} with ground");
    }
    Ok(())
}
