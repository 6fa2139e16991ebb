"""Compares terrain-ingest with other programs: the same DEMs, the same asked errors, one evaluator. See README.md."""

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

import dem
import report
from cache import Cache
from comparison import Comparison
from dem import Dem
from programs import HERE, OURS, Program, peers, terrain_ingest

ROOT = HERE.parents[1]
TARGET = ROOT / "target" / "peers"
SAMPLE = ROOT / "data-samples" / "jacksboro_fault.tif"
SHARED = Path(os.environ.get("TERRAIN_SHARED_DATA", ROOT.parent / "shared" / "data"))
SHARED_FOLDERS = ("srtm", "projected")


def main() -> int:
    options = parse()
    TARGET.mkdir(parents=True, exist_ok=True)
    print(report.CAPTION)
    with tempfile.TemporaryDirectory(dir=TARGET) as folder:
        comparison = Comparison(options.programs, Cache(TARGET / "cache", options.fresh), Path(folder))
        for grid in usable(options.dems):
            rows = comparison.run(grid, options.errors)
            print(f"\n### {grid.name}, {grid.size} samples\n\n{report.dem_table(rows)}", flush=True)
    print(f"\n### Summary\n\n{report.summary_table(comparison.rows)}")
    for failure in comparison.failures:
        print(f"\n{failure}")
    if options.json:
        options.json.write_text(json.dumps([row.record() for row in comparison.rows], indent=1) + "\n")
    return verdict(comparison)


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="./task peers", description=__doc__)
    option = parser.add_argument
    option("dems", nargs="*", type=Path, metavar="DEM", help="rasters without voids (the project's sample)")
    option("--shared", action="store_true", help=f"also those in ../shared/data: {', '.join(SHARED_FOLDERS)}")
    option("--errors", type=numbers, default="5,10,20,50", help="asked errors in metres (%(default)s)")
    option("--only", type=words, help="these programs: terrain-ingest,pydelatin,… (all)")
    option("--qualities", type=words, default="fast,default,best", help="of terrain-ingest (%(default)s)")
    option("--bounds", type=words, default="samples,surface", help="of terrain-ingest (%(default)s)")
    option("--program", type=Path, default=ROOT / "target/release/terrain-ingest", help="the terrain-ingest to run")
    option("--json", type=Path, metavar="FILE", help="write all rows there, too")
    option("--fresh", action="store_true", help="run the peers again, even where their runs are kept")
    options = parser.parse_args()
    options.dems = options.dems or [SAMPLE]
    if options.shared:
        options.dems += shared_files(parser)
    options.programs = chosen(parser, options)
    return options


def numbers(text: str) -> list[float]:
    values = [float(word) for word in words(text)]
    if not all(0 < value < float("inf") for value in values):
        raise ValueError
    return values


def words(text: str) -> list[str]:
    return text.split(",")


def shared_files(parser: argparse.ArgumentParser) -> list[Path]:
    if not SHARED.is_dir():
        parser.error(f"--shared: there is no {SHARED}")
    return sorted(path for name in SHARED_FOLDERS for path in (SHARED / name).rglob("*") if path.is_file())


def chosen(parser: argparse.ArgumentParser, options: argparse.Namespace) -> list[Program]:
    ours = [
        terrain_ingest(options.program, quality, bound) for bound in options.bounds for quality in options.qualities
    ]
    programs = [*peers(), *ours]
    families = {program.family for program in programs}
    only = set(options.only or families)
    if only - families:
        parser.error(f"--only: {', '.join(sorted(only - families))}: there are {', '.join(sorted(families))}")
    if OURS in only and not options.program.is_file():
        parser.error(f"there is no {options.program}: build it, or name another one by --program")
    return [program for program in programs if program.family in only]


def usable(paths: Iterable[Path]) -> Iterator[Dem]:
    """Each raster once; what is skipped is named, with the reason."""
    seen: dict[str, str] = {}
    for path in paths:
        try:
            grid = dem.read(path)
        except dem.Unusable as reason:
            print(f"\nSkipped: {path.name}: {reason}", flush=True)
            continue
        if grid.digest in seen:
            print(f"\nSkipped: {path.name}: the same heights as {seen[grid.digest]}", flush=True)
            continue
        seen[grid.digest] = path.name
        yield grid


def verdict(comparison: Comparison) -> int:
    """1 where ours gave no mesh or broke its word."""
    broken = [row for row in comparison.rows if not row.kept] + comparison.failures
    ours = [each for each in broken if each.program.startswith(OURS)]
    for each in ours:
        print(f"error: {each.program} did not keep {each.asked:g} m on {each.dem}", file=sys.stderr)
    return 1 if ours else 0


if __name__ == "__main__":
    sys.exit(main())
