//! Polygons of vector files.

use std::path::Path;

use gdal::vector::{Geometry, GeometryRef, LayerAccess, OGRwkbGeometryType};
use gdal::{Dataset, DatasetOptions, GdalOpenFlags};
use glam::DVec2;

use super::drivers::{VECTOR_DRIVERS, prepare_gdal};
use super::{ReadError, crs};
use crate::georeference::{Crs, GeoReferenceError, converted};

/// Vertices of all polygons of a file, at most.
const MOST_VERTICES: usize = 1 << 24;

/// The rings of a polygon: the outer one, then those of its holes.
pub type Rings = Vec<Vec<DVec2>>;

/// The polygons of a part of a vector file, in coordinates of its own.
pub(super) struct Layer {
    /// Of the coordinates.
    pub(super) crs: Crs,
    /// Each with its polygons.
    pub(super) features: Vec<Vec<Rings>>,
}

/// WGS84, in degrees.
pub(super) fn wgs84() -> Crs {
    Crs {
        name: "EPSG:4326".to_owned(),
        definition: "EPSG:4326".to_owned(),
    }
}

/// The polygons of a vector file in degrees of longitude and latitude (WGS84).
///
/// # Errors
/// When the file cannot be read, has no polygon, or has no place on the Earth.
pub fn polygons_on_earth(path: &Path) -> Result<Vec<Rings>, ReadError> {
    let mut found = Vec::new();
    for layer in layers(path, None)? {
        for polygon in layer.features.iter().flatten() {
            let on_earth = rings_in(polygon, &layer.crs, &wgs84());
            found.push(on_earth.map_err(|source| ReadError::Position(path.to_owned(), source))?);
        }
    }
    Ok(found)
}

/// Rings of one reference system in another.
pub(super) fn rings_in(rings: &[Vec<DVec2>], from: &Crs, to: &Crs) -> Result<Rings, GeoReferenceError> {
    let converted = |ring: &Vec<DVec2>| {
        if from == to {
            Ok(ring.clone())
        } else {
            converted(from, to, ring)
        }
    };
    rings.iter().map(converted).collect()
}

/// The polygons of a vector file, in coordinates of `crs` if that is given, whatever the file says.
///
/// # Errors
/// When the file cannot be read, has no polygon, or does not say what its coordinates are of.
pub(super) fn layers(path: &Path, crs: Option<&Crs>) -> Result<Vec<Layer>, ReadError> {
    prepare_gdal(false);
    std::fs::metadata(path).map_err(|error| ReadError::unreadable(path, error))?;
    let options = DatasetOptions {
        open_flags: GdalOpenFlags::GDAL_OF_VECTOR | GdalOpenFlags::GDAL_OF_READONLY,
        allowed_drivers: Some(&VECTOR_DRIVERS),
        ..DatasetOptions::default()
    };
    let dataset = Dataset::open_ex(path, options).map_err(|error| ReadError::gdal(path, error))?;
    let mut found = Vec::new();
    let mut vertices = 0;
    for mut layer in dataset.layers() {
        let described = || layer.spatial_ref().as_ref().and_then(crs::describe);
        let own = crs.cloned().or_else(described);
        let own = own.ok_or_else(|| ReadError::NoCrs(path.to_owned()))?;
        let mut features = Vec::new();
        for feature in layer.features() {
            let Some(geometry) = feature.geometry() else { continue };
            let mut polygons = Vec::new();
            collect_polygons(geometry, &mut polygons);
            vertices += polygons.iter().flatten().map(Vec::len).sum::<usize>();
            if vertices > MOST_VERTICES {
                return Err(ReadError::TooLarge {
                    path: path.to_owned(),
                    what: format!("{vertices} vertices of polygons"),
                    limit: MOST_VERTICES,
                });
            }
            features.push(polygons);
        }
        found.push(Layer { crs: own, features });
    }
    if vertices == 0 {
        return Err(ReadError::unreadable(path, "it has no polygon"));
    }
    Ok(found)
}

/// A polygon, or all polygons of a collection.
fn collect_polygons(geometry: &Geometry, polygons: &mut Vec<Rings>) {
    let is_polygon = matches!(
        geometry.geometry_type(),
        OGRwkbGeometryType::wkbPolygon | OGRwkbGeometryType::wkbPolygon25D
    );
    if is_polygon {
        let rings = (0..geometry.geometry_count()).map(|index| points(&geometry.get_geometry(index)));
        polygons.push(rings.collect());
        return;
    }
    (0..geometry.geometry_count()).for_each(|index| collect_polygons(&geometry.get_geometry(index), polygons));
}

fn points(ring: &GeometryRef<'_>) -> Vec<DVec2> {
    let mut points = Vec::new();
    ring.get_points(&mut points);
    points.into_iter().map(|(x, y, _)| DVec2::new(x, y)).collect()
}
