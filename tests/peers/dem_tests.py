"""Reading rasters: metres, voids, and where samples are."""

import math
import tempfile
import unittest
from pathlib import Path

import numpy
import rasterio
from affine import Affine
from plyfile import PlyData, PlyElement
from rasterio.transform import from_origin

import dem
import mesh
import ply

HEIGHTS = numpy.array([[100, 200, 300], [400, 500, 600]], dtype=numpy.int16)
UTM = from_origin(500_000, 4_000_000, 30, 20)


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def raster(self, heights=HEIGHTS, transform=UTM, crs="EPSG:32611", nodata=None):
        path = self.folder / "dem.tif"
        rows, columns = heights.shape
        shape = {"width": columns, "height": rows, "count": 1, "dtype": heights.dtype}
        with rasterio.open(path, "w", "GTiff", **shape, crs=crs, transform=transform, nodata=nodata) as raster:
            raster.write(heights, 1)
        return path

    def change(self, path, **properties):
        with rasterio.open(path, "r+") as raster:
            for name, value in properties.items():
                setattr(raster, name, (value,))
        return path


class Reading(Folder):
    def test_feet_scale_and_offset_become_metres(self):
        path = self.change(self.raster(), units="ft", scales=0.5, offsets=-10.0)
        self.assertAlmostEqual(dem.read(path).heights[1, 2], (600 * 0.5 - 10) * 0.3048, 12)

    def test_survey_feet_are_not_feet(self):
        path = self.change(self.raster(), units="US survey foot")
        self.assertAlmostEqual(dem.read(path).heights[0, 0], 100 * 1200 / 3937, 12)

    def test_a_raster_without_a_unit_is_in_metres(self):
        self.assertEqual(dem.read(self.raster()).heights[0, 1], 200.0)

    def test_voids_are_found_by_reading(self):
        for heights, nodata in [
            (HEIGHTS, 500),
            (numpy.where(HEIGHTS == 500, math.nan, HEIGHTS).astype(numpy.float32), None),
            (numpy.where(HEIGHTS == 500, -3.4e38, HEIGHTS).astype(numpy.float32), None),
        ]:
            with self.assertRaisesRegex(dem.Unusable, "1 of 6 samples are void"):
                dem.read(self.raster(heights, nodata=nodata))

    def test_what_is_no_raster_is_unusable(self):
        path = self.folder / "words.txt"
        path.write_text("no raster")
        self.assertRaises(dem.Unusable, dem.read, path)

    def test_ground_distances_are_metres(self):
        self.assertEqual(dem.read(self.raster()).cell, (30.0, 20.0))
        degrees = dem.read(self.raster(transform=from_origin(10, 60.001, 0.001, 0.001), crs="EPSG:4326"))
        self.assertAlmostEqual(degrees.cell[0], 55.66, 2)
        self.assertAlmostEqual(degrees.cell[1], 111.32, 2)

    def test_the_same_heights_have_the_same_digest_and_others_another(self):
        whole = dem.read(self.raster())
        self.assertEqual(whole.digest, dem.read(self.raster(crs="EPSG:32612")).digest)
        self.assertNotEqual(whole.digest, dem.read(self.raster(HEIGHTS + 1)).digest)
        self.assertNotEqual(whole.digest, dem.read(self.raster(HEIGHTS.reshape(3, 2))).digest)

    def test_the_first_square_is_the_north_west(self):
        square = dem.read(self.raster()).first_square(2)
        self.assertEqual(square.heights.tolist(), [[100, 200], [400, 500]])


class Meshes(Folder):
    def ply(self, to_crs, plan, triangle):
        corners = [(*(to_crs @ at), 7.0) for at in plan]
        vertices = numpy.array(corners, dtype=[(axis, "f8") for axis in "xyz"])
        faces = numpy.array([(triangle,)], dtype=[("vertex_indices", "u4", (3,))])
        path = self.folder / "mesh.ply"
        PlyData([PlyElement.describe(vertices, "vertex"), PlyElement.describe(faces, "face")]).write(path)
        return ply.read(path, to_crs)

    def test_sample_centres_are_whole_numbers(self):
        to_crs = dem.read(self.raster()).to_crs
        self.assertEqual(to_crs @ (0, 0), (500_015.0, 3_999_990.0))
        read = self.ply(to_crs, [(0, 0), (0, 1), (2, 0.5)], [0, 1, 2])
        self.assertEqual(read.vertices.tolist(), [[0, 0, 7], [0, 1, 7], [2, 0.5, 7]])
        self.assertEqual(read.triangles.tolist(), [[0, 1, 2]])

    def test_a_triangle_seen_from_above_stays_so_where_rows_go_north(self):
        read = self.ply(Affine(1, 0, 0, 0, 1, 0), [(0, 0), (1, 0), (0, 1)], [0, 1, 2])
        self.assertEqual(read.triangles.tolist(), [[2, 1, 0]])

    def test_only_rounding_is_taken_away(self):
        found = mesh.on_grid_lines(numpy.array([3 + 1e-9, 3 - 1e-9, 3 + 1e-5, 0.5]))
        self.assertEqual(found.tolist(), [3.0, 3.0, 3 + 1e-5, 0.5])

    def test_arrays_come_back_as_they_were_written(self):
        written = mesh.Mesh(numpy.array([[0.0, 1.0, 2.5], [3.0, 4.25, 5.0]]), numpy.array([[1, 0, 1]]))
        mesh.write_arrays(self.folder, written)
        read = mesh.read_arrays(self.folder)
        self.assertEqual(read.vertices.tolist(), written.vertices.tolist())
        self.assertEqual(read.triangles.tolist(), written.triangles.tolist())


if __name__ == "__main__":
    unittest.main()
