"""The meshes of terrain-ingest: PLY, in the raster's coordinate reference system."""

from pathlib import Path

import numpy
from affine import Affine
from plyfile import PlyData

from mesh import Mesh, on_grid_lines


def read(path: Path, to_crs: Affine) -> Mesh:
    """A mesh in a coordinate reference system that `to_crs` leads to from the grid."""
    ply = PlyData.read(path, known_list_len={"face": {"vertex_indices": 3}})
    x, y, z = (numpy.asarray(ply["vertex"][axis], dtype=numpy.float64) for axis in "xyz")
    columns, rows = ~to_crs @ (x, y)
    triangles = ply["face"]["vertex_indices"].astype(numpy.int64)
    is_mirrored = to_crs.determinant > 0
    vertices = numpy.column_stack([on_grid_lines(columns), on_grid_lines(rows), z])
    return Mesh(vertices, triangles[:, ::-1] if is_mirrored else triangles)
