"""Worlds for Gazebo, by the library that it reads them with."""

import functools
import subprocess
import unittest
from pathlib import Path

import numpy
import trimesh
from PIL import Image

import pack
from meshes_tests import glb


@functools.cache
def reader() -> Path:
    source, program = Path(__file__).with_name("sdf_shapes.cpp"), pack.folder() / "sdf_shapes"
    flags = subprocess.run(["pkg-config", "--cflags", "--libs", "sdformat12"], check=True, capture_output=True, text=True)
    subprocess.run(["c++", "-std=c++17", source, "-o", program, *flags.stdout.split()], check=True)
    return program


def shapes(world: Path) -> list[list[str]]:
    found = subprocess.run([reader(), world], check=True, capture_output=True, text=True)
    return [line.split() for line in found.stdout.splitlines()]


class Worlds(unittest.TestCase):
    def test_meshes_are_where_the_ground_is(self):
        path = pack.pack()
        manifest = pack.manifest(path)
        (_, *origin), *found = shapes(path / "meshes.sdf")
        # It keeps angles in radians.
        numpy.testing.assert_allclose([float(number) for number in origin], list(manifest["frame"]["origin"].values()), 1e-14)
        self.assertEqual(len(found), len(manifest["meshes"]["tiles"]))
        for kind, uri, *offset in found:
            self.assertEqual(kind, "mesh")
            expected, _ = glb((path / uri).with_suffix(".glb"))
            mesh = trimesh.load(path / uri, process=False)
            # The library prints six digits.
            numpy.testing.assert_allclose(mesh.vertices + numpy.array(offset, dtype=float), expected, atol=0.1)

    def test_heightmaps_are_where_the_ground_is(self):
        for options in [(), pack.MANY]:
            path = pack.pack(*options)
            manifest = pack.manifest(path)
            said = manifest["heightmaps"]
            _, *found = shapes(path / "heightmaps.sdf")
            self.assertEqual(len(found), len(said["tile"]))
            for (kind, uri, *numbers), tile in zip(found, said["tile"]):
                self.assertEqual((kind, uri), ("heightmap", f"{tile['path']}.png"))
                width, depth, height, x, y, z = map(float, numbers)
                image = numpy.asarray(Image.open(path / uri)).astype(float)
                # As Gazebo does it: the greatest number in the image is at `size`.
                heights = z + image / image.max() * height
                size = said["size"]
                across = x + numpy.linspace(-width / 2, width / 2, size)
                up = y + numpy.linspace(depth / 2, -depth / 2, size)
                points = numpy.column_stack([part.ravel() for part in (*numpy.meshgrid(across, up), heights)])
                off = abs(pack.errors(manifest, points))
                # Six digits of ten kilometres, on steep ground.
                self.assertLessEqual(numpy.nanmax(off), said["error_of_numbers"] + 0.2)
                self.assertLess(numpy.isnan(off).mean(), 0.01)


if __name__ == "__main__":
    unittest.main()
