"""Runs every program on every DEM at every asked error."""

import sys
from pathlib import Path

from cache import Cache
from dem import Dem
from programs import PYDELATIN, Failed, Program, Run
from report import Failure, Row


class Comparison:
    def __init__(self, programs: list[Program], cache: Cache, folder: Path) -> None:
        """`folder` is for the programs' files."""
        self.programs = programs
        self.cache = cache
        self.folder = folder
        self.rows: list[Row] = []
        self.failures: list[Failure] = []

    def run(self, dem: Dem, errors: list[float]) -> list[Row]:
        """The rows of one DEM."""
        jobs = [(program, error) for error in errors for program in self.programs]
        rows = [row for program, error in jobs if (row := self.row(program, dem, error))]
        self.rows += rows
        return rows

    def row(self, program: Program, dem: Dem, error: float) -> Row | None:
        """None where a program gives no mesh."""
        grid = program.grid(dem)
        try:
            run, baseline = (self.single(each, grid, error) for each in (program, PYDELATIN))
        except Failed as reason:
            self.failures.append(Failure(dem.name, program.name, error, str(reason)))
            say(str(self.failures[-1]))
            return None
        say(f"{program.name}, {dem.name}, {error:g} m: {run.measures.triangles:,} triangles, {run.cpu_seconds:.1f} s")
        return Row(
            dem=dem.name,
            size=grid.size,
            samples=grid.heights.size,
            is_part=grid.size != dem.size,
            program=program.name,
            asked=error,
            run=run,
            pydelatin_triangles=baseline.measures.triangles,
            kept=program.keeps(run.measures, error),
        )

    def single(self, program: Program, grid: Dem, error: float) -> Run:
        return self.cache.run(program, grid, error, lambda: program.run(grid, error, self.folder))


def say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
