"""The comparison as Markdown and as JSON."""

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass

from programs import Run

CAPTION = """\
- *÷ pydelatin*: triangles by those of pydelatin on the same samples at the same asked error.
- *at samples*, *everywhere*, *RMS*: errors in metres, measured by one evaluator: the largest at samples, the largest at
  any point of the surface that is bilinear between samples, the root of the mean square at samples.
- *CPU*: user and system seconds of the whole process, with reading, writing and the start of Python or Node.
- *algorithm*: the part of it from heights in memory to a mesh in memory, where the program tells it. M: million.
- *peak*: the most memory that the process had.
- *kept*: whether the asked error holds, at samples or everywhere as the program was asked, and the mesh is one surface
  over the whole raster.
- *searched*: the program takes no vertical error. The coarsest setting was searched whose measured error at samples is
  at most the asked one; the cost is that of one run with it.
- pymartini takes squares of 2ᵏ + 1 samples only and gets the first such square of the raster."""
# Where pydelatin needs fewer triangles than this, ratios say little of either program.
FEW_TRIANGLES = 100


@dataclass(frozen=True)
class Row:
    """One program on one DEM at one asked error."""

    dem: str
    size: str
    """Samples across × down that the program was given."""
    samples: int
    is_part: bool
    """Whether that is a part of the DEM."""
    program: str
    asked: float
    run: Run
    pydelatin_triangles: int
    """On the same samples, at the same asked error."""
    kept: bool

    @property
    def ratio(self) -> float:
        return self.run.measures.triangles / self.pydelatin_triangles

    @property
    def cpu_per_million(self) -> float:
        return self.run.cpu_seconds / self.samples * 1e6

    def record(self) -> dict:
        """Flat, for JSON."""
        cost = asdict(self.run)
        own = {key: value for key, value in asdict(self).items() if key != "run"}
        return own | cost.pop("measures") | cost | {"ratio": self.ratio, "flaws": self.run.measures.flaws}


@dataclass(frozen=True)
class Failure:
    """A program that gave no mesh on a DEM at an asked error."""

    dem: str
    program: str
    asked: float
    reason: str

    def __str__(self) -> str:
        return f"{self.program}, {self.dem}, {self.asked:g} m: no mesh: {self.reason}"


def dem_table(rows: Iterable[Row]) -> str:
    """All runs on one DEM."""
    head = [
        "program", "asked, m", "triangles", "÷ pydelatin", "at samples, m", "everywhere, m", "RMS, m",
        "CPU, s", "CPU s per M samples", "algorithm s per M samples", "peak, MB", "kept",
    ]  # fmt: skip
    return table(head, [dem_cells(row) for row in rows])


def dem_cells(row: Row) -> list[str]:
    run, measures = row.run, row.run.measures
    algorithm = run.algorithm_seconds
    return [
        f"{row.program} ({row.size})" if row.is_part else row.program,
        f"{row.asked:g}",
        f"{measures.triangles:,}",
        f"{row.ratio:.3f}",
        f"{measures.max_at_samples:.3f}",
        f"{measures.max_everywhere:.3f}",
        f"{measures.rms_at_samples:.3f}",
        f"{run.cpu_seconds:.2f}",
        f"{row.cpu_per_million:.2f}",
        "–" if algorithm is None else f"{algorithm / row.samples * 1e6:.2f}",
        f"{run.peak_megabytes:.0f}",
        ", ".join(["yes" if row.kept else "no", *measures.flaws]),
    ]


def summary_table(rows: list[Row]) -> str:
    """A line for each program: its geometric means over DEMs and errors, and what each error costs."""
    errors = sorted({row.asked for row in rows})
    head = ["program", "runs", "kept", "÷ pydelatin", f"where that needs ≥ {FEW_TRIANGLES}"]
    for error in errors:
        head += [f"÷ at {error:g} m", f"CPU s per M at {error:g} m"]
    programs = dict.fromkeys(row.program for row in rows)
    return table(head, [summary_cells([row for row in rows if row.program == name], errors) for name in programs])


def summary_cells(rows: list[Row], errors: list[float]) -> list[str]:
    many = [row for row in rows if row.pydelatin_triangles >= FEW_TRIANGLES]
    cells = [rows[0].program, str(len(rows)), f"{sum(row.kept for row in rows)} of {len(rows)}"]
    cells += [mean_ratio(rows), mean_ratio(many)]
    for error in errors:
        at_error = [row for row in rows if row.asked == error]
        cells += [mean_ratio(at_error), cpu_per_million(at_error)]
    return cells


def mean_ratio(rows: list[Row]) -> str:
    """The geometric mean."""
    return f"{math.exp(math.fsum(math.log(row.ratio) for row in rows) / len(rows)):.3f}" if rows else "–"


def cpu_per_million(rows: list[Row]) -> str:
    """All seconds by all samples."""
    samples = sum(row.samples for row in rows)
    return f"{sum(row.run.cpu_seconds for row in rows) / samples * 1e6:.2f}" if rows else "–"


def table(head: list[str], lines: list[list[str]]) -> str:
    """Markdown; figures stand to the right of their column, the first column to the left."""
    rule = ["---", *["---:"] * (len(head) - 1)]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in [head, rule, *lines])
