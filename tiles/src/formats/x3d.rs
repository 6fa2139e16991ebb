//! X3D and VRML worlds that show a multilevel mesh while it loads.
//!
//! After A. Guéziec, G. Taubin, B. Horn, F. Lazarus, *A Framework for Streaming Geometry in VRML*, IEEE Computer Graphics
//! and Applications 19(2), 1999, "VRML implementation" and Figures 7 and 8. The world holds the paper's prototype
//! `MultiLevelProgIfs`, whose script (`x3d/multilevel.js`) is ECMAScript where theirs is Java; the mesh stays in the
//! papers' ASCII file ([`to_ascii`](terrain_core::streaming::multilevel::to_ascii)) beside the world. `docs/formats/world.md` says what
//! the prototype offers.

use std::path::Path;

use glam::{DVec3, Vec3};
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use terrain_core::streaming::multilevel::MultilevelMesh;
use thiserror::Error;

const SCRIPT: &str = include_str!("x3d/multilevel.js");
const XML_TEMPLATE: &str = include_str!("x3d/world.x3d");
const VRML_TEMPLATE: &str = include_str!("x3d/world.wrl");

/// All that a relative URL may not hold as it is, and what XML or VRML would take for the end of a string.
const ESCAPED_IN_URL: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~');

/// Where the viewpoint is above and south of the middle, in radii. It looks 0.6 radians down from as far as a ball just
/// fits into its field of view of π/4: d sin 0.6 and d cos 0.6 with d = 1 ÷ sin(π/8).
const VIEW_HEIGHT: f32 = 1.476;
const VIEW_DISTANCE: f32 = 2.158;
/// The size of who looks, twice the nearest distance drawn, and the farthest, in radii: a depth buffer of 24 bits can tell
/// those apart.
const AVATAR_SIZE: f32 = 0.02;
const VISIBILITY_LIMIT: f32 = 50.0;
/// Far enough inside single precision, so that nothing that is made of coordinates overflows.
const LARGEST_COORDINATE: f64 = 1e30;

/// Why a mesh has no world.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum WorldError {
    /// X3D has single precision.
    #[error("a coordinate of {0:e} is more than X3D can hold; scale the mesh down to below {LARGEST_COORDINATE:e}")]
    TooLarge(f64),
}

/// How a world is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// X3D 3.3 as XML, `.x3d`.
    Xml,
    /// VRML 2.0, `.wrl`: the paper's own.
    Vrml,
}

impl Encoding {
    /// What the extension of a file's name asks for, if it is one of the two.
    #[must_use]
    pub fn of_file(file: &Path) -> Option<Self> {
        let extension = file.extension()?.to_ascii_lowercase();
        match extension.to_str()? {
            "x3d" => Some(Self::Xml),
            "wrl" => Some(Self::Vrml),
            _ => None,
        }
    }
}

/// The world that shows `mesh`, whose ASCII file is called `data_file` and lies in the world's folder. The mesh has z up
/// and any unit of length; the viewpoint sees all of it, from the south.
///
/// # Errors
/// When a coordinate is too large for X3D.
pub fn to_world(mesh: &MultilevelMesh, data_file: &str, encoding: Encoding) -> Result<String, WorldError> {
    let (template, script) = match encoding {
        Encoding::Xml => (XML_TEMPLATE, SCRIPT.to_owned()),
        Encoding::Vrml => (VRML_TEMPLATE, escaped_in_vrml(SCRIPT)),
    };
    let Ball { middle, radius } = Ball::around(mesh.positions())?;
    let number = |factor: f32| (radius * factor).to_string();
    let [x, y, z] = middle.to_array();
    let values = [
        ("@ORIGIN@", format!("{x} {y} {z}")),
        ("@RADIUS@", number(1.0)),
        ("@AVATAR_SIZE@", number(AVATAR_SIZE)),
        ("@VISIBILITY_LIMIT@", number(VISIBILITY_LIMIT)),
        ("@VIEW_HEIGHT@", number(VIEW_HEIGHT)),
        ("@VIEW_DISTANCE@", number(VIEW_DISTANCE)),
        ("@URL_DATA@", utf8_percent_encode(data_file, ESCAPED_IN_URL).to_string()),
        ("@SCRIPT@", script),
    ];
    let fill = |text: String, (name, value): &(&str, String)| text.replace(name, value);
    Ok(values.iter().fold(template.to_owned(), fill))
}

fn escaped_in_vrml(text: &str) -> String {
    text.replace('\\', r"\\").replace('"', r#"\""#)
}

/// What a viewpoint has to see, in the single precision of X3D.
#[derive(Debug, PartialEq)]
struct Ball {
    middle: Vec3,
    radius: f32,
}

impl Ball {
    /// Around the bounding box; of radius 1 where that has no extent.
    fn around(positions: &[[f64; 3]]) -> Result<Self, WorldError> {
        let positions = || positions.iter().copied().map(DVec3::from_array);
        let lowest = positions().reduce(DVec3::min).unwrap_or_default();
        let highest = positions().reduce(DVec3::max).unwrap_or_default();
        let largest = highest.abs().max(lowest.abs()).max_element();
        if largest > LARGEST_COORDINATE {
            return Err(WorldError::TooLarge(largest));
        }
        let diagonal = lowest.distance(highest);
        Ok(Self {
            middle: lowest.midpoint(highest).as_vec3(),
            radius: if diagonal > 0.0 { diagonal as f32 / 2.0 } else { 1.0 },
        })
    }
}

#[cfg(test)]
#[path = "x3d_tests.rs"]
mod tests;
