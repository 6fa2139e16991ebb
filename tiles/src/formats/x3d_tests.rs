#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use roxmltree::{Document, Node};
use terrain_core::streaming::multilevel::{LevelBatch, MultilevelLimits};

use super::*;

/// A box of 400 × 400 × 200 around (1000, 2000, 100): radius 300.
fn mesh() -> MultilevelMesh {
    let text = "{800 1800 0  1200 1800 0  1200 2200 200}{0 1 2}";
    MultilevelMesh::from_ascii(text, MultilevelLimits::default()).unwrap()
}

fn written(encoding: Encoding) -> String {
    to_world(&mesh(), "model.lod", encoding).unwrap()
}

fn named<'a>(world: &'a Document, tag: &str) -> Node<'a, 'a> {
    world.descendants().find(|node| node.has_tag_name(tag)).unwrap()
}

/// The fields of the first string of numbers after `key`.
fn numbers_after(world: &str, key: &str) -> Vec<f32> {
    let (_, rest) = world.split_once(key).unwrap();
    let words = rest.split([' ', '[', ',', '\n']).filter(|word| !word.is_empty());
    words.map_while(|word| word.parse().ok()).collect()
}

#[test]
fn the_viewpoint_sees_the_whole_ball_around_the_mesh() {
    let text = written(Encoding::Xml);
    let world = Document::parse(&text).unwrap();
    let numbers = |tag, name| -> Vec<f32> {
        let value = named(&world, tag).attribute(name).unwrap();
        value.split(' ').map(|word| word.parse().unwrap()).collect()
    };
    let position = numbers("Viewpoint", "position");
    let distance = Vec3::from_slice(&position).length();
    let seen = distance * (std::f32::consts::FRAC_PI_4 / 2.0).sin();
    assert!((300.0..302.0).contains(&seen), "a radius of {seen} fits");
    let tilt = (position[1] / position[2]).atan();
    assert!(
        (tilt + numbers("Viewpoint", "orientation")[3]).abs() < 1e-3,
        "looks {tilt} down"
    );
    assert!(numbers("NavigationInfo", "visibilityLimit")[0] > distance + 300.0);
    assert!(numbers("NavigationInfo", "avatarSize")[0] / 2.0 < distance - 300.0);
}

#[test]
fn both_encodings_say_where_the_data_are_and_what_is_subtracted() {
    let text = written(Encoding::Xml);
    let world = Document::parse(&text).unwrap();
    let value = |name| {
        let mut values = named(&world, "ProtoInstance").children();
        values
            .find(|node| node.attribute("name") == Some(name))
            .unwrap()
            .attribute("value")
    };
    assert_eq!(value("urlData"), Some("model.lod"));
    assert_eq!(value("origin"), Some("1000 2000 100"));
    let text = written(Encoding::Vrml);
    let (_, surface) = text.split_once("DEF Surface").unwrap();
    assert!(surface.contains("urlData \"model.lod\""));
    assert_eq!(numbers_after(surface, "origin"), [1000.0, 2000.0, 100.0]);
}

#[test]
fn the_two_encodings_have_the_same_view() {
    let view = |encoding| -> String {
        let text = written(encoding).replace("=\"", " ").replace('"', " ");
        let (_, view) = text.rsplit_once("NavigationInfo").unwrap();
        view.to_owned()
    };
    let [xml, vrml] = [Encoding::Xml, Encoding::Vrml].map(view);
    for key in [
        "skyColor",
        "position",
        "orientation",
        "direction ",
        "intensity",
        "rotation",
        "diffuseColor",
        "speed",
    ] {
        assert_eq!(numbers_after(&xml, key), numbers_after(&vrml, key), "{key}");
        assert!(!numbers_after(&vrml, key).is_empty(), "{key}");
    }
}

#[test]
fn the_script_arrives_as_it_is() {
    let text = written(Encoding::Xml);
    let world = Document::parse(&text).unwrap();
    let carried: String = named(&world, "Script")
        .children()
        .filter_map(|node| node.text())
        .collect();
    assert_eq!(carried.trim().strip_prefix("ecmascript:\n"), Some(SCRIPT.trim()));
    let text = written(Encoding::Vrml);
    let (_, string) = text.split_once("url \"javascript:\n").unwrap();
    let escaped_quote = '\u{1}';
    let string = string.replace(r"\\", "\u{2}").replace(r#"\""#, "\u{1}");
    let (carried, _) = string.split_once('"').unwrap();
    assert_eq!(carried.replace(escaped_quote, "\"").replace('\u{2}', r"\"), SCRIPT);
}

#[test]
fn any_file_name_is_a_relative_url() {
    for encoding in [Encoding::Xml, Encoding::Vrml] {
        let text = to_world(&mesh(), "a:b #1 \"50%\" <ä>.lod", encoding).unwrap();
        assert!(text.contains("\"a%3Ab%20%231%20%2250%25%22%20%3C%C3%A4%3E.lod\""));
    }
}

#[test]
fn nothing_of_the_templates_is_left_open() {
    for encoding in [Encoding::Xml, Encoding::Vrml] {
        assert!(!written(encoding).contains('@'), "{encoding:?}");
    }
}

#[test]
fn a_mesh_without_extent_has_a_view_all_the_same() {
    let empty = MultilevelMesh::<3>::default();
    let around = |mesh: &MultilevelMesh| Ball::around(mesh.positions()).unwrap();
    let unit = |middle| Ball { middle, radius: 1.0 };
    assert_eq!(around(&empty), unit(Vec3::ZERO));
    let mut point = empty;
    let positions = vec![[3.0, 4.0, 5.0]];
    point
        .add_level(LevelBatch {
            positions,
            ..LevelBatch::default()
        })
        .unwrap();
    assert_eq!(around(&point), unit(Vec3::new(3.0, 4.0, 5.0)));
}

#[test]
fn coordinates_beyond_single_precision_are_refused() {
    let mesh = MultilevelMesh::from_ascii("{0 -2e30 0  1 0 0  1 1 0}{0 1 2}", MultilevelLimits::default()).unwrap();
    let told = to_world(&mesh, "model.lod", Encoding::Xml).unwrap_err().to_string();
    assert_eq!(
        told,
        "a coordinate of 2e30 is more than X3D can hold; scale the mesh down to below 1e30"
    );
}

#[test]
fn the_extension_tells_the_encoding() {
    let of = |name: &str| Encoding::of_file(Path::new(name));
    assert_eq!(of("a/world.x3d"), Some(Encoding::Xml));
    assert_eq!(of("world.WRL"), Some(Encoding::Vrml));
    assert_eq!(of("world.x3dv"), None);
    assert_eq!(of("x3d"), None);
}
