"""JSBSim over the ground of an archive: it reads no file of ground, and is told the height below at every step."""

import contextlib
import tempfile
import unittest

import jsbsim
import numpy
import terrain_heights

import pack

FOOT = 0.3048
START = (-84.35, 36.22)


class Ground(unittest.TestCase):
    def test_a_flight_is_as_far_above_the_dem_as_jsbsim_says_within_the_error(self):
        heights = terrain_heights.Heights(pack.archive())
        # The model writes where it is.
        self.enterContext(contextlib.chdir(self.enterContext(tempfile.TemporaryDirectory())))
        flight = jsbsim.FGFDMExec(None)
        flight.set_debug_level(0)
        flight.load_model("ball")
        longitude, latitude = START
        for name, value in {
            "ic/long-gc-deg": longitude,
            "ic/lat-geod-deg": latitude,
            "ic/h-sl-ft": 20_000.0,
            "ic/vn-fps": 1500.0,
            "ic/ve-fps": 1500.0,
        }.items():
            flight[name] = value
        flight.run_ic()
        rows = []
        for _ in range(2400):
            longitude, latitude = flight["position/long-gc-deg"], flight["position/lat-geod-deg"]
            ground = heights.at(longitude, latitude)
            flight["position/terrain-elevation-asl-ft"] = ground.height / FOOT
            # What was set holds from now on, where the ball still is.
            below = (flight["position/geod-alt-ft"] - flight["position/h-agl-ft"]) * FOOT
            rows.append((longitude, latitude, below, ground.error))
            flight.run()
        longitudes, latitudes, below, errors = numpy.array(rows).T
        off = abs(below - pack.heights_of_dem(longitudes, latitudes)) / errors
        self.assertGreater(below.max() - below.min(), 100)
        self.assertGreater(off.max(), 0.3)
        self.assertLessEqual(off.max(), 1)


if __name__ == "__main__":
    unittest.main()
