"""Normals in a folder of quantized-mesh: neighbours agree, and zooms nearly do."""

import collections
import functools
import unittest
from pathlib import Path

import numpy
import rasterio

import pack
from quantized_mesh import EXTENT, read

# Vertices nearer than this, in parts of a tile, may have become one by rounding.
CLEAR = 8


def unit(coded: numpy.ndarray) -> numpy.ndarray:
    plane = coded / 255 * 2 - 1
    z = 1 - numpy.abs(plane).sum(axis=1)
    sign = numpy.where(plane >= 0, 1, -1)
    folded = numpy.where(z[:, None] < 0, (1 - numpy.abs(plane[:, ::-1])) * sign, plane)
    vectors = numpy.column_stack([folded, z])
    return vectors / numpy.linalg.norm(vectors, axis=1)[:, None]


@functools.cache
def around_the_earth() -> Path:
    """A folder of tiles of hills around the whole Earth, poles and antimeridian among them."""
    dem, archive, folder = (pack.folder() / name for name in ("earth.tif", "earth.pmtiles", "earth"))
    column, row = numpy.meshgrid(numpy.arange(72), numpy.arange(36))
    heights = (3000 * numpy.sin(column) * numpy.cos(row) + 1000).astype("int16")
    place = rasterio.transform.from_origin(-180, 90, 5, 5)
    profile = {"driver": "GTiff", "width": 72, "height": 36, "count": 1, "dtype": "int16", "crs": "EPSG:4326", "transform": place}
    with rasterio.open(dem, "w", **profile) as raster:
        raster.write(heights, 1)
    pack.run(dem, "--max-error", "300", "-o", archive)
    pack.run("pack", archive, "--format", "folder", "-o", folder)
    return folder


@functools.cache
def zooms(folder: Path) -> dict[int, dict[tuple[int, int], tuple]]:
    found = collections.defaultdict(dict)
    for path in folder.rglob("*.terrain"):
        z, x, y = (int(number) for number in path.relative_to(folder).with_suffix("").parts)
        found[z][x, y] = read(path.read_bytes())
    return found


class Normals(unittest.TestCase):
    def test_tiles_that_meet_have_the_same_bytes(self):
        for folder, least in ((pack.one_file("folder"), 1000), (around_the_earth(), 60)):
            shared = 0
            for zoom, tiles in zooms(folder).items():
                places = collections.defaultdict(lambda: collections.defaultdict(set))
                for (x, y), (vertices, normals, (low, high)) in tiles.items():
                    on_side = (vertices[:, :2] % EXTENT == 0).any(axis=1)
                    for (u, v, height), normal in zip(vertices[on_side], normals[on_side]):
                        column = (x * EXTENT + u) % (EXTENT << (zoom + 1))
                        metres = round(low + height / EXTENT * (high - low))
                        places[column, y * EXTENT + v, metres][x, y].add(tuple(normal))
                for place, by_tile in places.items():
                    if len(by_tile) > 1:
                        shared += 1
                        # At a step there may be two.
                        self.assertTrue(set.intersection(*by_tile.values()), f"{folder.name}, zoom {zoom}, {place}: {dict(by_tile)}")
            self.assertGreater(shared, least)

    def test_they_turn_by_two_degrees_at_most_to_the_next_zoom(self):
        compared = turned_more = 0
        for folder in (pack.one_file("folder"), around_the_earth()):
            found = zooms(folder)
            for zoom in sorted(found)[:-1]:
                (coarse, normals), (fine, finer_normals) = on_the_earth(found[zoom], 2), on_the_earth(found[zoom + 1], 1)
                near_coarse, near_fine = Near(coarse), Near(fine)
                for place, normal in zip(coarse[::4], normals[::4]):
                    same = near_fine.places(place)
                    if len(same) == 1 and len(near_coarse.places(place)) == 1 and numpy.abs(fine[same[0]] - place).max() <= 2:
                        turned = numpy.degrees(numpy.arccos(min(1, finer_normals[same[0]] @ normal)))
                        compared += 1
                        turned_more += turned > 2
        self.assertGreater(compared, 2000)
        # Several vertices at one place after rounding have one normal, which need not be that of the same one at the next zoom.
        self.assertLess(turned_more, compared / 200)


def on_the_earth(tiles: dict, scale: int) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Columns and rows of a zoom's vertices on the whole Earth, times `scale`, and their normals; a vertex that tiles share once."""
    places = [vertices[:, :2] + [x * EXTENT, y * EXTENT] for (x, y), (vertices, _, _) in tiles.items()]
    places, first = numpy.unique(numpy.concatenate(places), axis=0, return_index=True)
    normals = numpy.concatenate([normals for _, normals, _ in tiles.values()])
    return places * scale, unit(normals[first])


class Near:
    """Finds places by others near them."""

    def __init__(self, places: numpy.ndarray):
        self.all = places
        self.cells = collections.defaultdict(list)
        for index, (column, row) in enumerate(places // (CLEAR + 1)):
            self.cells[column, row].append(index)

    def places(self, place: numpy.ndarray) -> list[int]:
        """Those nearer than CLEAR along either axis."""
        column, row = place // (CLEAR + 1)
        cells = [self.cells.get((column + across, row + up), []) for across in (-1, 0, 1) for up in (-1, 0, 1)]
        return [index for cell in cells for index in cell if numpy.abs(self.all[index] - place).max() <= CLEAR]


if __name__ == "__main__":
    unittest.main()
