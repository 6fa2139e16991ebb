//! Random queries a second of one thread, from a warm cache, at places and in a local frame: `cargo run --release -p terrain-heights --example random_queries -- ARCHIVE
//! WEST SOUTH EAST NORTH`

use std::env;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

use terrain_heights::{Frame, Heights, HeightsError, Place};

const QUERIES: usize = 2_000_000;
/// Of latitude, about.
const METRES_IN_A_DEGREE: f64 = 111_000.0;

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
    let places: Vec<[f64; 2]> = std::iter::repeat_with(|| [random.f64(), random.f64()])
        .take(QUERIES)
        .collect();
    let within = |low: f64, high: f64, share: f64| low + share * (high - low);
    count("at places", || {
        let at = places
            .iter()
            .map(|&[x, y]| heights.at(within(west, east, x), within(south, north, y), u8::MAX));
        at.map(measured).sum()
    })?;
    let (longitude, latitude) = (west.midpoint(east), south.midpoint(north));
    let frame = Frame::at(longitude, latitude, 0.0).ok_or("there is no such place")?;
    let half = (north - south) / 2.0 * METRES_IN_A_DEGREE;
    count("in a frame", || {
        let in_frame = places
            .iter()
            .map(|&[x, y]| heights.in_frame(&frame, within(-half, half, x), within(-half, half, y), u8::MAX));
        in_frame.map(measured).sum()
    })
}

fn measured(place: Result<Place, HeightsError>) -> Result<usize, HeightsError> {
    Ok(usize::from(matches!(place?, Place::Measured(..))))
}

fn count(what: &str, ask: impl Fn() -> Result<usize, HeightsError>) -> Result<(), Box<dyn Error>> {
    for round in ["cold", "warm", "warm", "warm"] {
        let started = Instant::now();
        let measured = ask()?;
        let rate = QUERIES as f64 / started.elapsed().as_secs_f64();
        println!("{what}, {round}: {rate:.0} queries a second, {measured} of {QUERIES} with ground");
    }
    Ok(())
}
