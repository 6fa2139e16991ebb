"""Writes a made-up site of 2 km with cells of 5 m into a raster of its country: the country's heights, and relief of its own on them.

COUNTRY LONGITUDE LATITUDE SITE
"""

import sys

import numpy
import rasterio
from rasterio.transform import from_origin
from rasterio.warp import Resampling, reproject, transform

SIDE, CELL = 400, 5.0

country_path, longitude, latitude, out_path = sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), sys.argv[4]
# The zone of UTM there.
crs = f"EPSG:{(32600 if latitude >= 0 else 32700) + int((longitude + 180) // 6) + 1}"
(east,), (north,) = transform("EPSG:4326", crs, [longitude], [latitude])
to_crs = from_origin(round(east) - SIDE * CELL / 2, round(north) + SIDE * CELL / 2, CELL, CELL)
heights = numpy.full((SIDE, SIDE), numpy.nan, numpy.float32)
with rasterio.open(country_path) as country:
    reproject(rasterio.band(country, 1), heights, dst_transform=to_crs, dst_crs=crs, dst_nodata=numpy.nan, resampling=Resampling.cubic)
if numpy.isnan(heights).any():
    sys.exit("the country has voids there")

# Octaves of noise, each half as wide and 0.55 times as high as the one before; none at the site's edge.
chance = numpy.random.default_rng(5)
relief, width, height = numpy.zeros((SIDE, SIDE)), 160, 12.0
while width >= 5:
    knots = chance.normal(size=(SIDE // width + 2, SIDE // width + 2))
    at = numpy.arange(SIDE) / width
    low, part = at.astype(int), at % 1
    part = part * part * (3 - 2 * part)
    rows = knots[low] * (1 - part)[:, None] + knots[low + 1] * part[:, None]
    relief += height * (rows[:, low] * (1 - part) + rows[:, low + 1] * part)
    width, height = width // 2, height * 0.55
edge = numpy.minimum.outer(*[numpy.minimum(numpy.arange(SIDE), numpy.arange(SIDE)[::-1]) / 100] * 2)
heights += relief * numpy.clip(edge, 0, 1)

profile = dict(driver="GTiff", width=SIDE, height=SIDE, count=1, dtype="float32", crs=crs, transform=to_crs, compress="deflate", predictor=3)
with rasterio.open(out_path, "w", **profile) as site:
    site.write(heights, 1)
