//! Worlds that put heightmaps and meshes where they belong: SDFormat for Gazebo, MJCF for MuJoCo.

use std::io::{self, Write};

use glam::DVec2;

use super::frame::Frame;
use super::heightmaps::{Heightmap, Heightmaps};
use super::pieces::Record;

/// Metres of ground below the lowest post of a height field of MuJoCo.
const BASE: f64 = 10.0;

/// SDFormat 1.7: the meshes as one static model.
pub(super) fn write_sdf_of_meshes(out: &mut dyn Write, frame: &Frame, records: &[Record]) -> io::Result<()> {
    let shapes = records.iter().map(|record| {
        let offset = record.offset;
        Shape {
            name: record.path.trim_start_matches("meshes/"),
            pose: format!("{} {} {} 0 0 0", offset.x, offset.y, offset.z),
            geometry: format!("<mesh><uri>{}.obj</uri></mesh>", record.path),
        }
    });
    write_sdf(out, frame, shapes)
}

/// SDFormat 1.7: the heightmaps as one static model. Gazebo stretches the numbers of an image so that the greatest one is at the
/// height of `size`, and 0 at that of `pos`.
pub(super) fn write_sdf_of_heightmaps(out: &mut dyn Write, frame: &Frame, heightmaps: &Heightmaps) -> io::Result<()> {
    let scale = heightmaps.scale;
    let shapes = heightmaps.maps.iter().map(|map| {
        let Place { middle, extent } = Place::of(heightmaps, map);
        let greatest = map.heights.map_or(0, |[_, high]| scale.number(high));
        let height = f64::from(greatest) * scale.quantum;
        Shape {
            name: map.path.trim_start_matches("heightmaps/"),
            pose: "0 0 0 0 0 0".to_owned(),
            geometry: format!(
                "<heightmap><uri>{}.png</uri><size>{} {} {height}</size><pos>{} {} {}</pos></heightmap>",
                map.path, extent.x, extent.y, middle.x, middle.y, scale.zero
            ),
        }
    });
    write_sdf(out, frame, shapes)
}

/// What can be collided with.
struct Shape<'a> {
    name: &'a str,
    pose: String,
    geometry: String,
}

/// Where on the Earth the frame's origin is.
fn write_place(out: &mut dyn Write, origin: DVec2) -> io::Result<()> {
    let [longitude, latitude] = origin.to_array();
    write!(
        out,
        r#"    <spherical_coordinates>
      <surface_model>EARTH_WGS84</surface_model>
      <world_frame_orientation>ENU</world_frame_orientation>
      <latitude_deg>{latitude}</latitude_deg>
      <longitude_deg>{longitude}</longitude_deg>
      <elevation>0</elevation>
      <heading_deg>0</heading_deg>
    </spherical_coordinates>
"#
    )
}

fn write_sdf<'a>(out: &mut dyn Write, frame: &Frame, shapes: impl Iterator<Item = Shape<'a>>) -> io::Result<()> {
    write!(
        out,
        r#"<?xml version="1.0"?>
<sdf version="1.7">
  <world name="terrain">
"#
    )?;
    if frame.origin_on_plane().is_none() {
        write_place(out, frame.origin)?;
    }
    write!(
        out,
        r#"    <model name="terrain">
      <static>true</static>
      <link name="ground">
"#
    )?;
    for Shape { name, pose, geometry } in shapes {
        for kind in ["collision", "visual"] {
            writeln!(
                out,
                "        <{kind} name=\"{kind}_{name}\"><pose>{pose}</pose><geometry>{geometry}</geometry></{kind}>"
            )?;
        }
    }
    writeln!(out, "      </link>\n    </model>\n  </world>\n</sdf>")
}

/// MJCF: a height field for each heightmap. MuJoCo takes the lowest post as 0 and the highest as 1 of each.
pub(super) fn write_mjcf(out: &mut dyn Write, heightmaps: &Heightmaps) -> io::Result<()> {
    writeln!(out, "<mujoco model=\"terrain\">\n  <asset>")?;
    for map in &heightmaps.maps {
        let half = Place::of(heightmaps, map).extent / 2.0;
        let [low, high] = ends(heightmaps, map);
        // A range of nothing is refused; all posts are at its lower end then.
        let range = if high > low {
            high - low
        } else {
            heightmaps.scale.quantum
        };
        writeln!(
            out,
            "    <hfield name=\"{}\" file=\"{}.bin\" size=\"{} {} {range} {BASE}\"/>",
            map.path, map.path, half.x, half.y
        )?;
    }
    writeln!(out, "  </asset>\n  <worldbody>")?;
    for map in &heightmaps.maps {
        let middle = Place::of(heightmaps, map).middle;
        let [low, _] = ends(heightmaps, map);
        writeln!(
            out,
            "    <geom name=\"{}\" type=\"hfield\" hfield=\"{}\" pos=\"{} {} {low}\"/>",
            map.path, map.path, middle.x, middle.y
        )?;
    }
    writeln!(out, "  </worldbody>\n</mujoco>")
}

/// Metres of the lowest and the highest post of a file, with or without ground.
fn ends(heightmaps: &Heightmaps, map: &Heightmap) -> [f64; 2] {
    let zero = f64::from(heightmaps.scale.zero as f32);
    let [low, high] = map.heights.map_or([zero; 2], |heights| heights.map(f64::from));
    [if map.posts_without_ground > 0 { zero } else { low }, high]
}

/// Where a heightmap is in plan.
struct Place {
    middle: DVec2,
    extent: DVec2,
}

impl Place {
    fn of(heightmaps: &Heightmaps, map: &Heightmap) -> Self {
        let [low, high] = heightmaps.grid.rectangle(map.tile);
        Self {
            middle: low.midpoint(high),
            extent: high - low,
        }
    }
}
