//! Where on the Earth the samples of a raster are: from grid coordinates to WGS84 longitude and latitude and back.
//!
//! PROJ is asked at construction only. Where it finds that the raster's coordinates *are* WGS84 degrees, the map is an
//! affine formula; otherwise it is tabulated (see [`table`]). Both are plain data: fast, and usable from any thread.

mod error;
mod operations;
mod pole;
mod projection;
mod table;
mod turns;

use std::sync::Arc;

use glam::{DAffine2, DMat2, DVec2};
use terrain_codec::ellipsoid::{ECCENTRICITY_SQUARED, SEMI_MAJOR};

pub use error::GeoReferenceError;
pub(crate) use operations::{MissingGrids, missing_grids};
pub use projection::Crs;
pub(crate) use projection::converted;
pub(crate) use turns::nearest_turn;

use pole::Pole;
use projection::Projection;
use table::Table;

/// Degrees within which a raster's own coordinates count as WGS84's: a tenth of a millimetre on the ground.
const SAME_DEGREES: f64 = 1e-9;
/// Grid points along a side at which raster and WGS84 coordinates are compared.
const PROBES: usize = 5;

/// Maps grid coordinates (see [`crate::HeightGrid`]) to the raster's coordinate reference system, to WGS84, and back.
#[derive(Clone, Debug)]
pub struct GeoReference {
    crs_name: String,
    columns: usize,
    rows: usize,
    /// From the lattice of samples, of which this grid is a rectangle.
    to_crs: DAffine2,
    /// Where the grid's first sample is on the lattice: whole numbers, so that adding them rounds nothing.
    origin: DVec2,
    to_geographic: ToGeographic,
    /// Its columns go around the Earth, and some are there twice, beyond the antimeridian or beyond a pole.
    is_around: bool,
    is_ballpark: bool,
}

/// From the lattice of samples to longitude and latitude.
#[derive(Clone, Debug)]
enum ToGeographic {
    Affine {
        forward: DAffine2,
        inverse: DAffine2,
    },
    /// `first` is where the table's own grid begins.
    Table {
        table: Arc<Table>,
        first: DVec2,
    },
    /// The table leads to degrees from a pole that is among the samples, along the meridians of 0° and 90° E. Longitudes are those
    /// within half a turn of `facing`.
    Polar {
        table: Arc<Table>,
        first: DVec2,
        pole: Pole,
        facing: f64,
    },
}

impl GeoReference {
    /// The samples of a WGS84 grid whose first one is at `first` (longitude, latitude), with `step` degrees from column
    /// to column and from row to row (negative where rows run south).
    #[must_use]
    pub fn wgs84(columns: usize, rows: usize, first: DVec2, step: DVec2) -> Self {
        let to_crs = DAffine2::from_mat2_translation(DMat2::from_diagonal(step), first);
        Self::affine_to_geographic("EPSG:4326", to_crs, DVec2::ZERO, columns, rows)
    }

    /// The samples of a grid of `columns` by `rows` in `crs`; `to_crs` maps grid coordinates to its coordinates, x
    /// (east or longitude) first.
    ///
    /// # Errors
    /// If PROJ cannot transform the whole raster to WGS84, continuously.
    pub fn new(crs: &Crs, to_crs: DAffine2, columns: usize, rows: usize) -> Result<Self, GeoReferenceError> {
        Self::on_lattice(crs, to_crs, [0, 0], columns, rows)
    }

    /// The samples of a rectangle of a lattice: `to_crs` maps the lattice's coordinates, `origin` are those of the
    /// rectangle's first sample. The same sample has the same place, bit for bit, in every rectangle where places are affine.
    ///
    /// # Errors
    /// If PROJ cannot transform the whole rectangle to WGS84, continuously.
    pub fn on_lattice(
        crs: &Crs,
        to_crs: DAffine2,
        origin: [i64; 2],
        columns: usize,
        rows: usize,
    ) -> Result<Self, GeoReferenceError> {
        let origin = DVec2::new(origin[0] as f64, origin[1] as f64);
        let determinant = to_crs.matrix2.determinant();
        if !to_crs.is_finite() || determinant == 0.0 || !determinant.is_normal() {
            return Err(GeoReferenceError::Degenerate);
        }
        let probes = probes(columns, rows)
            .into_iter()
            .map(|grid| grid + origin)
            .collect::<Vec<_>>();
        let projection = Projection::new(crs, None)?;
        let geographic = projection.all_to_geographic(&to_crs, &probes)?;
        let mut georeference = if same_degrees(&to_crs, &probes, &geographic) {
            Self::affine_to_geographic(&crs.name, to_crs, origin, columns, rows)
        } else {
            Self::tabulated(crs, to_crs, origin, [columns, rows], &geographic)?
        };
        georeference.is_ballpark |= projection.is_ballpark();
        georeference.check_latitudes()?;
        Ok(georeference)
    }

    fn affine_to_geographic(crs_name: &str, to_crs: DAffine2, origin: DVec2, columns: usize, rows: usize) -> Self {
        let west = corners(columns, rows)
            .map(|corner| to_crs.transform_point2(corner + origin).x)
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        let mut forward = to_crs;
        forward.translation.x -= whole_turns(west);
        Self {
            crs_name: crs_name.to_owned(),
            columns,
            rows,
            to_crs,
            origin,
            to_geographic: ToGeographic::Affine {
                forward,
                inverse: forward.inverse(),
            },
            is_around: false,
            is_ballpark: false,
        }
    }

    fn tabulated(
        crs: &Crs,
        to_crs: DAffine2,
        origin: DVec2,
        [columns, rows]: [usize; 2],
        probed: &[DVec2],
    ) -> Result<Self, GeoReferenceError> {
        let projection = Projection::new(crs, projection::area(probed))?;
        let map = |grid: DVec2| projection.to_geographic(&to_crs, grid + origin);
        let mut table = match Table::new(columns, rows, map) {
            Err(GeoReferenceError::Discontinuous) => {
                return Self::polar(
                    &crs.name,
                    to_crs,
                    origin,
                    [columns, rows],
                    map,
                    projection.is_ballpark(),
                );
            }
            table => table?,
        };
        let west = edge(columns, rows)
            .map(|grid| table.forward(grid).x)
            .fold(f64::INFINITY, f64::min);
        table.shift(DVec2::new(-whole_turns(west), 0.0));
        let is_ballpark = projection.is_ballpark();
        Ok(Self {
            crs_name: crs.name.clone(),
            columns,
            rows,
            to_crs,
            origin,
            to_geographic: ToGeographic::Table {
                table: Arc::new(table),
                first: origin,
            },
            is_around: false,
            is_ballpark,
        })
    }

    /// Where longitudes are not continuous because a pole is among the samples.
    fn polar(
        crs_name: &str,
        to_crs: DAffine2,
        origin: DVec2,
        [columns, rows]: [usize; 2],
        map: impl Fn(DVec2) -> Result<DVec2, GeoReferenceError>,
        is_ballpark: bool,
    ) -> Result<Self, GeoReferenceError> {
        let middle = map(DVec2::new(columns as f64 - 1.0, rows as f64 - 1.0) / 2.0)?;
        let pole = Pole::nearest(middle.y);
        let table = Table::new(columns, rows, |grid| map(grid).map(|place| pole.on_plane(place)))?;
        Ok(Self {
            crs_name: crs_name.to_owned(),
            columns,
            rows,
            to_crs,
            origin,
            to_geographic: ToGeographic::Polar {
                table: Arc::new(table),
                first: origin,
                pole,
                facing: 0.0,
            },
            is_around: true,
            is_ballpark,
        })
    }

    /// Grid coordinates of the pole, where it makes longitudes jump.
    pub(crate) fn pole_among_samples(&self) -> Option<DVec2> {
        match &self.to_geographic {
            ToGeographic::Polar { table, first, .. } => Some(table.inverse(DVec2::ZERO) - (self.origin - *first)),
            ToGeographic::Affine { .. } | ToGeographic::Table { .. } => None,
        }
    }

    /// The same places with longitudes within half a turn of one, where there is a choice: around a pole.
    pub(crate) fn facing(mut self, longitude: f64) -> Self {
        if let ToGeographic::Polar { facing, .. } = &mut self.to_geographic {
            *facing = longitude;
        }
        self
    }

    /// The same places seen from a rectangle of these samples, whose first one is at `first`.
    #[must_use]
    pub fn window(&self, first: [i64; 2], columns: usize, rows: usize) -> Self {
        Self {
            columns,
            rows,
            origin: self.origin + DVec2::new(first[0] as f64, first[1] as f64),
            ..self.clone()
        }
    }

    /// The same rows of a grid in degrees, with so many columns in 360°, of which the lattice's first is at a longitude.
    pub(crate) fn around(&self, longitude: f64, columns: usize) -> Self {
        let ToGeographic::Affine { forward, .. } = self.to_geographic else {
            return self.clone();
        };
        let step = DVec2::new(360.0 / columns as f64, forward.matrix2.y_axis.y);
        let first = DVec2::new(longitude, forward.translation.y);
        let to_crs = DAffine2::from_mat2_translation(DMat2::from_diagonal(step), first);
        Self {
            is_around: true,
            is_ballpark: self.is_ballpark,
            ..Self::affine_to_geographic(&self.crs_name, to_crs, self.origin, columns, self.rows)
        }
    }

    /// True where columns go around the Earth: there is no side to the west or to the east then.
    pub(crate) fn is_around(&self) -> bool {
        self.is_around
    }

    /// The same places counted from the lattice's own first sample: the same whatever rectangle of it this is.
    pub(crate) fn of_lattice(&self) -> Self {
        let first = self.origin();
        self.window(first.map(|first| -first), self.columns, self.rows)
    }

    /// Column and row on the lattice of the first sample.
    pub(crate) fn origin(&self) -> [i64; 2] {
        [self.origin.x as i64, self.origin.y as i64]
    }

    fn check_latitudes(&self) -> Result<(), GeoReferenceError> {
        let [_, south, _, north] = self.geographic_bounds();
        match [south, north]
            .into_iter()
            .find(|latitude| latitude.abs() > 90.0 + SAME_DEGREES)
        {
            Some(latitude) => Err(GeoReferenceError::BeyondPole(latitude)),
            None => Ok(()),
        }
    }

    /// Code of the raster's coordinate reference system, or its name where it has none.
    #[must_use]
    pub fn crs_name(&self) -> &str {
        &self.crs_name
    }

    /// All that places on the lattice depend on: where they are affine, not how far the samples reach.
    pub(crate) fn fingerprint(&self) -> String {
        match &self.to_geographic {
            ToGeographic::Affine { forward, .. } => format!("{forward:?}"),
            ToGeographic::Table { table, first } => format!("{} {first:?}", table.fingerprint()),
            ToGeographic::Polar { table, first, pole, .. } => format!("{} {first:?} {pole:?}", table.fingerprint()),
        }
    }

    /// True where PROJ had no datum shift to WGS84 and took the coordinates for WGS84's, which may be a hundred metres
    /// off.
    #[must_use]
    pub fn is_ballpark(&self) -> bool {
        self.is_ballpark
    }

    /// Grid coordinates to coordinates of the raster's reference system, in its units, x to the east.
    #[must_use]
    pub fn affine(&self) -> DAffine2 {
        self.to_crs * DAffine2::from_translation(self.origin)
    }

    /// [`Self::affine`] of one point.
    #[must_use]
    pub fn crs_coordinates(&self, grid: DVec2) -> DVec2 {
        self.to_crs.transform_point2(grid + self.origin)
    }

    /// The inverse of [`Self::crs_coordinates`].
    pub(crate) fn grid_of_crs(&self, coordinates: DVec2) -> DVec2 {
        self.to_crs.inverse().transform_point2(coordinates) - self.origin
    }

    /// True where longitude and latitude are an affine function of grid coordinates, exactly.
    #[must_use]
    pub fn is_geographic(&self) -> bool {
        matches!(self.to_geographic, ToGeographic::Affine { .. })
    }

    /// WGS84 longitude and latitude in degrees. Longitudes are continuous over the raster: the westernmost is in
    /// −180 … 180, and those to the east of the antimeridian exceed 180. Around a pole they jump somewhere.
    #[must_use]
    pub fn geographic(&self, grid: DVec2) -> DVec2 {
        match &self.to_geographic {
            ToGeographic::Affine { forward, .. } => forward.transform_point2(grid + self.origin),
            ToGeographic::Table { table, first } => table.forward(grid + (self.origin - *first)),
            ToGeographic::Polar {
                table,
                first,
                pole,
                facing,
            } => pole.geographic(table.forward(grid + (self.origin - *first)), *facing),
        }
    }

    /// Grid coordinates of a WGS84 longitude and latitude; the longitude in the range of [`Self::geographic`].
    #[must_use]
    pub fn grid(&self, geographic: DVec2) -> DVec2 {
        match &self.to_geographic {
            ToGeographic::Affine { inverse, .. } => inverse.transform_point2(geographic) - self.origin,
            ToGeographic::Table { table, first } => table.inverse(geographic) - (self.origin - *first),
            ToGeographic::Polar { table, first, pole, .. } => {
                table.inverse(pole.on_plane(geographic)) - (self.origin - *first)
            }
        }
    }

    /// Length on the ellipsoid, in metres, of a step of one column and of one row.
    #[must_use]
    pub fn cell_metres(&self, grid: DVec2) -> DVec2 {
        let metres_per_degree = metres_per_degree(self.geographic(grid).y);
        let degrees = match &self.to_geographic {
            ToGeographic::Affine { forward, .. } => forward.matrix2,
            ToGeographic::Table { table, first } => table.jacobian(grid + (self.origin - *first)),
            ToGeographic::Polar { table, first, .. } => {
                let at = grid + (self.origin - *first);
                return pole::lengths(table.forward(at), table.jacobian(at), metres_per_degree);
            }
        };
        let length = |step: DVec2| (step * metres_per_degree).length();
        DVec2::new(length(degrees.x_axis), length(degrees.y_axis))
    }

    /// West, south, east, north of the samples, in degrees; found along the raster's edge. Around the Earth, −180 and 180.
    #[must_use]
    pub fn geographic_bounds(&self) -> [f64; 4] {
        let edge: Vec<DVec2> = match self.to_geographic {
            ToGeographic::Affine { .. } => corners(self.columns, self.rows).to_vec(),
            ToGeographic::Table { .. } | ToGeographic::Polar { .. } => edge(self.columns, self.rows).collect(),
        };
        let (mut low, mut high) = edge
            .into_iter()
            .map(|grid| self.geographic(grid))
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| {
                (low.min(point), high.max(point))
            });
        if let ToGeographic::Polar { pole, .. } = self.to_geographic {
            (low.x, high.x) = (-180.0, 180.0);
            (low.y, high.y) = pole.with(low.y, high.y);
        }
        if self.is_around {
            let ends = DVec2::new(180.0, 90.0);
            (low, high) = (low.clamp(-ends, ends), high.clamp(-ends, ends));
        }
        [low.x, low.y, high.x, high.y]
    }
}

/// Metres along a degree of longitude and of latitude at a latitude in degrees: the radii of curvature in the prime
/// vertical and in the meridian of the WGS84 ellipsoid.
fn metres_per_degree(latitude: f64) -> DVec2 {
    let (sine, cosine) = latitude.to_radians().sin_cos();
    let root = (1.0 - ECCENTRICITY_SQUARED * sine * sine).sqrt();
    let prime_vertical = SEMI_MAJOR / root;
    let meridian = prime_vertical * (1.0 - ECCENTRICITY_SQUARED) / (root * root);
    DVec2::new(prime_vertical * cosine, meridian) * 1.0_f64.to_radians()
}

/// The multiple of 360° to take from longitudes so that `west` comes to lie in −180 … 180.
fn whole_turns(west: f64) -> f64 {
    ((west + 180.0 + SAME_DEGREES) / 360.0).floor() * 360.0
}

fn same_degrees(to_crs: &DAffine2, probes: &[DVec2], geographic: &[DVec2]) -> bool {
    probes.iter().zip(geographic).all(|(&grid, &point)| {
        let difference = to_crs.transform_point2(grid) - point;
        let turns = (difference.x / 360.0).round() * 360.0;
        (difference - DVec2::new(turns, 0.0)).abs().max_element() < SAME_DEGREES
    })
}

fn probes(columns: usize, rows: usize) -> Vec<DVec2> {
    let last = DVec2::new((columns - 1) as f64, (rows - 1) as f64);
    let fraction = |index: usize| index as f64 / (PROBES - 1) as f64;
    (0..PROBES * PROBES)
        .map(|index| last * DVec2::new(fraction(index % PROBES), fraction(index / PROBES)))
        .collect()
}

fn corners(columns: usize, rows: usize) -> [DVec2; 4] {
    let (right, bottom) = ((columns - 1) as f64, (rows - 1) as f64);
    [(0.0, 0.0), (right, 0.0), (right, bottom), (0.0, bottom)].map(DVec2::from)
}

/// Every sample along the four sides of the raster.
fn edge(columns: usize, rows: usize) -> impl Iterator<Item = DVec2> {
    let (right, bottom) = ((columns - 1) as f64, (rows - 1) as f64);
    let sideways = (0..columns).flat_map(move |column| [0.0, bottom].map(|row| DVec2::new(column as f64, row)));
    let downwards = (0..rows).flat_map(move |row| [0.0, right].map(|column| DVec2::new(column, row as f64)));
    sideways.chain(downwards)
}

#[cfg(test)]
#[path = "georeference_tests.rs"]
mod tests;
