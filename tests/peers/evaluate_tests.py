"""The evaluator, on meshes whose figures are known by hand, and by brute force on random ones."""

import math
import unittest

import numpy

from evaluate import measure
from mesh import Broken, Mesh

TWO_BY_TWO = [(0, 0), (1, 0), (0, 1), (1, 1)]


def mesh(vertices, triangles) -> Mesh:
    return Mesh(numpy.array(vertices, dtype=float), numpy.array(triangles))


def lattice(columns, rows):
    """Numbers of vertices and the two triangles of each cell, counter-clockwise with the first row at the top."""
    number = numpy.arange(columns * rows).reshape(rows, columns)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]))
    return numpy.concatenate([numpy.column_stack([a, c, b]), numpy.column_stack([b, c, d])])


def full_mesh(heights) -> Mesh:
    row, column = numpy.indices(heights.shape)
    vertices = numpy.column_stack([column.ravel(), row.ravel(), heights.ravel()]).astype(float)
    return Mesh(vertices, lattice(*heights.shape[::-1]))


class KnownFigures(unittest.TestCase):
    def test_a_tilted_plane_is_two_triangles_without_error(self):
        row, column = numpy.indices((40, 70))
        heights = 3.0 * column - 7.0 * row + 100.0
        corners = [(x, y, 3.0 * x - 7.0 * y + 100.0) for x, y in [(0, 0), (69, 0), (0, 39), (69, 39)]]
        measures = measure(heights, mesh(corners, [(0, 2, 1), (1, 2, 3)]))
        self.assertEqual((measures.triangles, measures.uncovered, measures.overturned), (2, 0, 0))
        self.assertLess(measures.max_everywhere, 1e-12)
        self.assertAlmostEqual(measures.area, 1.0)
        self.assertEqual(measures.flaws, [])

    def test_a_raised_vertex_is_one_error_at_one_sample(self):
        heights = numpy.zeros((5, 5))
        raised = full_mesh(heights)
        raised.vertices[12, 2] = -3.0
        measures = measure(heights, raised)
        self.assertEqual((measures.max_at_samples, measures.max_everywhere), (3.0, 3.0))
        self.assertAlmostEqual(measures.rms_at_samples, math.sqrt(9 / 25))

    def test_a_vertex_beside_the_samples_is_measured_against_the_bilinear_surface(self):
        corners = [(x, y, 4.0 * x * y) for x, y in TWO_BY_TWO]
        centre = (0.5, 0.5, 3.0)
        fan = [(4, 1, 0), (4, 3, 1), (4, 2, 3), (4, 0, 2)]
        measures = measure(numpy.array([[0.0, 0.0], [0.0, 4.0]]), mesh([*corners, centre], fan))
        # The cell is 1 m high there.
        self.assertEqual((measures.max_at_samples, measures.max_everywhere), (0.0, 2.0))

    def test_a_bent_cell_is_farthest_in_the_middle_of_the_diagonal(self):
        # Height is 4 · column · row. Along one diagonal the cell is 4 t², the edge 4 t: 1 m apart at t = ½.
        # Along the other, where the edge is flat, the cell is 4 t (1 − t): 1 m as well, the other way.
        corners = [(x, y, 4.0 * x * y) for x, y in TWO_BY_TWO]
        for triangles in ([(0, 2, 3), (3, 1, 0)], [(1, 0, 2), (2, 3, 1)]):
            measures = measure(numpy.array([[0.0, 0.0], [0.0, 4.0]]), mesh(corners, triangles))
            self.assertEqual((measures.max_at_samples, measures.max_everywhere), (0.0, 1.0))
            self.assertEqual(measures.flaws, [])

    def test_the_extreme_of_a_piece_need_not_be_in_its_middle(self):
        # From (0, 0) to (2, 1) the left cell is 8 t² high and the edge −t: 8 t² + t grows to 2.5 at the grid line. The
        # right cell is 8 t (1 − t): 9 t − 8 t² is largest at t = 9/16, where it is 81/32.
        heights = numpy.array([[0.0, 0.0, 0.0], [0.0, 4.0, 0.0]])
        vertices = [(0, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, -1), (1, 1, 4)]
        measures = measure(heights, mesh(vertices, [(0, 2, 4), (0, 4, 3), (0, 3, 1)]))
        self.assertAlmostEqual(measures.max_everywhere, 81 / 32, 12)
        self.assertEqual((measures.max_at_samples, measures.flaws), (1.0, []))


class BrokenMeshes(unittest.TestCase):
    def setUp(self):
        self.heights = numpy.zeros((4, 4))
        self.whole = full_mesh(self.heights)

    def test_a_missing_triangle_uncovers_its_corner(self):
        corner = numpy.flatnonzero((self.whole.triangles == 0).any(axis=1))
        measures = measure(self.heights, Mesh(self.whole.vertices, numpy.delete(self.whole.triangles, corner, axis=0)))
        self.assertEqual(measures.uncovered, 1)
        self.assertAlmostEqual(measures.area, 8.5 / 9)
        self.assertEqual(measures.flaws, ["1 samples uncovered", "area × 0.944444"])

    def test_a_hole_between_samples_shows_in_the_area(self):
        middle = numpy.flatnonzero((self.whole.triangles == (5, 9, 6)).all(axis=1))
        measures = measure(self.heights, Mesh(self.whole.vertices, numpy.delete(self.whole.triangles, middle, axis=0)))
        self.assertEqual((len(middle), measures.uncovered), (1, 0))
        self.assertEqual(measures.flaws, ["area × 0.944444"])

    def test_a_triangle_twice_shows_in_the_area(self):
        twice = numpy.concatenate([self.whole.triangles, self.whole.triangles[:1]])
        self.assertEqual(measure(self.heights, Mesh(self.whole.vertices, twice)).flaws, ["area × 1.055556"])

    def test_overturned_and_flat_triangles_are_counted(self):
        self.whole.triangles[3] = self.whole.triangles[3][::-1]
        self.whole.triangles[4][1] = self.whole.triangles[4][0]
        self.assertEqual(measure(self.heights, self.whole).overturned, 2)

    def test_a_mesh_turned_over_as_a_whole_is_overturned(self):
        turned = Mesh(self.whole.vertices, self.whole.triangles[:, ::-1])
        self.assertEqual(measure(self.heights, turned).overturned, 18)

    def test_numbers_that_are_no_mesh_are_refused(self):
        for place, value in [((5, 2), math.nan), ((5, 0), 1e9)]:
            vertices = self.whole.vertices.copy()
            vertices[place] = value
            self.assertRaises(Broken, measure, self.heights, Mesh(vertices, self.whole.triangles))
        self.assertRaises(Broken, measure, self.heights, Mesh(self.whole.vertices, self.whole.triangles + 1))


class BruteForce(unittest.TestCase):
    """Random surfaces, meshes with vertices off the samples: what points in great number show, and nothing else."""

    def test_the_largest_error_between_samples(self):
        for seed in range(5):
            heights, random_mesh = random_case(seed)
            of_triangles = [dense_error(heights, random_mesh.vertices[corners]) for corners in random_mesh.triangles]
            dense = max(*of_triangles, errors_at_samples(heights, random_mesh).max())
            found = measure(heights, random_mesh).max_everywhere
            self.assertLessEqual(dense, found + 1e-9)
            self.assertAlmostEqual(dense, found, 2)

    def test_errors_at_samples(self):
        for seed in range(5):
            heights, random_mesh = random_case(seed)
            errors = errors_at_samples(heights, random_mesh)
            measures = measure(heights, random_mesh)
            self.assertEqual(measures.flaws, [])
            self.assertAlmostEqual(measures.max_at_samples, errors.max(), 9)
            self.assertAlmostEqual(measures.rms_at_samples, math.sqrt((errors**2).mean()), 9)


def random_case(seed):
    """A rough surface of 13 × 10 samples, and a mesh of 7 × 6 vertices that are moved off their lattice."""
    random = numpy.random.default_rng(seed)
    row, column = numpy.meshgrid(numpy.linspace(0, 9, 6), numpy.linspace(0, 12, 7), indexing="ij")
    inside = (slice(1, -1), slice(1, -1))
    column[inside] += random.uniform(-0.6, 0.6, column[inside].shape)
    row[inside] += random.uniform(-0.6, 0.6, row[inside].shape)
    vertices = numpy.column_stack([column.ravel(), row.ravel(), random.normal(0, 10, column.size)])
    return random.normal(0, 10, (10, 13)), Mesh(vertices, lattice(7, 6))


def dense_error(heights, corners):
    """The largest error at points all over a triangle, the more of them on its sides."""
    u, v = (axis.ravel() / 60 for axis in numpy.indices((61, 61)))
    inside = numpy.column_stack([1 - u - v, u, v])[u + v <= 1 + 1e-12]
    t = numpy.linspace(0, 1, 20_001)
    side = numpy.column_stack([1 - t, t, numpy.zeros_like(t)])
    shares = numpy.concatenate([inside, side, numpy.roll(side, 1, axis=1), numpy.roll(side, 2, axis=1)])
    column, row, height = (shares @ corners).T
    left = numpy.clip(numpy.floor(column).astype(int), 0, heights.shape[1] - 2)
    top = numpy.clip(numpy.floor(row).astype(int), 0, heights.shape[0] - 2)
    x, y = column - left, row - top
    upper = heights[top, left] * (1 - x) + heights[top, left + 1] * x
    lower = heights[top + 1, left] * (1 - x) + heights[top + 1, left + 1] * x
    return numpy.abs(upper * (1 - y) + lower * y - height).max()


def errors_at_samples(heights, random_mesh):
    """Every sample against every triangle that has it, by barycentric coordinates."""
    errors = numpy.full(heights.shape, math.nan)
    for row, column in numpy.ndindex(heights.shape):
        for a, b, c in random_mesh.vertices[random_mesh.triangles]:
            sides = numpy.column_stack([b[:2] - a[:2], c[:2] - a[:2]])
            u, v = numpy.linalg.solve(sides, (column, row) - a[:2])
            if min(u, v, 1 - u - v) >= -1e-12:
                errors[row, column] = abs(a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]) - heights[row, column])
    return errors


if __name__ == "__main__":
    unittest.main()
