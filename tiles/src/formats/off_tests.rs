#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

fn read_text(text: &str) -> Result<Polygons, PolygonError> {
    read(text.as_bytes(), PolygonLimits::default())
}

#[test]
fn polygons_are_read_wherever_the_counts_stand() {
    for header in [
        "OFF\n# a square\n\n4 1 4\n",
        "OFF 4 1 4 # counts\n",
        "OFF4 1 4\n",
        "COFF\n4 1\n",
    ] {
        let polygons = read_text(&format!(
            "{header}0 0 0 255 0 0\n1 0 0\n1 1 0.5\n0 1 0\n4 0 1 2 3 0.5 0.5 0.5\n"
        ))
        .unwrap();
        assert_eq!(polygons.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(polygons.positions[2], DVec3::new(1.0, 1.0, 0.5));
        assert!(polygons.columns.is_empty());
    }
}

#[test]
fn normals_are_kept() {
    let polygons = read_text("CNOFF\n3 1 3\n0 0 0 0 0 1 9 9 9\n1 0 0 0 0 1\n0 1 0 0 0.5 2\n3 0 1 2\n").unwrap();
    let names: Vec<&str> = polygons.columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["nx", "ny", "nz"]);
    assert_eq!(polygons.columns[2].values, [1.0, 1.0, 2.0]);
}

#[test]
fn faults_are_named_by_line() {
    let fault = |text: &str| read_text(text).unwrap_err().to_string();
    assert_eq!(fault("ply\n"), "not a readable OFF file: it does not begin with OFF");
    assert_eq!(
        fault("OFF BINARY\n"),
        "not a readable OFF file: it is binary; only text is read"
    );
    assert_eq!(
        fault("4OFF\n1 0 0\n"),
        "not a readable OFF file: it has not three dimensions"
    );
    assert_eq!(
        fault("OFF\n3 1 3\n0 0 0\n0 0\n"),
        "not a readable OFF file: line 4: expected a vertex"
    );
    assert_eq!(
        fault("OFF\n1 1 1\n0 0 0\n3 0 0\n"),
        "not a readable OFF file: line 4: expected a face"
    );
    assert_eq!(
        fault("OFF\n1 1 1\n0 0 0\n"),
        "not a readable OFF file: line 4: expected more lines"
    );
    assert_eq!(
        fault("OFF\n1 1 1\n0 0 0\n3 0 0 7\n"),
        "face 0 uses vertex 7, but there are 1 (counted from 0)"
    );
    assert_eq!(fault("OFF\n4000000000 1 1\n"), "more than 134217728 vertices");
}
