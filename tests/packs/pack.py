"""Packs of the project's sample, each made once, and what they are held against: the DEM itself, by rasterio and PROJ.

None of the code here is the project's own but the program that writes the pack.
"""

import functools
import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy
import pyproj
import rasterio

TOP = Path(__file__).resolve().parents[2]
DEM = TOP / "data-samples/jacksboro_fault.tif"
# Options of a pack of many heightmaps.
MANY = ("--bbox=-84.4,36.2,-84.1,36.4", "--size", "65", "--spacing", "100")
PROGRAM = os.environ.get("TERRAIN_INGEST", str(TOP / "target/debug/terrain-ingest"))


@functools.cache
def folder() -> Path:
    """Where everything is; it goes when Python does."""
    folder.kept = tempfile.TemporaryDirectory(prefix="packs-")
    return Path(folder.kept.name)


@functools.cache
def archive() -> Path:
    path = folder() / "sample.pmtiles"
    run(DEM, "--max-error", "10", "-o", path)
    return path


@functools.cache
def with_a_hole() -> tuple[Path, numpy.ndarray]:
    """An archive of the sample without a part in its middle, and that raster's heights; -32768 where there are none."""
    dem, path = folder() / "holes.tif", folder() / "holes.pmtiles"
    with rasterio.open(DEM) as whole:
        profile, heights = whole.profile, whole.read(1)
    profile.update(nodata=-32768)
    heights[100:160, 120:200] = -32768
    with rasterio.open(dem, "w", **profile) as holes:
        holes.write(heights, 1)
    run(dem, "--max-error", "10", "-o", path)
    return path, heights


@functools.cache
def pack(*options: str) -> Path:
    path = folder() / "-".join(["sim", *options]).replace("--", "").replace(",", "_")
    run("pack", archive(), "--format", "sim", *options, "-o", path)
    return path


@functools.cache
def one_file(format: str, *options: str) -> Path:
    """A pack of another format."""
    words = [Path(word).name for word in (format, *options)]
    path = folder() / "-".join(words).replace("--", "").replace(",", "_")
    if not path.exists():
        run("pack", archive(), "--format", format, *options, "-o", path)
    return path


def run(*arguments) -> None:
    subprocess.run([PROGRAM, *map(str, arguments), "--quiet"], check=True, stdout=subprocess.DEVNULL)


def manifest(path: Path) -> dict:
    return json.loads((path / "manifest.json").read_text())


@functools.cache
def samples():
    with rasterio.open(DEM) as dem:
        return dem.read(1).astype(float), ~dem.transform


def to_geodetic(manifest: dict, points: numpy.ndarray) -> numpy.ndarray:
    """Longitudes, latitudes and heights of points in the frame, one a row, by PROJ."""
    origin = manifest["frame"]["origin"]
    pipeline = pyproj.Transformer.from_pipeline(
        "+proj=pipeline +step +inv +proj=topocentric +ellps=WGS84 "
        f"+lon_0={origin['longitude']!r} +lat_0={origin['latitude']!r} +h_0={origin['height']!r} "
        "+step +inv +proj=cart +ellps=WGS84 +step +proj=unitconvert +xy_in=rad +xy_out=deg"
    )
    return numpy.column_stack(pipeline.transform(*points.T))


def errors(manifest: dict, points: numpy.ndarray) -> numpy.ndarray:
    """How far points in the frame are above the DEM; NaN beside it."""
    longitude, latitude, height = to_geodetic(manifest, points).T
    return height - heights_of_dem(longitude, latitude)


def heights_of_dem(longitude: numpy.ndarray, latitude: numpy.ndarray) -> numpy.ndarray:
    """Heights of the DEM, which is bilinear between samples; NaN beside it."""
    dem, to_pixels = samples()
    column = to_pixels.a * longitude + to_pixels.b * latitude + to_pixels.c - 0.5
    row = to_pixels.d * longitude + to_pixels.e * latitude + to_pixels.f - 0.5
    rows, columns = dem.shape
    # PROJ and the program round differently: a billionth of a cell beside the outermost sample is on it.
    outside = (column < -1e-6) | (row < -1e-6) | (column > columns - 1 + 1e-6) | (row > rows - 1 + 1e-6)
    left = numpy.clip(numpy.floor(column), 0, columns - 2).astype(int)
    top = numpy.clip(numpy.floor(row), 0, rows - 2).astype(int)
    u, v = column - left, row - top
    upper = dem[top, left] * (1 - u) + dem[top, left + 1] * u
    lower = dem[top + 1, left] * (1 - u) + dem[top + 1, left + 1] * u
    return numpy.where(outside, numpy.nan, upper * (1 - v) + lower * v)


def places(manifest: dict, count: int, seed: int = 1) -> numpy.ndarray:
    """Places in plan that heightmaps cover."""
    low, high = manifest["heightmaps"]["low"], manifest["heightmaps"]["high"]
    return numpy.random.default_rng(seed).uniform(low, high, (count, 2))
