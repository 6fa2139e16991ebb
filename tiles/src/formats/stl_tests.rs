#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

fn facet(x: f32) -> String {
    format!("facet normal 0 0 1\nouter loop\nvertex {x} 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n")
}

fn text(bytes: &[u8]) -> Result<Polygons, PolygonError> {
    read(bytes, PolygonLimits::default())
}

fn binary(count: u32, header: &[u8]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend(count.to_le_bytes());
    for triangle in 0..count {
        let numbers = [0.0, 0.0, 1.0, triangle as f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        bytes.extend(numbers.iter().flat_map(|number: &f32| number.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

#[test]
fn all_solids_of_a_text_are_read_with_names_or_without() {
    let solids = format!(
        "solid\n{}endsolid\n  solid one more\r\n{}{}endsolid one more\n",
        facet(0.5),
        facet(2.0),
        facet(3.0)
    );
    let polygons = text(solids.as_bytes()).unwrap();
    assert_eq!(polygons.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    assert_eq!([0, 3, 6].map(|vertex| polygons.positions[vertex].x), [0.5, 2.0, 3.0]);
}

#[test]
fn a_binary_file_is_one_by_its_length_even_if_it_begins_like_a_text() {
    for header in [b"made by something".as_slice(), b"solid something"] {
        let polygons = text(&binary(3, header)).unwrap();
        assert_eq!(polygons.faces, 3);
        assert_eq!(polygons.positions[6], DVec3::new(2.0, 0.0, 0.0));
    }
}

#[test]
fn what_is_neither_or_too_much_is_refused() {
    let cut = &binary(3, b"")[..150];
    for bytes in [b"".as_slice(), b"no mesh", cut] {
        assert!(matches!(
            text(bytes),
            Err(PolygonError::Malformed { format: "STL", .. })
        ));
    }
    let broken = format!("solid\n{}endsolid", facet(0.5).replace("vertex 1", "vertex one"));
    assert!(matches!(
        text(broken.as_bytes()),
        Err(PolygonError::Malformed { format: "STL", .. })
    ));
    let limits = PolygonLimits {
        vertices: 8,
        triangles: 9,
    };
    assert!(matches!(
        read(binary(3, b"").as_slice(), limits),
        Err(PolygonError::TooLarge(8, "vertices"))
    ));
}
