"""Records `cases.json`: masks of water that Rust and TypeScript both have to give, by exact arithmetic.

    python3 tests/water/record.py > tests/water/cases.json

A mask has 256 rows of 256 pixels, the northernmost first, told as lengths of runs of land, water, land, … A pixel is what its middle is: water if
an odd number of edges of one polygon are crossed to the west of it. What is exactly on an edge belongs to what is east or south of it.
"""

import json
import random
from fractions import Fraction
from itertools import groupby
from math import ceil, cos, pi, sin

SIDE = 256


def mask(polygons, zoom, x, y):
    degrees = Fraction(180, 2**zoom)
    west, north = x * degrees - 180, (y + 1) * degrees - 90
    pixels = [[False] * SIDE for _ in range(SIDE)]
    for rings in polygons:
        for turn in (-360, 0, 360):
            crossings = [[] for _ in range(SIDE)]
            for ring in rings:
                places = [
                    ((Fraction(a) - west - turn) / degrees * SIDE - Fraction(1, 2), (north - Fraction(b)) / degrees * SIDE - Fraction(1, 2))
                    for a, b in ring
                ]
                for (ax, ay), (bx, by) in zip(places, places[1:] + places[:1]):
                    for row in range(max(0, ceil(min(ay, by))), min(SIDE, ceil(max(ay, by)))):
                        crossings[row].append(ax + (bx - ax) * (row - ay) / (by - ay))
            for row, places in enumerate(crossings):
                places.sort()
                for first, last in zip(places[::2], places[1::2]):
                    for column in range(max(0, ceil(first)), min(SIDE, ceil(last))):
                        pixels[row][column] = True
    return [pixel for row in pixels for pixel in row]


def runs(pixels):
    lengths = [len(list(run)) for _, run in groupby(pixels)]
    return [0, *lengths] if pixels[0] else lengths


def rectangle(west, south, east, north):
    return [[west, south], [east, south], [east, north], [west, north]]


def shore(chance, vertices, west, south, size):
    """A ring of many vertices that goes back and forth across a square and beyond."""
    place = [west + size / 2, south + size / 2]
    ring = []
    for _ in range(vertices):
        place = [round(min(max(at + chance.uniform(-0.06, 0.06) * size, low - size), low + 2 * size), 6) for at, low in zip(place, (west, south))]
        ring.append(place)
    return ring


def island(vertices, longitude, latitude):
    """A ring whose edges are much shorter than pixels of the whole Earth."""
    angles = [2 * pi * at / vertices for at in range(vertices)]
    return [[round(longitude + r * cos(a), 3), round(latitude + r * sin(a), 3)] for a in angles for r in [4 + sin(5 * a)]]


def cases():
    chance = random.Random(1)
    middle = 180 / SIDE  # of two pixels beside each other, of zoom 0: exact
    yield [[rectangle(10.1, 10.2, 50.3, 50.4), rectangle(20.1, 20.2, 30.3, 30.4)], [rectangle(40.1, 40.2, 60.3, 60.4)]], [(0, 1, 0), (3, 8, 4)]
    yield [[rectangle(170.3, -10.1, 190.7, 10.9)]], [(0, 0, 0), (0, 1, 0), (4, 31, 8)]
    yield [[[[0.123, 0.456], [10.77, 3.21], [2.5, 11.1]]]], [(4, 16, 8), (4, 0, 0)]
    # Sides through middles of pixels.
    yield [[rectangle(*(middle * at for at in (64.5, 32.5, 128.5, 96.5)))]], [(0, 1, 0)]
    yield [[shore(chance, 1000, 11.25, 45, 11.25)]], [(4, 17, 12), (4, 18, 12), (5, 34, 24), (7, 140, 100)]
    yield [[island(1200, 60, 20)]], [(0, 1, 0), (1, 2, 1)]


print("[")
print(",\n".join(
    json.dumps({"polygons": polygons, "masks": [{"tile": tile, "runs": runs(mask(polygons, *tile))} for tile in tiles]})
    for polygons, tiles in cases()
))
print("]")
