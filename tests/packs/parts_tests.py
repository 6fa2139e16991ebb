"""Packs of a part: tiles that touch a polygon; and what changed since an older pack, which makes the newer one of it."""

import hashlib
import json
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy
import pyproj
import rasterio

import pack
from quantized_mesh import extensions_at

# In degrees; no side is along a tile's.
TRIANGLE = numpy.array([(-84.40, 36.19), (-84.17, 36.22), (-84.33, 36.31)])


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def refused(*arguments) -> str:
    """What the program says where it refuses."""
    done = subprocess.run([pack.PROGRAM, *map(str, arguments), "--quiet"], capture_output=True, text=True)
    assert done.returncode == 2, (done.returncode, done.stderr)
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    return done.stderr


def is_apart(one: numpy.ndarray, other: numpy.ndarray) -> bool:
    """Whether a line along a side of a convex polygon parts it from another."""
    for polygon, beside in [(one, other), (other, one)]:
        for side in numpy.roll(polygon, -1, axis=0) - polygon:
            across = numpy.array([side[1], -side[0]])
            if (polygon @ across).max() < (beside @ across).min() or (beside @ across).max() < (polygon @ across).min():
                return True
    return False


def square(name: str) -> numpy.ndarray:
    z, x, y = [int(number) for number in name.removesuffix(".terrain").split("/")]
    side = 180 / 2**z
    west, south = x * side - 180, y * side - 90
    return numpy.array([(west, south), (west + side, south), (west + side, south + side), (west, south + side)])


def around(name: str) -> set:
    """The tile and those beside it and across its corners."""
    zoom, x, y = [int(number) for number in name.removesuffix(".terrain").split("/")]
    rows = range(max(y - 1, 0), min(y + 2, 2**zoom))
    return {f"{zoom}/{column % 2 ** (zoom + 1)}/{row}.terrain" for column in range(x - 1, x + 2) for row in rows}


def write_polygons(path: Path, polygons, crs: int) -> None:
    rings = [[[*polygon.tolist(), polygon[0].tolist()]] for polygon in polygons]
    path.write_text(json.dumps({
        "type": "FeatureCollection",
        "crs": {"type": "name", "properties": {"name": f"urn:ogc:def:crs:EPSG::{crs}"}},
        "features": [{"type": "Feature", "properties": {}, "geometry": {"type": "MultiPolygon", "coordinates": rings}}],
    }))


class Polygons(unittest.TestCase):
    def test_tiles_of_a_part_are_those_that_touch_a_polygon(self):
        whole = files(pack.one_file("folder"))
        measured = {name.replace(".glb", ".terrain") for name in files(pack.one_file("3d-tiles")) if name.endswith(".glb")}
        to_utm = pyproj.Transformer.from_crs(4326, 32616, always_xy=True)
        island = TRIANGLE * 0.02 + numpy.array([-84.12, 36.4]) * 0.98
        for crs, turned in [(4326, lambda points: points), (32616, lambda points: numpy.column_stack(to_utm.transform(*points.T)))]:
            polygons = pack.folder() / f"polygons-{crs}.geojson"
            write_polygons(polygons, [turned(TRIANGLE), turned(island)], crs)
            part = files(pack.one_file("folder", "--polygon", str(polygons)))
            chosen = {name for name in measured if not all(is_apart(square(name), area) for area in (TRIANGLE, island))}
            expected = chosen.union(*map(around, chosen), {"0/0/0.terrain", "0/1/0.terrain"})
            self.assertEqual(set(part), expected | {"layer.json"})
            self.assertLess(len(part), len(whole))
            for name in expected:
                self.assertEqual(part[name], whole[name])

    def test_a_raster_has_tiles_that_touch_a_polygon_too(self):
        polygons = pack.folder() / "polygon.geojson"
        write_polygons(polygons, [TRIANGLE], 4326)
        import pmtiles.reader

        def tiles(path):
            source = pmtiles.reader.MemorySource(path.read_bytes())
            return pmtiles.reader.Reader(source).header(), dict(pmtiles.reader.all_tiles(source))

        whole_header, whole = tiles(pack.one_file("terrarium", "--tile-size", "256"))
        header, part = tiles(pack.one_file("terrarium", "--tile-size", "256", "--polygon", str(polygons)))
        self.assertTrue(set(part) < set(whole))
        for tile, file in part.items():
            self.assertEqual(file, whole[tile])
        names = ("min_lon_e7", "min_lat_e7", "max_lon_e7", "max_lat_e7")
        bounds = [header[name] / 1e7 for name in names]
        numpy.testing.assert_allclose(bounds, [*TRIANGLE.min(axis=0), *TRIANGLE.max(axis=0)], atol=1e-6)

    def test_what_has_no_polygon_there_is_refused_and_leaves_nothing(self):
        far = pack.folder() / "far.geojson"
        write_polygons(far, [TRIANGLE + 30], 4326)
        empty = pack.folder() / "empty.geojson"
        write_polygons(empty, [], 4326)
        output = pack.folder() / "refused"
        for polygons in (far, empty, pack.folder() / "missing.geojson", pack.DEM):
            refused("pack", pack.archive(), "--format", "folder", "--polygon", polygons, "-o", output)
            self.assertFalse(output.exists())


class Differences(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # Its name is in every file of 3D Tiles.
        changed = pack.folder() / "changed" / pack.DEM.name
        changed.parent.mkdir()
        with rasterio.open(pack.DEM) as dem:
            profile, heights = dem.profile, dem.read(1)
        heights[40:50, 40:50] += 3
        with rasterio.open(changed, "w", **profile) as out:
            out.write(heights, 1)
        newer = pack.folder() / "changed.pmtiles"
        pack.run(changed, "--max-error", "10", "-o", newer)
        cls.newer = newer

    def difference(self, format, name, *options):
        """An old pack, a new one, the difference, and what the program makes of the first and the last."""
        old = pack.one_file(format)
        new, difference, made = [pack.folder() / f"{format}-{name}-{kind}" for kind in ("new", "difference", "made")]
        pack.run("pack", self.newer, "--format", format, *options, "-o", new)
        pack.run("pack", self.newer, "--format", format, *options, "--since", old, "-o", difference)
        pack.run("apply", old, difference, "-o", made)
        return [files(folder) for folder in (old, new, difference, made)]

    def test_the_old_pack_and_the_difference_make_the_new_pack_byte_for_byte(self):
        for format in ("folder", "3d-tiles"):
            old, new, difference, made = self.difference(format, "all")
            self.assertEqual(made, new)
            said = json.loads(difference.pop("difference.json"))
            changed = {name for name in new if new[name] != old.get(name)}
            self.assertEqual(set(said["changed"]), changed)
            self.assertEqual(set(said["gone"]), set(old) - set(new))
            self.assertEqual(difference, {f"files/{name}": new[name] for name in changed})
            self.assertLess(len(changed), len(new))
            self.assertGreater(len(changed), 5)
            if format == "folder":
                # Normals depend on the tiles above, which are made anew.
                surface = lambda file: file[: extensions_at(file)]
                tiles = [name for name in changed if name.endswith(".terrain")]
                moved = [name for name in tiles if name not in old or surface(new[name]) != surface(old[name])]
                self.assertLess(len(moved), len(new) / 2, "most tiles are far from what changed")

    def test_what_is_no_longer_meant_goes(self):
        old, new, difference, made = self.difference("folder", "part", "--bbox=-84.4,36.2,-84.3,36.3", "--max-zoom", "9")
        self.assertEqual(made, new)
        said = json.loads(difference["difference.json"])
        self.assertEqual(set(said["gone"]), set(old) - set(new))
        self.assertGreater(len(said["gone"]), 10)

    def test_another_old_pack_is_refused_and_leaves_nothing(self):
        self.difference("folder", "refused")
        old = pack.one_file("folder")
        difference = pack.folder() / "folder-refused-difference"
        said = json.loads((difference / "difference.json").read_text())
        kept = sorted(set(said["files"]) - set(said["changed"]))
        with tempfile.TemporaryDirectory(dir=pack.folder()) as home:
            other, output = Path(home) / "other", Path(home) / "output"
            subprocess.run(["cp", "-r", old, other], check=True)
            damaged = bytearray((other / kept[-1]).read_bytes())
            damaged[-1] ^= 1
            (other / kept[-1]).write_bytes(damaged)
            self.assertIn(kept[-1], refused("apply", other, difference, "-o", output))
            (other / kept[-1]).unlink()
            refused("apply", other, difference, "-o", output)
            outside = Path(home) / "outside"
            outside.mkdir()
            said["files"]["../escaped"] = said["files"][kept[0]]
            said["changed"].append("../escaped")
            (outside / "difference.json").write_text(json.dumps(said))
            self.assertIn("no path inside a pack", refused("apply", old, outside, "-o", output))
            self.assertEqual(sorted(path.name for path in Path(home).iterdir()), ["other", "outside"])

    def test_an_old_file_and_the_difference_make_the_new_file_byte_for_byte(self):
        for format, *options in [("3tz",), ("mbtiles-qm",), ("pmtiles-qm",), ("terrarium", "--tile-size", "256"), ("mapbox", "--tile-size", "256"), ("gpkg",)]:
            old = pack.one_file(format, *options)
            new, difference, made = [pack.folder() / f"{format}-file-{kind}" for kind in ("new", "difference", "made")]
            pack.run("pack", self.newer, "--format", format, *options, "-o", new)
            pack.run("pack", self.newer, "--format", format, *options, "--since", old, "-o", difference)
            pack.run("apply", old, difference, "-o", made)
            self.assertNotEqual(old.read_bytes(), new.read_bytes())
            self.assertEqual(made.read_bytes(), new.read_bytes(), format)
            self.assertEqual(set(files(difference)), {"difference.json", "pieces", "pieces.txt"})
            said = json.loads((difference / "difference.json").read_text())
            self.assertEqual(said["file"]["sha256"], hashlib.sha256(new.read_bytes()).hexdigest())
            # A fiftieth of the DEM changed. Of a GeoPackage all pages say where others are.
            size = sum(len(content) for content in files(difference).values())
            self.assertLess(size, new.stat().st_size * (0.7 if format != "gpkg" else 1.1), format)

    def test_another_old_file_is_refused_and_leaves_nothing(self):
        old = pack.one_file("pmtiles-qm")
        difference, output = pack.folder() / "another-difference", pack.folder() / "another"
        pack.run("pack", self.newer, "--format", "pmtiles-qm", "--since", old, "-o", difference)
        damaged = pack.folder() / "damaged"
        content = bytearray(old.read_bytes())
        content[len(content) // 2] ^= 1
        damaged.write_bytes(content)
        for other in (damaged, pack.one_file("terrarium", "--tile-size", "256"), pack.one_file("folder"), pack.folder() / "missing"):
            refused("apply", other, difference, "-o", output)
        for pieces in ("pieces.txt", "pieces"):
            cut = pack.folder() / f"cut-{pieces}"
            subprocess.run(["cp", "-r", difference, cut], check=True)
            (cut / pieces).write_bytes((cut / pieces).read_bytes()[:-100])
            refused("apply", old, cut, "-o", output)
        self.assertFalse(output.exists())

    def test_an_old_pack_of_another_kind_is_refused(self):
        output = pack.folder() / "no-difference"
        refused("pack", self.newer, "--format", "3tz", "--since", pack.one_file("folder"), "-o", output)
        refused("pack", self.newer, "--format", "mbtiles-qm", "--since", pack.one_file("3tz"), "-o", output)
        refused("pack", self.newer, "--format", "folder", "--since", pack.archive(), "-o", output)
        self.assertFalse(output.exists())


if __name__ == "__main__":
    unittest.main()
