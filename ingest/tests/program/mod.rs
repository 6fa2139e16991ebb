//! The program, run as a person runs it, on terrain made up for a test.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::run::run;

const WGS84: &str = r#"GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]"#;

/// Samples a degree of made-up terrain.
const A_DEGREE: usize = 1200;

/// Runs the program, which must succeed; its report.
pub(crate) fn report(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, &[arguments, &["--json", "--quiet"]].concat());
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Runs the program, which must fail with an exit code; its last line.
pub(crate) fn failure(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = run(folder, &[arguments, &["--quiet"]].concat());
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    error.lines().last().unwrap_or_default().to_owned()
}

/// A hilly land; metres.
pub(crate) fn hills(column: usize, row: usize) -> f64 {
    let (x, y) = (column as f64, row as f64);
    400.0 + 120.0 * (x / 23.0).sin() * (y / 31.0).cos() + 40.0 * ((x + 2.0 * y) / 7.0).sin()
}

/// Writes a raster of so many columns and rows, its first sample at a column and row of a lattice that all of them share.
pub(crate) fn write(path: &Path, first: [usize; 2], size: [usize; 2], height: impl Fn(usize, usize) -> f64) {
    let cell = 1.0 / A_DEGREE as f64;
    let west = 10.0 + (first[0] as f64 - 0.5) * cell;
    let south = 50.0 - (first[1] as f64 + size[1] as f64 - 0.5) * cell;
    let mut text = format!(
        "ncols {}\nnrows {}\nxllcorner {west:.12}\nyllcorner {south:.12}\ncellsize {cell:.15}\nNODATA_value -9999\n",
        size[0], size[1]
    );
    for row in first[1]..first[1] + size[1] {
        for column in first[0]..first[0] + size[0] {
            write!(text, "{:.3} ", height(column, row)).unwrap();
        }
        text.push('\n');
    }
    fs::write(path, text).unwrap();
    fs::write(path.with_extension("prj"), WGS84).unwrap();
}

/// Whether two files have the same bytes.
pub(crate) fn same(folder: &Path, a: &str, b: &str) -> bool {
    fs::read(folder.join(a)).unwrap() == fs::read(folder.join(b)).unwrap()
}
