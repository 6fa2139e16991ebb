#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::error::Error as _;

use super::*;

fn collapse(blue: u32, red: u32, moved_to: Option<[f64; 3]>) -> ListedCollapse {
    let moved_to = moved_to.map(DVec3::from_array);
    ListedCollapse { blue, red, moved_to }
}

#[test]
fn text_and_json_say_the_same() {
    let text = "# a list\n5 1\n\n 6\t2  2.0 -0.5 1e2 # moved\n";
    let json = "[[5, 1], [6, 2, 2.0, -0.5, 1e2]]";
    let expected = [collapse(5, 1, None), collapse(6, 2, Some([2.0, -0.5, 100.0]))];
    assert_eq!(parse_text(text).unwrap(), expected);
    assert_eq!(parse_json(json).unwrap(), expected);
}

#[test]
fn coordinates_are_read_to_the_last_bit() {
    let [text, json] = ["5 1 1.440683692773128 0 0", "[[5, 1, 1.440683692773128, 0, 0]]"];
    let expected = [collapse(5, 1, Some([1.440683692773128, 0.0, 0.0]))];
    assert_eq!(parse_text(text).unwrap(), expected);
    assert_eq!(parse_json(json).unwrap(), expected);
}

#[test]
fn faults_are_told_with_their_place() {
    let text = |text: &str| parse_text(text).unwrap_err().to_string();
    let json = |text: &str| parse_json(text).unwrap_err().to_string();
    assert_eq!(text("5 1\n5 one\n"), "line 2: \"one\" is not a number");
    for bad in [
        "5",
        "5 1 0 0",
        "5 1 0 0 0 0",
        "-5 1",
        "5.5 1",
        "5 4294967296",
        "5 1 0 0 inf",
        "5 NaN",
    ] {
        let told = text(&format!("# first\n{bad}"));
        assert!(told.starts_with("line 2: a collapse is"), "{bad}: {told}");
    }
    assert!(json("[[5, 1], [5]]").starts_with("entry 1: a collapse is"));
    let cause = |text: &str| parse_json(text).unwrap_err().source().unwrap().to_string();
    assert!(cause("[[5, 1], [5, null]]").contains("line 1 column 17"));
    assert!(json("{}").contains("not an array of arrays"));
}

#[test]
fn a_log_follows_the_red_vertex_from_place_to_place() {
    let list = [collapse(0, 2, Some([1.0, 1.0, 1.0])), collapse(1, 2, None)];
    let log = to_log(&list, &[DVec3::ZERO; 3], 4.0).unwrap();
    let moves: Vec<_> = log.collapses.iter().map(|c| (c.red_before, c.red_after)).collect();
    assert_eq!(moves, [(DVec3::ZERO, DVec3::ONE), (DVec3::ONE, DVec3::ONE)]);
    assert_eq!(log.bands, [Band { end: 2, error: 4.0 }]);
    let beyond = to_log(&[collapse(0, 3, None)], &[DVec3::ZERO; 3], 4.0);
    assert_eq!(beyond, Err(LogError::BadVertices(0)));
}
