"""The library of heights for Python, as its wheel has it: within what it says of the DEM."""

import subprocess
import sys
import threading
import unittest

import numpy
import pyproj
import terrain_heights

import pack

EXAMPLE = pack.TOP / "heights/examples/profile.py"


def places(count):
    dem, to_pixels = pack.samples()
    west, north = ~to_pixels * (1, 1)
    east, south = ~to_pixels * (dem.shape[1] - 1, dem.shape[0] - 1)
    numbers = numpy.random.default_rng(2)
    return numbers.uniform(west, east, count), numbers.uniform(south, north, count)


class Heights(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.heights = terrain_heights.Heights(pack.archive())

    def test_heights_are_as_near_to_the_dem_as_is_said(self):
        longitudes, latitudes = places(20_000)
        for zoom in (8, None):
            grounds = self.heights.at_many(longitudes, latitudes, zoom)
            self.assertTrue((grounds.status == terrain_heights.MEASURED).all())
            off = abs(grounds.height - pack.heights_of_dem(longitudes, latitudes)) / grounds.error
            self.assertLessEqual(off.max(), 1)
            self.assertGreater(off.max(), 0.5)
            self.assertLess(abs(numpy.linalg.norm(grounds.normal, axis=1) - 1).max(), 1e-12)

    def test_normals_are_those_of_the_surface(self):
        longitudes, latitudes = places(500)
        step = 1e-7
        here = self.heights.at_many(longitudes, latitudes)
        east = self.heights.at_many(longitudes + step, latitudes).height - here.height
        north = self.heights.at_many(longitudes, latitudes + step).height - here.height
        metres = 111_320 * step
        expected = numpy.column_stack([-east / (metres * numpy.cos(numpy.radians(latitudes))), -north / metres, numpy.ones(500)])
        expected /= numpy.linalg.norm(expected, axis=1)[:, None]
        angle = numpy.arccos(numpy.clip((expected * here.normal).sum(axis=1), -1, 1))
        # Where an edge is between the places, they say nothing.
        self.assertLess((angle > 0.01).sum(), 5)
        self.assertGreater((here.normal[:, 2] < 0.95).sum(), 100)

    def test_in_a_frame_heights_are_as_near_to_the_dem_along_its_up_as_is_said(self):
        longitudes, latitudes = places(5_000)
        # The second is 400 km away, where the vertical leans by almost 4 degrees.
        for longitude, latitude, height in [(-84.2, 36.3, 250.0), (-88.0, 38.5, 0.0)]:
            frame = terrain_heights.Frame(longitude, latitude, height)
            to_frame = pyproj.Transformer.from_pipeline(
                "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 "
                f"+step +proj=topocentric +ellps=WGS84 +lon_0={longitude} +lat_0={latitude} +h_0={height}"
            )
            easts, norths, _ = to_frame.transform(longitudes, latitudes, numpy.full(5_000, 500.0))
            grounds = self.heights.in_frame_many(frame, easts, norths)
            # Walls have no bound for a vertical that leans.
            measured = numpy.flatnonzero((grounds.status == terrain_heights.MEASURED) & numpy.isfinite(grounds.error))
            self.assertGreater(len(measured), 4_900)
            heights, errors = grounds.height[measured], grounds.error[measured]

            def above_the_dem(ups):
                at = to_frame.transform(easts[measured], norths[measured], ups, direction="INVERSE")
                return at[2] - pack.heights_of_dem(at[0], at[1])

            below, over = [above_the_dem(heights + side * errors) for side in (-1, 1)]
            inside = ~numpy.isnan(below) & ~numpy.isnan(over)
            self.assertTrue((below[inside] <= 0).all() and (over[inside] >= 0).all())
            off = abs(above_the_dem(heights)) / errors
            self.assertGreater(off[inside].max(), 0.5)
            place = measured[7]
            one = self.heights.in_frame(frame, easts[place], norths[place])
            self.assertEqual((one.height, one.error), (grounds.height[place], grounds.error[place]))
            self.assertEqual(one.normal, tuple(grounds.normal[place]))
            self.assertLess(abs(numpy.array(frame.axes) @ numpy.array(frame.axes).T - numpy.eye(3)).max(), 1e-15)
        with self.assertRaises(ValueError):
            terrain_heights.Frame(0.0, 91.0)

    def test_one_place_is_the_same_as_among_many_and_for_all_threads(self):
        longitudes, latitudes = places(1_000)
        many = self.heights.at_many(longitudes, latitudes)
        for place in range(0, 1_000, 7):
            one = self.heights.at(longitudes[place], latitudes[place])
            self.assertEqual((one.height, one.error, one.status), (many.height[place], many.error[place], many.status[place]))
            self.assertEqual(one.normal, tuple(many.normal[place]))
        small, found = terrain_heights.Heights(pack.archive(), cache_bytes=1 << 20), []
        threads = [threading.Thread(target=lambda: found.append(small.at_many(longitudes, latitudes))) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(found), 4)
        for other in found:
            numpy.testing.assert_array_equal(other.height, many.height)

    def test_what_cannot_be_answered_is_told(self):
        outside = self.heights.at_many(numpy.array([0.0, numpy.nan]), numpy.array([0.0, 36.0]))
        self.assertEqual(outside.status.tolist(), [terrain_heights.OUTSIDE] * 2)
        self.assertTrue(numpy.isnan(outside.height).all() and numpy.isnan(outside.normal).all())
        self.assertEqual(self.heights.at_many(numpy.zeros(0), numpy.zeros(0)).normal.shape, (0, 3))
        with self.assertRaises(ValueError):
            self.heights.at_many(numpy.zeros(2), numpy.zeros(3))
        with self.assertRaisesRegex(OSError, "nowhere.pmtiles"):
            terrain_heights.Heights("/nowhere.pmtiles")

    def test_the_example_prints_what_the_library_says(self):
        line = ["-84.6", "36.15", "-83.9", "36.45", "200"]
        done = subprocess.run([sys.executable, EXAMPLE, pack.archive(), *line], capture_output=True, text=True, check=True)
        head, *rows = done.stdout.splitlines()
        self.assertEqual(head, f"metres above {self.heights.above}")
        square = rows.index("metres east, north and up of the first place")
        rows, measured = rows[:square], 0
        for row in rows:
            longitude, latitude, *said = row.split(" ")
            ground = self.heights.at(float(longitude), float(latitude))
            if ground.status == terrain_heights.MEASURED:
                self.assertLess(abs(float(said[0]) - ground.height), 0.01, row)
                measured += 1
            else:
                self.assertEqual(said, ["outside"])
        self.assertEqual(len(rows), 200)
        self.assertTrue(80 < measured < 120, measured)
        line = ["-84.3", "36.2", "-84.2", "36.2", "2"]
        done = subprocess.run([sys.executable, EXAMPLE, pack.archive(), *line], capture_output=True, text=True, check=True)
        square = [row.split(" ") for row in done.stdout.splitlines()[4:]]
        self.assertEqual(len(square), 25)
        frame = terrain_heights.Frame(-84.3, 36.2)
        for east, north, up, error in square:
            ground = self.heights.in_frame(frame, float(east), float(north))
            self.assertEqual((up, error), (f"{ground.height:.4f}", f"{ground.error:.4f}"))


if __name__ == "__main__":
    unittest.main()
