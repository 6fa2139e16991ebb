//! Coordinate reference systems as GDAL has them, turned into names and definitions.

use gdal::spatial_ref::SpatialRef;

use super::ReadError;
use crate::georeference::Crs;

/// The coordinate reference system that a user names.
pub(super) fn from_user(definition: &str) -> Result<SpatialRef, ReadError> {
    SpatialRef::from_definition(definition).map_err(|_| ReadError::UnknownCrs(definition.to_owned()))
}

/// Name and PROJ definition of `reference`; None where it cannot be expressed, as for a bare local system.
pub(super) fn describe(reference: &SpatialRef) -> Option<Crs> {
    if reference.is_local() {
        return None;
    }
    let definition = reference.to_projjson().or_else(|_| reference.to_wkt()).ok()?;
    let name = reference.authority().ok().or_else(|| reference.name());
    Some(Crs {
        name: name.unwrap_or_else(|| "unnamed".to_owned()),
        definition,
    })
}

/// Name of the vertical datum that comes with `reference`, if one does.
pub(super) fn vertical_datum(reference: &SpatialRef) -> Option<String> {
    let vertical = reference.get_attr_value("VERT_CS", 0).ok().flatten();
    let is_ellipsoidal = reference.is_geographic() && reference.axes_count() == 3;
    match vertical {
        Some(name) if !name.eq_ignore_ascii_case("unknown") => Some(name),
        _ => is_ellipsoidal.then(|| "ellipsoid".to_owned()),
    }
}

/// Metres in the unit of the vertical coordinate reference system that comes with `reference`, if one does.
pub(super) fn vertical_unit(reference: &SpatialRef) -> Option<f64> {
    let factor = reference.get_attr_value("VERT_CS|UNIT", 1).ok().flatten()?;
    factor.parse().ok().filter(|&metres| metres > 0.0)
}

/// Whether x is a longitude in degrees.
pub(super) fn is_in_degrees(reference: &SpatialRef) -> bool {
    reference.is_geographic() && (reference.angular_units().to_degrees() - 1.0).abs() < 1e-12
}
