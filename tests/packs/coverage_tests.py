"""Heights as a raster in a GeoPackage, by GDAL, by rasterio, and by what the standard says of its tables."""

import sqlite3
import subprocess
import unittest

import numpy
import rasterio

import pack


def places(raster):
    """Longitudes and latitudes of the middles of pixels."""
    rows, columns = numpy.indices(raster.shape)
    transform = raster.transform
    return transform.c + transform.a * (columns + 0.5), transform.f + transform.e * (rows + 0.5)


class Coverages(unittest.TestCase):
    def test_pixels_are_within_the_certified_error_of_the_dem(self):
        error = None
        for options in [(), ("--spacing", "60"), ("--max-zoom", "9")]:
            with rasterio.open(pack.one_file("gpkg", *options)) as raster:
                self.assertEqual((raster.driver, raster.crs.to_epsg(), raster.dtypes), ("GPKG", 4326, ("float32",)))
                heights, (longitudes, latitudes) = raster.read(1), places(raster)
                is_there = heights != raster.nodata
                said = float(raster.tags()["DESCRIPTION"].split("within ")[1].split(" m of")[0])
            error = error or said
            dem = pack.heights_of_dem(longitudes, latitudes)
            off = abs(heights - dem)[is_there & ~numpy.isnan(dem)]
            self.assertLessEqual(off.max(), said)
            self.assertGreater(off.max(), said / 2)
            # All of the DEM is there, but for what its outline errs.
            self.assertGreater((is_there & ~numpy.isnan(dem)).sum(), 0.97 * (~numpy.isnan(dem)).sum())
        self.assertGreater(said, error)

    def test_pixels_are_the_samples_of_the_dem_unless_others_are_asked_for(self):
        with rasterio.open(pack.one_file("gpkg")) as raster, rasterio.open(pack.DEM) as dem:
            self.assertEqual(raster.shape, dem.shape)
            numpy.testing.assert_allclose(raster.bounds, dem.bounds, atol=1e-5)
        west, south, east, north = -84.4, 36.2, -84.2, 36.3
        with rasterio.open(pack.one_file("gpkg")) as whole, rasterio.open(pack.one_file("gpkg", f"--bbox={west},{south},{east},{north}")) as part:
            heights, others = part.read(1), whole.read(1)
            column, row = [round(number) for number in ~whole.transform * (part.transform.c, part.transform.f)]
            numpy.testing.assert_array_equal(heights, others[row : row + part.height, column : column + part.width])
            longitudes, latitudes = places(part)
            # Some are on its sides.
            self.assertTrue((longitudes > west - 1e-9).all() and (longitudes < east + 1e-9).all())
            self.assertTrue((latitudes > south - 1e-9).all() and (latitudes < north + 1e-9).all())
            pixel = whole.transform.a
            self.assertTrue(longitudes.min() < west + pixel and longitudes.max() > east - pixel)

    def test_voids_are_no_ground(self):
        archive, heights = pack.with_a_hole()
        output = pack.folder() / "holes.gpkg"
        pack.run("pack", archive, "--format", "gpkg", "-o", output)
        with rasterio.open(output) as raster:
            found = raster.read(1, masked=True)
        self.assertTrue(found.mask[104:156, 124:196].all())
        self.assertGreater(found.min(), heights[heights != -32768].min() - 11)

    def test_the_tables_are_those_of_the_standard(self):
        database = sqlite3.connect(pack.one_file("gpkg"))
        self.assertEqual(database.execute("PRAGMA integrity_check").fetchone(), ("ok",))
        self.assertEqual(database.execute("PRAGMA application_id").fetchone(), (0x47504B47,))
        contents = database.execute("SELECT table_name, data_type, srs_id FROM gpkg_contents").fetchall()
        self.assertEqual(contents, [("heights", "2d-gridded-coverage", 4326)])
        ancillary = database.execute(
            "SELECT datatype, scale, offset, grid_cell_encoding, uom, data_null FROM gpkg_2d_gridded_coverage_ancillary"
        ).fetchall()
        self.assertEqual(ancillary, [("float", 1.0, 0.0, "grid-value-is-center", "m", -32768.0)])
        extensions = {name for (name,) in database.execute("SELECT extension_name FROM gpkg_extensions")}
        self.assertIn("gpkg_2d_gridded_coverage", extensions)
        tiles = database.execute("SELECT tile_data FROM heights").fetchall()
        # TIFF of either order of bytes.
        self.assertTrue(all(data[:4] in (b"II*\0", b"MM\0*") for (data,) in tiles))

    def test_the_same_archive_gives_the_same_bytes(self):
        again = pack.folder() / "again.gpkg"
        pack.run("pack", pack.archive(), "--format", "gpkg", "-o", again)
        self.assertEqual(again.read_bytes(), pack.one_file("gpkg").read_bytes())

    def test_what_has_no_ground_is_refused_and_leaves_nothing(self):
        output = pack.folder() / "refused.gpkg"
        done = subprocess.run(
            [pack.PROGRAM, "pack", pack.archive(), "--format", "gpkg", "--bbox=7,45,8,46", "-o", output], capture_output=True, text=True
        )
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertFalse(output.exists())


if __name__ == "__main__":
    unittest.main()
