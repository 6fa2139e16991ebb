//! The decoder of tiles for browsers: `terrain_codec::spt` as WebAssembly, its arrays as JavaScript has them. What calls it is `spt.ts` of
//! the page.

use terrain_codec::{DecodeError, LevelLimits, spt};
use terrain_core::SurfacePartition;
use terrain_core::levels::partition::Level;
use wasm_bindgen::JsError;
use wasm_bindgen::prelude::wasm_bindgen;

/// What a tile may ask of the browser; far above any real tile, far below what would hurt.
const TILE_LIMITS: LevelLimits = LevelLimits {
    levels: 256,
    vertices: 1 << 20,
    triangles: 1 << 21,
};

/// A tile while its bytes come in; see [`spt::TileDecoder`].
#[derive(Debug)]
#[wasm_bindgen]
pub struct TileDecoder(spt::TileDecoder);

#[wasm_bindgen]
impl TileDecoder {
    /// Begins with a tile's first bytes; none if they end before the levels begin.
    ///
    /// # Errors
    /// When they are not the beginning of a tile.
    pub fn begin(first: &[u8]) -> Result<Option<TileDecoder>, JsError> {
        match spt::TileDecoder::new(first, &TILE_LIMITS) {
            Ok(decoder) => Ok(Some(Self(decoder))),
            Err(DecodeError::Truncated(_)) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Goes on with the bytes that come next.
    ///
    /// # Errors
    /// When they make no surface, or are too many. Then the decoder is of no more use.
    pub fn add(&mut self, bytes: &[u8]) -> Result<(), JsError> {
        Ok(self.0.add(bytes)?)
    }

    /// Decodes what is there of the level that is not whole: nothing more comes.
    ///
    /// # Errors
    /// When its bytes make no surface.
    pub fn cut(&mut self) -> Result<(), JsError> {
        Ok(self.0.cut()?)
    }

    /// Zoom, column and row.
    #[must_use]
    pub fn address(&self) -> Vec<u32> {
        let address = self.0.address();
        vec![u32::from(address.zoom), address.x, address.y]
    }

    /// A bit for each cell of the tile whose ground was filled; none where all was measured.
    #[must_use]
    pub fn filled(&self) -> Option<Vec<u8>> {
        let filled = self.0.filled();
        (!filled.is_empty()).then(|| filled.bits())
    }

    /// Bytes of the tile up to the end of each level.
    #[must_use]
    pub fn ends(&self) -> Vec<f64> {
        self.0.ends().map(|end| end as f64).collect()
    }

    /// The levels as the tile's directory tells them; see [`Surface::levels`].
    #[must_use]
    pub fn levels(&self) -> Vec<f64> {
        flat(self.0.levels())
    }

    /// How many levels are whole.
    #[must_use]
    pub fn levels_there(&self) -> usize {
        self.0.levels_there()
    }

    /// How many bytes of the tile have come.
    #[must_use]
    pub fn bytes_there(&self) -> usize {
        self.0.bytes_there()
    }

    /// What has been decoded so far: lattice units from the south-west corner, heights in metres.
    ///
    /// # Errors
    /// Before the first level, and where what was decoded is no Surface Partition.
    pub fn surface(&self) -> Result<Surface, JsError> {
        let tile = self.0.tile()?;
        Ok(Surface(tile.partition))
    }

    /// The tile's side is 2^`extent_bits` lattice units.
    #[must_use]
    pub fn extent_bits(&self) -> u8 {
        self.0.extent_bits()
    }
}

/// A Surface Partition, in arrays of numbers.
#[derive(Debug)]
#[wasm_bindgen]
pub struct Surface(SurfacePartition);

#[wasm_bindgen]
impl Surface {
    /// Three numbers a level: vertices and triangles of it and all before it, and its certified error.
    #[must_use]
    pub fn levels(&self) -> Vec<f64> {
        flat(self.0.levels.iter().copied())
    }

    /// Three coordinates for each vertex as stored, then for where its representative goes when it comes in.
    #[must_use]
    pub fn positions(&self) -> Vec<f64> {
        let positions = self.0.positions.iter().chain(&self.0.blue_positions);
        positions.flat_map(|position| position.to_array()).collect()
    }

    /// Vertex that each one is drawn at until its level comes in; itself in level 0.
    #[must_use]
    pub fn representatives(&self) -> Vec<u32> {
        self.0.representatives.clone()
    }

    /// Three corners a triangle, in the numbering of the finest surface.
    #[must_use]
    pub fn corners(&self) -> Vec<u32> {
        self.0.triangles.as_flattened().to_vec()
    }
}

fn flat(levels: impl Iterator<Item = Level>) -> Vec<f64> {
    let numbers = |level: Level| [f64::from(level.vertex_end), f64::from(level.triangle_end), level.error];
    levels.flat_map(numbers).collect()
}
