//! Coordinates by PROJ.

use std::ffi::CString;
use std::ptr;

use glam::{DAffine2, DVec2};
use proj::{Area, Proj};
use serde::{Deserialize, Serialize};

use super::GeoReferenceError;
use super::operations::{one_for_all, silence};

/// A coordinate reference system by name and in a form that PROJ reads.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Crs {
    /// `EPSG:4326` where it has a code, its own name otherwise.
    pub name: String,
    /// Anything that PROJ takes: a code, WKT, PROJJSON, a PROJ string.
    pub definition: String,
}

/// A plane laid on the Earth: metres east and north of 0° N, 0° E, true there and along the meridian. No other place bends it less.
const LAID_PLANE: &str =
    "+proj=tmerc +lat_0=0 +lon_0=0 +k=1 +x_0=0 +y_0=0 +ellps=WGS84 +towgs84=0,0,0 +units=m +no_defs +type=crs";

impl Crs {
    /// Where ground is laid that is nowhere on the Earth: metres on its plane.
    pub(crate) fn laid_plane() -> Self {
        Self {
            name: "local metres".to_owned(),
            definition: LAID_PLANE.to_owned(),
        }
    }

    /// Whether coordinates are metres of ground that is nowhere on the Earth.
    pub(crate) fn is_laid_plane(&self) -> bool {
        self.definition == LAID_PLANE
    }
}

/// A transformation from a coordinate reference system to WGS84 longitude and latitude in degrees.
pub(super) struct Projection {
    proj: Proj,
}

impl Projection {
    /// For an `area` (see [`area`]), the same datum shift serves the whole raster; without, PROJ chooses one point by point.
    pub(super) fn new(crs: &Crs, area: Option<[f64; 4]>) -> Result<Self, GeoReferenceError> {
        let one = area.and_then(|area| one_for_all(&crs.definition, area));
        let proj = match one {
            Some(definition) => Proj::new(&definition).map_err(|error| error.to_string()),
            None => operation(
                &crs.definition,
                "EPSG:4326",
                area.map(|[w, s, e, n]| Area::new(w, s, e, n)),
            ),
        };
        proj.map(|proj| Self { proj })
            .map_err(|reason| GeoReferenceError::NoTransformation {
                crs: crs.name.clone(),
                reason,
            })
    }

    /// Longitude (in −180 … 180) and latitude at grid coordinates.
    pub(super) fn to_geographic(&self, to_crs: &DAffine2, grid: DVec2) -> Result<DVec2, GeoReferenceError> {
        let untransformable = |reason: String| GeoReferenceError::Untransformable {
            column: grid.x,
            row: grid.y,
            reason,
        };
        convert(&self.proj, to_crs.transform_point2(grid)).map_err(untransformable)
    }

    /// [`Self::to_geographic`] of many points.
    pub(super) fn all_to_geographic(&self, to_crs: &DAffine2, grid: &[DVec2]) -> Result<Vec<DVec2>, GeoReferenceError> {
        grid.iter().map(|&point| self.to_geographic(to_crs, point)).collect()
    }

    /// Whether the transformation that was used last lacks the datum shift, for want of a grid or of knowledge.
    pub(super) fn is_ballpark(&self) -> bool {
        let description = self.proj.proj_info().description.unwrap_or_default();
        description.to_lowercase().contains("ballpark")
    }
}

/// Coordinates of one reference system in another.
///
/// # Errors
/// If PROJ cannot transform all of them.
pub(crate) fn converted(from: &Crs, to: &Crs, points: &[DVec2]) -> Result<Vec<DVec2>, GeoReferenceError> {
    let fault = |reason: String| GeoReferenceError::NoTransformation {
        crs: format!("{} to {}", from.name, to.name),
        reason,
    };
    let proj = operation(&from.definition, &to.definition, None).map_err(fault)?;
    points
        .iter()
        .map(|&point| convert(&proj, point).map_err(fault))
        .collect()
}

/// The best operation from one reference system to another, or why there is none.
fn operation(from: &str, to: &str, area: Option<Area>) -> Result<Proj, String> {
    silence();
    if !has_operation(from, to) {
        return Err("they have nothing in common".to_owned());
    }
    Proj::new_known_crs(from, to, area).map_err(|error| error.to_string())
}

/// Whether PROJ makes an operation: where it neither does nor says why, as between a system of no place on the Earth and one of the
/// Earth, the crate `proj` would end the program.
fn has_operation(from: &str, to: &str) -> bool {
    let (Ok(from), Ok(to)) = (CString::new(from), CString::new(to)) else {
        return false;
    };
    // SAFETY: the context and the operation live until they are destroyed here; PROJ copies both texts, which end in a zero, and takes
    // null for no area, and to destroy.
    unsafe {
        let context = proj_sys::proj_context_create();
        let operation = proj_sys::proj_create_crs_to_crs(context, from.as_ptr(), to.as_ptr(), ptr::null_mut());
        let is_there = !operation.is_null() || proj_sys::proj_context_errno(context) != 0;
        proj_sys::proj_destroy(operation);
        proj_sys::proj_context_destroy(context);
        is_there
    }
}

/// A point transformed, or why it cannot be.
fn convert(proj: &Proj, point: DVec2) -> Result<DVec2, String> {
    let (x, y) = proj.convert((point.x, point.y)).map_err(|error| error.to_string())?;
    let converted = DVec2::new(x, y);
    let is_there = converted.is_finite().then_some(converted);
    is_there.ok_or_else(|| "it is outside of the projection".to_owned())
}

/// West, south, east and north of `points` in degrees, if it does not cross the antimeridian.
pub(super) fn area(points: &[DVec2]) -> Option<[f64; 4]> {
    let low = points.iter().copied().reduce(DVec2::min)?;
    let high = points.iter().copied().reduce(DVec2::max)?;
    (high.x - low.x < 180.0).then_some([low.x, low.y, high.x, high.y])
}
