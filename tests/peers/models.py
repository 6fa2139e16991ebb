"""Polygonal models: `terrain-ingest mesh` beside meshoptimizer at the same number of triangles.

    python tests/peers/models.py [--program target/release/terrain-ingest] [--shares 0.1,0.01] MODEL…

One evaluator for both: points at most a 500th of the model's diagonal apart on each surface, and the exact distance of each
from the other surface, by libigl. What it finds is never more than the true distance, so no claim may be below it; the
exit code is 1 if one is.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import igl
import numpy
from plyfile import PlyData

HERE = Path(__file__).parent
PROGRAM = HERE.parent.parent / "target/release/terrain-ingest"
# Points on a surface, as a share of the diagonal of the box around the model.
SPACING = 1 / 500


@dataclass(frozen=True)
class Surface:
    positions: numpy.ndarray
    """float64, n × 3."""
    triangles: numpy.ndarray
    """int64, n × 3."""

    @property
    def diagonal(self) -> float:
        used = self.positions[numpy.unique(self.triangles)]
        return float(numpy.linalg.norm(used.max(axis=0) - used.min(axis=0)))


def read(path: Path) -> Surface:
    if path.suffix == ".ply":
        data = PlyData.read(path)
        positions = numpy.column_stack([data["vertex"][axis] for axis in "xyz"]).astype(numpy.float64)
        name = next(list_.name for list_ in data["face"].properties if list_.name.startswith("vertex_ind"))
        faces = list(data["face"][name])
    else:
        lines = [line.split() for line in path.read_text().splitlines()]
        positions = numpy.array([line[1:4] for line in lines if line[:1] == ["v"]], dtype=numpy.float64)
        faces = [[int(corner.split("/")[0]) - 1 for corner in line[1:]] for line in lines if line[:1] == ["f"]]
    fans = [[face[0], *pair] for face in faces for pair in zip(face[1:], face[2:])]
    return Surface(positions, numpy.array(fans, dtype=numpy.int64))


def distance(one: Surface, other: Surface, spacing: float) -> float:
    """The larger one of the largest distances found, each way."""
    return max(one_sided(one, other, spacing), one_sided(other, one, spacing))


def one_sided(source: Surface, target: Surface, spacing: float) -> float:
    squared, _, _ = igl.point_mesh_squared_distance(points(source, spacing), target.positions, target.triangles)
    return float(numpy.sqrt(squared.max()))


def points(surface: Surface, spacing: float) -> numpy.ndarray:
    """Rows of points along two sides of each triangle, its corners and the middles of its sides among them."""
    corners = surface.positions[surface.triangles]
    longest = numpy.linalg.norm(corners - numpy.roll(corners, 1, axis=1), axis=2).max(axis=1)
    steps = numpy.maximum(2 * numpy.ceil(longest / spacing / 2).astype(int), 2)
    groups = [spread(corners[steps == count], count) for count in numpy.unique(steps)]
    return numpy.concatenate(groups)


def spread(corners: numpy.ndarray, steps: int) -> numpy.ndarray:
    weights = numpy.array([(i, j, steps - i - j) for i in range(steps + 1) for j in range(steps + 1 - i)]) / steps
    return numpy.einsum("wc,tcx->twx", weights, corners).reshape(-1, 3)


def ours(program: Path, model: Path, triangles: int, folder: Path) -> tuple[Surface, float, float]:
    """The surface, what it claims, and CPU seconds."""
    output, cost = folder / "level.ply", folder / "cost.json"
    command = [program, "mesh", model, "--target-triangles", str(triangles), "-o", output, "--json", "--quiet"]
    report = json.loads(measured(command, cost))
    return read(output), report["levels"][-1]["certified_error"], json.loads(cost.read_text())["cpu_seconds"]


def meshoptimizer(surface: Surface, triangles: int, folder: Path) -> tuple[Surface, float]:
    """The surface and CPU seconds."""
    surface.positions.astype("<f4").tofile(folder / "positions.f32")
    surface.triangles.astype("<u4").tofile(folder / "triangles.u32")
    cost = folder / "cost.json"
    measured(["node", HERE / "meshoptimizer_model.mjs", folder, str(3 * triangles)], cost)
    indices = numpy.fromfile(folder / "simplified.u32", dtype="<u4").reshape(-1, 3).astype(numpy.int64)
    return Surface(surface.positions, indices), json.loads(cost.read_text())["cpu_seconds"]


def measured(command: list, cost: Path) -> bytes:
    return subprocess.run(
        [sys.executable, HERE / "measured.py", cost, *command], check=True, stdout=subprocess.PIPE
    ).stdout


def compare(program: Path, model: Path, share: float) -> bool:
    """Prints a row of the table; tells whether our claim holds."""
    surface = read(model)
    triangles = round(share * len(surface.triangles))
    spacing = SPACING * surface.diagonal
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        level, claim, seconds = ours(program, model.resolve(), triangles, folder)
        peer, peer_seconds = meshoptimizer(surface, triangles, folder)
    found, peer_found = (distance(surface, other, spacing) for other in (level, peer))
    print(
        f"| `{model.name}` | {len(surface.triangles):,} | {len(level.triangles):,} | {claim:.3e} | {found:.3e} | {seconds:.1f} "
        f"| {len(peer.triangles):,} | {peer_found:.3e} | {peer_seconds:.1f} |",
        flush=True,
    )
    return found <= claim


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", metavar="MODEL", nargs="+", type=Path)
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--shares", type=lambda text: [float(word) for word in text.split(",")], default=[0.1, 0.01])
    options = parser.parse_args()
    print("| input | triangles | left | claimed | measured | CPU s | meshoptimizer: left | measured | CPU s |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    holds = [compare(options.program, model, share) for model in options.models for share in options.shares]
    return 0 if all(holds) else 1


if __name__ == "__main__":
    sys.exit(main())
