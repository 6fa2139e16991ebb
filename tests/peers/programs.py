"""Every program of the comparison: how it is run on a DEM at an asked error, and what it promises."""

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mesh
import ply
from dem import Dem
from evaluate import Measures, measure
from mesh import Mesh
from search import coarsest

HERE = Path(__file__).resolve().parent
OURS = "terrain-ingest"
# Metres that a measured error may be above the asked one: the rounding of coordinates and of the measurement.
ROUNDING = 1e-6
# Fewest triangles that a search for a number of triangles considers.
FEWEST_TRIANGLES = 16
# Peers that measure distances to planes get a plan this many times as wide. Such a distance is then nearly the vertical
# one that all are asked for: 0.97 of it on a slope of 45°.
PLAN_STRETCH = 4.0
# A search for meshoptimizer's error considers those from a share of the asked error to a multiple of it.
LEAST_SHARE, GREATEST_SHARE = 1 / 4096, 4.0


class Failed(Exception):
    """A program that gave no mesh, with what it said."""


class NoSetting(Failed):
    """No setting of a program gives the asked error."""


@dataclass(frozen=True)
class Run:
    """What one run of a program gave and cost."""

    measures: Measures
    cpu_seconds: float
    """User and system time of the whole process."""
    algorithm_seconds: float | None
    """CPU time from heights in memory to a mesh in memory, where the program tells it."""
    peak_megabytes: float
    setting: float
    """What the program was asked for: metres, or a number of triangles."""


@dataclass(frozen=True)
class Program:
    name: str
    run: Callable[[Dem, float, Path], Run]
    """On a DEM, at an asked error in metres, with a folder for its files."""
    is_bounded_everywhere: bool = False
    """Whether the asked error is to hold between samples, too."""
    is_cached: bool = True
    side: Callable[[Dem], int] | None = None
    """For a program that takes certain squares only: how many samples the largest one in a DEM has along its side."""

    @property
    def family(self) -> str:
        """The program without its settings."""
        return self.name.replace(",", " ").split()[0]

    def grid(self, dem: Dem) -> Dem:
        """What of `dem` it is run on."""
        return dem.first_square(self.side(dem)) if self.side else dem

    def keeps(self, measures: Measures, asked: float) -> bool:
        """Whether the mesh is what was asked for."""
        worst = measures.max_everywhere if self.is_bounded_everywhere else measures.max_at_samples
        return worst <= asked + ROUNDING and not measures.flaws


def terrain_ingest(executable: Path, quality: str, bound: str) -> Program:
    def run(dem: Dem, error: float, folder: Path) -> Run:
        output = folder / "mesh.ply"
        asked = ["--max-error", repr(error), "--quality", quality, "--bound", bound]
        command = [str(executable), "tin", str(dem.path), *asked, "--quiet", "--output", str(output)]
        return measured(dem, command, folder, error, lambda: ply.read(output, dem.to_crs))

    return Program(f"{OURS} {quality}, {bound}", run, is_bounded_everywhere=bound == "surface", is_cached=False)


def peers() -> list[Program]:
    return [
        PYDELATIN,
        Program("pymartini", lambda *job: run_peer(python_peer("pymartini"), *job), side=martini_side),
        Program("meshoptimizer", lambda *job: run_peer(MESHOPTIMIZER, *job)),
        Program("meshoptimizer, searched", search_error),
        Program("fast-simplification, searched", lambda *job: search_count(python_peer("fast_simplification"), *job)),
        Program("pyfqmr, searched", lambda *job: search_count(python_peer("pyfqmr"), *job)),
    ]


def martini_side(dem: Dem) -> int:
    """The largest 2ᵏ + 1 that fits."""
    return (1 << (min(dem.heights.shape) - 1).bit_length() - 1) + 1


def python_peer(name: str) -> list[str]:
    return [sys.executable, str(HERE / "peer.py"), name]


def run_peer(command: list[str], dem: Dem, setting: float, folder: Path) -> Run:
    dem.heights.astype("<f4").tofile(folder / "heights.f32")
    rows, columns = dem.heights.shape
    cell = [side * PLAN_STRETCH for side in dem.cell]
    arguments = [str(argument) for argument in (folder, columns, rows, *cell, setting)]
    return measured(dem, command + arguments, folder, setting, lambda: mesh.read_arrays(folder))


def search_error(dem: Dem, error: float, folder: Path) -> Run:
    return found(
        lambda setting: run_peer(MESHOPTIMIZER, dem, setting, folder),
        error,
        fine=error * LEAST_SHARE,
        coarse=error * GREATEST_SHARE,
    )


def search_count(command: list[str], dem: Dem, error: float, folder: Path) -> Run:
    rows, columns = dem.heights.shape
    return found(
        lambda count: run_peer(command, dem, round(count), folder),
        error,
        fine=2 * (columns - 1) * (rows - 1),
        coarse=FEWEST_TRIANGLES,
    )


def found(run: Callable[[float], Run], error: float, fine: float, coarse: float) -> Run:
    """The run with the coarsest setting whose measured error at samples is the asked one."""

    def meets(run: Run) -> bool:
        return run.measures.max_at_samples <= error + ROUNDING and run.measures.uncovered == 0

    best = coarsest(run, meets, fine, coarse)
    if best is None:
        raise NoSetting(f"no setting gives an error of {error:g} m at samples")
    return best


def measured(dem: Dem, command: list[str], folder: Path, setting: float, read: Callable[[], Mesh]) -> Run:
    report = folder / "cost.json"
    launcher = [sys.executable, "-I", str(HERE / "measured.py"), str(report)]
    process = subprocess.run(launcher + command, capture_output=True, text=True, check=False)
    if process.returncode != 0:
        raise Failed((process.stderr.strip() or "no word of why").splitlines()[-1])
    told = json.loads(process.stdout) if process.stdout.startswith("{") else {}
    try:
        measures = measure(dem.heights, read())
    except mesh.Broken as error:
        raise Failed(str(error)) from error
    cost = json.loads(report.read_text())
    return Run(measures, cost["cpu_seconds"], told.get("algorithm_seconds"), cost["peak_megabytes"], setting)


MESHOPTIMIZER = ["node", str(HERE / "meshoptimizer.mjs")]
PYDELATIN = Program("pydelatin", lambda *job: run_peer(python_peer("pydelatin"), *job))
