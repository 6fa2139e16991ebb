//! Heights above the sea, for programs that know no others.

use terrain_tiles::metadata::Metadata;

use super::unusable::Unusable;
use crate::raster::{SeaLevel, UNSPECIFIED, is_ellipsoid};

/// How heights of an archive become heights above the sea.
pub(super) struct AboveSea {
    /// What is taken off heights above the ellipsoid; none where the archive's are above the sea, or above nobody knows what.
    geoid: Option<SeaLevel>,
    /// What heights of the archive are above.
    above: String,
}

impl AboveSea {
    /// By the grid `geoid`, or that of EGM96, where heights are above the ellipsoid. `option` is what asks for it.
    pub(super) fn of(metadata: &Metadata, option: &str, geoid: Option<&str>) -> Result<Self, Unusable> {
        let above = metadata.source.tiles_above().to_owned();
        let geoid = is_ellipsoid(&above).then(|| SeaLevel::new(option, geoid)).transpose();
        Ok(Self {
            geoid: geoid.map_err(|error| Unusable(error.to_string()))?,
            above,
        })
    }

    /// A height of the archive at degrees of longitude and latitude.
    pub(super) fn height(&self, longitude: f64, latitude: f64, height: f64) -> Result<f64, Unusable> {
        let Some(geoid) = &self.geoid else { return Ok(height) };
        let undulation = geoid.height(longitude, latitude);
        let beyond = || Unusable(format!("{} does not reach {longitude}, {latitude}", geoid.name()));
        Ok(height - undulation.ok_or_else(beyond)?)
    }

    /// What heights of the pack are above.
    pub(super) fn in_words(&self) -> String {
        match &self.geoid {
            Some(geoid) => format!("the geoid of {}", geoid.name()),
            None => self.above.clone(),
        }
    }

    /// What the person has to know.
    pub(super) fn remark(&self) -> Option<String> {
        let is_unknown = self.geoid.is_none() && self.above == UNSPECIFIED;
        is_unknown.then(|| {
            "nothing says what heights of the archive are above; they are taken as above the sea, as they are"
                .to_owned()
        })
    }
}
