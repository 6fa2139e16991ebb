//! Places as clients write them.

use serde::Deserialize;
use utoipa::IntoParams;

use crate::failure::Failure;
use crate::heights::Place;

/// Most places of a request.
pub(super) const MOST_PLACES: usize = 10_000;

/// Places in an address.
#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct Asked {
    /// Degrees, of one place.
    longitude: Option<f64>,
    /// Degrees, of one place.
    latitude: Option<f64>,
    /// Or `latitude,longitude|latitude,longitude|…`, or `enc:` and an encoded polyline of 5 decimals.
    locations: Option<String>,
}

impl Asked {
    pub(super) fn places(&self) -> Result<Vec<Place>, Failure> {
        match (self.longitude, self.latitude, &self.locations) {
            (Some(longitude), Some(latitude), None) => places_of(&[[longitude, latitude]]),
            (None, None, Some(text)) => places_in(text),
            _ => Err(Failure::BadRequest(
                "longitude and latitude of one place are needed, or locations of several".to_owned(),
            )),
        }
    }
}

/// `lat,lng|lat,lng` or `enc:POLYLINE`.
pub(super) fn places_in(text: &str) -> Result<Vec<Place>, Failure> {
    if let Some(polyline) = text.strip_prefix("enc:") {
        return decoded(polyline, 5);
    }
    let pair = |(index, text): (usize, &str)| {
        let numbers = text
            .split_once(',')
            .map(|(one, two)| (one.trim().parse(), two.trim().parse()));
        match numbers {
            Some((Ok(latitude), Ok(longitude))) => Ok([longitude, latitude]),
            _ => Err(Failure::BadRequest(format!(
                "place {index}, “{text}”, is no latitude,longitude"
            ))),
        }
    };
    let pairs: Vec<[f64; 2]> = text
        .split('|')
        .take(MOST_PLACES + 1)
        .enumerate()
        .map(pair)
        .collect::<Result<_, _>>()?;
    places_of(&pairs)
}

/// An encoded polyline (Google, *Encoded Polyline Algorithm Format*) of so many decimals.
pub(super) fn decoded(polyline: &str, decimals: u32) -> Result<Vec<Place>, Failure> {
    let line = polyline::decode_polyline(polyline, decimals)
        .map_err(|error| Failure::BadRequest(format!("the polyline: {error}")))?;
    let pairs: Vec<[f64; 2]> = line.0.iter().map(|point| [point.x, point.y]).collect();
    places_of(&pairs)
}

/// Places on the Earth; longitudes up to a whole turn away are brought within −180° to 180°.
pub(super) fn places_of(pairs: &[[f64; 2]]) -> Result<Vec<Place>, Failure> {
    if pairs.is_empty() || pairs.len() > MOST_PLACES {
        return Err(Failure::BadRequest(format!(
            "1 to {MOST_PLACES} places may be asked for"
        )));
    }
    let place = |(index, &[longitude, latitude]): (usize, &[f64; 2])| {
        if !(longitude.abs() <= 360.0 && latitude.abs() <= 90.0) {
            let reason = format!("place {index} is not on the Earth: longitude {longitude}, latitude {latitude}");
            return Err(Failure::BadRequest(reason));
        }
        let longitude = match longitude {
            east if east > 180.0 => east - 360.0,
            west if west < -180.0 => west + 360.0,
            longitude => longitude,
        };
        Ok(Place { longitude, latitude })
    };
    pairs.iter().enumerate().map(place).collect()
}
