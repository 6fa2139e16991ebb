"""Heights for ArduPilot, read as the autopilot reads its card: in single precision, and within what the pack says of the DEM."""

import binascii
import json
import math
import struct
import subprocess
import unittest

import numpy

import pack

BLOCK, POSTS, STEP = 2048, (28, 32), (24, 28)
# Of `Location`: metres in 1e-7 degrees, and their inverse.
METRES, UNITS = numpy.float32(0.011131884502145034), numpy.float32(89.83204953368922)


def scale(latitude, precision):
    """Of longitudes, at 1e-7 degrees of latitude."""
    return max(precision(math.cos(precision(latitude * 1e-7 * math.pi / 180))), precision(0.01))


def distance(one, other, precision):
    """Metres north and east from one place to another, in 1e-7 degrees."""
    half_way = (one[0] + other[0]) // 2
    north = precision(other[0] - one[0]) * precision(METRES)
    return north, precision(other[1] - one[1]) * precision(METRES) * scale(half_way, precision)


def offset(place, north, east, precision):
    up = int(precision(north) * precision(UNITS))
    return place[0] + up, place[1] + int(precision(east) * precision(UNITS) / scale(place[0] + up / 2, precision))


class Card:
    """A folder of files, as an autopilot of a precision sees it."""

    def __init__(self, folder, spacing=100, precision=numpy.float32):
        self.folder, self.spacing, self.precision = folder, spacing, precision

    def stride(self, corner):
        east = offset((corner[0], corner[1] + 10_000_000), 0, 2 * self.spacing * POSTS[1], self.precision)
        return int(distance(corner, east, self.precision)[1] / (self.spacing * STEP[1]))

    def lookup(self, place):
        """The four heights around a place, and the shares of the upper and the right ones; none where there is no block for it."""
        degrees = [number // 10_000_000 for number in place]
        corner = [number * 10_000_000 for number in degrees]
        cells = [metres / self.spacing for metres in distance(corner, place, self.precision)]
        index = [int(number) for number in cells]
        block = [number // step for number, step in zip(index, STEP)]
        up, across = [number % step for number, step in zip(index, STEP)]
        latitude, longitude = degrees
        path = self.folder / f"{'NS'[latitude < 0]}{abs(latitude):02}{'EW'[longitude < 0]}{abs(longitude):03}.DAT"
        if not path.exists():
            return None
        begin = (self.stride(corner) * block[0] + block[1]) * BLOCK
        raw = path.read_bytes()[begin : begin + BLOCK]
        expected = offset(corner, *(number * step * self.spacing for number, step in zip(block, STEP)), self.precision)
        if not self.is_good(raw, expected):
            return None
        bitmap = struct.unpack_from("<Q", raw)[0]
        heights = numpy.frombuffer(raw, "<i2", POSTS[0] * POSTS[1], 22).reshape(POSTS)
        corners = [(up, across), (up, across + 1), (up + 1, across), (up + 1, across + 1)]
        if not all(bitmap >> (column // 4 + 8 * (row // 4)) & 1 for row, column in corners):
            return None
        return [float(heights[post]) for post in corners], [number - whole for number, whole in zip(cells, index)]

    def is_good(self, raw, expected):
        if len(raw) < BLOCK:
            return False
        bitmap, latitude, longitude, checksum, version, spacing = struct.unpack_from("<QiiHHH", raw)
        # The autopilot lets 5 units pass by its usual margin of 0.05 m; it warns of minor versions below 1.
        return (
            bitmap != 0
            and abs(latitude - expected[0]) <= 2
            and abs(longitude - expected[1]) <= 2
            and (version, spacing, raw[1821]) == (1, self.spacing, 1)
            and checksum == binascii.crc_hqx(raw[:16] + b"\0\0" + raw[18:1821], 0)
        )

    def height(self, place):
        found = self.lookup(place)
        if found is None:
            return None
        (south_west, south_east, north_west, north_east), (up, across) = found
        west, east = south_west + up * (north_west - south_west), south_east + up * (north_east - south_east)
        return west + across * (east - west)


def post(corner, north, east):
    """Longitude and latitude where an autopilot measures so many metres from a corner, in degrees."""
    latitude = corner[0] + north / 111_318.84502145034
    return corner[1] + east / 111_318.84502145034 / math.cos(math.radians((corner[0] + latitude) / 2)), latitude


def blocks(path):
    content = path.read_bytes()
    for number in range(len(content) // BLOCK):
        raw = content[number * BLOCK : (number + 1) * BLOCK]
        if any(raw):
            yield number, raw


def places(count):
    dem, to_pixels = pack.samples()
    west, north = ~to_pixels * (1, 1)
    east, south = ~to_pixels * (dem.shape[1] - 1, dem.shape[0] - 1)
    numbers = numpy.random.default_rng(5)
    longitudes, latitudes = numbers.uniform(west, east, count), numbers.uniform(south, north, count)
    return [(round(latitude * 1e7), round(longitude * 1e7)) for longitude, latitude in zip(longitudes, latitudes)]


class ArduPilot(unittest.TestCase):
    def test_every_block_is_where_an_autopilot_of_either_precision_looks_for_it(self):
        for spacing in (100, 30):
            folder = pack.one_file("ardupilot", "--spacing", str(spacing))
            files = sorted(folder.glob("*.DAT"))
            self.assertEqual([path.name for path in files], ["N36W085.DAT"])
            count = 0
            for path in files:
                corner = (int(path.name[1:3]) * 10_000_000, -int(path.name[4:7]) * 10_000_000)
                self.assertEqual(path.stat().st_size % BLOCK, 0)
                for number, raw in blocks(path):
                    row, column, longitude, latitude = struct.unpack_from("<HHhb", raw, 1814)
                    self.assertEqual((latitude * 10_000_000, longitude * 10_000_000), corner)
                    for precision in (numpy.float32, float):
                        card = Card(folder, spacing, precision)
                        self.assertEqual(number, card.stride(corner) * row + column)
                        expected = offset(corner, row * STEP[0] * spacing, column * STEP[1] * spacing, precision)
                        self.assertTrue(card.is_good(raw, expected), (path, number))
                    count += 1
            self.assertEqual(count, json.loads((folder / "manifest.json").read_text())["blocks"])

    def test_posts_are_within_the_error_of_the_dem_and_there_is_none_without_ground(self):
        for spacing in (100, 30):
            folder = pack.one_file("ardupilot", "--spacing", str(spacing))
            said = json.loads((folder / "manifest.json").read_text())
            self.assertEqual(said["error"], said["certified_error"] + 0.5)
            off = []
            for path in folder.glob("*.DAT"):
                for _, raw in blocks(path):
                    row, column, longitude, latitude = struct.unpack_from("<HHhb", raw, 1814)
                    heights = numpy.frombuffer(raw, "<i2", POSTS[0] * POSTS[1], 22).reshape(POSTS)
                    up, across = numpy.indices(POSTS)
                    north, east = (row * STEP[0] + up) * spacing, (column * STEP[1] + across) * spacing
                    at = [numpy.array(part) for part in numpy.vectorize(lambda n, e: post((latitude, longitude), n, e))(north, east)]
                    dem = pack.heights_of_dem(*at)
                    is_there = heights != -32768
                    # Outlines are as far off in plan as the surface is upwards.
                    self.assertLess((is_there & numpy.isnan(dem)).sum(), 60)
                    off.append(abs(heights - dem)[is_there & ~numpy.isnan(dem)])
                    bits = struct.unpack_from("<Q", raw)[0]
                    squares = is_there.reshape(7, 4, 8, 4).all(axis=(1, 3)).ravel()
                    self.assertEqual(bits, sum(int(square) << number for number, square in enumerate(squares)))
            off = numpy.concatenate(off)
            self.assertLessEqual(off.max(), said["error"])
            self.assertGreater(off.max(), said["error"] / 2)
            self.assertGreater(len(off), 300_000 if spacing == 30 else 40_000)

    def test_an_autopilot_finds_ground_as_the_dem_has_it_at_the_posts_around(self):
        folder = pack.one_file("ardupilot", "--spacing", "30")
        error = json.loads((folder / "manifest.json").read_text())["error"]
        card, found = Card(folder, 30), 0
        for place in places(2_000):
            height = card.height(place)
            corner = [number // 10_000_000 for number in place]
            cells = [int(metres / 30) for metres in distance([number * 10_000_000 for number in corner], place, numpy.float32)]
            around = [post(corner, (cells[0] + up) * 30, (cells[1] + across) * 30) for up in (0, 1) for across in (0, 1)]
            dem = pack.heights_of_dem(*numpy.array(around).T)
            if height is None:
                continue
            found += 1
            self.assertTrue(dem.min() - error <= height <= dem.max() + error, place)
        # Squares of posts at the outline are not there.
        self.assertGreater(found, 1_850)
        self.assertIsNone(card.height((100_000_000, 100_000_000)))

    def test_voids_are_no_ground_and_no_zeros(self):
        archive, _ = pack.with_a_hole()
        folder, transform = pack.folder() / "ardupilot-holes", ~pack.samples()[1]
        pack.run("pack", archive, "--format", "ardupilot", "-o", folder)
        card = Card(folder)
        for row in range(104, 156, 4):
            for column in range(124, 196, 4):
                longitude, latitude = transform * (column + 0.5, row + 0.5)
                self.assertIsNone(card.height((round(latitude * 1e7), round(longitude * 1e7))))
        for path in folder.glob("*.DAT"):
            for _, raw in blocks(path):
                metres = numpy.frombuffer(raw, "<i2", POSTS[0] * POSTS[1], 22)
                self.assertTrue(((metres == -32768) | (metres > 150)).all())

    def test_heights_above_the_ellipsoid_become_heights_above_the_sea(self):
        archive, folder = pack.folder() / "ellipsoid.pmtiles", pack.folder() / "ardupilot-sea"
        pack.run(pack.DEM, "--max-error", "10", "--vertical", "egm96", "-o", archive)
        pack.run("pack", archive, "--format", "ardupilot", "-o", folder)
        said = json.loads((folder / "manifest.json").read_text())
        self.assertIn("egm96", said["heights_above"])
        card, off = Card(folder), []
        for corner in ((36, -85),):
            for north in range(12_000, 40_000, 700):
                for east in range(62_000, 85_000, 700):
                    longitude, latitude = post(corner, north, east)
                    dem = pack.heights_of_dem(numpy.array(longitude), numpy.array(latitude))
                    # Half a millimetre inside the cell, for single precision.
                    found = card.lookup((round(latitude * 1e7) + 3, round(longitude * 1e7) + 3))
                    if found is not None and not numpy.isnan(dem):
                        off.append(min(abs(height - dem) for height in found[0]))
        self.assertGreater(len(off), 500)
        # The geoid is 30 m below the ellipsoid there.
        self.assertLessEqual(max(off), said["error"])

    def test_what_cannot_be_a_spacing_is_refused(self):
        for spacing in ("12.5", "4", "70000"):
            output = pack.folder() / "refused-ardupilot"
            done = subprocess.run(
                [pack.PROGRAM, "pack", pack.archive(), "--format", "ardupilot", "--spacing", spacing, "-o", output],
                capture_output=True, text=True,
            )
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("--spacing", done.stderr)
            self.assertFalse(output.exists())


if __name__ == "__main__":
    unittest.main()
