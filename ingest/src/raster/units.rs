//! Units of height by the names that files give them.

/// Metres in the unit that a raster calls `name`; None for a name that is not known. No name means metres.
pub(super) fn metres_in(name: &str) -> Option<f64> {
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
