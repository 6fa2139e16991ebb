//! Vertical datums by the names that people, files and coordinate reference systems give them.

use std::fmt;

use super::super::ReadError;

/// What heights are above where nothing says so.
pub(crate) const UNSPECIFIED: &str = "unspecified";
pub(super) const ELLIPSOID: &str = "WGS 84 ellipsoid";

/// What heights are above.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Datum {
    Unspecified,
    Ellipsoid,
    /// A model of the geoid, or of another surface near the sea's, of which grids are known.
    Model(&'static Model),
    /// Another one.
    Named(String),
}

/// A surface that heights are counted from, and the grids of its height above the ellipsoid.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Model {
    pub(super) name: &'static str,
    /// EPSG's code of heights above it.
    code: u32,
    /// As people and files call it, without spaces, in small letters.
    aliases: &'static [&'static str],
    /// Names of grids, the first of which is the one to get.
    pub(super) grids: &'static [&'static str],
    /// Whose ellipsoid the grids are above; none where it is that of WGS 84.
    frame: Option<&'static Frame>,
}

/// A national or continental reference frame with an ellipsoid of its own, which is that of WGS 84 at another place.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Frame {
    pub(super) name: &'static str,
    /// How far heights above it are from heights above that of WGS 84.
    apart: &'static str,
}

impl Frame {
    /// To be said behind "the ellipsoid".
    pub(super) fn remark(&self) -> String {
        format!(" of {} ({} from that of WGS 84)", self.name, self.apart)
    }
}

/// North America's was put 2 m beside the Earth's centre; plates of the others move, but level.
const NAD83: Frame = Frame {
    name: "NAD83",
    apart: "up to 2 m",
};
const ETRS89: Frame = Frame {
    name: "ETRS89",
    apart: "less than 0.2 m",
};
const NZGD2000: Frame = Frame {
    name: "NZGD2000",
    apart: "less than 0.2 m",
};

pub(super) const MODELS: [Model; 9] = [
    Model {
        name: "EGM96",
        code: 5773,
        aliases: &["egm96", "egm1996"],
        grids: &["us_nga_egm96_15.tif", "egm96_15.gtx"],
        frame: None,
    },
    Model {
        name: "EGM2008",
        code: 3855,
        aliases: &["egm2008", "egm08"],
        grids: &["us_nga_egm08_25.tif", "egm08_25.gtx"],
        frame: None,
    },
    Model {
        name: "EGM84",
        code: 5798,
        aliases: &["egm84", "egm1984"],
        grids: &["us_nga_egm84_30.tif"],
        frame: None,
    },
    Model {
        name: "NAVD88",
        code: 5703,
        aliases: &["navd88", "northamericanverticaldatum1988"],
        grids: &["us_noaa_g2018u0.tif", "g2018u0.gtx"],
        frame: Some(&NAD83),
    },
    Model {
        name: "CGVD2013",
        code: 6647,
        aliases: &["cgvd2013"],
        grids: &["ca_nrc_CGG2013n83.tif"],
        frame: Some(&NAD83),
    },
    Model {
        name: "DHHN2016",
        code: 7837,
        aliases: &["dhhn2016"],
        grids: &["de_bkg_gcg2016.tif"],
        frame: Some(&ETRS89),
    },
    Model {
        name: "LN02",
        code: 5728,
        aliases: &["ln02"],
        grids: &["ch_swisstopo_chgeo2004_ETRS89_LN02.tif"],
        frame: Some(&ETRS89),
    },
    Model {
        name: "NAP",
        code: 5709,
        aliases: &["nap", "amsterdamordnance"],
        grids: &["nl_nsgi_nlgeo2018.tif"],
        frame: Some(&ETRS89),
    },
    Model {
        name: "NZVD2016",
        code: 7839,
        aliases: &["nzvd2016", "newzealandverticaldatum2016"],
        grids: &["nz_linz_nzgeoid2016.tif"],
        frame: Some(&NZGD2000),
    },
];

impl Datum {
    /// The one that a user names: an alias or an EPSG code.
    ///
    /// # Errors
    /// When nothing is called so.
    pub(super) fn said(name: &str) -> Result<Self, ReadError> {
        match Self::named(name) {
            Self::Named(_) | Self::Unspecified => Err(ReadError::UnknownDatum(name.to_owned())),
            known => Ok(known),
        }
    }

    /// Whose ellipsoid its grids are above; none where it is that of WGS 84, or not known.
    pub(super) fn frame(&self) -> Option<&'static Frame> {
        match self {
            Self::Model(model) => model.frame,
            _ => None,
        }
    }

    /// The one that a file names.
    pub(super) fn named(name: &str) -> Self {
        let short: String = name
            .chars()
            .filter(|letter| letter.is_alphanumeric())
            .flat_map(char::to_lowercase)
            .collect();
        let code = name.trim().strip_prefix("EPSG:").and_then(|code| code.parse().ok());
        if short.contains("ellipsoid") || matches!(code, Some(4979 | 4978)) {
            return Self::Ellipsoid;
        }
        // A short alias may begin a longer name of another datum.
        let is_called = |alias: &str| {
            short == alias || alias.len() > 4 && short.contains(alias) || short == format!("{alias}height")
        };
        let known = MODELS
            .iter()
            .find(|model| Some(model.code) == code || model.aliases.iter().any(|alias| is_called(alias)));
        match known {
            Some(model) => Self::Model(model),
            None if short.is_empty() || short == "unknown" => Self::Unspecified,
            None => Self::Named(name.trim().to_owned()),
        }
    }
}

impl fmt::Display for Datum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unspecified => UNSPECIFIED,
            Self::Ellipsoid => ELLIPSOID,
            Self::Model(model) => model.name,
            Self::Named(name) => name,
        })
    }
}
