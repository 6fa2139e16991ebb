"""Requests a second of terrain-server beside nginx on the same bytes, by turns, asked by wrk.

    python3 tests/load/beside_nginx.py ARCHIVE.pmtiles [--rounds 5] [--seconds 5] [--connections 16,64,256]

nginx has the tiles as files that gzip made, open and in the system's cache; terrain-server has them in its own. Needs nginx and wrk;
TERRAIN_SERVER is another program than target/release/terrain-server.
"""

import argparse
import json
import pathlib
import statistics
import tempfile

from load import asked_by_wrk
from programs import get, nginx, processor_seconds, terrain_server


def main():
    options = arguments()
    with tempfile.TemporaryDirectory(prefix="load-") as name, terrain_server(options.archive) as ours:
        home = pathlib.Path(name)
        paths, size = tiles_as_files(ours[1], home / "files")
        print(f"{len(paths)} tiles, {size / len(paths) / 1000:.1f} kB each\n")
        print("| connections | requests a second | nginx | share | p50, ms | nginx | p99, ms | nginx | share | own + system µs of the processor a request | nginx |")
        print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
        with nginx(home / "files", home) as theirs:
            for connections in options.connections:
                compare(ours, theirs, paths, home, connections, options)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("archive", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=int, default=5)
    parser.add_argument("--connections", type=lambda text: [int(number) for number in text.split(",")], default=[16, 64, 256])
    return parser.parse_args()


def tiles_as_files(address, folder):
    """Writes every tile as it is sent; returns their paths with the version, and how many bytes they have."""
    [tileset] = json.loads(get(f"{address}/tilesets"))
    paths, size = [], 0
    for zoom in tileset["metadata"]["zooms"]:
        for west, south, east, north in zoom["available"]:
            for x in range(west, east + 1):
                for y in range(south, north + 1):
                    path = f"/{tileset['name']}/{zoom['zoom']}/{x}/{y}.terrain"
                    body = get(f"{address}{path}", accept_encoding="gzip")
                    file = folder / path[1:]
                    file.parent.mkdir(parents=True, exist_ok=True)
                    file.write_bytes(body)
                    paths.append(f"{path}?v={tileset['version']}")
                    size += len(body)
    return paths, size


def compare(ours, theirs, paths, home, connections, options):
    measured = [[], []]
    for number in range(options.rounds + 1):
        for program, rounds in zip((ours, theirs), measured):
            figures = asked(program, paths, home, connections, options.seconds)
            if number > 0:  # The first one warms up.
                rounds.append(figures)
    middle = {name: [statistics.median(one[name] for one in rounds) for rounds in measured] for name in measured[0][0]}
    (requests, of_nginx), p50, p99 = middle["requests"], middle["p50"], middle["p99"]
    shares = [requests / of_nginx, p99[0] / p99[1]]
    cells = [f"{requests:.0f}", f"{of_nginx:.0f}", f"{shares[0]:.2f}", *(f"{ms:.2f}" for ms in p50 + p99), f"{shares[1]:.2f}"]
    cells += [f"{own:.1f} + {system:.1f}" for own, system in zip(middle["own"], middle["system"])]
    print(f"| {connections} | {' | '.join(cells)} |", flush=True)


def asked(program, paths, home, connections, seconds):
    """What wrk says, and the processor's work for each request."""
    process, address = program
    before = processor_seconds(process)
    figures = asked_by_wrk(address, paths, home, connections, seconds)
    if figures["failed"]:
        raise SystemExit(f"{figures['failed']} answers of {address} failed")
    work = [(after - start) / (figures["requests"] * seconds) * 1e6 for start, after in zip(before, processor_seconds(process))]
    return figures | {"own": work[0], "system": work[1]}


if __name__ == "__main__":
    main()
