//! OpenEXR height maps, which GDAL does not read here. They hold no position: `--crs` and `--bounds` give it.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use exr::meta::MetaData;
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};

use super::ReadError;
use super::reader::{Found, Reader};

/// Channels that hold heights, the likeliest first.
const CHANNELS: [&str; 5] = ["height", "Z", "Y", "R", "A"];

/// A height map whose header was read.
pub(super) struct ExrFile {
    path: PathBuf,
    size: [usize; 2],
    whole: OnceLock<Vec<f32>>,
}

impl ExrFile {
    pub(super) fn open(path: &Path) -> Result<Found, ReadError> {
        let metadata = MetaData::read_from_file(path, false).map_err(|error| ReadError::unreadable(path, error))?;
        let no_image = || ReadError::unreadable(path, "it has no image without depth");
        let header = metadata
            .headers
            .iter()
            .find(|header| !header.deep)
            .ok_or_else(no_image)?;
        let size = [header.layer_size.width(), header.layer_size.height()];
        let reader = Self {
            path: path.to_owned(),
            size,
            whole: OnceLock::new(),
        };
        Ok(Found::bare(reader, size, 1.0))
    }

    fn values(&self) -> Result<Vec<f32>, ReadError> {
        let path = &self.path;
        let image = read_first_flat_layer_from_file(path).map_err(|error| ReadError::unreadable(path, error))?;
        let channels = &image.layer_data.channel_data.list;
        let named = |name: &&str| channels.iter().find(|channel| channel.name.eq_case_insensitive(name));
        let channel = CHANNELS.iter().find_map(named).or(channels.first());
        let values: Vec<f32> = match channel.map(|channel| &channel.sample_data) {
            Some(FlatSamples::F16(values)) => values.iter().map(|value| value.to_f32()).collect(),
            Some(FlatSamples::F32(values)) => values.clone(),
            Some(FlatSamples::U32(values)) => values.iter().map(|&value| value as f32).collect(),
            None => Vec::new(),
        };
        if values.len() != self.size[0] * self.size[1] {
            return Err(ReadError::unreadable(path, "its height channel is not a full image"));
        }
        Ok(values)
    }
}

impl Reader for ExrFile {
    /// The format is read whole, once.
    fn stored(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f64>, ReadError> {
        let whole = match self.whole.get() {
            Some(whole) => whole,
            None => {
                let values = self.values()?;
                self.whole.get_or_init(|| values)
            }
        };
        let row = |row: usize| &whole[row * self.size[0]..][columns.clone()];
        Ok(rows.flat_map(row).map(|&value| f64::from(value)).collect())
    }
}
