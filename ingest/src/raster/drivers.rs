//! Which of GDAL's drivers may open a file.

use std::sync::Once;

use gdal::DriverManager;

/// Formats of elevation data whose drivers read the named file and its plain side files, nothing else. VRT and its
/// like are left out on purpose: they name other files and addresses.
const DRIVERS: [&str; 21] = [
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
/// Megabytes of unpacked blocks that GDAL may keep, all files together.
const BLOCK_CACHE: &str = "32";

/// Once a process: GDAL keeps its messages to itself (they come back as errors), and forgets all drivers but ours.
pub(super) fn prepare_gdal() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        gdal::config::set_error_handler(|_, _, _| {});
        // Blocks are read once and in order: more would only be memory.
        let _ = gdal::config::set_config_option("GDAL_CACHEMAX", BLOCK_CACHE);
        DriverManager::prevent_auto_registration();
        DriverManager::register_all();
        let unwanted: Vec<_> = DriverManager::all()
            .filter(|driver| !DRIVERS.contains(&driver.short_name().as_str()))
            .collect();
        unwanted.iter().for_each(DriverManager::deregister_driver);
    });
}
