#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::fmt::Write;

use super::*;

fn read_text(text: &str) -> Result<Vec<TensorPatch>, BezierError> {
    read(text.as_bytes(), BezierLimits::default())
}

/// Point `index` of patch `patch`.
fn coordinates(patch: usize, index: usize) -> [f64; 3] {
    [index as f64 / 7.0, (index * index) as f64, patch as f64]
}

fn texts(patches: usize) -> [String; 4] {
    let point = |patch, index| coordinates(patch, index).map(|number| number.to_string()).join(" ");
    let points = |patch| (0..16).map(|index| point(patch, index)).collect::<Vec<_>>();
    let all: Vec<String> = (0..patches).flat_map(points).collect();
    let rows = (0..patches).map(|patch| {
        (1..=16)
            .map(|index| (16 * patch + index).to_string())
            .collect::<Vec<_>>()
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let mut degrees = format!("{patches}\n");
    for patch in 0..patches {
        writeln!(degrees, "3 3\n{}", points(patch).join("\n")).unwrap();
    }
    let spaced = rows.iter().map(|row| row.join(" ")).collect::<Vec<_>>().join("\n");
    let commas = rows.iter().map(|row| row.join(",")).collect::<Vec<_>>().join("\n");
    [
        format!("{patches}\n{}", all.join("   ")),
        degrees,
        format!("BEZ {} {patches}\n{}\n{spaced}\n", all.len(), all.join("\n")),
        format!(
            "{}\n{}\n{patches}\n{commas}",
            all.len(),
            all.join("\n").replace(' ', ",")
        ),
    ]
}

#[test]
fn the_four_layouts_hold_the_same_patches() {
    for count in [1, 2, 5] {
        for text in texts(count) {
            let patches = read_text(&text).unwrap();
            assert_eq!(patches.len(), count, "{text}");
            for (number, patch) in patches.iter().enumerate() {
                let expected = (0..16)
                    .map(|index| DVec3::from_array(coordinates(number, index)))
                    .collect();
                assert_eq!(*patch, TensorPatch::new(expected, 4).unwrap());
            }
        }
    }
}

#[test]
fn patches_of_other_degrees_are_read() {
    let patches = read_text("2\n1 2\n0 0 0 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0\n1 1\n0 0 0 1 0 0 0 1 0 1 1 0\n").unwrap();
    assert_eq!(
        patches.iter().map(TensorPatch::degrees).collect::<Vec<_>>(),
        [[1, 2], [1, 1]]
    );
    assert_eq!(patches[0].point(1.0, 1.0), DVec3::new(2.0, 1.0, 0.0));
}

#[test]
fn faults_are_named() {
    let fault = |text: &str| read_text(text).unwrap_err().to_string();
    let prefix = "not a readable file of Bézier patches: ";
    assert_eq!(fault(""), format!("{prefix}it ends too early"));
    assert_eq!(fault("1 0 0 x"), format!("{prefix}`x` is no number"));
    assert_eq!(fault("1.5 0"), format!("{prefix}a count is no whole number"));
    assert_eq!(fault("BEZ 900000000 1 0 0 0"), format!("{prefix}it ends too early"));
    assert_eq!(
        fault("1 1 1 0 0 0 1 0 0 0 1 0 1 1 0 5"),
        format!("{prefix}there are numbers after the last patch")
    );
    assert_eq!(fault("1 40 3"), "more than the degree that is read");
    assert_eq!(
        fault("1 0 3 0 0 0 1 0 0 0 1 0 1 1 0"),
        "patch 0: 4 control points in rows of 4 are no patch"
    );
    let [.., indexed, _] = texts(1);
    assert_eq!(
        fault(&indexed.replace("15 16", "15 17")),
        "patch 0 uses point 17, but there are 16 (counted from 1)"
    );
    assert_eq!(
        fault(&indexed.replace("15 16", "15 0")),
        "patch 0 uses point 0, but there are 16 (counted from 1)"
    );
    let small = BezierLimits {
        bytes: 10,
        ..BezierLimits::default()
    };
    assert!(matches!(read(indexed.as_bytes(), small), Err(BezierError::TooLarge(_))));
}
