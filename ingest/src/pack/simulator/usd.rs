//! Universal Scene Description as text (Pixar, *Usda File Format Specification*), with the schemas of UsdPhysics: static meshes that
//! collide triangle by triangle.

use std::io::{self, Write};

use glam::{DVec3, Vec3};

const HEADER: &str = "#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Z\"\n    defaultPrim = ";

/// One mesh, about its offset.
pub(super) fn write_mesh(
    out: &mut dyn Write,
    offset: DVec3,
    positions: &[Vec3],
    triangles: &[[u32; 3]],
) -> io::Result<()> {
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    write!(out, "{HEADER}\"Mesh\"\n)\n\ndef Mesh \"Mesh\" (\n")?;
    writeln!(
        out,
        "    prepend apiSchemas = [\"PhysicsCollisionAPI\", \"PhysicsMeshCollisionAPI\"]\n)\n{{"
    )?;
    writeln!(out, "    uniform token physics:approximation = \"none\"")?;
    writeln!(out, "    uniform token subdivisionScheme = \"none\"")?;
    writeln!(out, "    float3[] extent = [{}, {}]", tuple(low), tuple(high))?;
    let ones = triangles.iter().map(|_| 3);
    list(out, "int[] faceVertexCounts", ones, |out, three| write!(out, "{three}"))?;
    let corners = triangles.as_flattened().iter();
    list(out, "int[] faceVertexIndices", corners, |out, corner| {
        write!(out, "{corner}")
    })?;
    list(out, "point3f[] points", positions.iter(), |out, at| {
        write!(out, "{}", tuple(*at))
    })?;
    let DVec3 { x, y, z } = offset;
    writeln!(out, "    double3 xformOp:translate = ({x}, {y}, {z})")?;
    writeln!(out, "    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}}")
}

/// A stage of the meshes whose files are at `paths`, without their extensions.
pub(super) fn write_stage<'a>(out: &mut dyn Write, paths: impl Iterator<Item = &'a str>) -> io::Result<()> {
    write!(out, "{HEADER}\"Terrain\"\n)\n\ndef Xform \"Terrain\"\n{{\n")?;
    for path in paths {
        let name = path.trim_start_matches("meshes/");
        writeln!(
            out,
            "    def \"tile_{name}\" (\n        prepend references = @./{path}.usda@\n    )\n    {{\n    }}"
        )?;
    }
    writeln!(out, "}}")
}

fn tuple(at: Vec3) -> String {
    format!("({}, {}, {})", at.x, at.y, at.z)
}

fn list<T>(
    out: &mut dyn Write,
    name: &str,
    items: impl Iterator<Item = T>,
    write: impl Fn(&mut dyn Write, T) -> io::Result<()>,
) -> io::Result<()> {
    write!(out, "    {name} = [")?;
    for (index, item) in items.enumerate() {
        if index > 0 {
            write!(out, ", ")?;
        }
        write(out, item)?;
    }
    writeln!(out, "]")
}
