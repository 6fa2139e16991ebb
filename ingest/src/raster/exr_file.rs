//! OpenEXR height maps, which GDAL does not read here. They hold no position: `--crs` and `--bounds` give it.

use std::ops::Range;
use std::path::Path;
use std::sync::OnceLock;

use exr::meta::MetaData;
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};

use super::layout::Layout;
use super::vertical::HeightReference;
use super::{ReadError, ReadOptions, crs, placement};

/// Channels that hold heights, the likeliest first.
const CHANNELS: [&str; 5] = ["height", "Z", "Y", "R", "A"];

/// A height map whose header was read.
pub(super) struct ExrFile {
    layout: Layout,
    whole: OnceLock<Vec<f32>>,
}

impl ExrFile {
    pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Self, ReadError> {
        let metadata = MetaData::read_from_file(path, false).map_err(|error| ReadError::unreadable(path, error))?;
        let no_image = || ReadError::unreadable(path, "it has no image without depth");
        let header = metadata
            .headers
            .iter()
            .find(|header| !header.deep)
            .ok_or_else(no_image)?;
        let (columns, rows) = (header.layer_size.width(), header.layer_size.height());
        placement::check_size(path, columns, rows, options.limits.samples)?;
        let definition = options
            .overrides
            .crs
            .as_ref()
            .ok_or_else(|| ReadError::NoCrs(path.to_owned()))?;
        let bounds = options
            .overrides
            .bounds
            .ok_or_else(|| ReadError::NoPosition(path.to_owned()))?;
        let to_crs = placement::from_bounds(bounds, columns, rows)?;
        let reference = crs::from_user(definition)?;
        let of_crs = crs::vertical_datum(&reference);
        let heights = HeightReference::of_file(path, of_crs, None, &options.overrides.vertical)?;
        let layout = Layout::new(path, (columns, rows), to_crs, &reference, heights)?;
        Ok(Self {
            layout,
            whole: OnceLock::new(),
        })
    }

    pub(super) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Metres of a rectangle of samples, row by row. The format is read whole, once.
    pub(super) fn read(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f64>, ReadError> {
        let whole = match self.whole.get() {
            Some(whole) => whole,
            None => {
                let metres = self.metres()?;
                self.whole.get_or_init(|| metres)
            }
        };
        let row = |row: usize| &whole[row * self.layout.columns..][columns.clone()];
        Ok(rows.flat_map(row).map(|&metres| f64::from(metres)).collect())
    }

    fn metres(&self) -> Result<Vec<f32>, ReadError> {
        let path = &self.layout.path;
        let image = read_first_flat_layer_from_file(path).map_err(|error| ReadError::unreadable(path, error))?;
        let channels = &image.layer_data.channel_data.list;
        let named = |name: &&str| channels.iter().find(|channel| channel.name.eq_case_insensitive(name));
        let channel = CHANNELS.iter().find_map(named).or(channels.first());
        let metres: Vec<f32> = match channel.map(|channel| &channel.sample_data) {
            Some(FlatSamples::F16(values)) => values.iter().map(|value| value.to_f32()).collect(),
            Some(FlatSamples::F32(values)) => values.clone(),
            Some(FlatSamples::U32(values)) => values.iter().map(|&value| value as f32).collect(),
            None => Vec::new(),
        };
        if metres.len() != self.layout.columns * self.layout.rows {
            return Err(ReadError::unreadable(path, "its height channel is not a full image"));
        }
        Ok(metres)
    }
}
