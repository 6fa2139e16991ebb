"""Runs one peer once, as a process of its own: `python3 peer.py PEER FOLDER COLUMNS ROWS CELL_WIDTH CELL_HEIGHT KNOB`

Reads `heights.f32` in FOLDER, writes the mesh there and prints the CPU seconds from heights in memory to a mesh in
memory. KNOB is the asked error in metres, or the asked number of triangles for the peers that take one.
"""

import json
import sys
import time
from pathlib import Path

import numpy

from mesh import Mesh, write_arrays


def pydelatin(heights, _cell, error):
    from pydelatin import Delatin

    mesh = Delatin(heights, max_error=error)
    vertices = mesh.vertices.astype(numpy.float64)
    # Its y counts upwards from the last row.
    vertices[:, 1] = heights.shape[0] - 1 - vertices[:, 1]
    return Mesh(vertices, mesh.triangles)


def pymartini(heights, _cell, error):
    from pymartini import Martini

    plan, triangles = Martini(len(heights)).create_tile(heights).get_mesh(error)
    columns, rows = plan[:, 0], plan[:, 1]
    return Mesh(numpy.column_stack([columns, rows, heights[rows, columns]]).astype(numpy.float64), triangles)


def fast_simplification(heights, cell, count):
    from fast_simplification import simplify

    positions, triangles = full_mesh(heights, cell)
    positions, triangles = simplify(positions, triangles, target_count=int(count), preserve_border=True)
    return in_grid(positions, triangles, cell)


def pyfqmr(heights, cell, count):
    from pyfqmr import Simplify

    simplifier = Simplify()
    simplifier.setMesh(*full_mesh(heights, cell))
    simplifier.simplify_mesh(target_count=int(count), preserve_border=True, verbose=False)
    positions, triangles, _ = simplifier.getMesh()
    return in_grid(positions, triangles, cell)


def full_mesh(heights, cell):
    """Positions in metres of all samples, y downwards, and two triangles a cell."""
    rows, columns = heights.shape
    number = numpy.arange(rows * columns, dtype=numpy.int32).reshape(rows, columns)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]))
    triangles = numpy.concatenate([numpy.column_stack([a, c, b]), numpy.column_stack([b, c, d])])
    y, x = numpy.indices(heights.shape, dtype=numpy.float64)
    return numpy.column_stack([x.ravel() * cell[0], y.ravel() * cell[1], heights.ravel()]), triangles


def in_grid(positions, triangles, cell):
    return Mesh(positions / (*cell, 1.0), triangles)


PEERS = {peer.__name__: peer for peer in (pydelatin, pymartini, fast_simplification, pyfqmr)}


def main() -> None:
    name, folder = sys.argv[1], Path(sys.argv[2])
    columns, rows = map(int, sys.argv[3:5])
    width, height, knob = map(float, sys.argv[5:8])
    heights = numpy.fromfile(folder / "heights.f32", dtype="<f4").reshape(rows, columns)
    started = time.process_time()
    mesh = PEERS[name](heights, (width, height), knob)
    print(json.dumps({"algorithm_seconds": time.process_time() - started}))
    write_arrays(folder, mesh)


if __name__ == "__main__":
    main()
