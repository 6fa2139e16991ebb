# /// script
# requires-python = ">=3.10"
# dependencies = ["matplotlib==3.11.2", "rasterio==1.4.4"]
# ///
"""Rebuilds jacksboro_fault.tif from the sample data that the matplotlib package carries.

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install matplotlib==3.11.2 rasterio==1.4.4
    /tmp/venv/bin/python data-samples/jacksboro_fault.py

or `uv run data-samples/jacksboro_fault.py`.
"""

from pathlib import Path

import numpy
import rasterio
from matplotlib import cbook
from rasterio.transform import from_origin

SOURCE = "jacksboro_fault_dem.npz"
OUTPUT = Path(__file__).with_name("jacksboro_fault.tif")
# Outer edges of the north-western pixel, degrees. The source's own `ymin` (36.7329) is no edge of these data: its
# `ymax` is the north edge, and the south edge is 344 pixels below it.
WEST, NORTH = -84.41375, 36.44625
STEP = 1 / 1200


def main():
    heights = numpy.load(cbook.get_sample_data(SOURCE, asfileobj=False))["elevation"]
    assert heights.shape == (344, 403) and heights.dtype == numpy.int16, (heights.shape, heights.dtype)
    assert (heights.min(), heights.max()) == (236, 1076), (heights.min(), heights.max())
    profile = {
        "driver": "GTiff",
        "width": heights.shape[1],
        "height": heights.shape[0],
        "count": 1,
        "dtype": "int16",
        "crs": "EPSG:4326",
        "transform": from_origin(WEST, NORTH, STEP, STEP),
        "compress": "deflate",
        "predictor": 2,
        "zlevel": 9,
    }
    with rasterio.open(OUTPUT, "w", **profile) as raster:
        raster.write(heights, 1)
        raster.units = ["m"]


if __name__ == "__main__":
    main()
