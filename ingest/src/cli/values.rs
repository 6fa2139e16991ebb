//! Values of options: from text to numbers, or what is wrong with it.

use terrain_ingest::raster;

/// Numbers, or none of them.
#[derive(Clone)]
pub(crate) struct Values(pub(crate) Vec<f64>);

pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if number > 0.0 && number.is_finite() {
        Ok(number)
    } else {
        Err("must be a number above 0".to_owned())
    }
}

pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if number >= 0.0 && number.is_finite() {
        Ok(number)
    } else {
        Err("must be 0 or a number above it".to_owned())
    }
}

/// Metres in a unit.
pub(super) fn unit(text: &str) -> Result<f64, String> {
    let named = raster::metres_in(text).filter(|_| !text.is_empty());
    named.map_or_else(
        || positive(text).map_err(|_| "is no unit: metre, foot, us-foot …, or so many metres".to_owned()),
        Ok,
    )
}

pub(super) fn number(text: &str) -> Result<f64, String> {
    let number: f64 = text.trim().parse().map_err(|_| "not a number".to_owned())?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err("must be finite".to_owned())
    }
}

pub(super) fn values(text: &str) -> Result<Values, String> {
    if text.eq_ignore_ascii_case("none") {
        return Ok(Values(Vec::new()));
    }
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    numbers
        .map(Values)
        .map_err(|_| "needs a number, several with commas between them, or `none`".to_owned())
}

pub(super) fn pixel_size(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').map(positive).collect::<Result<_, _>>()?;
    match numbers[..] {
        [both] => Ok([both, both]),
        [across, down] => Ok([across, down]),
        _ => Err("needs one number, or two with a comma between them".to_owned()),
    }
}

pub(super) fn degrees(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (0.0..=180.0).contains(&number) {
        Ok(number)
    } else {
        Err("must be a number from 0 to 180".to_owned())
    }
}

pub(super) fn bounds(text: &str) -> Result<[f64; 4], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    numbers
        .ok()
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| "needs four numbers: WEST,SOUTH,EAST,NORTH".to_owned())
}

pub(super) fn place(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    match numbers[..] {
        [longitude, latitude] if longitude.abs() <= 360.0 && latitude.abs() <= 90.0 => Ok([longitude, latitude]),
        _ => Err("needs two numbers of degrees: LON,LAT".to_owned()),
    }
}

/// Posts along a side of a heightmap.
pub(super) fn posts(text: &str) -> Result<u32, String> {
    let count: u32 = text.parse().map_err(|_| "not a whole number".to_owned())?;
    if (3..=8193).contains(&count) && (count - 1).is_power_of_two() {
        Ok(count)
    } else {
        Err("must be a power of two and one, from 3 to 8193".to_owned())
    }
}

/// Bytes, from a number with K, M, G or T behind it.
pub(super) fn size(text: &str) -> Result<u64, String> {
    let (number, unit) = text.split_at(text.trim_end_matches(|unit: char| unit.is_ascii_alphabetic()).len());
    let factor = match unit.to_ascii_uppercase().trim_end_matches("IB").trim_end_matches('B') {
        "" => 1.0,
        "K" => 1024.0,
        "M" => 1_048_576.0,
        "G" => 1_073_741_824.0,
        "T" => 1_099_511_627_776.0,
        _ => return Err("is a number with K, M, G or T behind it".to_owned()),
    };
    Ok((positive(number)? * factor) as u64)
}
