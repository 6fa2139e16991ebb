"""Raster tiles of heights, by the package that reads PMTiles and by Pillow: within what they say of the DEM."""

import io
import json
import math
import socket
import subprocess
import time
import unittest
import urllib.error
import urllib.request
from pathlib import Path

import numpy
import pmtiles.reader
import pmtiles.tile
import pyproj
import rasterio
from PIL import Image

import pack

SERVER = Path(pack.PROGRAM).with_name("terrain-server")
# Metres along a side of the square of Web Mercator.
WORLD = 2 * math.pi * 6378137
TO_DEGREES = pyproj.Transformer.from_crs(3857, 4326, always_xy=True)
METRES_IN_A_DEGREE = 111_000
FORMS = [
    ("terrarium", "png", 512),
    ("terrarium", "webp", 256),
    ("mapbox", "png", 256),
    ("mapbox", "webp", 512),
]


def packs():
    for encoding, image, size in FORMS:
        yield Rasters(pack.one_file(encoding, "--image", image, "--tile-size", str(size)))


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def fetched(url: str) -> bytes:
    """What is at an address, as soon as anybody listens there."""
    for _ in range(100):
        try:
            with urllib.request.urlopen(url) as answer:
                return answer.read()
        except urllib.error.HTTPError:
            raise
        except urllib.error.URLError:
            time.sleep(0.1)
    raise TimeoutError(url)


class Rasters:
    def __init__(self, path):
        self.source = source = pmtiles.reader.MemorySource(path.read_bytes())
        reader = pmtiles.reader.Reader(source)
        self.header, self.metadata = reader.header(), reader.metadata()
        self.size = self.metadata["tileSize"]
        self.tiles = {coordinate: self.heights(file) for coordinate, file in pmtiles.reader.all_tiles(source)}

    def heights(self, file):
        image = Image.open(io.BytesIO(file))
        assert (image.mode, image.size) == ("RGB", (self.size, self.size)), image
        assert not image.info.get("icc_profile") and not image.info.get("gamma"), image.info
        red, green, blue = numpy.moveaxis(numpy.asarray(image).astype(float), 2, 0)
        if self.metadata["encoding"] == "terrarium":
            return red * 256 + green + blue / 256 - 32768
        return -10000 + (red * 65536 + green * 256 + blue) * 0.1

    def places(self, zoom, x, y):
        """Longitudes and latitudes of the middles of a tile's pixels."""
        pixel = WORLD / 2**zoom / self.size
        along = (numpy.arange(self.size) + 0.5) * pixel
        eastings = x * self.size * pixel + along - WORLD / 2
        northings = WORLD / 2 - y * self.size * pixel - along
        # Each is a function of one of the two.
        longitudes, _ = TO_DEGREES.transform(eastings, numpy.zeros(self.size))
        _, latitudes = TO_DEGREES.transform(numpy.zeros(self.size), northings)
        return numpy.meshgrid(longitudes, latitudes)


def to_the_outline(longitude, latitude):
    """Metres from places to the nearest side of the DEM, about; below 0 beside it."""
    dem, to_pixels = pack.samples()
    to_degrees = ~to_pixels
    west, north = to_degrees * (0.5, 0.5)
    east, south = to_degrees * (dem.shape[1] - 0.5, dem.shape[0] - 0.5)
    across = numpy.minimum(longitude - west, east - longitude) * numpy.cos(numpy.radians(latitude))
    return numpy.minimum(across, numpy.minimum(latitude - south, north - latitude)) * METRES_IN_A_DEGREE


class HeightsOfRasters(unittest.TestCase):
    def test_heights_are_within_the_certified_error_and_half_a_quantum_of_the_dem(self):
        for rasters in packs():
            said = {zoom["zoom"]: zoom for zoom in rasters.metadata["zooms"]}
            for (zoom, x, y), heights in rasters.tiles.items():
                longitude, latitude = rasters.places(zoom, x, y)
                # Outlines are simplified by as many metres as heights.
                inside = to_the_outline(longitude, latitude) > said[zoom]["error"] + 10
                off = abs(heights - pack.heights_of_dem(longitude, latitude))[inside]
                self.assertFalse(numpy.isnan(off).any())
                claim = said[zoom]["error"] + said[zoom]["quantum"] / 2
                self.assertLessEqual(off.max(initial=0), claim, (zoom, x, y))
                steps = heights / said[zoom]["quantum"]
                self.assertLess(abs(steps - steps.round()).max(), 1e-6)
                if zoom == rasters.header["max_zoom"] and inside.all():
                    # A claim that is far from what it is about says nothing.
                    self.assertGreater(off.max(), claim / 8)

    def test_all_of_the_dem_is_there_at_every_zoom(self):
        for rasters in packs():
            finest = rasters.header["max_zoom"]
            self.assertEqual(sorted({zoom for zoom, _, _ in rasters.tiles}), list(range(finest + 1)))
            for zoom in range(finest + 1):
                there = 0
                for tile in (tile for tile in rasters.tiles if tile[0] == zoom):
                    longitude, latitude = rasters.places(*tile)
                    there += (to_the_outline(longitude, latitude) > 0).sum()
                dem, to_pixels = pack.samples()
                corners = [~to_pixels * (0.5, 0.5), ~to_pixels * (dem.shape[1] - 0.5, dem.shape[0] - 0.5)]
                (west, north), (east, south) = [TO_DEGREES.transform(*corner, direction="INVERSE") for corner in corners]
                pixel = WORLD / 2**zoom / rasters.size
                expected, outline = (east - west) * (north - south) / pixel**2, 2 * (east - west + north - south) / pixel
                self.assertLessEqual(abs(there - expected), outline / 2 + 2, zoom)

    def test_the_header_and_the_metadata_say_what_clients_need(self):
        for (encoding, image, size), rasters in zip(FORMS, packs(), strict=True):
            header, metadata = rasters.header, rasters.metadata
            with rasterio.open(pack.DEM) as dem:
                # Samples are in the middles of pixels.
                half = [dem.transform.a / 2, -dem.transform.e / 2]
                bounds = dem.bounds
            expected = [bounds.left + half[0], bounds.bottom + half[1], bounds.right - half[0], bounds.top - half[1]]
            names = ["min_lon_e7", "min_lat_e7", "max_lon_e7", "max_lat_e7"]
            numpy.testing.assert_allclose([header[name] / 1e7 for name in names], expected, atol=2e-6)
            numpy.testing.assert_allclose(metadata["bounds"], expected, atol=2e-6)
            middle = [(expected[0] + expected[2]) / 2, (expected[1] + expected[3]) / 2]
            numpy.testing.assert_allclose([header["center_lon_e7"] / 1e7, header["center_lat_e7"] / 1e7], middle, atol=2e-6)
            kind = pmtiles.tile.TileType.PNG if image == "png" else pmtiles.tile.TileType.WEBP
            self.assertEqual((header["tile_type"], header["min_zoom"]), (kind, 0))
            self.assertEqual(header["tile_compression"], pmtiles.tile.Compression.NONE)
            self.assertEqual((metadata["encoding"], metadata["tileSize"]), (encoding, size))
            self.assertEqual((metadata["minzoom"], metadata["maxzoom"]), (header["min_zoom"], header["max_zoom"]))
            self.assertEqual(metadata["attribution"], pack.DEM.name)
            self.assertTrue(metadata["heights_above"])

    def test_tiles_are_those_of_the_server(self):
        port = free_port()
        server = subprocess.Popen([SERVER, pack.archive(), "--listen", f"127.0.0.1:{port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(server.wait)
        self.addCleanup(server.terminate)
        url = f"http://127.0.0.1:{port}/{pack.archive().stem}"
        for (encoding, image, size), rasters in zip(FORMS, packs(), strict=True):
            said = json.loads(fetched(f"{url}/{encoding}.json?size={size}&format={image}"))
            for key in ("encoding", "tileSize", "minzoom", "maxzoom", "attribution", "heights_above", "zooms"):
                self.assertEqual(rasters.metadata[key], said[key], key)
            # The server has tiles of all ground beside the data, too.
            (west, south, east, north), own = said["bounds"], rasters.metadata["bounds"]
            self.assertTrue(west < own[0] and south < own[1] and east > own[2] and north > own[3])
            for (zoom, x, y), file in list(pmtiles.reader.all_tiles(rasters.source))[::4]:
                self.assertEqual(fetched(f"{url}/{encoding}/{zoom}/{x}/{y}.{image}?size={size}"), file)

    def test_beside_the_data_ground_goes_on_and_every_tile_over_them_has_its_neighbours(self):
        dem, to_pixels = pack.samples()
        # A cell of the grid that the ground goes on by.
        near = dem.shape[1] / 32 * (~to_pixels).a * METRES_IN_A_DEGREE
        for rasters in packs():
            errors = {zoom["zoom"]: zoom["error"] + zoom["quantum"] / 2 for zoom in rasters.metadata["zooms"]}
            over, looked_at = 0, 0
            for (zoom, x, y), heights in rasters.tiles.items():
                to_the_side = to_the_outline(*rasters.places(zoom, x, y))
                beside = (to_the_side < 0) & (to_the_side > -near)
                looked_at += beside.sum()
                self.assertGreater(heights[beside].min(initial=numpy.inf), dem.min() / 2, (zoom, x, y))
                self.assertLess(heights[beside].max(initial=0), dem.max() + errors[zoom], (zoom, x, y))
                if (to_the_side > 0).any():
                    over += 1
                    rows = range(max(y - 1, 0), min(y + 2, 2**zoom))
                    around = {(zoom, column % 2**zoom, row) for column in range(x - 1, x + 2) for row in rows}
                    self.assertTrue(around <= set(rasters.tiles), (zoom, x, y))
            self.assertTrue(over > 10 and looked_at > 10_000, (over, looked_at))

    def test_under_voids_are_heights_of_what_is_around(self):
        archive, heights = pack.with_a_hole()
        there = heights[heights != -32768]
        for encoding in ("terrarium", "mapbox"):
            output = pack.folder() / f"holes-{encoding}.pmtiles"
            pack.run("pack", archive, "--format", encoding, "-o", output)
            rasters = Rasters(output)
            finest = rasters.header["max_zoom"]
            is_some = False
            for tile, found in rasters.tiles.items():
                inside = to_the_outline(*rasters.places(*tile)) > 0
                if tile[0] == finest:
                    self.assertTrue((found[inside] > there.min() - 20).all(), tile)
                    self.assertTrue((found[inside] < there.max() + 20).all(), tile)
                    is_some = is_some or inside.any()
                else:
                    # Beside the DEM is the ellipsoid.
                    self.assertGreater(found.min(), min(there.min(), 0) - 2000, tile)
            self.assertTrue(is_some)

    def test_a_part_is_the_same_tiles(self):
        whole = Rasters(pack.one_file("terrarium", "--image", "png", "--tile-size", "512"))
        west, south, east, north = -84.4, 36.2, -84.35, 36.25
        part = Rasters(pack.one_file("terrarium", f"--bbox={west},{south},{east},{north}", "--max-error", "100"))
        errors = {zoom["zoom"]: zoom["error"] + zoom["quantum"] / 2 for zoom in whole.metadata["zooms"]}
        finest = part.header["max_zoom"]
        self.assertLess(finest, whole.header["max_zoom"])
        self.assertLessEqual(errors[finest], 100)
        self.assertGreater(errors[finest - 1], 100)
        self.assertEqual(part.metadata["maxzoom"], finest)
        names = ["min_lon_e7", "min_lat_e7", "max_lon_e7", "max_lat_e7"]
        self.assertEqual([part.header[name] for name in names], [round(side * 1e7) for side in (west, south, east, north)])
        self.assertEqual(part.metadata["bounds"], [west, south, east, north])
        for tile, heights in part.tiles.items():
            longitude, latitude = part.places(*tile)
            is_of_part = ((longitude > west) & (longitude < east) & (latitude > south) & (latitude < north)).any()
            is_beside_the_data = (to_the_outline(longitude, latitude) < 0).all()
            self.assertTrue(is_of_part or is_beside_the_data or tile[0] < 6)
            numpy.testing.assert_array_equal(heights, whole.tiles[tile])
        self.assertTrue(set(part.tiles) < set(whole.tiles))


if __name__ == "__main__":
    unittest.main()
