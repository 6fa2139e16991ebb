"""Quantized-mesh, read after its specification alone."""

import struct

import numpy

# What u, v and heights are parts of.
EXTENT = 32_767


def extensions_at(content: bytes) -> int:
    """Where the surface ends and the extensions begin."""
    count = struct.unpack_from("<I", content, 88)[0]
    at = 92 + 6 * count
    width = 2 if count <= 65_536 else 4
    at += -at % width
    at += 4 + 3 * width * struct.unpack_from("<I", content, at)[0]
    for _ in range(4):
        at += 4 + width * struct.unpack_from("<I", content, at)[0]
    return at


def read(content: bytes) -> tuple[numpy.ndarray, numpy.ndarray, tuple[float, float]]:
    """Of one tile: u, v and height of its vertices, their normals as two bytes each, and its least and greatest height."""
    heights = struct.unpack_from("<2f", content, 24)
    count = struct.unpack_from("<I", content, 88)[0]
    coded = numpy.frombuffer(content, "<u2", 3 * count, 92).reshape(3, count).astype(int)
    vertices = numpy.cumsum((coded >> 1) ^ -(coded & 1), axis=1).T
    at, normals = extensions_at(content), None
    while at < len(content):
        kind, length = struct.unpack_from("<BI", content, at)
        if kind == 1:
            normals = numpy.frombuffer(content, "u1", length, at + 5).reshape(count, 2)
        at += 5 + length
    return vertices, normals, heights
