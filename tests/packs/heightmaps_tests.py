"""Heightmaps, by the libraries that read such images."""

import unittest

import numpy
import OpenEXR
import rasterio
from PIL import Image

import pack


def png(path):
    image = Image.open(path)
    assert image.mode == "I;16", image.mode
    return numpy.asarray(image).astype(int)


def metres(path):
    with rasterio.open(path) as image:
        return image.read(1).astype(float)


def all_of(path, said):
    """Each heightmap with the places of its posts, the north row first."""
    size = said["size"]
    for tile in said["tile"]:
        x = numpy.linspace(tile["low"][0], tile["high"][0], size)
        y = numpy.linspace(tile["high"][1], tile["low"][1], size)
        yield tile, path / tile["path"], *numpy.meshgrid(x, y)


def packs():
    """One heightmap of all, and many of a part."""
    for options in [(), pack.MANY]:
        path = pack.pack(*options)
        manifest = pack.manifest(path)
        yield path, manifest, manifest["heightmaps"]


class Heightmaps(unittest.TestCase):
    def test_the_same_heights_are_in_all_formats(self):
        for path, _, said in packs():
            for tile, stem, *_ in all_of(path, said):
                numbers = png(stem.with_suffix(".png"))
                raw = numpy.fromfile(stem.with_suffix(".r16"), dtype="<u2").reshape(numbers.shape)
                numpy.testing.assert_array_equal(numbers, raw)
                heights = metres(stem.with_suffix(".tif"))
                luminance = OpenEXR.File(str(stem.with_suffix(".exr"))).channels()["Y"].pixels
                numpy.testing.assert_array_equal(heights, luminance)
                file = stem.with_suffix(".bin").read_bytes()
                self.assertEqual(numpy.frombuffer(file[:8], dtype="<i4").tolist(), [said["size"], said["size"]])
                mujoco = numpy.frombuffer(file[8:], dtype="<f4").reshape(heights.shape)
                numpy.testing.assert_array_equal(heights, mujoco[::-1])
                decoded = said["zero"] + said["quantum"] * numbers
                self.assertLessEqual(abs(decoded - heights).max(), said["quantum"] / 2 * 1.001)
                self.assertEqual([heights.min(), heights.max()], tile["heights"])

    def test_posts_and_what_is_between_them_are_as_near_to_the_dem_as_is_said(self):
        for path, manifest, said in packs():
            worst = 0.0
            for _, stem, x, y in all_of(path, said):
                for heights, claim in [
                    (metres(stem.with_suffix(".tif")), said["error_of_metres"]),
                    (said["zero"] + said["quantum"] * png(stem.with_suffix(".png")), said["error_of_numbers"]),
                ]:
                    points = [numpy.column_stack([part.ravel() for part in (x, y, heights)])]
                    points += between(x, y, heights)
                    off = abs(pack.errors(manifest, numpy.concatenate(points)))
                    self.assertFalse(numpy.isnan(off).any())
                    self.assertLessEqual(off.max(), claim)
                    worst = max(worst, off.max())
            # Of rows in another order they would be off by hundreds of metres; and a claim that is far from what it is about says
            # nothing.
            self.assertGreater(worst, said["error_of_metres"] / 2)

    def test_heightmaps_share_their_outer_posts_to_the_bit(self):
        path = pack.pack(*pack.MANY)
        said = pack.manifest(path)["heightmaps"]
        self.assertGreater(min(said["tiles"]), 2)
        for read, extension in [(png, ".png"), (metres, ".tif")]:
            tiles = {
                (tile["column"], tile["row"]): read((path / tile["path"]).with_suffix(extension)) for tile in said["tile"]
            }
            self.assertEqual(len(tiles), said["tiles"][0] * said["tiles"][1])
            for (column, row), heights in tiles.items():
                if east := (tiles.get((column + 1, row)) is not None):
                    numpy.testing.assert_array_equal(heights[:, -1], tiles[column + 1, row][:, 0])
                if north := (tiles.get((column, row + 1)) is not None):
                    numpy.testing.assert_array_equal(heights[0], tiles[column, row + 1][-1])
                self.assertTrue(east or column + 1 == said["tiles"][0])
                self.assertTrue(north or row + 1 == said["tiles"][1])


def between(x, y, heights):
    """Points of both cuts of each cell and of the bilinear surface, at some places inside."""
    a, b = heights[1:, :-1], heights[1:, 1:]
    c, d = heights[:-1, :-1], heights[:-1, 1:]
    for u, v in [(0.5, 0.5), (0.25, 0.75), (0.2, 0.3), (0.9, 0.6), (0.5, 0.0), (0.0, 0.5)]:
        place = [part[1:, :-1] + share * (end - part[1:, :-1]) for part, share, end in
                 [(x, u, x[1:, 1:]), (y, v, y[:-1, :-1])]]
        for share in (max(0.0, u + v - 1), min(u, v), u * v):
            between = a + u * (b - a) + v * (c - a) + share * (d - b - c + a)
            yield numpy.column_stack([part.ravel() for part in (*place, between)])


if __name__ == "__main__":
    unittest.main()
