//! Units of height by the names that files give them.

/// Share of a unit within which two are the same: the foot and the US survey foot are a 500,000th apart.
const SAME: f64 = 1e-7;
/// Share of a unit within which a scale is likely to stand for it.
const LIKELY: f64 = 1e-3;

/// Metres in the unit of a file's heights, and what the person is told of it: what they say themselves goes first, then the band's
/// own unit, then that of the vertical coordinate reference system. `scale` makes heights in that unit of stored values.
pub(super) fn of_heights(band: &str, of_crs: Option<f64>, said: Option<f64>, scale: f64) -> (f64, Vec<String>) {
    let known = metres_in(band).filter(|_| !band.trim().is_empty());
    let is_unknown = metres_in(band).is_none();
    let metres = said.or(known).or(of_crs).unwrap_or(1.0);
    let differ = |&(a, b): &(f64, f64)| (a / b - 1.0).abs() > SAME;
    let either = known.zip(of_crs).filter(|_| said.is_none()).filter(differ);
    let against = said.zip(known.or(of_crs)).filter(differ);
    let is_twice = metres != 1.0 && (scale / metres - 1.0).abs() < LIKELY;
    let remarks = [
        (is_unknown && said.is_none())
            .then(|| format!("unit `{band}` is not known, {metres} m are taken for it; if that is wrong, say it by --unit")),
        either.map(|(band, crs)| {
            format!(
                "its unit of height is {band} m by its band, which counts, and {crs} m by its coordinate reference system; if that is \
                 wrong, say it by --unit"
            )
        }),
        against.map(|(said, own)| format!("its unit of height is {said} m by --unit, {own} m by what it says itself")),
        is_twice.then(|| {
            format!("both its scale and its unit are {metres}, and each is applied; if the scale alone makes metres, say --unit metre")
        }),
    ];
    (metres, remarks.into_iter().flatten().collect())
}

/// Metres in the unit that a raster calls `name`; None for a name that is not known. No name means metres.
#[must_use]
pub fn metres_in(name: &str) -> Option<f64> {
    const TABLE: [(&[&str], f64); 7] = [
        (&["", "m", "metre", "metres", "meter", "meters"], 1.0),
        (&["dm", "decimetre", "decimetres", "decimeter", "decimeters"], 0.1),
        (&["cm", "centimetre", "centimetres", "centimeter", "centimeters"], 0.01),
        (&["mm", "millimetre", "millimetres", "millimeter", "millimeters"], 0.001),
        (&["km", "kilometre", "kilometres", "kilometer", "kilometers"], 1000.0),
        (
            &["ft", "foot", "feet", "international foot", "international feet"],
            0.3048,
        ),
        (
            &[
                "us-ft",
                "us-foot",
                "ftus",
                "us_ft",
                "us foot",
                "us feet",
                "us survey foot",
                "us survey feet",
                "foot_us",
            ],
            1200.0 / 3937.0,
        ),
    ];
    let name = name.trim().to_lowercase();
    TABLE
        .iter()
        .find(|(names, _)| names.contains(&name.as_str()))
        .map(|&(_, metres)| metres)
}

#[cfg(test)]
#[path = "units_tests.rs"]
mod tests;
