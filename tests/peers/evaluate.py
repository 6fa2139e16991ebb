"""How far a mesh is from a raster: the one judge of all programs. It shares nothing with any of them.

Between samples the raster is bilinear in its cells. Against a plane that is a saddle (its second derivatives in
column and row are zero), so inside a cell and a triangle there is no extreme; on a triangle's edge the difference is a
parabola in each cell, on a cell's side it is linear. The largest difference is therefore at one of

    samples,
    vertices of the mesh,
    points where edges of the mesh cross grid lines,
    vertices of the parabolas, one at most for each piece of an edge inside a cell.
"""

import math
from dataclasses import dataclass

import numpy
from numba import njit

from mesh import Mesh

# Cells: a sample so near outside of a triangle counts as covered by it.
TOUCH = 1e-9
# Relative difference of areas that sums of millions of doubles may have.
AREA_ROUNDING = 1e-9


@dataclass(frozen=True)
class Measures:
    """Heights in metres."""

    triangles: int
    max_at_samples: float
    max_everywhere: float
    """At samples and between them."""
    rms_at_samples: float
    uncovered: int
    """Samples that no triangle covers; the errors above are those of the others."""
    overturned: int
    """Triangles that are not counter-clockwise as seen from above; those without area among them."""
    area: float
    """All triangles together, in plan, as a share of the raster's area."""

    @property
    def flaws(self) -> list[str]:
        """What keeps the mesh from being one surface over the whole raster."""
        flaws = []
        if self.uncovered:
            flaws.append(f"{self.uncovered} samples uncovered")
        if self.overturned:
            flaws.append(f"{self.overturned} triangles overturned")
        if not abs(self.area - 1) < AREA_ROUNDING:
            flaws.append(f"area × {self.area:.6f}")
        return flaws


def measure(heights: numpy.ndarray, mesh: Mesh) -> Measures:
    """Compares `mesh` with the samples `heights`, rows × columns; raises `Broken` where there is no mesh to compare."""
    rows, columns = heights.shape
    mesh.check(rows, columns)
    at_samples = sample_errors(heights, mesh.vertices, mesh.triangles)
    is_covered = at_samples >= 0
    covered = at_samples[is_covered]
    max_at_samples = float(covered.max(initial=0.0))
    doubled_areas = plan_areas(mesh) * 2
    return Measures(
        triangles=len(mesh.triangles),
        max_at_samples=max_at_samples,
        max_everywhere=max(max_at_samples, worst_of_edges(heights, mesh.vertices, edges(mesh.triangles))),
        rms_at_samples=float(numpy.sqrt(numpy.mean(covered**2))) if covered.size else 0.0,
        uncovered=int(is_covered.size - covered.size),
        overturned=int((doubled_areas <= 0).sum()),
        area=float(doubled_areas.sum() / 2 / ((columns - 1) * (rows - 1))),
    )


def plan_areas(mesh: Mesh) -> numpy.ndarray:
    """Signed area of each triangle in cells, positive where it is counter-clockwise as seen from above."""
    a, b, c = (mesh.vertices[mesh.triangles[:, corner], :2] for corner in range(3))
    ab, ac = b - a, c - a
    # Rows count downwards, so this is the usual cross product with its sign turned.
    return (ab[:, 1] * ac[:, 0] - ab[:, 0] * ac[:, 1]) / 2


def edges(triangles: numpy.ndarray) -> numpy.ndarray:
    """Each edge once, as a pair of vertices."""
    ends = numpy.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    ends.sort(axis=1)
    keys = numpy.unique(ends[:, 0] << 32 | ends[:, 1])
    return numpy.column_stack([keys >> 32, keys & 0xFFFF_FFFF])


@njit(cache=True)
def sample_errors(heights, vertices, triangles):
    """Largest absolute error at each sample of the triangles that cover it, −1 where none does."""
    errors = numpy.full(heights.shape, -1.0)
    for corners in triangles:
        a, b, c = vertices[corners[0]], vertices[corners[1]], vertices[corners[2]]
        first = max(math.ceil(min(a[1], b[1], c[1]) - TOUCH), 0)
        last = min(math.floor(max(a[1], b[1], c[1]) + TOUCH), heights.shape[0] - 1)
        for row in range(first, last + 1):
            cover_row(heights[row], errors[row], row, a, b, c)
    return errors


@njit(cache=True)
def cover_row(heights, errors, row, a, b, c):
    """Compares the samples of one row with the segment in which the row's line cuts the triangle a, b, c."""
    left, left_height, right, right_height = math.inf, 0.0, -math.inf, 0.0
    for p, q in ((a, b), (b, c), (c, a)):
        if min(p[1], q[1]) - TOUCH <= row <= max(p[1], q[1]) + TOUCH:
            for t in cuts(p[1], q[1], row):
                x, height = p[0] + t * (q[0] - p[0]), p[2] + t * (q[2] - p[2])
                if x < left:
                    left, left_height = x, height
                if x > right:
                    right, right_height = x, height
    for column in range(max(math.ceil(left - TOUCH), 0), min(math.floor(right + TOUCH), len(heights) - 1) + 1):
        t = 0.0 if left == right else min(max((column - left) / (right - left), 0.0), 1.0)
        height = left_height + t * (right_height - left_height)
        errors[column] = max(errors[column], abs(height - heights[column]))


@njit(cache=True)
def cuts(from_row, to_row, row):
    """Where a segment from one row to another is on `row`: shares of its length, both ends if it lies along it."""
    if abs(to_row - from_row) <= TOUCH:
        return 0.0, 1.0
    t = min(max((row - from_row) / (to_row - from_row), 0.0), 1.0)
    return t, t


@njit(cache=True)
def worst_of_edges(heights, vertices, edges):
    """Largest absolute error at any point of any edge."""
    worst = 0.0
    for ends in edges:
        worst = max(worst, worst_of_edge(heights, vertices[ends[0]], vertices[ends[1]]))
    return worst


@njit(cache=True)
def worst_of_edge(heights, p, q):
    """Walks the edge from p to q, cell by cell."""
    worst, start = 0.0, 0.0
    column_line, row_line = first_line(p[0], q[0]), first_line(p[1], q[1])
    while start < 1.0:
        at_column, at_row = share_at(column_line, p[0], q[0]), share_at(row_line, p[1], q[1])
        end = min(at_column, at_row, 1.0)
        if at_column <= end:
            column_line += 1 if q[0] > p[0] else -1
        if at_row <= end:
            row_line += 1 if q[1] > p[1] else -1
        worst = max(worst, worst_of_piece(heights, p, q, start, end))
        start = max(start, end)
    return worst


@njit(cache=True)
def first_line(begin, end):
    """The first grid line after `begin` on the way to `end`."""
    return math.floor(begin) + 1 if end > begin else math.ceil(begin) - 1


@njit(cache=True)
def share_at(line, begin, end):
    """The share of the way from `begin` to `end` at which `line` is crossed."""
    return math.inf if begin == end else (line - begin) / (end - begin)


@njit(cache=True)
def worst_of_piece(heights, p, q, start, end):
    """Largest absolute error on an edge from share `start` to `end`, which is all in one cell."""
    middle = (start + end) / 2
    column = cell_at(p[0] + middle * (q[0] - p[0]), heights.shape[1])
    row = cell_at(p[1] + middle * (q[1] - p[1]), heights.shape[0])
    corners = heights[row, column], heights[row, column + 1], heights[row + 1, column], heights[row + 1, column + 1]
    first = error_at(corners, column, row, p, q, start)
    last = error_at(corners, column, row, p, q, end)
    worst = max(abs(first), abs(last))
    # Along the edge the error is bent · share² + … .
    bent = (corners[0] - corners[1] - corners[2] + corners[3]) * (q[0] - p[0]) * (q[1] - p[1])
    if bent != 0.0 and end > start:
        extreme = middle - (last - first) / (end - start) / (2 * bent)
        if start < extreme < end:
            worst = max(worst, abs(error_at(corners, column, row, p, q, extreme)))
    return worst


@njit(cache=True)
def cell_at(coordinate, samples):
    return min(max(math.floor(coordinate), 0), samples - 2)


@njit(cache=True)
def error_at(corners, column, row, p, q, share):
    """Bilinear height of the cell less the height of the edge, at a share of the edge's length."""
    u = p[0] + share * (q[0] - p[0]) - column
    v = p[1] + share * (q[1] - p[1]) - row
    above = corners[0] + u * (corners[1] - corners[0])
    below = corners[2] + u * (corners[3] - corners[2])
    return above + v * (below - above) - (p[2] + share * (q[2] - p[2]))
