"""Meshes in grid coordinates, and the plain arrays in which peers leave them.

A vertex is (column, row, height in metres), integers at samples; a triangle is three vertices, counter-clockwise as
seen from above with the first row at the top.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy

# Cells. A coordinate so near to a grid line is on it: what a round trip through coordinates of a reference system can
# do in doubles is some 1e-9, and a side that is off by that much would leave samples uncovered.
ROUNDING = 1e-7


class Broken(Exception):
    """Numbers that are no mesh."""


@dataclass(frozen=True)
class Mesh:
    vertices: numpy.ndarray
    """float64, n × 3."""
    triangles: numpy.ndarray
    """int64, n × 3."""

    def check(self, rows: int, columns: int) -> None:
        """Raises `Broken` where there are no numbers, no such vertices, or vertices more than a cell off the raster."""
        if not numpy.isfinite(self.vertices).all():
            raise Broken("a coordinate is not a number")
        if self.triangles.size and not 0 <= self.triangles.min() <= self.triangles.max() < len(self.vertices):
            raise Broken("a triangle has a vertex that does not exist")
        plan = self.vertices[:, :2]
        if not ((plan >= -1) & (plan <= (columns, rows))).all():
            raise Broken("a vertex is off the raster")


def on_grid_lines(coordinates: numpy.ndarray) -> numpy.ndarray:
    lines = numpy.round(coordinates)
    return numpy.where(numpy.abs(coordinates - lines) < ROUNDING, lines, coordinates)


def read_arrays(folder: Path) -> Mesh:
    """What a peer wrote: `vertices.f64` and `triangles.u32`."""
    vertices = numpy.fromfile(folder / "vertices.f64", dtype="<f8").reshape(-1, 3)
    triangles = numpy.fromfile(folder / "triangles.u32", dtype="<u4").reshape(-1, 3).astype(numpy.int64)
    return Mesh(numpy.column_stack([on_grid_lines(vertices[:, :2]), vertices[:, 2]]), triangles)


def write_arrays(folder: Path, mesh: Mesh) -> None:
    mesh.vertices.astype("<f8").tofile(folder / "vertices.f64")
    mesh.triangles.astype("<u4").tofile(folder / "triangles.u32")
