//! How the numbers of a file are kept, and how finely.

use terrain_codec::address::TileAddress;

/// How the numbers are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Packing {
    /// As they are, for any reader of glTF 2.0.
    #[default]
    Plain,
    /// In few bits (`KHR_mesh_quantization`), compressed (`EXT_meshopt_compression`).
    Meshopt,
}

/// Finer than by a 2^11th of a metre positions are never told: a tile of 8 km with all its relief then fits in single precision.
const FINEST_STEP_EXPONENT: i32 = -11;

impl Packing {
    /// By its name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "plain" => Some(Self::Plain),
            "meshopt" => Some(Self::Meshopt),
            _ => None,
        }
    }

    /// Its name in addresses.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Meshopt => "meshopt",
        }
    }

    /// Metres that Earth-centred positions of tiles of a zoom are multiples of, along each axis: a power of two, the same for all of
    /// them, so that they meet without a crack.
    ///
    /// Plain it is a metre at zoom 0, halved a zoom downwards. In 16 bits it is 512 times that: a square of zoom z is no wider from
    /// corner to corner than 28,400 km / 2^z, which is 55,500 such steps, and what is left is room for relief.
    #[must_use]
    pub fn step(self, address: TileAddress) -> f64 {
        let at_zoom_0 = match self {
            Self::Plain => 0,
            Self::Meshopt => 9,
        };
        let exponent = (at_zoom_0 - i32::from(address.zoom)).max(FINEST_STEP_EXPONENT);
        f64::from(exponent).exp2()
    }

    /// How far in space a place of a tile's surface is moved at most, metres.
    #[must_use]
    pub fn rounding(self, address: TileAddress) -> f64 {
        half_diagonal(self.step(address))
    }
}

/// Of a cube.
pub(super) fn half_diagonal(side: f64) -> f64 {
    side * 3.0_f64.sqrt() / 2.0
}
