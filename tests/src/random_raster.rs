//! Small rasters of every kind, by a seed: where they are, what lies on them, what is missing, and how they are to be
//! made into tiles. The same seed makes the same files.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::Result;
use fastrand::Rng;
use glam::{DAffine2, DMat2, DVec2};
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

/// Where a raster lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// UTM, columns to the east.
    Utm,
    /// UTM, turned and sheared.
    Turned,
    /// UTM, cells of a metre or less.
    Fine,
    /// Degrees, cells of less than a tenth of one.
    Geographic,
    /// Degrees, cells of one to ten.
    Coarse,
    /// Degrees, over 180°.
    Antimeridian,
    /// Degrees, with a row at a pole.
    PoleRow,
    /// Polar stereographic, beside the pole.
    BesidePole,
    /// Polar stereographic, with the pole among the samples and no outline beside it.
    OverPole,
    /// UTM, in files that abut or overlap.
    Files,
    /// Degrees, around the whole Earth, wherever it begins, in one file or two.
    Around,
    /// UTM, and a larger raster with other cells below or above it, that has no voids.
    Mixed,
}

impl Place {
    /// All of them.
    pub const ALL: [Self; 12] = [
        Self::Utm,
        Self::Turned,
        Self::Fine,
        Self::Geographic,
        Self::Coarse,
        Self::Antimeridian,
        Self::PoleRow,
        Self::BesidePole,
        Self::OverPole,
        Self::Files,
        Self::Around,
        Self::Mixed,
    ];
}

/// What lies on a raster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relief {
    /// One height.
    Flat,
    /// Planes.
    Ramp,
    /// Waves.
    Hills,
    /// Every sample by chance.
    Noise,
    /// One sample high above all others.
    Spike,
    /// Walls between terraces.
    Steps,
}

/// What is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Voids {
    /// Nothing.
    None,
    /// Samples by chance.
    Scattered,
    /// A rectangle inside.
    Hole,
    /// A ragged edge.
    Ragged,
    /// All but one cell.
    AllButOneCell,
    /// All but one sample.
    AllButOneSample,
}

/// A raster and how to make tiles of it.
#[derive(Clone, Debug)]
pub struct RandomRaster {
    /// Where it lies.
    pub place: Place,
    /// What lies on it.
    pub relief: Relief,
    /// What is missing.
    pub voids: Voids,
    /// Samples in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Row by row, metres; NaN where void.
    pub heights: Vec<f32>,
    /// Options of `terrain-ingest`.
    pub options: Vec<String>,
    epsg: u16,
    /// Columns and rows, at samples, to coordinates of the reference system.
    to_crs: DAffine2,
    /// Whether the file tells of points or of areas.
    is_point: bool,
    is_integer: bool,
    /// First column and number of columns of each file.
    files: Vec<(usize, usize)>,
    /// Another raster at the same place.
    other: Option<Box<Self>>,
}

const NODATA: f32 = -32768.0;
/// Samples around a pole that are there.
const CLEAR: usize = 5;

impl RandomRaster {
    /// That of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut random = Rng::with_seed(seed);
        let place = pick(&mut random, &Place::ALL);
        let side = |random: &mut Rng| {
            let most = pick(random, &[2, 3, 8, 20, 40]);
            random.usize(2..=most)
        };
        let (mut columns, mut rows) = (side(&mut random), side(&mut random));
        let (epsg, step, first) = place_of(&mut random, place, &mut columns, &mut rows);
        let cell = if epsg == 4326 {
            step.x_axis.length() * 111_000.0
        } else {
            step.x_axis.length()
        };
        let relief = pick(
            &mut random,
            &[
                Relief::Flat,
                Relief::Ramp,
                Relief::Hills,
                Relief::Noise,
                Relief::Spike,
                Relief::Steps,
            ],
        );
        let kinds = [
            Voids::None,
            Voids::None,
            Voids::None,
            Voids::Scattered,
            Voids::Hole,
            Voids::Ragged,
            Voids::AllButOneCell,
            Voids::AllButOneSample,
        ];
        let voids = pick(&mut random, &kinds);
        let is_integer = random.bool();
        let mut heights = heights(&mut random, relief, columns, rows, cell);
        if is_integer {
            heights.iter_mut().for_each(|height| *height = height.round());
        }
        let whole = heights.clone();
        make_voids(&mut random, voids, columns, rows, &mut heights);
        if place == Place::OverPole {
            let pole = -first / DVec2::new(step.x_axis.x, step.y_axis.y);
            let is_near = |index: usize| {
                let at = DVec2::new((index % columns) as f64, (index / columns) as f64);
                (at - pole).abs().max_element() < CLEAR as f64
            };
            let near = (0..heights.len()).filter(|&index| is_near(index));
            near.for_each(|index| heights[index] = whole[index]);
        }
        if place == Place::Around && !has_whole_cell(&heights, columns) {
            // A cell may be whole where the raster is closed, all the same.
            heights = whole;
        }
        let options = options(&mut random, cell);
        let files = match place {
            Place::Files => in_files(&mut random, columns),
            Place::Around if random.bool() => in_files(&mut random, columns),
            _ => vec![(0, columns)],
        };
        let mut raster = Self {
            place,
            relief,
            voids,
            columns,
            rows,
            heights,
            options,
            epsg,
            to_crs: DAffine2::from_mat2_translation(step, first),
            is_point: random.bool(),
            is_integer,
            files,
            other: None,
        };
        if place == Place::Mixed {
            raster.other = Some(Box::new(raster.larger(&mut random)));
            raster.options.extend(mixing_options(&mut random));
        }
        raster
    }

    /// Half as far again on all sides, with finer or coarser cells, turned or not, and without voids.
    fn larger(&self, random: &mut Rng) -> Self {
        let size = DVec2::new(self.columns as f64, self.rows as f64);
        let middle = self.to_crs.transform_point2(size / 2.0);
        let coarseness = magnitude(random, 0.5, 4.0);
        let turn = DMat2::from_angle(pick(random, &[0.0, 0.0, 0.3, 2.0]));
        let step = turn * self.to_crs.matrix2 * coarseness;
        let side = 2.0 * size.length() / coarseness;
        let side = (side.ceil() as usize).clamp(2, 60);
        let cell = step.x_axis.length();
        let heights = heights(random, self.relief, side, side, cell);
        Self {
            voids: Voids::None,
            columns: side,
            rows: side,
            to_crs: DAffine2::from_mat2_translation(step, middle - step * DVec2::splat(side as f64 / 2.0)),
            heights: if self.is_integer {
                heights.into_iter().map(f32::round).collect()
            } else {
                heights
            },
            files: vec![(0, side)],
            ..self.clone()
        }
    }

    /// Code of its reference system.
    #[must_use]
    pub fn epsg(&self) -> u16 {
        self.epsg
    }

    /// Coordinates of a place on its grid.
    #[must_use]
    pub fn place(&self, grid: DVec2) -> DVec2 {
        self.to_crs.transform_point2(grid)
    }

    /// Whether some four neighbouring samples are all there.
    #[must_use]
    pub fn has_surface(&self) -> bool {
        self.other.is_some() || has_whole_cell(&self.heights, self.columns)
    }

    /// Writes its files into a folder and returns their names.
    ///
    /// # Errors
    /// When that fails.
    pub fn write(&self, folder: &Path) -> Result<Vec<String>> {
        let of_other = self.other.iter().map(|other| (other.as_ref(), 0, other.columns));
        let own = self.files.iter().map(|&(first, columns)| (self, first, columns));
        own.chain(of_other)
            .enumerate()
            .map(|(index, (raster, first, columns))| {
                let name = format!("{index}.tif");
                raster.write_file(&folder.join(&name), first, columns)?;
                Ok(name)
            })
            .collect()
    }

    fn write_file(&self, path: &PathBuf, first: usize, columns: usize) -> Result<()> {
        let rows = self.heights.chunks(self.columns);
        let values = rows.flat_map(|row| row[first..first + columns].iter().copied());
        let values: Vec<f32> = values
            .map(|height| if height.is_nan() { NODATA } else { height })
            .collect();
        let mut file = TiffEncoder::new(BufWriter::new(File::create(path)?))?;
        let size = [columns as u32, self.rows as u32];
        if self.is_integer {
            let mut image = file.new_image::<colortype::GrayI16>(size[0], size[1])?;
            self.write_tags(image.encoder(), first)?;
            let values: Vec<i16> = values.into_iter().map(|value| value as i16).collect();
            image.write_data(&values)?;
        } else {
            let mut image = file.new_image::<colortype::Gray32Float>(size[0], size[1])?;
            self.write_tags(image.encoder(), first)?;
            image.write_data(&values)?;
        }
        Ok(())
    }

    /// GeoTIFF 1.1: the matrix from pixels to coordinates, and the keys of the reference system.
    fn write_tags<W: std::io::Write + std::io::Seek>(
        &self,
        image: &mut tiff::encoder::DirectoryEncoder<'_, W, tiff::encoder::TiffKindStandard>,
        first: usize,
    ) -> Result<()> {
        const MODEL_TRANSFORMATION: Tag = Tag::Unknown(34264);
        const GEO_KEYS: Tag = Tag::Unknown(34735);
        const GDAL_NODATA: Tag = Tag::Unknown(42113);
        let corner = DVec2::new(first as f64, 0.0) - if self.is_point { 0.0 } else { 0.5 };
        let origin = self.to_crs.transform_point2(corner);
        let [x, y] = [self.to_crs.matrix2.x_axis, self.to_crs.matrix2.y_axis];
        let matrix = [
            x.x, y.x, 0.0, origin.x, x.y, y.y, 0.0, origin.y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ];
        image.write_tag(MODEL_TRANSFORMATION, &matrix[..])?;
        let (model, crs_key) = if self.epsg == 4326 { (2, 2048) } else { (1, 3072) };
        let keys = [
            [1, 1, 0, 3],
            [1024, 0, 1, model],
            [1025, 0, 1, 1 + u16::from(self.is_point)],
            [crs_key, 0, 1, self.epsg],
        ];
        image.write_tag(GEO_KEYS, keys.as_flattened())?;
        image.write_tag(GDAL_NODATA, NODATA.to_string().as_str())?;
        Ok(())
    }
}

fn has_whole_cell(heights: &[f32], columns: usize) -> bool {
    let is_there = |column: usize, row: usize| !heights[row * columns + column].is_nan();
    let whole =
        |x: usize, y: usize| is_there(x, y) && is_there(x + 1, y) && is_there(x, y + 1) && is_there(x + 1, y + 1);
    (0..heights.len() / columns - 1).any(|y| (0..columns - 1).any(|x| whole(x, y)))
}

fn pick<T: Copy>(random: &mut Rng, from: &[T]) -> T {
    from[random.usize(0..from.len())]
}

fn between(random: &mut Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.f64()
}

/// From `low` to `high`, each order of magnitude as likely as another.
fn magnitude(random: &mut Rng, low: f64, high: f64) -> f64 {
    between(random, low.ln(), high.ln()).exp()
}

/// EPSG code, steps from column to column and from row to row, and the first sample.
fn place_of(random: &mut Rng, place: Place, columns: &mut usize, rows: &mut usize) -> (u16, DMat2, DVec2) {
    let north_up = |cell: f64| DMat2::from_diagonal(DVec2::new(cell, -cell));
    match place {
        Place::Utm | Place::Files | Place::Turned | Place::Fine | Place::Mixed => {
            let epsg = pick(random, &[32600, 32700]) + random.u16(1..=60);
            let first = DVec2::new(between(random, 3e5, 6.5e5), between(random, 1e6, 8e6));
            let cell = match place {
                Place::Fine => magnitude(random, 0.1, 1.0),
                _ => magnitude(random, 1.0, 1000.0),
            };
            if place == Place::Files {
                *columns = (*columns).max(6);
            }
            let turn = DMat2::from_angle(between(random, -3.1, 3.1));
            let shear = DMat2::from_cols(DVec2::X, DVec2::new(between(random, -0.4, 0.4), 1.0));
            let step = north_up(cell);
            (
                epsg,
                if place == Place::Turned {
                    turn * shear * step
                } else {
                    step
                },
                first,
            )
        }
        Place::Geographic | Place::Antimeridian => {
            let cell = magnitude(random, 1e-4, 0.1);
            let middle = match place {
                Place::Antimeridian => 180.0,
                _ => between(random, -170.0, 165.0),
            };
            let west = middle - cell * between(random, 0.0, *columns as f64 - 1.0);
            (4326, north_up(cell), DVec2::new(west, between(random, -65.0, 75.0)))
        }
        Place::Coarse => {
            let cell = pick(random, &[1.0, 2.0, 5.0, 10.0]);
            *columns = (*columns).min((360.0 / cell) as usize + 1);
            *rows = (*rows).min((160.0 / cell) as usize);
            let height = cell * (*rows as f64 - 1.0);
            let north = 80.0 - ((160.0 - height) * random.f64()).floor();
            (
                4326,
                north_up(cell),
                DVec2::new(-180.0 + random.u8(0..20) as f64, north),
            )
        }
        Place::PoleRow => {
            let cell = magnitude(random, 0.01, 1.0);
            let north = random.bool();
            let first = if north {
                90.0
            } else {
                -90.0 + cell * (*rows as f64 - 1.0)
            };
            (4326, north_up(cell), DVec2::new(between(random, -180.0, 100.0), first))
        }
        Place::Around => {
            let around = random.usize(12..=60);
            // The first column may be there again at the end.
            *columns = around + random.usize(0..=1);
            let step = 360.0 / around as f64;
            let down = (*rows - 1) as f64;
            // Rows are at both poles, half a cell from them, or anywhere.
            let (height, north) = match random.u8(0..3) {
                0 => (180.0 / down, 90.0),
                1 => (180.0 / (down + 1.0), 90.0 - 90.0 / (down + 1.0)),
                _ => (between(random, 0.2, 1.0) * 120.0 / down, between(random, 30.0, 90.0)),
            };
            let anywhere = between(random, -180.0, 180.0);
            let west = pick(random, &[-180.0, -180.0 + step / 2.0, 0.0, anywhere]);
            (
                4326,
                DMat2::from_diagonal(DVec2::new(step, -height)),
                DVec2::new(west, north),
            )
        }
        Place::OverPole => {
            // Each zoom has twice as many tiles at a pole as the one above: finer cells only take time.
            let cell = magnitude(random, 500.0, 50_000.0);
            (*columns, *rows) = (*columns + CLEAR * 2, *rows + CLEAR * 2);
            let within = |random: &mut Rng, count: usize| {
                let place = random.f64() * (count - 2 * CLEAR - 1) as f64 + CLEAR as f64;
                if random.bool() { place.round() } else { place }
            };
            let pole = DVec2::new(within(random, *columns), within(random, *rows));
            (
                pick(random, &[3413, 3031]),
                north_up(cell),
                DVec2::new(-pole.x, pole.y) * cell,
            )
        }
        Place::BesidePole => {
            let cell = magnitude(random, 10.0, 2000.0);
            let away = DVec2::from_angle(between(random, -3.1, 3.1)) * magnitude(random, 1e4, 5e5);
            // The whole raster is on the far side of its nearest corner.
            let size = DVec2::new(*columns as f64, *rows as f64) * cell;
            let low = DVec2::new(
                if away.x < 0.0 { away.x - size.x } else { away.x },
                if away.y < 0.0 { away.y - size.y } else { away.y },
            );
            (
                pick(random, &[3413, 3031]),
                north_up(cell),
                DVec2::new(low.x, low.y + size.y),
            )
        }
    }
}

fn heights(random: &mut Rng, relief: Relief, columns: usize, rows: usize, cell: f64) -> Vec<f32> {
    let base = between(random, -400.0, 3000.0);
    // The surface of a cell with a saddle of so many errors takes as many triangles: steeper ones only take time.
    let range = magnitude(random, 0.5, 1500.0).min(cell * 300.0);
    let slope = DVec2::new(between(random, -1.0, 1.0), between(random, -1.0, 1.0)) * range / 20.0;
    let waves = DVec2::new(between(random, 0.05, 1.5), between(random, 0.05, 1.5));
    let spike = (random.usize(0..columns), random.usize(0..rows));
    let terrace = random.usize(1..6);
    let mut height = |x: usize, y: usize| {
        let at = DVec2::new(x as f64, y as f64);
        match relief {
            Relief::Flat => 0.0,
            Relief::Ramp => slope.dot(at),
            Relief::Hills => range / 2.0 * ((at.x * waves.x).sin() + (at.y * waves.y).cos()),
            Relief::Noise => range * random.f64(),
            Relief::Spike => range * f64::from(u8::from((x, y) == spike)),
            Relief::Steps => range * ((x / terrace + y / terrace) % 2) as f64,
        }
    };
    let posts = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    posts.map(|(x, y)| (base + height(x, y)) as f32).collect()
}

fn make_voids(random: &mut Rng, voids: Voids, columns: usize, rows: usize, heights: &mut [f32]) {
    let part = between(random, 0.02, 0.4);
    let (x, y) = (random.usize(0..columns), random.usize(0..rows));
    let (width, depth) = (random.usize(1..=columns), random.usize(1..=rows));
    let edge: Vec<usize> = (0..rows).map(|_| random.usize(0..=columns / 2)).collect();
    for (index, height) in heights.iter_mut().enumerate() {
        let (column, row) = (index % columns, index / columns);
        let cell = (x.min(columns - 2), y.min(rows - 2));
        let is_void = match voids {
            Voids::None => false,
            Voids::Scattered => random.f64() < part,
            Voids::Hole => (x..x + width).contains(&column) && (y..y + depth).contains(&row),
            Voids::Ragged => column < edge[row],
            Voids::AllButOneCell => !((cell.0..cell.0 + 2).contains(&column) && (cell.1..cell.1 + 2).contains(&row)),
            Voids::AllButOneSample => (column, row) != (x, y),
        };
        if is_void {
            *height = f32::NAN;
        }
    }
}

fn options(random: &mut Rng, cell: f64) -> Vec<String> {
    let mut options = Vec::new();
    if random.bool() {
        let error = magnitude(random, 0.02, 2.0) * cell;
        options.extend(["--max-error".to_owned(), format!("{error:.3e}")]);
    }
    let bound = pick(random, &["surface", "surface", "samples"]);
    let quality = pick(random, &["fast", "default", "best"]);
    options.extend(["--bound", bound, "--quality", quality].map(str::to_owned));
    options
}

/// How several rasters become one surface.
fn mixing_options(random: &mut Rng) -> Vec<String> {
    let mut options = Vec::new();
    if random.bool() {
        options.extend(["--blend".to_owned(), format!("{}", random.u32(0..500))]);
    }
    if random.bool() {
        options.extend(["--priority", "order"].map(str::to_owned));
    }
    if random.bool() {
        options.extend(["--voids", "fill"].map(str::to_owned));
    }
    options
}

/// Runs of at least two columns that abut, or overlap by up to three.
fn in_files(random: &mut Rng, columns: usize) -> Vec<(usize, usize)> {
    let cut = random.usize(2..=columns - 3);
    let overlap = random.usize(0..=3).min(columns - cut);
    vec![(0, cut + overlap), (cut, columns - cut)]
}
