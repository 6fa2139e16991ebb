//! Which of GDAL's drivers may open a file.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use gdal::DriverManager;

/// Formats of elevation data whose drivers read the named file and its plain side files, nothing else. VRT and its
/// like are left out on purpose: they name other files and addresses.
pub(super) const DRIVERS: [&str; 21] = [
    "AAIGrid",
    "AIG",
    "BAG",
    "BT",
    "DTED",
    "EHdr",
    "ENVI",
    "GRIB",
    "GSAG",
    "GSBG",
    "GTX",
    "GTiff",
    "GXF",
    "HFA",
    "JP2OpenJPEG",
    "netCDF",
    "PNG",
    "PNM",
    "SRTMHGT",
    "USGSDEM",
    "XYZ",
];
/// Formats of polygons.
pub(super) const VECTOR_DRIVERS: [&str; 4] = ["GeoJSON", "ESRI Shapefile", "FlatGeobuf", "GPKG"];
/// The driver of virtual rasters, for whoever asks for it.
pub(super) const VIRTUAL: &str = "VRT";
/// That of rasters in memory.
const MEMORY: &str = "MEM";
/// How names of rasters end that are looked for in a folder or an archive, in small letters.
const ENDINGS: [&str; 22] = [
    "asc", "bag", "bil", "bt", "dem", "dt0", "dt1", "dt2", "flt", "grb", "grb2", "grd", "gtx", "gxf", "hgt", "img",
    "jp2", "nc", "tif", "tiff", "xyz", "zip",
];
/// Megabytes of unpacked blocks that GDAL may keep, all files together.
const BLOCK_CACHE: &str = "32";

/// Whether a file looks like a raster, by its name.
#[must_use]
pub fn is_raster(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    extension.to_str().is_some_and(|extension| ENDINGS.contains(&extension))
}

/// GDAL keeps its messages to itself (they come back as errors), and forgets all drivers but ours; that of virtual rasters, too, as
/// long as nobody asked for it.
pub(super) fn prepare_gdal(with_virtual: bool) {
    static HAS_VIRTUAL: Mutex<Option<bool>> = Mutex::new(None);
    let mut has_virtual = HAS_VIRTUAL.lock().unwrap_or_else(PoisonError::into_inner);
    if has_virtual.is_some_and(|has| has || !with_virtual) {
        return;
    }
    gdal::config::set_error_handler(|_, _, _| {});
    // Blocks are read once and in order: more would only be memory.
    let _ = gdal::config::set_config_option("GDAL_CACHEMAX", BLOCK_CACHE);
    DriverManager::prevent_auto_registration();
    keep(with_virtual.then_some(VIRTUAL));
    *has_virtual = Some(with_virtual);
}

/// The same, for whoever writes a file by a driver that keeps parts of it in memory. Nothing may be opened by its name from then on that
/// others have named: that driver takes addresses in memory for names.
pub(super) fn prepare_gdal_to_write() {
    prepare_gdal(false);
    keep(Some(MEMORY));
}

/// Forgets all drivers but ours and one more.
fn keep(one_more: Option<&str>) {
    DriverManager::register_all();
    let is_wanted = |name: &str| {
        DRIVERS.contains(&name) || VECTOR_DRIVERS.contains(&name) || one_more.is_some_and(|more| name == more)
    };
    let unwanted: Vec<_> = DriverManager::all()
        .filter(|driver| !is_wanted(&driver.short_name()))
        .collect();
    unwanted.iter().for_each(DriverManager::deregister_driver);
}
