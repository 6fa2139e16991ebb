"""Curved levels of models: what `terrain-ingest clod` certifies beside what is measured.

    python tests/peers/curved_models.py [--program target/release/terrain-ingest] [--patches 10000,1000] MODEL…

One level for each number of patches, drawn as triangles within a 20,000th of the diagonal, is set beside the model's own triangles;
beside the bicubic patches of a file `.bez`, which are evaluated here on a grid of 33 × 33 points each. Points at most a 500th of the
diagonal apart on each surface, and the exact distance of each from the other one, by libigl: never more than the true distance but for
what drawing adds, which is the slack of the last column. The exit code is 1 if a claim is below what was measured by more than that.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

import numpy
from models import PROGRAM, SPACING, Surface, distance, measured, read

# How far drawn triangles may be from patches, as a share of the diagonal.
DRAWING = 1 / 20_000
# Steps along each side of a bicubic patch.
STEPS = 32


def bicubics(path: Path) -> tuple[Surface, float]:
    """The patches of a file as triangles, and how far these may be from the patches: the largest step between two halvings."""
    numbers = numpy.array(path.read_text().split()[1:], dtype=numpy.float64)
    patches = numbers.reshape(-1, 4, 4, 3)
    fine, coarse = grids(patches, 2 * STEPS), grids(patches, STEPS)
    middles = (coarse[:, 1:, 1:] + coarse[:, :-1, :-1]) / 2
    strayed = float(numpy.linalg.norm(fine[:, 1::2, 1::2] - middles, axis=-1).max())
    count = STEPS + 1
    corner = numpy.arange(count * count).reshape(count, count)
    a, b, c, d = (corner[rows, columns].ravel() for rows, columns in SQUARE)
    two = numpy.concatenate([numpy.column_stack([a, b, c]), numpy.column_stack([a, c, d])])
    triangles = numpy.concatenate([two + patch * count * count for patch in range(len(patches))])
    return Surface(coarse.reshape(-1, 3), triangles), strayed


LOW, HIGH = slice(None, -1), slice(1, None)
SQUARE = [(LOW, LOW), (LOW, HIGH), (HIGH, HIGH), (HIGH, LOW)]


def grids(patches: numpy.ndarray, steps: int) -> numpy.ndarray:
    """Points of each patch: patches × (steps + 1) × (steps + 1) × 3."""
    t = numpy.linspace(0, 1, steps + 1)
    basis = numpy.column_stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    return numpy.einsum("si,tj,pijx->pstx", basis, basis, patches)


def original(path: Path) -> tuple[Surface, float]:
    return bicubics(path) if path.suffix == ".bez" else (read(path), 0.0)


def compare(program: Path, model: Path, counts: list[int]) -> bool:
    """Prints a row of the table for each number of patches; tells whether all claims hold."""
    surface, strayed = original(model)
    diagonal = surface.diagonal
    with tempfile.TemporaryDirectory() as name:
        levels, drawn, cost = Path(name) / "levels.clod", Path(name) / "drawn.ply", Path(name) / "cost.json"
        made = [program, "clod", model, "--patches", str(min(counts)), "-o", levels, "--json", "--quiet"]
        known = json.loads(measured(made, cost))["levels"]
        spent = json.loads(cost.read_text())
        print(f"`{model.name}`: {len(known)} levels in {spent['cpu_seconds']:.1f} CPU s, {spent['peak_megabytes']:.0f} MB")
        holds = True
        for count in sorted(counts, reverse=True):
            level = next((level for level in known if level["patches"] <= count), known[-1])
            number = str(known.index(level))
            measured([program, "clod", levels, "--level", number, "--tessellate", str(DRAWING * diagonal), "-o", drawn, "-q"], cost)
            found = distance(surface, read(drawn), SPACING * diagonal)
            claim, slack = level["certified_error"], DRAWING * diagonal + strayed
            shares = [f"{100 * value / diagonal:.4f}" for value in (claim, found, slack)]
            print(f"| {known[0]['patches']:,} | {level['patches']:,} | {' | '.join(shares)} |", flush=True)
            holds &= found <= claim + slack
    return holds


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", metavar="MODEL", nargs="+", type=Path)
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--patches", type=lambda text: [int(word) for word in text.split(",")], default=[10_000, 1_000])
    options = parser.parse_args()
    print("| patches of level 0 | left | certified, % of the diagonal | measured | slack |")
    print("| ---: | ---: | ---: | ---: | ---: |")
    holds = [compare(options.program, model, options.patches) for model in options.models]
    return 0 if all(holds) else 1


if __name__ == "__main__":
    sys.exit(main())
