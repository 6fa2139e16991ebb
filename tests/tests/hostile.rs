//! Damaged, odd and lying rasters, through the whole program: a right result, which `verify` measures again, or one line and exit
//! code 2, in time, in little memory, without a file opened that nobody named.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use rayon::prelude::*;
use serde_json::Value;
use tempfile::TempDir;
use terrain_tests::{files_below, program, sample, shared_data};

/// Seconds of a processor's time that a file may take: on a busy machine, too, what takes longer does not end.
const MOST_SECONDS: u32 = 60;
/// Bytes of memory that a file may take.
const MOST_MEMORY: u64 = 1_000_000_000;
/// Kilobytes of addresses that the program may ask for: far more than it uses, far less than a lying header may claim.
const MOST_ADDRESSES: u32 = 4_000_000;
/// Bytes of the files that are looked at: of larger ones there are other tests.
const MOST_BYTES: u64 = 400_000;
/// Coarse tiles, where it is the reading that is looked at: fine ones take time.
const COARSE: &[&str] = &["--max-error", "50"];
/// Files that take longer, and so are left out: walls of hundreds of errors in nearly every cell.
const SLOW: [&str; 1] = ["epsg_2853_with_us_feet.tif"];

/// What became of a file.
struct Outcome {
    line: String,
    is_built: bool,
}

/// Runs the program with limits; its exit code, none where a limit ended it, and what it wrote on standard error and output.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let limited = format!("ulimit -t {MOST_SECONDS}; ulimit -v {MOST_ADDRESSES}; exec \"$@\"");
    let output = Command::new("sh")
        .args(["-c", &limited, "sh"])
        .arg(program())
        .args(arguments)
        .args(["--json", "--quiet", "--jobs", "1"])
        .current_dir(folder)
        .output()
        .unwrap();
    let [error, report] = [output.stderr, output.stdout].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    (output.status.code(), error, report)
}

/// Builds and verifies an archive of a raster.
fn outcome(path: &Path, how: &[&str]) -> Outcome {
    let folder = TempDir::new().unwrap();
    let name = path.display().to_string();
    let (code, error, output) = run(
        folder.path(),
        &[&[&name, "-o", "out.pmtiles", "--quality", "fast"], how].concat(),
    );
    match code {
        Some(0) => {
            let report: Value = serde_json::from_str(&output).unwrap();
            let memory = report["peak_memory_bytes"].as_u64().unwrap();
            assert!(memory < MOST_MEMORY, "{name} takes {memory} bytes");
            let (code, error, measured) = run(folder.path(), &["verify", "out.pmtiles", &name]);
            assert_eq!(code, Some(0), "{name} does not hold: {error}{measured}");
            let seconds = report["seconds"].as_f64().unwrap();
            let megabytes = memory / 1_000_000;
            Outcome {
                line: format!("built and verified, {seconds:.1} s, {megabytes} MB"),
                is_built: true,
            }
        }
        Some(2) => {
            let lines: Vec<&str> = error.lines().collect();
            assert!(lines.len() == 1 && lines[0].starts_with("error: "), "{name}: {error}");
            assert!(!folder.path().join("out.pmtiles").exists(), "{name}");
            Outcome {
                line: lines[0].replace(&name, &path.file_name().unwrap().to_string_lossy()),
                is_built: false,
            }
        }
        code => panic!("{name}: exit code {code:?}: {error}"),
    }
}

/// Every file below a folder of the larger data set; prints what became of it, returns how many were built.
fn all_in(folder: &str, how: &[&str]) -> Option<usize> {
    let folder = shared_data(folder)?;
    let mut paths = files_below(&folder);
    let is_slow = |path: &Path| SLOW.iter().any(|slow| path.ends_with(slow));
    paths.retain(|path| !is_slow(path) && fs::metadata(path).unwrap().len() < MOST_BYTES);
    let outcomes: Vec<Outcome> = paths.par_iter().map(|path| outcome(path, how)).collect();
    for (path, outcome) in paths.iter().zip(&outcomes) {
        let name = path.strip_prefix(&folder).unwrap().display();
        println!("| {name} | {} |", outcome.line);
    }
    Some(outcomes.iter().filter(|outcome| outcome.is_built).count())
}

/// All in a folder, of which at least so many are built.
fn check(folder: &str, least: usize, how: &[&str]) {
    if let Some(built) = all_in(folder, how) {
        assert!(built >= least, "{built} of {folder} are built");
    }
}

#[test]
fn damaged_files_are_built_or_refused() {
    check("corrupt", 3, &[]);
}

#[test]
fn odd_tiffs_are_built_or_refused() {
    check("odd_tiff", 15, &[]);
}

#[test]
fn files_with_all_kinds_of_voids_are_built_or_refused() {
    check("nodata", 4, &[]);
}

#[test]
fn all_encodings_are_built_or_refused() {
    check("encodings", 27, COARSE);
}

#[test]
fn small_hard_cases_are_built_or_refused() {
    check("cases", 36, &[]);
}

/// Files of our own, for whoever has no others: the sample cut off, damaged, and names that mean more than a file to GDAL.
#[test]
fn our_own_damaged_files_are_built_or_refused() {
    let folder = TempDir::new().unwrap();
    let whole = fs::read(sample("jacksboro_fault.tif")).unwrap();
    let mut written: Vec<PathBuf> = Vec::new();
    let mut write = |name: String, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        written.push(path);
    };
    for length in [0, 1, 8, 100, 5000, whole.len() / 2, whole.len() - 1] {
        write(format!("first_{length}_bytes.tif"), &whole[..length]);
    }
    // Bytes of the directory, which is at one of the file's ends, turned around one by one.
    let near_ends = (0..4)
        .map(|index| index * 10)
        .chain((1..6).map(|index| whole.len() - index * 46));
    for at in near_ends {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xff;
        write(format!("byte_{at}_turned.tif"), &bytes);
    }
    write("two_bytes.r16".to_owned(), &[1, 2]);
    write("text.exr".to_owned(), b"no image");
    write("text.zip".to_owned(), b"PK\x03\x04 no archive");
    write(
        "text.asc".to_owned(),
        b"ncols 99999999\nnrows 99999999\nxllcorner 0\nyllcorner 0\ncellsize 1\n",
    );
    let outcomes: Vec<Outcome> = written.par_iter().map(|path| outcome(path, COARSE)).collect();
    for (path, outcome) in written.iter().zip(&outcomes) {
        println!("{}: {}", path.file_name().unwrap().display(), outcome.line);
    }
    let refused = outcomes.iter().filter(|outcome| !outcome.is_built).count();
    assert!(refused >= 10, "{refused} are refused");
}

/// What the program opens, by `strace`: the files named, files beside them with their names, its output, and the system's own.
#[test]
fn no_file_is_opened_that_nobody_named() {
    if Command::new("strace").arg("-V").output().is_err() {
        println!("skipped: strace is not here");
        return;
    }
    let folder = TempDir::new().unwrap();
    let secret = folder.path().join("secret.tif");
    fs::copy(sample("jacksboro_fault.tif"), &secret).unwrap();
    let named = secret.display();
    let vrt = format!(
        r#"<VRTDataset rasterXSize="2" rasterYSize="2"><SRS>EPSG:4326</SRS><GeoTransform>0,1,0,0,0,-1</GeoTransform>
        <VRTRasterBand dataType="Int16" band="1"><SimpleSource><SourceFilename>{named}</SourceFilename>
        <SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"#
    );
    fs::write(folder.path().join("sly.vrt"), &vrt).unwrap();
    fs::write(folder.path().join("sly.tif"), &vrt).unwrap();
    fs::copy(&secret, folder.path().join("dem.tif")).unwrap();
    // Side files that are virtual rasters: overviews, a mask.
    fs::write(folder.path().join("dem.tif.ovr"), &vrt).unwrap();
    fs::write(folder.path().join("dem.tif.msk"), &vrt).unwrap();
    let vsi = format!("/vsisubfile/0_1000,{named}");
    let wms = format!("<GDAL_WMS><Service name=\"TMS\"><ServerUrl>file://{named}</ServerUrl></Service></GDAL_WMS>");
    for (argument, code) in [
        ("sly.vrt", 2),
        ("sly.tif", 2),
        (&vsi, 2),
        (&vrt, 2),
        (&wms, 2),
        ("dem.tif", 0),
    ] {
        let status = Command::new("strace")
            .args(["-f", "-qq", "-e", "trace=open,openat", "-o", "trace"])
            .arg(program())
            .args([argument, "-o", "out.pmtiles", "--max-error", "100", "--quiet"])
            .current_dir(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .unwrap();
        assert_eq!(status.code(), Some(code), "{argument}");
        let trace = fs::read_to_string(folder.path().join("trace")).unwrap();
        assert!(trace.contains("open"), "nothing was traced");
        let opened = trace.lines().find(|line| line.contains("secret.tif\""));
        assert_eq!(opened, None, "{argument}");
    }
}
