//! Where a line meets the surface of a zoom from above, if it is upright at another place: the vertical of a local frame.
//!
//! ```text
//! line ─▶ the stretch of it between the lowest and the highest ground ─▶ halved, the upper half first, until it is over few tiles
//!      ─▶ of each tile: halved again, until it is over few cells ─▶ their triangles ─▶ the highest point that is met
//! ```
//! The source is no further away along the line than `error`: whoever goes δ along it, by an angle θ from the vertical, goes δ cos θ
//! up and δ sin θ sideways, where the surface rises by no more than δ sin θ times its slope. So the line has left what is within the
//! certified error ε of the surface after ε / (cos θ − slope · sin θ).

use std::ops::Deref;

use glam::{DVec2, DVec3};
use terrain_codec::address::{MAX_ZOOM, TileAddress};
use terrain_codec::ellipsoid::{Geodetic, MEAN_RADIUS, normal, to_geodetic};

use super::{Ground, SLACK, beside, bulge, cell_of, fraction};

/// A line may be so far from the vertical where it comes to the ellipsoid: the cosine of 45°.
const LEAST_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Steps of Newton's method that find the ellipsoid, at most.
const STEPS: usize = 8;
/// Metres to which it is found.
const NEAR: f64 = 1e-3;
/// Metres by which a stretch is longer than it has to be.
const MARGIN: f64 = 1.0;
/// A stretch is over few tiles, or cells, if it is over so many across and up.
const FEW: i64 = 2;
/// Metres: shorter stretches are not halved.
const SHORT: f64 = 1e-3;
/// Metres by which a point may be beyond the end of its stretch, for rounding.
const BEYOND: f64 = 1e-6;
/// How many certified errors along the line slopes are looked at, one after the other until it is far enough.
const REACHES: [f64; 4] = [1.5, 4.0, 16.0, 64.0];

/// A line that goes up through the ground.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Earth-centred metres of its point on the ellipsoid.
    foot: DVec3,
    up: DVec3,
    /// Metres along the line from the point that it was given by to `foot`.
    below: f64,
    /// That of `foot`, degrees.
    place: DVec2,
    /// Of its angle to the vertical there.
    cosine: f64,
}

/// Where a line meets the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// Metres along the line from the point that it was given by.
    pub along: f64,
    /// Metres along the line that the source may be from that, certified; infinite where the ground is too steep for the line's tilt.
    pub error: f64,
    /// Unit normal of the surface, Earth-centred.
    pub normal: DVec3,
    /// Whether the ground there was not measured, but a void of the source was filled: no error is certified of it.
    pub is_filled: bool,
}

impl Line {
    /// The line through an Earth-centred point in the direction `up`; none if it does not come down to the ellipsoid within 45° of the
    /// vertical there.
    #[must_use]
    pub fn through(point: DVec3, up: DVec3) -> Option<Self> {
        let mut below = 0.0;
        for _ in 0..STEPS {
            let foot = point + below * up;
            let Geodetic {
                longitude,
                latitude,
                height,
            } = to_geodetic(foot);
            let cosine = normal(longitude, latitude).dot(up);
            if height.abs() < NEAR && cosine >= LEAST_COSINE {
                return Some(Self {
                    foot,
                    up,
                    below,
                    place: DVec2::new(longitude, latitude),
                    cosine,
                });
            }
            if cosine <= 0.0 {
                return None;
            }
            below -= height / cosine;
        }
        None
    }

    /// Longitude and latitude where it comes to the ellipsoid, degrees.
    #[must_use]
    pub fn place(&self) -> DVec2 {
        self.place
    }

    /// Where it first meets the surface of `zoom` on its way down. All ground is between the heights `lowest` and `highest`.
    ///
    /// # Errors
    /// What `ground_at` says.
    pub fn meet<G: Deref<Target = Ground>, E>(
        &self,
        zoom: u8,
        heights: [f64; 2],
        mut ground_at: impl FnMut(TileAddress) -> Result<Option<G>, E>,
    ) -> Result<Option<Met>, E> {
        let zoom = zoom.min(MAX_ZOOM);
        let stretch = self.between(heights);
        let mut own = |square: Square, part: &Stretch| {
            let ground = ground_at(square.address)?;
            Ok(ground.and_then(|ground| ground.first_met(self, part, square.turn)))
        };
        let mut met = self.highest(stretch, zoom, &mut own)?;
        if met.is_none() {
            // Of edges that are straight in space, some of the tiles beside bulge into this square.
            let mut across = |square: Square, part: &Stretch| {
                let mut highest = None;
                for (neighbour, distance) in beside(square.address, part.low.place.y) {
                    let ground = ground_at(neighbour)?.filter(|ground| distance <= ground.reach);
                    highest = higher(
                        highest,
                        ground.and_then(|ground| ground.first_met(self, part, square.turn)),
                    );
                }
                Ok(highest)
            };
            met = self.highest(stretch, zoom, &mut across)?;
        }
        let Some(met) = met else { return Ok(None) };
        Ok(Some(Met {
            along: met.along + self.below,
            error: self.error(met, zoom, ground_at)?,
            ..met
        }))
    }

    /// The highest that `look` finds over all tiles of `zoom` that a stretch is over.
    fn highest<E>(
        &self,
        stretch: Stretch,
        zoom: u8,
        look: &mut impl FnMut(Square, &Stretch) -> Result<Option<Met>, E>,
    ) -> Result<Option<Met>, E> {
        let squares = Squares::under(&stretch, zoom);
        if squares.are_many() && !stretch.is_short() {
            let [upper, lower] = self.halves(&stretch);
            let found = self.highest(upper, zoom, look)?;
            return if found.is_some() {
                Ok(found)
            } else {
                self.highest(lower, zoom, look)
            };
        }
        let mut highest = None;
        for square in squares.all() {
            highest = higher(highest, look(square, &stretch)?);
        }
        Ok(highest)
    }

    /// How far the source may be along the line from where that meets the surface with the certified error `met.error`.
    fn error<G: Deref<Target = Ground>, E>(
        &self,
        met: Met,
        zoom: u8,
        mut ground_at: impl FnMut(TileAddress) -> Result<Option<G>, E>,
    ) -> Result<f64, E> {
        let here = to_geodetic(self.at(met.along));
        let up = normal(here.longitude, here.latitude);
        let cosine = up.dot(self.up);
        let sine = up.cross(self.up).length();
        for reach in REACHES.map(|errors| errors * met.error) {
            let near = self.stretch(met.along - reach, met.along + reach);
            let (mut slope, mut certified) = (0.0_f64, met.error);
            for square in Squares::under(&near, zoom).all() {
                if let Some(ground) = ground_at(square.address)? {
                    slope = slope.max(ground.steepest_under(&near, square.turn, up));
                    certified = certified.max(ground.error);
                }
            }
            let share = cosine - slope * sine;
            if share > 0.0 && certified / share <= reach {
                return Ok(certified / share);
            }
        }
        Ok(f64::INFINITY)
    }

    /// Metres are from `foot` here and below.
    fn at(&self, along: f64) -> DVec3 {
        self.foot + along * self.up
    }

    fn end(&self, along: f64) -> End {
        let Geodetic {
            longitude, latitude, ..
        } = to_geodetic(self.at(along));
        // On the same side of the antimeridian as the foot, so that a stretch is short in degrees, too.
        let turns = ((self.place.x - longitude) / 360.0).round();
        End {
            along,
            place: DVec2::new(longitude + 360.0 * turns, latitude),
        }
    }

    fn stretch(&self, low: f64, high: f64) -> Stretch {
        Stretch {
            low: self.end(low),
            high: self.end(high),
        }
    }

    /// The stretch that has all points between two heights: the line gets higher by its cosine for each metre, and a little more the
    /// further it is from the foot, since the Earth falls away.
    fn between(&self, [lowest, highest]: [f64; 2]) -> Stretch {
        let [low, high] = [lowest, highest].map(|height| height / self.cosine);
        self.stretch(low - low * low / MEAN_RADIUS - MARGIN, high + MARGIN)
    }

    /// The upper one first.
    fn halves(&self, stretch: &Stretch) -> [Stretch; 2] {
        let middle = self.end(stretch.low.along.midpoint(stretch.high.along));
        [
            Stretch {
                low: middle,
                high: stretch.high,
            },
            Stretch {
                low: stretch.low,
                high: middle,
            },
        ]
    }
}

/// A part of a line.
#[derive(Clone, Copy)]
struct Stretch {
    low: End,
    high: End,
}

#[derive(Clone, Copy)]
struct End {
    along: f64,
    /// Degrees; longitudes may be beyond ±180.
    place: DVec2,
}

impl Stretch {
    fn is_short(&self) -> bool {
        self.high.along - self.low.along < SHORT
    }

    fn has(&self, along: f64) -> bool {
        (self.low.along - BEYOND..=self.high.along + BEYOND).contains(&along)
    }

    /// Degrees around all places that it is over.
    fn plan(&self) -> [DVec2; 2] {
        let [low, high] = [self.low.place.min(self.high.place), self.low.place.max(self.high.place)];
        let extent = (high - low).max_element().to_radians();
        let margin = bulge(extent, [low.y, high.y]).to_degrees();
        [low - margin, high + margin]
    }
}

/// The tiles of a zoom that a stretch may be over.
struct Squares {
    zoom: u8,
    columns: [i64; 2],
    rows: [i64; 2],
}

/// One of them.
#[derive(Clone, Copy)]
struct Square {
    address: TileAddress,
    /// Degrees by which longitudes of the stretch exceed those of the tile.
    turn: f64,
}

impl Squares {
    fn under(stretch: &Stretch, zoom: u8) -> Self {
        let last = (1_i64 << zoom) - 1;
        let [low, high] = stretch
            .plan()
            .map(|place| ((place + DVec2::new(180.0, 90.0)) / 180.0 * (last + 1) as f64).floor());
        Self {
            zoom,
            columns: [low.x as i64, high.x as i64],
            rows: [low.y, high.y].map(|row| (row as i64).clamp(0, last)),
        }
    }

    fn are_many(&self) -> bool {
        [self.columns, self.rows]
            .iter()
            .any(|[first, last]| last - first >= FEW)
    }

    fn all(&self) -> impl Iterator<Item = Square> {
        let &Self { zoom, columns, rows } = self;
        let around = 2_i64 << zoom;
        let square = move |column: i64, row: i64| Square {
            address: TileAddress {
                zoom,
                x: column.rem_euclid(around) as u32,
                y: row as u32,
            },
            turn: 360.0 * column.div_euclid(around) as f64,
        };
        // Where it passes a pole, longitudes go once around the Earth and no further.
        let last = columns[1].min(columns[0] + around - 1);
        (rows[0]..=rows[1]).flat_map(move |row| (columns[0]..=last).map(move |column| square(column, row)))
    }
}

impl Ground {
    /// Where the highest point of a stretch on the surface is. Its error is the surface's own.
    fn first_met(&self, line: &Line, stretch: &Stretch, turn: f64) -> Option<Met> {
        let [low, high] = self.cells_under(stretch, turn);
        let are_many = (0..2).any(|axis| high[axis] as i64 - low[axis] as i64 >= FEW);
        if are_many && !stretch.is_short() {
            let halves = line.halves(stretch);
            return halves.iter().find_map(|half| self.first_met(line, half, turn));
        }
        let foot = line.foot - self.origin;
        let hits = self.in_cells([low, high]).filter_map(|triangle| {
            let (inside, along) = self.hit(triangle, foot, line.up)?;
            (inside >= -SLACK && stretch.has(along)).then_some((triangle, along))
        });
        let (triangle, along) = hits.max_by(|(_, one), (_, other)| one.total_cmp(other))?;
        let place = to_geodetic(line.at(along));
        Some(Met {
            along,
            error: self.error,
            normal: self.across(triangle).normalize(),
            is_filled: self.is_filled(place.longitude, place.latitude),
        })
    }

    /// Metres up for a metre across of the triangles that a stretch may be over, at most.
    fn steepest_under(&self, stretch: &Stretch, turn: f64, up: DVec3) -> f64 {
        let slope = |triangle| {
            let across = self.across(triangle);
            let upwards = across.dot(up).max(0.0);
            across.cross(up).length() / upwards
        };
        let triangles = self.in_cells(self.cells_under(stretch, turn));
        triangles.map(slope).fold(0.0, f64::max)
    }

    fn cells_under(&self, stretch: &Stretch, turn: f64) -> [[usize; 2]; 2] {
        stretch
            .plan()
            .map(|place| cell_of(fraction(self.address, place.x - turn, place.y), self.cells))
    }

    fn in_cells(&self, [low, high]: [[usize; 2]; 2]) -> impl Iterator<Item = u32> {
        let cells = (low[1]..=high[1]).flat_map(move |row| (low[0]..=high[0]).map(move |column| (row, column)));
        cells.flat_map(move |(row, column)| self.members.row((row * self.cells + column) as u32).iter().copied())
    }
}

fn higher(one: Option<Met>, other: Option<Met>) -> Option<Met> {
    one.into_iter()
        .chain(other)
        .max_by(|one, other| one.along.total_cmp(&other.along))
}

#[cfg(test)]
#[path = "line_tests.rs"]
mod tests;
