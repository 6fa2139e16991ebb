#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::super::tests::square;
use super::*;

const SQUARE: &str = "\
#3-level progressive mesh
{#level 2 vertices (4)
0.0, 0.0,
4.0, 0.0,
4.0, 4.0,
0.0, 4.0}
{#level 2 triangles (2)
1, 2, 5, 4, 0,
2, 3, 4}
{#level 1 vertices (1)
2.0, 2.0}
{#level 1 triangles (2)
0, 1, 4,
3, 0, 4}
{#level 0 vertices (1)
3.0, 2.0}
{#level 0 triangles (2)
4, 1, 5,
2, 4, 5}
";

fn read(text: &str) -> Result<MultilevelMesh<2>, ReadError> {
    MultilevelMesh::from_ascii(text, MultilevelLimits::default())
}

fn refusal(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

#[test]
fn a_mesh_is_written_with_each_representative_where_it_is_first_needed() {
    assert_eq!(to_ascii(&square()), SQUARE);
}

#[test]
fn what_is_written_is_read_back() {
    assert_eq!(read(SQUARE), Ok(square()));
}

#[test]
fn a_corner_that_stands_for_another_one_is_given_its_representative_once() {
    let text = "{0 0 4 0}{5 4 1 4 0}{0 4}{0 1 2}{4 4 2 2 3 2}{0 2 5}";
    let mesh = read(text).unwrap();
    assert_eq!(mesh.representatives().collect::<Vec<_>>(), [(4, 0), (5, 4)]);
    assert_eq!(read(&to_ascii(&mesh)), Ok(mesh));
}

#[test]
fn commas_line_ends_and_comments_only_separate() {
    let loose = "{0 0\t4,0,,4 4#} ignored {\r\n0,4,}{1 2 5 4 0 2 3 4}{2 2}{0 1 4 3 0 4}{3,2}{4 1 5 2 4 5}";
    assert_eq!(read(loose), Ok(square()));
}

#[test]
fn coordinates_come_back_bit_for_bit() {
    let mut mesh = MultilevelMesh::<3>::default();
    let positions = vec![
        [0.1, -1e-300, 1e300],
        [f64::MIN_POSITIVE, -0.0, 1.0 / 3.0],
        [5e-324, 1e21, 123_456_789.123],
    ];
    let triangles = vec![[0, 1, 2]];
    mesh.add_level(LevelBatch {
        positions: positions.clone(),
        triangles,
        ..LevelBatch::default()
    })
    .unwrap();
    let read = MultilevelMesh::<3>::from_ascii(&to_ascii(&mesh), MultilevelLimits::default()).unwrap();
    let bits = |positions: &[[f64; 3]]| positions.as_flattened().iter().map(|c| c.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(read.positions()), bits(&positions));
}

#[test]
fn a_vertex_may_carry_properties() {
    let text = "{0 0 0 0.5 1, 1 0 0 1 1, 0 1 0 0 0}{0 1 2}";
    let mesh = MultilevelMesh::<5>::from_ascii(text, MultilevelLimits::default()).unwrap();
    assert_eq!(mesh.positions()[0], [0.0, 0.0, 0.0, 0.5, 1.0]);
    assert_eq!(mesh.positions().len(), 3);
}

#[test]
fn every_level_is_there_as_soon_as_its_last_brace_has_been_read() {
    let mut reader = AsciiReader::<2>::new(MultilevelLimits::default());
    let mut level_ends = Vec::new();
    for (index, byte) in SQUARE.bytes().enumerate() {
        let before = reader.mesh().level_count();
        reader.push(&[byte]).unwrap();
        if reader.mesh().level_count() > before {
            level_ends.push(&SQUARE[..=index]);
        }
    }
    assert!(level_ends.iter().all(|text| text.ends_with('}')));
    assert_eq!(level_ends.len(), 3);
    assert_eq!(reader.finish(), Ok(square()));
}

#[test]
fn a_refusal_tells_line_and_column() {
    assert_eq!(
        refusal("{0 0\n  3.0. 1}"),
        "line 2, column 3: expected a vertex's first coordinate or '}', found 3.0."
    );
    assert_eq!(
        refusal("# comment\nx{0 0}{}"),
        "line 2, column 1: expected '{' and the vertices of a level, found x"
    );
    assert_eq!(
        refusal("{0 0 1 0 0 1}\n{0 1 1}"),
        "line 2, column 6: vertex 1 is used twice by one triangle"
    );
    assert_eq!(
        refusal("{0 0}{0 1 2 0}"),
        "line 1, column 14: expected the representative of a vertex that is missing, found '}'"
    );
}

#[test]
fn texts_that_are_no_mesh_are_refused() {
    let cases = [
        (
            "",
            "line 1, column 1: expected '{' and the vertices of a level, found the end of the text",
        ),
        (
            "{0 0 1}{}",
            "line 1, column 7: expected a vertex's next coordinate, found '}'",
        ),
        (
            "{0 0 1 0 0 1}",
            "line 1, column 14: expected '{' and the triangles of the level, found the end of the text",
        ),
        (
            "{0 0 1 0 0 1}{0 1}",
            "line 1, column 18: expected a triangle's next corner, found '}'",
        ),
        (
            "{0 0 1 0 0 1}{0 1 2",
            "line 1, column 20: expected a triangle's first corner or '}', found the end of the text",
        ),
        (
            "{0 {0}}{}",
            "line 1, column 4: expected a vertex's next coordinate, found '{'",
        ),
        ("{0 nan}{}", "line 1, column 4: a coordinate is not finite"),
        ("{0 1e999}{}", "line 1, column 4: a coordinate is not finite"),
        (
            "{0 0 1 0 0 1}{0 1 -2}",
            "line 1, column 19: expected a triangle's next corner, found -2",
        ),
        (
            "{0 0 1 0 0 1}{0 1 2.0}",
            "line 1, column 19: expected a triangle's next corner, found 2.0",
        ),
        (
            "{0 0 1 0 0 1}{0 1 2}}",
            "line 1, column 21: expected '{' and the vertices of a level, found '}'",
        ),
        (
            "{0 0 1 0 0 1}{0 1 5 5}",
            "line 1, column 21: vertex 5 cannot be represented by 5: a representative comes before its vertex",
        ),
        (
            "{0 0 1 0 0 1}{0 1 5 2}",
            "line 1, column 19: vertex 5 is used, but there are only 3 vertices",
        ),
        (
            "{0 0 1 0 0 1}{0 1 4294967295 2}",
            "line 1, column 19: more than 134217728 vertices, or the index of one; raise the limit to read it",
        ),
    ];
    for (text, message) in cases {
        assert_eq!(refusal(text), message, "{text}");
    }
}

#[test]
fn a_word_without_end_is_refused_before_it_fills_the_memory() {
    let mut reader = AsciiReader::<2>::new(MultilevelLimits::default());
    reader.push(b"{").unwrap();
    let error = reader.push(&[b'1'; 100]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "line 1, column 2: a word that is too long to be a number"
    );
}

#[test]
fn a_level_without_end_is_refused_at_the_limits() {
    let limits = MultilevelLimits {
        vertices: 3,
        triangles: 2,
        levels: 1,
    };
    let refusal = |text: &str| MultilevelMesh::<2>::from_ascii(text, limits).unwrap_err().to_string();
    let too_many_vertices = "line 1, column 16: more than 3 vertices, or the index of one; raise the limit to read it";
    assert_eq!(refusal("{0 0 1 0 0 1 1 1"), too_many_vertices);
    let too_many_triangles = "line 1, column 31: more than 2 triangles; raise the limit to read it";
    assert_eq!(refusal("{0 0 1 0 0 1}{0 1 2 1 2 0 2 0 1"), too_many_triangles);
    assert_eq!(
        refusal("{0 0 1 0 0 1}{0 1 2}{}{}"),
        "line 1, column 24: more than 1 levels; raise the limit to read it"
    );
}

#[test]
fn truncated_and_corrupted_texts_never_panic() {
    for end in 0..SQUARE.len() - 1 {
        let _ = read(&SQUARE[..end]);
    }
    for (index, byte) in (0..SQUARE.len()).flat_map(|index| b"{}#9-.,\xff".map(|byte| (index, byte))) {
        let mut bytes = SQUARE.as_bytes().to_vec();
        bytes[index] = byte;
        let mut reader = AsciiReader::<2>::new(MultilevelLimits::default());
        let Ok(()) = reader.push(&bytes) else { continue };
        if let Ok(mesh) = reader.finish() {
            let mut view = super::super::LevelView::default();
            (0..mesh.level_count()).for_each(|level| view.set_level(&mesh, level).unwrap());
        }
    }
}
