"""Scenery for FlightGear, by SimGear, the library that it reads scenery with."""

import functools
import gzip
import json
import subprocess
import unittest
from pathlib import Path

import numpy
import pyproj

import pack

TO_GEODETIC = pyproj.Transformer.from_crs(4978, 4979, always_xy=True)


@functools.cache
def reader() -> Path:
    source, program = Path(__file__).with_name("btg_surface.cpp"), pack.folder() / "btg_surface"
    subprocess.run(["c++", "-std=c++17", source, "-o", program, "-lSimGearCore", "-lz", "-lcurl"], check=True)
    return program


class Bucket:
    """A file, as SimGear reads it."""

    def __init__(self, path):
        self.path = path
        found = subprocess.run([reader(), path], check=True, capture_output=True, text=True).stdout.splitlines()
        lines = [line.split() for line in found]
        self.version, *self.sphere = [float(number) for number in lines[0][1:]]
        self.folder, self.index, *self.place = lines[1][1:]
        vertices = numpy.array([line[1:] for line in lines if line[0] == "v"], dtype=float)
        self.positions, self.normals, self.textures = vertices[:, :3], vertices[:, 3:6], vertices[:, 6:]
        self.triangles = numpy.array([line[2:] for line in lines if line[0] == "t"], dtype=int)
        self.materials = [line[1] for line in lines if line[0] == "t"]
        self.geodetic = numpy.column_stack(TO_GEODETIC.transform(*self.positions.T))

    def bounds(self):
        longitude, latitude, width, height = [float(number) for number in self.place]
        return longitude - width / 2, latitude - height / 2, longitude + width / 2, latitude + height / 2


@functools.cache
def buckets(folder):
    return [Bucket(path) for path in sorted(folder.glob("Terrain/*/*/*.btg.gz"))]


def samples_of(bucket, count, seed=3):
    """Points on triangles, more where these are larger."""
    numbers = numpy.random.default_rng(seed)
    corners = bucket.positions[bucket.triangles]
    areas = numpy.linalg.norm(numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    chosen = numbers.choice(len(corners), count, p=areas / areas.sum())
    shares = numbers.dirichlet((1, 1, 1), count)
    return (corners[chosen] * shares[:, :, None]).sum(axis=1)


class FlightGear(unittest.TestCase):
    def test_files_are_in_the_bucket_that_simgear_puts_them_in(self):
        folder = pack.one_file("btg")
        found = buckets(folder)
        self.assertEqual(len(found), 6)
        for bucket in found:
            inside = bucket.path.relative_to(folder / "Terrain")
            self.assertEqual(str(inside), f"{bucket.folder}/{bucket.index}.btg.gz")
            stg = bucket.path.with_name(f"{bucket.index}.stg").read_text()
            self.assertEqual(stg, f"OBJECT_BASE {bucket.index}.btg\n")
            self.assertEqual(bucket.version, 10)
            west, south, east, north = bucket.bounds()
            longitudes, latitudes, _ = bucket.geodetic.T
            # A few millimetres, for single precision.
            self.assertTrue((longitudes > west - 1e-7).all() and (longitudes < east + 1e-7).all())
            self.assertTrue((latitudes > south - 1e-7).all() and (latitudes < north + 1e-7).all())
            away = numpy.linalg.norm(bucket.positions - bucket.sphere[:3], axis=1)
            self.assertTrue(bucket.sphere[3] * 0.999 < away.max() <= bucket.sphere[3])

    def test_triangles_are_as_near_to_the_dem_as_is_said(self):
        folder = pack.one_file("btg")
        said = json.loads((folder / "manifest.json").read_text())
        self.assertLess(said["rounding_error"], 0.02)
        self.assertEqual(said["buckets"], len(buckets(folder)))
        worst = 0.0
        for bucket in buckets(folder):
            longitudes, latitudes, heights = TO_GEODETIC.transform(*samples_of(bucket, 3_000).T)
            off = abs(heights - pack.heights_of_dem(longitudes, latitudes))
            self.assertLess(numpy.isnan(off).sum(), 100)
            self.assertLessEqual(numpy.nanmax(off), said["error"])
            worst = max(worst, numpy.nanmax(off))
        self.assertGreater(worst, said["error"] / 2)

    def test_all_of_the_dem_is_there_once(self):
        dem, to_pixels = pack.samples()
        west, north = ~to_pixels * (0.5, 0.5)
        east, south = ~to_pixels * (dem.shape[1] - 0.5, dem.shape[0] - 0.5)
        # Areas in plan, in squared degrees: triangles that overlap or are missing would be more or less.
        plan = sum(
            abs(numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])).sum() / 2
            for corners in (bucket.geodetic[:, :2][bucket.triangles] for bucket in buckets(pack.one_file("btg")))
        )
        self.assertAlmostEqual(plan / ((east - west) * (north - south)), 1, delta=1e-3)

    def test_buckets_meet(self):
        found = buckets(pack.one_file("btg"))
        meetings = 0
        for one in found:
            for other in found:
                if one is other or abs(one.bounds()[2] - other.bounds()[0]) > 1e-9 or one.bounds()[1] != other.bounds()[1]:
                    continue
                side = one.bounds()[2]
                mine, others = [bucket.positions[abs(bucket.geodetic[:, 0] - side) < 1e-8] for bucket in (one, other)]
                self.assertGreater(len(mine), 5)
                self.assertEqual(len(mine), len(others))
                for position in mine:
                    self.assertLess(numpy.linalg.norm(others - position, axis=1).min(), 0.003)
                meetings += 1
        self.assertGreater(meetings, 2)

    def test_triangles_face_up_and_normals_are_near_theirs(self):
        for bucket in buckets(pack.one_file("btg")):
            corners = bucket.positions[bucket.triangles]
            across = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            length = numpy.linalg.norm(across, axis=1)
            is_large = length > 1
            up = corners.mean(axis=1) / numpy.linalg.norm(corners.mean(axis=1), axis=1)[:, None]
            self.assertTrue(((across * up).sum(axis=1) > 0)[is_large].all())
            self.assertLess(abs(numpy.linalg.norm(bucket.normals, axis=1) - 1).max(), 0.02)
            mean = bucket.normals[bucket.triangles].mean(axis=1)
            cosine = (mean * across).sum(axis=1)[is_large] / length[is_large]
            self.assertGreater(numpy.median(cosine), 0.95)
            # A texture is a kilometre wide.
            edges = numpy.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
            textures = bucket.textures[bucket.triangles]
            on_texture = numpy.linalg.norm(textures[:, 1] - textures[:, 0], axis=1) * 1000
            self.assertTrue((on_texture[edges > 10] <= edges[edges > 10] * 1.001).all())
            self.assertGreater(numpy.median(on_texture[edges > 10] / edges[edges > 10]), 0.9)

    def test_ground_is_of_the_material_asked_for_and_water_is_a_lake(self):
        self.assertEqual({name for bucket in buckets(pack.one_file("btg")) for name in bucket.materials}, {"Grassland"})
        lake = [(-84.3, 36.2), (-84.2, 36.2), (-84.2, 36.3), (-84.3, 36.3), (-84.3, 36.2)]
        polygons = pack.folder() / "lake.geojson"
        polygons.write_text(json.dumps({
            "type": "FeatureCollection",
            "features": [{"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [lake]}}],
        }))
        archive, folder = pack.folder() / "lake.pmtiles", pack.folder() / "lake"
        pack.run(pack.DEM, "--max-error", "10", "--water", polygons, "-o", archive)
        pack.run("pack", archive, "--format", "btg", "--material", "EvergreenForest", "-o", folder)
        found = {"Lake": [], "EvergreenForest": []}
        for bucket in buckets(folder):
            for material, corners in zip(bucket.materials, bucket.geodetic[bucket.triangles]):
                found[material].append(corners.mean(axis=0)[:2])
        pixel = 0.001
        for longitude, latitude in found["Lake"]:
            self.assertTrue(-84.3 - pixel < longitude < -84.2 + pixel and 36.2 - pixel < latitude < 36.3 + pixel)
        for longitude, latitude in found["EvergreenForest"]:
            self.assertFalse(-84.3 + pixel < longitude < -84.2 - pixel and 36.2 + pixel < latitude < 36.3 - pixel)
        self.assertGreater(len(found["Lake"]), 10)

    def test_heights_above_the_ellipsoid_become_heights_above_the_sea(self):
        archive, folder = pack.folder() / "btg-ellipsoid.pmtiles", pack.folder() / "btg-sea"
        pack.run(pack.DEM, "--max-error", "10", "--vertical", "egm96", "-o", archive)
        pack.run("pack", archive, "--format", "btg", "--bbox=-84.4,36.2,-84.2,36.3", "-o", folder)
        said = json.loads((folder / "manifest.json").read_text())
        self.assertIn("egm96", said["heights_above"])
        for bucket in buckets(folder):
            longitudes, latitudes, heights = bucket.geodetic.T
            off = abs(heights - pack.heights_of_dem(longitudes, latitudes))
            self.assertLessEqual(numpy.nanmax(off), said["error"])

    def test_the_same_archive_gives_the_same_bytes(self):
        again = pack.folder() / "btg-again"
        pack.run("pack", pack.archive(), "--format", "btg", "-o", again)
        for path in pack.one_file("btg").rglob("*"):
            if path.is_file():
                self.assertEqual(path.read_bytes(), (again / path.relative_to(pack.one_file("btg"))).read_bytes())
        self.assertTrue(gzip.decompress(next(again.rglob("*.btg.gz")).read_bytes()).startswith(b"\x0a\x00GS"))


if __name__ == "__main__":
    unittest.main()
