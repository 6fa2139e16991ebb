//! Polygons on the Earth that tiles may touch.

use std::path::Path;

use geo::{BoundingRect, Coord, Intersects, LineString, Polygon, Rect};

use crate::raster::{ReadError, Rings, polygons_on_earth};

/// Polygons of a file, in degrees; longitudes may exceed 180.
#[derive(Clone, Debug)]
pub struct Area(Vec<(Rect, Polygon)>);

impl Area {
    /// The polygons of a vector file.
    ///
    /// # Errors
    /// When the file cannot be read, has no polygon, or has no place on the Earth.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let polygons = polygons_on_earth(path)?.into_iter().map(polygon);
        let with_box = |polygon: Polygon| Some((polygon.bounding_rect()?, polygon));
        Ok(Self(polygons.filter_map(with_box).collect()))
    }

    /// Whether it has a point in common with a box.
    pub(super) fn touches(&self, [west, south, east, north]: [f64; 4]) -> bool {
        let wanted = Rect::new(Coord { x: west, y: south }, Coord { x: east, y: north });
        let touches = |(extent, polygon): &(Rect, Polygon)| extent.intersects(&wanted) && polygon.intersects(&wanted);
        self.0.iter().any(touches)
    }

    /// West, south, east, north of all of it.
    pub(super) fn bounds(&self) -> [f64; 4] {
        let nothing = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        self.0.iter().fold(nothing, |[west, south, east, north], (extent, _)| {
            let (low, high) = (extent.min(), extent.max());
            [west.min(low.x), south.min(low.y), east.max(high.x), north.max(high.y)]
        })
    }
}

fn polygon(rings: Rings) -> Polygon {
    let closed = |ring: Vec<glam::DVec2>| LineString::from_iter(ring.into_iter().map(|at| Coord { x: at.x, y: at.y }));
    let mut rings = rings.into_iter().map(closed);
    let outer = rings.next().unwrap_or_else(LineString::empty);
    Polygon::new(outer, rings.collect())
}
