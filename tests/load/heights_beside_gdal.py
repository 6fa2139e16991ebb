"""Heights at random places a second: the service and the library of this project beside GDAL on the raster that the archive is made of.

    python3 tests/load/heights_beside_gdal.py ARCHIVE.pmtiles RASTER.tif [--rounds 3]

Each is asked for the same places, by turns. The library is asked where terrain_heights and NumPy are installed. The service of GDAL is
what most services of heights are: Python's own server, rasterio, and bilinear heights from blocks that GDAL keeps. Needs gdal-bin and
rasterio; TERRAIN_SERVER is another program than target/release/terrain-server.
"""

import argparse
import contextlib
import http.client
import http.server
import json
import math
import pathlib
import random
import statistics
import subprocess
import threading
import time
import urllib.parse

import rasterio
from programs import get, terrain_server
from rasterio.windows import Window

PLACES = 20_000
# What services commonly take at once.
FEW = 100
MANY = 10_000
MARGIN = 0.01


def main():
    options = arguments()
    with terrain_server(options.archive) as (_, address), raster_server(options.raster) as of_raster:
        [tileset] = json.loads(get(f"{address}/tilesets"))
        places = random_places(tileset["metadata"]["bounds"])
        name = tileset["name"]
        programs = {
            "service, 10,000 places a request": lambda: service(address, name, places, MANY),
            "service, 100 places a request": lambda: service(address, name, places, FEW),
            "service, one place a request": lambda: one_by_one(address, name, places[:2_000]),
            "Python and rasterio, 100 places a request": lambda: of_rasterio(of_raster, places[:2_000]),
            "gdallocationinfo, all places at once": lambda: gdallocationinfo(options.raster, places),
        }
        programs |= library(options.archive, places)
        seconds = {program: [] for program in programs}
        for _ in range(options.rounds + 1):
            for program, ask in programs.items():
                began = time.perf_counter()
                count = ask()
                seconds[program].append((time.perf_counter() - began) / count)
    print("| | places a second |\n| --- | ---: |")
    for program, each in seconds.items():
        # The first round fills caches.
        print(f"| {program} | {1 / statistics.median(each[1:]):,.0f} |")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("archive", type=pathlib.Path)
    parser.add_argument("raster", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=3)
    return parser.parse_args()


def random_places(bounds):
    west, south, east, north = bounds
    chance = random.Random(1)
    within = [(west, east), (south, north)]
    return [[chance.uniform(low + MARGIN * (high - low), high - MARGIN * (high - low)) for low, high in within] for _ in range(PLACES)]


def service(address, name, places, at_once):
    connection = http.client.HTTPConnection(urllib.parse.urlsplit(address).netloc)
    for first in range(0, len(places), at_once):
        part = places[first : first + at_once]
        connection.request("POST", f"/{name}/height", json.dumps({"points": part}), {"Content-Type": "application/json"})
        answer = connection.getresponse()
        body = answer.read()
        if answer.status != 200:
            raise SystemExit(body.decode())
    return len(places)


def one_by_one(address, name, places):
    connection = http.client.HTTPConnection(urllib.parse.urlsplit(address).netloc)
    for x, y in places:
        connection.request("GET", f"/{name}/height?longitude={x}&latitude={y}")
        connection.getresponse().read()
    return len(places)


def of_rasterio(address, places):
    connection = http.client.HTTPConnection(address)
    for first in range(0, len(places), FEW):
        locations = "|".join(f"{y},{x}" for x, y in places[first : first + FEW])
        connection.request("GET", "/v1/dem?" + urllib.parse.urlencode({"locations": locations}))
        connection.getresponse().read()
    return len(places)


def gdallocationinfo(raster, places):
    lines = "".join(f"{x} {y}\n" for x, y in places)
    command = ["gdallocationinfo", "-valonly", "-wgs84", str(raster)]
    subprocess.run(command, input=lines, check=True, capture_output=True, text=True)
    return len(places)


def library(archive, places):
    try:
        import numpy
        import terrain_heights
    except ModuleNotFoundError:
        return {}
    heights = terrain_heights.Heights(str(archive), cache_bytes=256 << 20)
    longitudes, latitudes = numpy.array(places).T.copy()

    def ask():
        heights.at_many(longitudes, latitudes)
        return len(places)

    return {"library in Python, one thread": ask}


@contextlib.contextmanager
def raster_server(raster):
    """The address of a service like those that read rasters with rasterio."""
    with rasterio.open(raster) as dataset:

        class Answer(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                [locations] = urllib.parse.parse_qs(urllib.parse.urlsplit(self.path).query)["locations"]
                places = [tuple(map(float, place.split(","))) for place in locations.split("|")]
                results = [{"elevation": bilinear(dataset, x, y), "location": {"lat": y, "lng": x}} for y, x in places]
                body = json.dumps({"results": results, "status": "OK"}).encode()
                self.send_response(200)
                self.send_header("Content-Type", "application/json")
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_):
                pass

        server = http.server.HTTPServer(("127.0.0.1", 0), Answer)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield f"127.0.0.1:{server.server_address[1]}"
        finally:
            server.shutdown()


def bilinear(dataset, x, y):
    column, row = ~dataset.transform * (x, y)
    column, row = column - 0.5, row - 0.5
    first = [math.floor(column), math.floor(row)]
    (a, b), (c, d) = dataset.read(1, window=Window(*first, 2, 2)).astype(float)
    across, down = column - first[0], row - first[1]
    above, below = a + (b - a) * across, c + (d - c) * across
    return above + (below - above) * down


if __name__ == "__main__":
    main()
