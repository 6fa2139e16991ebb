//! How FlightGear cuts the Earth (SimGear, `SGBucket`): rows an eighth of a degree high, cut into buckets that are wider the nearer
//! they are to a pole.

/// Buckets along a degree of latitude.
const ROWS_IN_A_DEGREE: i32 = 8;
/// From which latitude of its middle, north or south, a bucket is so many degrees wide.
const WIDTHS: [(f64, f64); 6] = [
    (89.0, 12.0),
    (86.0, 4.0),
    (83.0, 2.0),
    (76.0, 1.0),
    (62.0, 0.5),
    (22.0, 0.25),
];
/// Nearer to the equator.
const LEAST_WIDTH: f64 = 0.125;

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Bucket {
    /// Rows from the south pole.
    row: i32,
    /// From 180° W, in the row's own widths.
    column: i32,
}

impl Bucket {
    /// Those that meet a box in degrees by more than its sides, whose east may exceed 180.
    pub(super) fn all([west, south, east, north]: [f64; 4]) -> impl Iterator<Item = Self> {
        let row = |latitude: f64| (latitude + 90.0) * f64::from(ROWS_IN_A_DEGREE);
        let rows = row(south).floor() as i32..row(north).ceil() as i32;
        rows.flat_map(move |row| {
            let width = width(row);
            let column = |longitude: f64| (longitude + 180.0) / width;
            let around = (360.0 / width) as i32;
            let columns = column(west).floor() as i32..column(east).ceil() as i32;
            columns.map(move |column| Self {
                row,
                column: column.rem_euclid(around),
            })
        })
    }

    /// West, south, east, north.
    pub(super) fn bounds(self) -> [f64; 4] {
        let (width, height) = (width(self.row), 1.0 / f64::from(ROWS_IN_A_DEGREE));
        let west = f64::from(self.column) * width - 180.0;
        let south = f64::from(self.row) * height - 90.0;
        [west, south, west + width, south + height]
    }

    /// The number that its files are named by.
    pub(super) fn index(self) -> i32 {
        let [longitude, latitude] = self.degree();
        let [west, ..] = self.bounds();
        let across = ((west - f64::from(longitude)) / width(self.row)) as i32;
        let up = self.row.rem_euclid(ROWS_IN_A_DEGREE);
        ((longitude + 180) << 14) + ((latitude + 90) << 6) + (up << 3) + across
    }

    /// The folder of its files: that of its ten degrees, and in it that of its degree.
    pub(super) fn folder(self) -> String {
        let [longitude, latitude] = self.degree();
        let of = |longitude: i32, latitude: i32| {
            let hemisphere = if longitude < 0 { 'w' } else { 'e' };
            let pole = if latitude < 0 { 's' } else { 'n' };
            format!("{hemisphere}{:03}{pole}{:02}", longitude.abs(), latitude.abs())
        };
        let tens = [longitude, latitude].map(|degrees| degrees.div_euclid(10) * 10);
        format!("{}/{}", of(tens[0], tens[1]), of(longitude, latitude))
    }

    /// Whole degrees of its south-west corner.
    fn degree(self) -> [i32; 2] {
        let [west, south, ..] = self.bounds();
        [west, south].map(|degrees| degrees.floor() as i32)
    }
}

fn width(row: i32) -> f64 {
    let middle = (f64::from(row) + 0.5) / f64::from(ROWS_IN_A_DEGREE) - 90.0;
    let found = WIDTHS.iter().find(|(from, _)| middle.abs() >= *from);
    found.map_or(LEAST_WIDTH, |&(_, width)| width)
}

#[cfg(test)]
#[path = "bucket_tests.rs"]
mod tests;
