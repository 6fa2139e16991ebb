//! Polygons and lines of vector files.

use std::path::Path;

use gdal::vector::{Geometry, LayerAccess, OGRwkbGeometryType};
use gdal::{Dataset, DatasetOptions, GdalOpenFlags};
use glam::DVec2;

use super::drivers::{VECTOR_DRIVERS, prepare_gdal};
use super::{ReadError, crs};
use crate::georeference::{Crs, GeoReferenceError, converted};

/// Vertices of all that is read of a file, at most.
const MOST_VERTICES: usize = 1 << 24;
/// Polygons and lines with and without heights and measures.
const POLYGONS: [OGRwkbGeometryType::Type; 4] = [
    OGRwkbGeometryType::wkbPolygon,
    OGRwkbGeometryType::wkbPolygon25D,
    OGRwkbGeometryType::wkbPolygonM,
    OGRwkbGeometryType::wkbPolygonZM,
];
const LINES: [OGRwkbGeometryType::Type; 4] = [
    OGRwkbGeometryType::wkbLineString,
    OGRwkbGeometryType::wkbLineString25D,
    OGRwkbGeometryType::wkbLineStringM,
    OGRwkbGeometryType::wkbLineStringZM,
];

/// The rings of a polygon: the outer one, then those of its holes.
pub type Rings = Vec<Vec<DVec2>>;

/// What a part of a vector file has of one kind, in coordinates of its own.
pub(super) struct Layer<T> {
    /// Of the coordinates.
    pub(super) crs: Crs,
    /// What each feature has.
    pub(super) features: Vec<Vec<T>>,
}

/// A kind of geometry that is read.
trait Kind: Sized {
    /// What one is called.
    const NAME: &str;

    /// Takes all that a geometry has.
    fn collect(geometry: &Geometry, found: &mut Vec<Self>);

    fn vertices(&self) -> usize;
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
    for layer in polygons(path, None)? {
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
pub(super) fn polygons(path: &Path, crs: Option<&Crs>) -> Result<Vec<Layer<Rings>>, ReadError> {
    layers(path, crs)
}

/// The lines of a vector file, and the rings of its polygons, in coordinates of `crs` if that is given, whatever the file says.
///
/// # Errors
/// When the file cannot be read, has no line, or does not say what its coordinates are of.
pub(super) fn lines(path: &Path, crs: Option<&Crs>) -> Result<Vec<Layer<Vec<DVec2>>>, ReadError> {
    layers(path, crs)
}

fn layers<T: Kind>(path: &Path, crs: Option<&Crs>) -> Result<Vec<Layer<T>>, ReadError> {
    prepare_gdal(false);
    std::fs::metadata(path).map_err(|error| ReadError::unreadable(path, error))?;
    let options = DatasetOptions {
        open_flags: GdalOpenFlags::GDAL_OF_VECTOR | GdalOpenFlags::GDAL_OF_READONLY,
        allowed_drivers: Some(&VECTOR_DRIVERS),
        ..DatasetOptions::default()
    };
    let dataset = Dataset::open_ex(path, options).map_err(|error| ReadError::gdal(path, error))?;
    let mut layers = Vec::new();
    let mut vertices = 0;
    for mut layer in dataset.layers() {
        let described = || layer.spatial_ref().as_ref().and_then(crs::describe);
        let own = crs.cloned().or_else(described);
        let own = own.ok_or_else(|| ReadError::NoCrs(path.to_owned()))?;
        let mut features = Vec::new();
        for feature in layer.features() {
            let Some(geometry) = feature.geometry() else { continue };
            let mut found = Vec::new();
            T::collect(geometry, &mut found);
            vertices += found.iter().map(T::vertices).sum::<usize>();
            if vertices > MOST_VERTICES {
                return Err(ReadError::TooLarge {
                    path: path.to_owned(),
                    what: format!("{vertices} vertices of {}s", T::NAME),
                    limit: MOST_VERTICES,
                });
            }
            features.push(found);
        }
        layers.push(Layer { crs: own, features });
    }
    if vertices == 0 {
        return Err(ReadError::unreadable(path, format!("it has no {}", T::NAME)));
    }
    Ok(layers)
}

impl Kind for Rings {
    const NAME: &str = "polygon";

    /// A polygon, or all polygons of a collection.
    fn collect(geometry: &Geometry, polygons: &mut Vec<Self>) {
        if POLYGONS.contains(&geometry.geometry_type()) {
            let rings = (0..geometry.geometry_count()).map(|index| points(&geometry.get_geometry(index)));
            polygons.push(rings.collect());
            return;
        }
        (0..geometry.geometry_count()).for_each(|index| Self::collect(&geometry.get_geometry(index), polygons));
    }

    fn vertices(&self) -> usize {
        self.iter().map(Vec::len).sum()
    }
}

impl Kind for Vec<DVec2> {
    const NAME: &str = "line";

    /// A line or the rings of a polygon, or all of a collection.
    fn collect(geometry: &Geometry, lines: &mut Vec<Self>) {
        if geometry.geometry_count() > 0 {
            (0..geometry.geometry_count()).for_each(|index| Self::collect(&geometry.get_geometry(index), lines));
            return;
        }
        // The rings of polygons are lines, too, as their geometries say.
        if LINES.contains(&geometry.geometry_type()) {
            lines.push(points(geometry));
        }
    }

    fn vertices(&self) -> usize {
        self.len()
    }
}

fn points(line: &Geometry) -> Vec<DVec2> {
    let mut points = Vec::new();
    line.get_points(&mut points);
    points.into_iter().map(|(x, y, _)| DVec2::new(x, y)).collect()
}
