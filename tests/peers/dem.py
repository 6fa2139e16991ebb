"""Elevation rasters as every program of the comparison gets them: one grid of metres, void-free.

Heights, units and voids are read as terrain-ingest reads them (`ingest/src/raster`), from GDAL by another binding.
"""

import hashlib
import math
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy
import rasterio
from affine import Affine
from rasterio.errors import RasterioError

# Metres in the units that rasters name; no name means metres.
METRES_IN = {
    "": 1.0, "m": 1.0, "metre": 1.0, "metres": 1.0, "meter": 1.0, "meters": 1.0,
    "dm": 0.1, "decimetre": 0.1, "decimetres": 0.1, "decimeter": 0.1, "decimeters": 0.1,
    "cm": 0.01, "centimetre": 0.01, "centimetres": 0.01, "centimeter": 0.01, "centimeters": 0.01,
    "mm": 0.001, "millimetre": 0.001, "millimetres": 0.001, "millimeter": 0.001, "millimeters": 0.001,
    "km": 1000.0, "kilometre": 1000.0, "kilometres": 1000.0, "kilometer": 1000.0, "kilometers": 1000.0,
    "ft": 0.3048, "foot": 0.3048, "feet": 0.3048, "international foot": 0.3048, "international feet": 0.3048,
    "us-ft": 1200 / 3937, "ftus": 1200 / 3937, "us_ft": 1200 / 3937, "foot_us": 1200 / 3937,
    "us foot": 1200 / 3937, "us feet": 1200 / 3937, "us survey foot": 1200 / 3937, "us survey feet": 1200 / 3937,
}  # fmt: skip
# Metres; what is beyond is an undeclared void.
HIGHEST = 100_000.0
METRES_IN_A_DEGREE = 111_320.0


class Unusable(Exception):
    """A raster that cannot be compared, with the reason."""


@dataclass(frozen=True)
class Dem:
    """Samples in metres, and where they are."""

    name: str
    path: Path
    heights: numpy.ndarray
    """float64, rows × columns, no voids."""
    to_crs: Affine
    """Grid coordinates (column, row), integers at samples, to the coordinate reference system."""
    cell: tuple[float, float]
    """Ground distance in metres from one column to the next, and from one row to the next."""

    @property
    def digest(self) -> str:
        """Names the heights, whatever file they come from."""
        shape = repr(self.heights.shape).encode()
        return hashlib.sha256(shape + self.heights.tobytes()).hexdigest()[:16]

    @property
    def size(self) -> str:
        rows, columns = self.heights.shape
        return f"{columns} × {rows}"

    def first_square(self, side: int) -> "Dem":
        """The first `side` × `side` samples; `path` stays that of the whole."""
        return replace(self, heights=numpy.ascontiguousarray(self.heights[:side, :side]))


def read(path: Path) -> Dem:
    """Band 1 of a raster; `Unusable` where it is no raster or has voids."""
    try:
        with warnings.catch_warnings(action="ignore"), rasterio.open(path) as raster:
            heights = metres(raster)
            to_crs = raster.transform @ Affine.translation(0.5, 0.5)
            return Dem(path.name, path.resolve(), heights, to_crs, ground_cell(raster))
    except RasterioError as error:
        raise Unusable(f"not read: {error}") from error


def metres(raster: rasterio.DatasetReader) -> numpy.ndarray:
    unit = (raster.units[0] or "").strip().lower()
    scale = METRES_IN.get(unit, 1.0)
    heights = raster.read(1).astype(numpy.float64) * (raster.scales[0] * scale) + raster.offsets[0] * scale
    is_void = (raster.read_masks(1) == 0) | ~(numpy.abs(heights) < HIGHEST)
    if min(heights.shape) < 2:
        raise Unusable(f"has no cell: {heights.shape[1]} × {heights.shape[0]} samples")
    if is_void.any():
        raise Unusable(f"{is_void.sum():,} of {is_void.size:,} samples are void")
    return heights


def ground_cell(raster: rasterio.DatasetReader) -> tuple[float, float]:
    step = raster.transform
    width, height = math.hypot(step.a, step.d), math.hypot(step.b, step.e)
    if raster.crs is None:
        raise Unusable("does not say where it is")
    if not raster.crs.is_geographic:
        metres_in_unit = raster.crs.linear_units_factor[1]
        return width * metres_in_unit, height * metres_in_unit
    _, middle = step @ (raster.width / 2, raster.height / 2)
    return width * METRES_IN_A_DEGREE * math.cos(math.radians(middle)), height * METRES_IN_A_DEGREE
