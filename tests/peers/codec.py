"""Bytes a triangle of the progressive codec beside Draco and gzip, and bytes at one error beside LERC.

    codec.py tiles ARCHIVE.pmtiles             the tiles of an archive
    codec.py mesh MESH.ply --cells N --step S  one mesh of `terrain-ingest tin` with N cells a degree, heights in steps of S metres
    codec.py model MODEL.spm                   a file of `terrain-ingest mesh`, with all levels, beside its finest mesh alone
    codec.py raster DEM.tif 5 10 20 50         a mesh at each error, bounded at samples, beside LERC_ZSTD of the raster
"""

import argparse
import gzip
import json
import os
import subprocess
import tempfile
from pathlib import Path

import DracoPy
import numpy
import rasterio
from plyfile import PlyData

CODEC = os.environ.get("CODEC_SIZES", "target/release/examples/codec_sizes")
INGEST = os.environ.get("TERRAIN_INGEST", "target/release/terrain-ingest")
# Plan units in a cell of the meshes of `terrain-ingest tin`.
UNITS = 256


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    tiles = commands.add_parser("tiles")
    tiles.add_argument("archive", type=Path)
    tiles.set_defaults(run=lambda options: print_tiles(options.archive))
    mesh = commands.add_parser("mesh")
    mesh.add_argument("mesh", type=Path)
    mesh.add_argument("--cells", type=float, required=True)
    mesh.add_argument("--step", type=float, required=True)
    mesh.set_defaults(run=lambda options: print_mesh(options.mesh, options.cells, options.step))
    model = commands.add_parser("model")
    model.add_argument("model", type=Path)
    model.set_defaults(run=lambda options: print_model(options.model))
    raster = commands.add_parser("raster")
    raster.add_argument("dem", type=Path)
    raster.add_argument("errors", type=float, nargs="+")
    raster.set_defaults(run=lambda options: print_raster(options.dem, options.errors))
    options = parser.parse_args()
    options.run(options)


def draco(positions: numpy.ndarray, triangles: numpy.ndarray) -> int:
    """Bytes of Draco at its highest compression, of exactly these whole-numbered positions."""
    unsigned = (positions - positions.min(axis=0)).astype(numpy.uint32)
    return len(DracoPy.encode(unsigned, triangles.astype(numpy.uint32), compression_level=10, quantization_bits=0))


def quantized_mesh(positions: numpy.ndarray, triangles: numpy.ndarray) -> int:
    """Bytes of what quantized-mesh holds of a mesh, after gzip: zigzag differences of 16 bits, high-water-mark indices."""
    low, high = positions.min(axis=0), positions.max(axis=0)
    numbers, first = numpy.unique(triangles, return_index=True)
    order = numbers[numpy.argsort(first)]
    place = numpy.empty(len(positions), dtype=numpy.int64)
    place[order] = numpy.arange(len(order))
    scaled = ((positions[order] - low) * 32767 // numpy.maximum(high - low, 1)).astype(numpy.int64)
    steps = numpy.diff(scaled, axis=0, prepend=0)
    zigzag = (steps << 1 ^ steps >> 63).astype(numpy.uint16)
    indices = place[triangles].ravel()
    highest = numpy.maximum.accumulate(numpy.concatenate([[-1], indices]))[:-1] + 1
    codes = (highest - indices).astype(numpy.uint16 if len(order) < 65536 else numpy.uint32)
    return len(gzip.compress(zigzag.T.tobytes() + codes.tobytes(), 9))


def read_raw(path: Path) -> tuple[numpy.ndarray, numpy.ndarray]:
    words = numpy.fromfile(path, dtype="<u4")
    vertices, triangles = (int(count) for count in words[:2])
    positions = words[2 : 2 + 3 * vertices].view("<i4").reshape(-1, 3).astype(numpy.int64)
    return positions, words[2 + 3 * vertices :].reshape(triangles, 3)


def print_row(name: str, triangles: int, ours: int, positions_and_triangles: list) -> None:
    rivals = [sum(size(*mesh) for mesh in positions_and_triangles) for size in (draco, quantized_mesh)]
    sizes = [ours, *rivals]
    print(f"| {name} | {triangles:,} | " + " | ".join(f"{size:,} ({size / triangles:.2f})" for size in sizes) + " |")


def print_head() -> None:
    print("| meshes | triangles | ours, progressive | Draco | quantized-mesh, gzip |")
    print("| --- | ---: | ---: | ---: | ---: |")


def print_tiles(archive: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        lines = subprocess.run([CODEC, "tiles", archive, folder], check=True, capture_output=True, text=True).stdout
        rows = [json.loads(line) for line in lines.splitlines()]
        rows = [row for row in rows if row["triangles"] >= 1000]
        print_head()
        for zoom in [*sorted({row["zoom"] for row in rows}), None]:
            chosen = [row for row in rows if zoom in (row["zoom"], None)]
            meshes = [read_raw(Path(folder) / row["mesh"]) for row in chosen]
            name = "all" if zoom is None else f"zoom {zoom}"
            sums = [sum(row[key] for row in chosen) for key in ("triangles", "bytes")]
            print_row(name, *sums, meshes)


def encoded(path: Path, cells: float, step: float) -> tuple[dict, numpy.ndarray, numpy.ndarray]:
    """Our bytes of a mesh of `terrain-ingest tin`, and the whole-numbered positions they are of."""
    ply = PlyData.read(path, known_list_len={"face": {"vertex_indices": 3}})
    plan = [numpy.asarray(ply["vertex"][axis]) for axis in "xy"]
    plan = [(axis - axis.min()) * cells * UNITS for axis in plan]
    heights = numpy.asarray(ply["vertex"]["z"]) / step
    positions = numpy.rint(numpy.column_stack([*plan, heights])).astype(numpy.int64)
    triangles = numpy.asarray(ply["face"]["vertex_indices"])
    with tempfile.NamedTemporaryFile(suffix=".raw") as raw:
        counts = numpy.array([len(positions), len(triangles)], dtype="<u4")
        raw.write(counts.tobytes() + positions.astype("<i4").tobytes() + triangles.astype("<u4").tobytes())
        raw.flush()
        command = [CODEC, "mesh", raw.name, str(UNITS)]
        result = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return json.loads(result), positions, triangles


def print_mesh(path: Path, cells: float, step: float) -> None:
    result, positions, triangles = encoded(path, cells, step)
    print_head()
    print_row(path.name, len(triangles), result["bytes"], [(positions, triangles)])
    print(f"\ndecoded {result['triangles_a_second'] / 1e6:.2f} million triangles a second")


def finest(model: Path) -> tuple[numpy.ndarray, numpy.ndarray]:
    """The finest mesh of a `.spm` file on the file's lattice, whose origin and step are 48 bytes from byte 6 on."""
    origin, step = numpy.frombuffer(model.read_bytes(), dtype="<f8", offset=6, count=6).reshape(2, 3)
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder) / "finest.ply"
        subprocess.run([INGEST, "mesh", model, "--lod", "0", "-o", whole], check=True, capture_output=True)
        ply = PlyData.read(whole, known_list_len={"face": {"vertex_indices": 3}})
    positions = numpy.column_stack([numpy.asarray(ply["vertex"][axis]) for axis in "xyz"])
    lattice = numpy.rint((positions - origin) / step).astype(numpy.int64)
    if not numpy.allclose(origin + lattice * step, positions, rtol=0, atol=step.min() / 100):
        raise SystemExit(f"{model}: its finest mesh is not on its lattice; use a terrain-ingest that writes doubles")
    return lattice, numpy.asarray(ply["face"]["vertex_indices"])


def print_model(model: Path) -> None:
    positions, triangles = finest(model)
    sizes = [model.stat().st_size, draco(positions, triangles)]
    print("| model | triangles | ours, all levels | Draco, finest only |")
    print("| --- | ---: | ---: | ---: |")
    cells = " | ".join(f"{size:,} ({size / len(triangles):.2f})" for size in sizes)
    print(f"| {model.name} | {len(triangles):,} | {cells} |")


def print_raster(dem: Path, errors: list[float]) -> None:
    with rasterio.open(dem) as source:
        profile, heights, cells = source.profile, source.read(1), 1 / source.transform.a
    print("| error at samples, m | triangles | ours, bytes | LERC_ZSTD, bytes |")
    print("| ---: | ---: | ---: | ---: |")
    with tempfile.TemporaryDirectory() as folder:
        for error in errors:
            # Rounding heights may add half a step.
            step = 2.0 ** numpy.floor(numpy.log2(error / 32))
            mesh, lerc = Path(folder) / "mesh.ply", Path(folder) / "lerc.tif"
            tin = [INGEST, "tin", dem, "--max-error", str(error - step / 2), "--bound", "samples"]
            subprocess.run([*tin, "--quality", "best", "-o", mesh], check=True, capture_output=True)
            result, _, triangles = encoded(mesh, cells, step)
            profile.update(compress="LERC_ZSTD", max_z_error=error, tiled=False, blockysize=heights.shape[0])
            with rasterio.open(lerc, "w", **profile) as target:
                target.write(heights, 1)
            print(f"| {error:g} | {len(triangles):,} | {result['bytes']:,} | {lerc.stat().st_size:,} |")


if __name__ == "__main__":
    main()
