//! Recorded cases of the selection, `tests/selection/cases.json`: pyramids of tiles, cameras over them, what is loaded and
//! what was drawn before, and the answers. Rust and TypeScript answer the same cases.

pub mod random;

use std::collections::BTreeSet;
use std::path::PathBuf;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use terrain_codec::address::TileAddress;
use terrain_core::selection::camera::{Camera, Ellipsoid, HalfSpace};
use terrain_core::selection::hierarchy::Level;
use terrain_core::selection::oriented_box::OrientedBox;
use terrain_core::selection::select::{Choice, Demand, Selection, select};
use terrain_tiles::pyramid::{Pyramid, Summary};

use crate::workspace;

/// A tile's zoom, column and row.
pub type Place = [u32; 3];

/// All that is in the file.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Cases {
    /// Tiles to select from.
    pub pyramids: Vec<Vec<TileRecord>>,
    /// What was asked, and the answers.
    pub cases: Vec<Case>,
}

/// A tile; metres.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct TileRecord {
    tile: Place,
    centre: [f64; 3],
    axes: [[f64; 3]; 3],
    half_sizes: [f64; 3],
    /// Of each level, coarsest first: error, triangles, bytes.
    levels: Vec<(f64, u64, u64)>,
}

/// One selection.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Case {
    /// Which of the pyramids.
    pub pyramid: usize,
    eye: [f64; 3],
    /// Normals and offsets.
    frustum: Vec<[f64; 4]>,
    pixels_per_radian: f64,
    /// None where errors may look as small as they are.
    farthest: Option<f64>,
    ground: Option<Ground>,
    tolerance: f64,
    keep: f64,
    triangles: u64,
    bytes: u64,
    /// Tiles that are loaded; none where all are.
    loaded: Option<Vec<Place>>,
    before: Vec<ChoiceRecord>,
    /// What is selected.
    pub answer: Answer,
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
struct Ground {
    centre: [f64; 3],
    axis: [f64; 3],
    equatorial: f64,
    polar: f64,
}

/// Zoom, column, row, level, and the fine sides as bits, the west side the lowest.
type ChoiceRecord = [u32; 5];

/// What a selection answers.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Answer {
    /// Tiles to draw.
    pub choices: Vec<ChoiceRecord>,
    /// Tiles to load.
    pub requests: Vec<Place>,
    /// None where the budget permits nothing but the roots at their coarsest.
    pub tolerance: Option<f64>,
}

impl Cases {
    /// Where they are recorded.
    #[must_use]
    pub fn path() -> PathBuf {
        workspace().join("tests/selection/cases.json")
    }
}

/// The hierarchy of some recorded tiles.
///
/// # Panics
/// Where the scheme has no such tile.
#[must_use]
pub fn pyramid(tiles: &[TileRecord]) -> Pyramid {
    Pyramid::new(tiles.iter().map(|tile| (address(tile.tile), tile.summary())))
}

impl TileRecord {
    fn new(address: TileAddress, bounds: OrientedBox, levels: &[Level]) -> Self {
        let level = |level: &Level| (level.error, level.triangles, level.bytes);
        Self {
            tile: place(address),
            centre: bounds.centre.to_array(),
            axes: bounds.axes.map(|axis| axis.to_array()),
            half_sizes: bounds.half_sizes,
            levels: levels.iter().map(level).collect(),
        }
    }

    fn summary(&self) -> Summary {
        let level = |&(error, triangles, bytes)| Level {
            error,
            triangles,
            bytes,
        };
        Summary {
            bounds: OrientedBox {
                centre: self.centre.into(),
                axes: self.axes.map(DVec3::from),
                half_sizes: self.half_sizes,
            },
            levels: self.levels.iter().map(level).collect(),
        }
    }
}

impl Case {
    /// From where the tiles are seen.
    #[must_use]
    pub fn camera(&self) -> Camera {
        let half_space = |&[x, y, z, offset]: &[f64; 4]| HalfSpace {
            normal: DVec3::new(x, y, z),
            offset,
        };
        let ellipsoid = |ground: Ground| Ellipsoid {
            centre: ground.centre.into(),
            axis: ground.axis.into(),
            equatorial: ground.equatorial,
            polar: ground.polar,
        };
        Camera {
            eye: self.eye.into(),
            frustum: self.frustum.iter().map(half_space).collect(),
            pixels_per_radian: self.pixels_per_radian,
            farthest: self.farthest.unwrap_or(f64::INFINITY),
            ground: self.ground.map(ellipsoid),
        }
    }

    /// How well the picture has to look.
    #[must_use]
    pub fn demand(&self) -> Demand {
        Demand {
            tolerance: self.tolerance,
            keep: self.keep,
            triangles: self.triangles,
            bytes: self.bytes,
        }
    }

    /// The tiles that are loaded; none where all are.
    #[must_use]
    pub fn loaded(&self) -> Option<BTreeSet<TileAddress>> {
        let loaded = self.loaded.as_ref()?;
        Some(loaded.iter().copied().map(address).collect())
    }

    /// What was drawn before.
    #[must_use]
    pub fn before(&self) -> Vec<Choice<TileAddress>> {
        self.before.iter().copied().map(choice).collect()
    }

    /// What is selected of a pyramid.
    #[must_use]
    pub fn selection(&self, pyramid: &Pyramid) -> Selection<TileAddress> {
        let loaded = self.loaded();
        let is_loaded = |tile| loaded.as_ref().is_none_or(|loaded| loaded.contains(&tile));
        select(pyramid, &self.camera(), &self.demand(), is_loaded, &self.before())
    }
}

impl From<&Selection<TileAddress>> for Answer {
    fn from(selection: &Selection<TileAddress>) -> Self {
        Self {
            choices: selection.choices.iter().map(record).collect(),
            requests: selection.requests.iter().copied().map(place).collect(),
            tolerance: Some(selection.tolerance).filter(|tolerance| tolerance.is_finite()),
        }
    }
}

fn place(address: TileAddress) -> Place {
    [u32::from(address.zoom), address.x, address.y]
}

#[expect(clippy::expect_used, reason = "a recorded case is right or to be recorded again")]
fn address([zoom, x, y]: Place) -> TileAddress {
    let zoom = u8::try_from(zoom).ok();
    zoom.and_then(|zoom| TileAddress::new(zoom, x, y))
        .expect("the scheme has the tile")
}

fn record(choice: &Choice<TileAddress>) -> ChoiceRecord {
    let [zoom, x, y] = place(choice.node);
    let bits = choice
        .fine_sides
        .iter()
        .enumerate()
        .map(|(side, &fine)| u32::from(fine) << side);
    [zoom, x, y, choice.level as u32, bits.sum()]
}

fn choice([zoom, x, y, level, sides]: ChoiceRecord) -> Choice<TileAddress> {
    Choice {
        node: address([zoom, x, y]),
        level: level as usize,
        fine_sides: [0, 1, 2, 3].map(|side| sides >> side & 1 == 1),
    }
}
