"""The archive's tiles, by a reader that was written from the formats' description alone: what they claim is measured against the DEM."""

import unittest
from functools import cache
from pathlib import Path

import numpy
import pmtiles.reader
import pyproj

import pack
from rasters_tests import METRES_IN_A_DEGREE, to_the_outline
from terrain_tile import Tile

GOLDEN = pack.TOP / "codec/golden"
TO_EARTH_CENTRED = pyproj.Transformer.from_crs(4979, 4978, always_xy=True)
# Of heights of some hundred metres; where the outlets' own arithmetic rounds.
ROUNDING = 1e-3


@cache
def tiles(archive: Path) -> dict[tuple, Tile]:
    """By zoom, column and row from the south."""
    found = {}
    for (zoom, x, y), file in pmtiles.reader.all_tiles(pmtiles.reader.MemorySource(archive.read_bytes())):
        tile = Tile(file)
        address = (zoom - 1, x, 2 ** (zoom - 1) - 1 - y)
        assert tile.header.address == address, address
        found[address] = tile
    return found


def earth_centred(degrees: numpy.ndarray) -> numpy.ndarray:
    return numpy.column_stack(TO_EARTH_CENTRED.transform(*degrees.T))


class Ground:
    """A surface whose triangles are flat in space, and the heights at which verticals meet it."""

    def __init__(self, tile: Tile, level: int):
        places, corners = tile.drawn(level)
        self.degrees = tile.degrees(places)
        self.corners, self.positions = corners, earth_centred(self.degrees)

    def heights(self, feet: numpy.ndarray, ups: numpy.ndarray, longitudes: numpy.ndarray, latitudes: numpy.ndarray) -> numpy.ndarray:
        """Over places on the ellipsoid, a grid of rows of latitudes and columns of longitudes, both growing; NaN where no triangle is."""
        heights = numpy.full(feet.shape[:2], numpy.nan)
        for corners in self.corners:
            low, high = self.degrees[corners, :2].min(axis=0), self.degrees[corners, :2].max(axis=0)
            # Edges that are straight in space bulge in plan.
            margin = 0.02 * (high - low).max()
            columns = slice(*numpy.searchsorted(longitudes, [low[0] - margin, high[0] + margin]))
            rows = slice(*numpy.searchsorted(latitudes, [low[1] - margin, high[1] + margin]))
            foot, up = feet[rows, columns], ups[rows, columns]
            a, b, c = self.positions[corners]
            normal = numpy.cross(b - a, c - a)
            height = (a - foot) @ normal / (up @ normal)
            at = foot + up * height[..., None]
            inside = numpy.ones(height.shape, bool)
            for start, end in ((a, b), (b, c), (c, a)):
                inside &= numpy.cross(end - start, at - start) @ normal >= -1e-9 * (normal @ normal)
            heights[rows, columns][inside] = height[inside]
        return heights


class Samples:
    """Places and heights of the DEM's samples, from the south, and of a part of it that may be missing how far each is from its edge."""

    def __init__(self, heights: numpy.ndarray):
        _, to_pixels = pack.samples()
        rows, columns = heights.shape
        step, west, north = (~to_pixels).a, (~to_pixels).c, (~to_pixels).f
        self.longitudes = west + step * (numpy.arange(columns) + 0.5)
        self.latitudes = (north - step * (numpy.arange(rows) + 0.5))[::-1]
        self.heights = numpy.where(heights == -32768, numpy.nan, heights)[::-1]
        missing = numpy.argwhere(numpy.isnan(self.heights))
        self.in_the_hole = numpy.full(heights.shape, -numpy.inf)
        if missing.size:
            low, high = missing.min(axis=0) - 1, missing.max(axis=0) + 1
            row, column = numpy.indices(heights.shape)
            metres = step * METRES_IN_A_DEGREE * numpy.array([1, numpy.cos(numpy.radians(self.latitudes.mean()))])
            north_south = numpy.minimum(row - low[0], high[0] - row) * metres[0]
            self.in_the_hole = numpy.minimum(north_south, numpy.minimum(column - low[1], high[1] - column) * metres[1])
        places = numpy.stack(numpy.meshgrid(self.longitudes, self.latitudes), axis=-1)
        self.feet = self.raised(places, 0)
        self.ups = self.raised(places, 1) - self.feet
        self.to_the_side = to_the_outline(places[..., 0], places[..., 1])

    @staticmethod
    def raised(places: numpy.ndarray, height: float) -> numpy.ndarray:
        flat = numpy.column_stack([places.reshape(-1, 2), numpy.full(places.size // 2, height)])
        return earth_centred(flat).reshape(*places.shape[:2], 3)

    def under(self, ground: Ground) -> numpy.ndarray:
        return ground.heights(self.feet, self.ups, self.longitudes, self.latitudes)


def triangles(tile: Tile, level: int) -> set:
    """Each by its corners, from the least on."""
    places, corners = tile.drawn(level)
    return {min((a, b, c), (b, c, a), (c, a, b)) for a, b, c in ([tuple(places[corner]) for corner in triangle] for triangle in corners)}


def side(tile: Tile, level: int, axis: int, at_end: bool) -> set:
    """The vertices of drawn triangles on one side."""
    places, corners = tile.drawn(level)
    used = places[numpy.unique(corners)]
    line = (tile.header.address[1 + axis] + at_end) * tile.header.extent
    return {tuple(place) for place in used if place[axis] == line}


class Tiles(unittest.TestCase):
    def test_recorded_tiles_have_their_recorded_arrays(self):
        for name, triangle_count in (("jacksboro_v3", 1671), ("holes_v4", 163)):
            tile = Tile((GOLDEN / f"{name}.spt").read_bytes())
            positions = numpy.array(tile.made + tile.restored, "<f8") * [1, 1, tile.header.step]
            numbers = numpy.array(tile.representative + tile.surface.origin, "<u4")
            self.assertEqual(positions.tobytes() + numbers.tobytes(), (GOLDEN / f"{name}.arrays").read_bytes())
            self.assertEqual(len(tile.surface.origin), 3 * triangle_count)

    def test_every_level_is_within_its_certified_error_of_the_samples_and_covers_them(self):
        self.check(pack.archive(), Samples(pack.samples()[0]))

    def test_the_same_beside_a_hole_in_which_nothing_is_drawn(self):
        archive, heights = pack.with_a_hole()
        samples = Samples(heights.astype(float))
        self.check(archive, samples)
        reaches = [tile.header.levels[-1].outline_error for (zoom, _, _), tile in tiles(archive).items() if zoom >= 10]
        self.assertGreater(samples.in_the_hole.max(), 2 * max(reaches), "else nothing was seen of the hole")

    def check(self, archive: Path, samples: Samples) -> None:
        claims, measured = [], []
        for zoom in sorted({zoom for zoom, _, _ in tiles(archive)}):
            of_zoom = [tile for address, tile in tiles(archive).items() if address[0] == zoom]
            covered = numpy.zeros(samples.heights.shape, bool)
            for tile in of_zoom:
                levels = tile.header.levels
                for level in (*range(len(levels) - 4), len(levels) - 1):
                    heights = samples.under(Ground(tile, level))
                    off = abs(heights - samples.heights)
                    claims.append(levels[level].error)
                    measured.append(numpy.nanmax(off, initial=0))
                    self.assertLessEqual(measured[-1], claims[-1] + ROUNDING, (tile.header.address, level))
                covered |= ~numpy.isnan(heights)
            reach = max(tile.header.levels[-1].outline_error for tile in of_zoom)
            self.assertTrue(covered[(samples.to_the_side > reach) & (samples.in_the_hole < -reach)].all(), zoom)
            if samples.in_the_hole.max() > reach:
                self.assertFalse(covered[samples.in_the_hole > reach].any(), zoom)
        self.assertGreater(len(claims), 100)
        # Claims that are far from what they are about say nothing.
        self.assertGreater(numpy.median(numpy.array(measured) / claims), 0.99)

    def test_neighbours_have_the_same_vertices_along_their_side_fine_and_coarse_and_one_zoom_apart(self):
        found, compared = tiles(pack.archive()), [0, 0, 0]
        for (zoom, x, y), tile in found.items():
            finest = len(tile.header.levels) - 1
            for axis, (other_x, other_y) in enumerate(((x + 1, y), (x, y + 1))):
                other = found.get((zoom, other_x, other_y))
                if other is None:
                    continue
                fine = side(tile, finest, axis, True)
                self.assertEqual(fine, side(other, len(other.header.levels) - 1, axis, False), tile.header.address)
                coarse = side(tile, 0, axis, True)
                self.assertEqual(coarse, side(other, 0, axis, False), tile.header.address)
                # The finer ones that begin at this side, coarse, beside this one, fine.
                ahead = ((0, 0), (0, 1)) if axis == 0 else ((0, 0), (1, 0))
                finer = [found.get((zoom + 1, 2 * other_x + right, 2 * other_y + up)) for right, up in ahead]
                if all(finer):
                    self.assertEqual(fine, set.union(*(side(one, 0, axis, False) for one in finer)), tile.header.address)
                    compared[2] += len(fine)
                compared[0] += len(fine)
                compared[1] += len(coarse)
        self.assertTrue(min(compared) > 200, compared)

    def test_a_tile_begins_as_its_parent_ends(self):
        found, compared = tiles(pack.archive()), 0
        for (zoom, x, y), tile in found.items():
            parent = found.get((zoom - 1, x // 2, y // 2))
            if parent is not None:
                whole = triangles(parent, len(parent.header.levels) - 1)
                corner, extent = numpy.array([x, y]) * tile.header.extent, tile.header.extent
                is_here = lambda place: all(0 <= place[axis] - corner[axis] <= extent for axis in (0, 1))
                here = {triangle for triangle in whole if all(map(is_here, triangle))}
                self.assertEqual(triangles(tile, 0), here, tile.header.address)
                compared += len(here)
        self.assertGreater(compared, 1000)


if __name__ == "__main__":
    unittest.main()
