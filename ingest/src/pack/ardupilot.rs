//! Heights for ArduPilot, as it keeps them on its card: a file for each degree, of blocks of heights above the sea in whole metres.
//!
//! ```text
//! degrees that the archive meets ─▶ rows of blocks, where the autopilot looks for them ─▶ heights of the surface at posts ─▶ bytes
//! ```
//! What is not there is left out: a block without ground is no block, and one with some tells which squares of posts it has.

mod block;
mod lattice;

use anyhow::ensure;
use rayon::prelude::*;
use serde_json::json;
use terrain_tiles::archive::Reader;
use terrain_tiles::ground::Place;

use self::lattice::{Lattice, POSTS, STEP};
use super::choice::Choice;
use super::folder::{Folder, sums};
use super::sea_level::AboveSea;
use super::unusable::Unusable;
use crate::archive_tiles::Grounds;

/// Metres from post to post, if nothing else is asked for: what autopilots ask for.
const USUAL_SPACING: f64 = 100.0;
/// With fewer, a file has more bytes than the autopilot can count.
const LEAST_SPACING: f64 = 5.0;
/// A height is rounded by half a metre at most.
const ROUNDING: f64 = 0.5;

/// Writes the files of all degrees that `choice` means into `folder`. Gives how many blocks there are.
pub(super) fn write(
    archive: &Reader,
    choice: &Choice,
    spacing: Option<f64>,
    sea: &AboveSea,
    folder: &Folder,
) -> anyhow::Result<usize> {
    let spacing = whole_spacing(spacing)?;
    let metadata = archive.metadata();
    let zoom = choice.finest_zoom(metadata.max_zoom, |zoom| metadata.finest_error(zoom))?;
    let [west, south, east, north] = choice.bounds(metadata.bounds)?;
    let heights = Heights {
        grounds: &Grounds::of(archive),
        zoom,
        choice,
        sea,
    };
    let mut blocks = 0;
    for latitude in south.floor() as i8..north.ceil() as i8 {
        for longitude in west.floor() as i16..east.ceil() as i16 {
            let lattice = Lattice {
                longitude: (longitude + 180).rem_euclid(360) - 180,
                latitude,
                spacing,
            };
            blocks += write_degree(lattice, &heights, folder)?;
        }
    }
    if blocks == 0 {
        return Err(Unusable("there is no ground in that box".to_owned()).into());
    }
    let certified = metadata.finest_error(zoom);
    let manifest = json!({
        "generator": metadata.generator,
        "source": metadata.source.files,
        "archive": format!("{:032x}", archive.version()),
        "heights_above": sea.in_words(),
        "spacing": spacing,
        "zoom": zoom,
        "blocks": blocks,
        // Metres at posts, from the source.
        "certified_error": certified,
        "rounding_error": ROUNDING,
        "error": certified + ROUNDING,
        "files": sums(folder.path())?,
    });
    folder.write("manifest.json", &serde_json::to_vec_pretty(&manifest)?)?;
    Ok(blocks)
}

fn whole_spacing(asked: Option<f64>) -> Result<u16, Unusable> {
    let spacing = asked.unwrap_or(USUAL_SPACING);
    let is_usable = spacing.fract() == 0.0 && (LEAST_SPACING..=f64::from(u16::MAX)).contains(&spacing);
    is_usable.then_some(spacing as u16).ok_or_else(|| {
        Unusable(format!(
            "--spacing {spacing}: for ardupilot it is a whole number of metres, {LEAST_SPACING} or more"
        ))
    })
}

/// Writes the file of a degree, if that has ground.
fn write_degree(lattice: Lattice, heights: &Heights, folder: &Folder) -> anyhow::Result<usize> {
    let (rows, columns) = (lattice.rows(), lattice.blocks_in_row());
    let mut missing = 0;
    let mut blocks = 0;
    let mut bytes = Vec::new();
    for row in 0..rows {
        let of_row: Vec<_> = (0..columns)
            .into_par_iter()
            .map(|column| heights.block(lattice, [row, column]))
            .collect::<anyhow::Result<_>>()?;
        for block in of_row {
            let Some(block) = block else {
                missing += 1;
                continue;
            };
            // Blocks are at their places; where there is none before one that is there, are bytes without a version.
            bytes.resize(bytes.len() + missing * block::BYTES, 0);
            missing = 0;
            bytes.extend(block);
            blocks += 1;
        }
    }
    if blocks > 0 {
        folder.write(&name(lattice), &bytes)?;
    }
    Ok(blocks)
}

/// As the autopilot calls it.
fn name(lattice: Lattice) -> String {
    let of = |negative: char, positive: char, degrees: i16| if degrees < 0 { negative } else { positive };
    let (latitude, longitude) = (i16::from(lattice.latitude), lattice.longitude);
    format!(
        "{}{:02}{}{:03}.DAT",
        of('S', 'N', latitude),
        latitude.abs(),
        of('W', 'E', longitude),
        longitude.abs()
    )
}

/// Where heights come from.
struct Heights<'a> {
    grounds: &'a Grounds<&'a Reader>,
    zoom: u8,
    choice: &'a Choice,
    sea: &'a AboveSea,
}

impl Heights<'_> {
    /// A block as bytes, if it is meant and has ground.
    fn block(&self, lattice: Lattice, index: [u32; 2]) -> anyhow::Result<Option<Vec<u8>>> {
        if !self.choice.meets(bounds(lattice, index)) {
            return Ok(None);
        }
        let posts = (0..POSTS[0]).flat_map(|row| (0..POSTS[1]).map(move |column| [row, column]));
        let places: Vec<Place> = posts.map(|post| lattice.post(index, post)).collect();
        let found = self.grounds.heights(self.zoom, &places)?;
        if found.iter().all(Option::is_none) {
            return Ok(None);
        }
        let whole = |(height, at): (Option<f64>, &Place)| height.map(|height| self.whole(*at, height)).transpose();
        let heights: Vec<Option<i16>> = found
            .into_iter()
            .zip(&places)
            .map(whole)
            .collect::<anyhow::Result<_>>()?;
        Ok(Some(block::encode(lattice, index, &heights)))
    }

    fn whole(&self, at: Place, height: f64) -> anyhow::Result<i16> {
        let metres = self.sea.height(at.longitude, at.latitude, height)?.round();
        ensure!(
            metres > f64::from(i16::MIN) && metres <= f64::from(i16::MAX),
            "a height of {metres} m does not fit into a block"
        );
        Ok(metres as i16)
    }
}

/// West, south, east, north of the posts of a block that no other block has, too.
fn bounds(lattice: Lattice, index: [u32; 2]) -> [f64; 4] {
    let corners = [[0, 0], [STEP[0], 0], [0, STEP[1]], STEP];
    let corners = corners.map(|post| lattice.post(index, post));
    let west = corners[0].longitude.min(corners[1].longitude);
    // Across the antimeridian longitudes go on.
    let east = corners[2..]
        .iter()
        .map(|corner| corner.longitude + if corner.longitude < west { 360.0 } else { 0.0 });
    [
        west,
        corners[0].latitude,
        east.fold(west, f64::max),
        corners[3].latitude,
    ]
}
