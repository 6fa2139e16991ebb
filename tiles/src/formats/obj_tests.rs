#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

fn read_text(text: &str) -> Polygons {
    read(text.as_bytes(), PolygonLimits::default()).unwrap()
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn materials_do_not_matter() {
    for odd in [
        "mtllib\n",
        "mtllib not there.mtl\n",
        "  usemtl\n",
        "usemtl \nusemtl one\nmtllib a b\n",
        "mtllib x",
    ] {
        let whole = format!("{odd}\n{TRIANGLE}{odd}");
        assert_eq!(read_text(&whole).triangles, [[0, 1, 2]], "{odd}");
    }
    let between = format!("mtllib a.mtl\nusemtl a\n{TRIANGLE}usemtl b\nv 1 1 0\nf 2 4 3\n");
    assert_eq!(read_text(&between).faces, 2);
}

#[test]
fn normals_at_corners_come_back() {
    let mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 1, 2], [1, 0, 3]],
    };
    let mut text = Vec::new();
    write_with_normals(&mut text, &mesh, &[DVec3::Z, DVec3::NEG_Y], &[[0; 3], [1; 3]], "a roof").unwrap();
    let back = read(text.as_slice(), PolygonLimits::default()).unwrap();
    let corner = |triangle: usize, corner: usize| back.triangles[triangle][corner] as usize;
    for (triangle, normal) in [DVec3::Z, DVec3::NEG_Y].into_iter().enumerate() {
        for at in 0..3 {
            let vertex = corner(triangle, at);
            assert_eq!(
                back.positions[vertex],
                mesh.positions[mesh.triangles[triangle][at] as usize]
            );
            let found = [0, 1, 2].map(|axis| back.columns[axis].values[vertex]);
            assert_eq!(DVec3::from_array(found), normal);
        }
    }
}
