//! Archives that hold one raster.

use std::path::{Path, PathBuf};

use super::ReadError;
use super::drivers::is_raster;

/// What GDAL is to open for a file: the raster inside it, if it is a `.zip`. GDAL knows `.hgt.zip` by itself.
///
/// # Errors
/// When the archive cannot be read, or holds no raster or several.
pub(super) fn in_zip(path: &Path) -> Result<PathBuf, ReadError> {
    let name = path.to_string_lossy().to_lowercase();
    if !name.ends_with(".zip") || name.ends_with(".hgt.zip") {
        return Ok(path.to_owned());
    }
    let inside = Path::new("/vsizip").join(format!("{{{}}}", path.display()));
    let entries = gdal::vsi::read_dir(&inside, true).map_err(|error| ReadError::gdal(path, error))?;
    let mut rasters: Vec<PathBuf> = entries.into_iter().filter(|entry| is_raster(entry)).collect();
    match (rasters.pop(), rasters.len()) {
        (Some(only), 0) => Ok(inside.join(only)),
        (Some(_), others) => Err(ReadError::unreadable(
            path,
            format!("it holds {} rasters; unpack it", others + 1),
        )),
        (None, _) => Err(ReadError::unreadable(path, "it holds no raster")),
    }
}
