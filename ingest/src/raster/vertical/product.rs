//! What products of elevation are above, by the names of their files: most say it in their documents alone.

use std::path::Path;
use std::sync::LazyLock;

use regex::Regex;

use super::datum::Datum;

/// Files of one product.
pub(super) struct Product {
    pub(super) name: &'static str,
    pattern: Regex,
    pub(super) datum: Datum,
}

/// Patterns of file names, in the order in which they are tried; products that are above the ellipsoid are told apart first.
const PRODUCTS: [(&str, &str, &str); 16] = [
    ("an ellipsoidal DEM", r"(?i)(\.wgs84$|[_.-]ellipsoid)", "ellipsoid"),
    ("NASADEM HGTS", r"(?i)^NASADEM_HGTS_", "ellipsoid"),
    ("NASADEM", r"(?i)^NASADEM_HGT_", "EGM96"),
    ("TanDEM-X", r"^TDM1_DEM__", "ellipsoid"),
    (
        "ArcticDEM or REMA",
        r"(?i)(^SETSM_|^\d\d_\d\d(_\d_\d)?_\d+m_v\d.*_dem|arcticdem|^rema_)",
        "ellipsoid",
    ),
    ("Copernicus DEM", r"(?i)^Copernicus_DSM_", "EGM2008"),
    ("FABDEM", r"(?i)_FABDEM_", "EGM2008"),
    ("GEDTM30", r"(?i)^gedtm_", "EGM2008"),
    ("CGIAR SRTM", r"(?i)^srtm_\d\d_\d\d\b", "EGM96"),
    ("ASTER GDEM", r"^ASTGTM", "EGM96"),
    ("ALOS World 3D", r"(?i)(^ALPSMLC30_|_AVE_DSM)", "EGM96"),
    ("SRTM", r"^[NS]\d\d[EW]\d\d\d(\.SRTMGL[13])?\.hgt(\.zip)?$", "EGM96"),
    ("SRTM", r"(?i)^SRTMGL[13]_", "EGM96"),
    ("USGS 1 m DEM", r"(?i)^USGS_(1M|one_meter)_", "NAVD88"),
    (
        "USGS 3DEP",
        r"(?i)^(USGS_(13|1|2)_[ns]\d|ned\d\d?_|n\d\dw\d\d\d_)",
        "NAVD88",
    ),
    ("swissALTI3D", r"(?i)^swissalti3d_", "LN02"),
];

static KNOWN: LazyLock<Vec<Product>> = LazyLock::new(|| {
    let product = |(name, pattern, datum)| Product {
        name,
        pattern: Regex::new(pattern).expect("the patterns above are regular expressions"),
        datum: Datum::named(datum),
    };
    PRODUCTS.into_iter().map(product).collect()
});

/// The product that a file is of, by its name.
pub(super) fn of(path: &Path) -> Option<&'static Product> {
    let name = path.file_name()?.to_string_lossy();
    KNOWN.iter().find(|product| product.pattern.is_match(&name))
}
