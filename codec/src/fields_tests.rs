#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

fn entry(length: usize, [vertex_end, triangle_end]: [u32; 2], error: f32) -> Entry {
    Entry {
        length,
        level: Level {
            vertex_end,
            triangle_end,
            error: f64::from(error),
        },
        outline_error: 0.25,
    }
}

#[test]
fn entries_come_back_and_take_a_byte_for_what_does_not_change() {
    let entries = [
        entry(300, [100, 150], 2.0),
        entry(0, [100, 150], 2.0),
        entry(7, [103, 156], 1.5),
    ];
    let (mut writer, mut reader) = (Directory::new(true), Directory::new(true));
    let mut bytes = Vec::new();
    let ends = entries.each_ref().map(|entry| {
        writer.write(&mut bytes, entry).unwrap();
        bytes.len()
    });
    assert_eq!(ends[1] - ends[0], 5, "nothing is new in the second");
    let mut fields = Fields::new(&bytes);
    for entry in &entries {
        assert_eq!(reader.read(&mut fields, &LevelLimits::default()).unwrap(), *entry);
    }
    assert!(fields.rest.is_empty());
}

#[test]
fn numbers_that_none_can_be_are_refused() {
    let number = |bytes: &[u8]| Fields::new(bytes).number();
    assert_eq!(number(&[0xac, 0x02]), Ok(300));
    assert_eq!(number(&[0xff, 0xff, 0xff, 0xff, 0x0f]), Ok(u32::MAX));
    assert_eq!(
        number(&[0x80, 0x80, 0x80, 0x80, 0x10]),
        Err(DecodeError::OutOfRange("a number"))
    );
    assert_eq!(number(&[0x80; 3]), Err(DecodeError::Truncated(3)));
    let negative_error = [0, 0, 0, 0x01];
    let refused = Directory::new(false).read(&mut Fields::new(&negative_error), &LevelLimits::default());
    assert_eq!(refused, Err(DecodeError::OutOfRange("an error")));
}

#[test]
fn another_format_and_another_version_are_told_by_name() {
    let format = Format {
        name: "raster of bricks",
        magic: *b"BRIC",
        versions: [3, 4],
    };
    let refused = |bytes: &[u8]| Fields::open(bytes, &format).err().map(|error| error.to_string());
    assert_eq!(
        [3, 4].map(|version| refused(&[b"BRIC".as_slice(), &[version]].concat())),
        [None, None]
    );
    assert_eq!(refused(b"BRIK\x03").unwrap(), "not a raster of bricks");
    assert_eq!(
        refused(b"BRIC\x05").unwrap(),
        "raster of bricks of version 5; this program reads version 4"
    );
    assert_eq!(refused(b"BRIC").unwrap(), "truncated at byte 4");
}
