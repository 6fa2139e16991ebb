"""Runs of peers, kept from one comparison to the next: peers do not change, our program does."""

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from dem import Dem
from evaluate import Measures
from programs import HERE, NoSetting, Program, Run

# A run is kept as long as these are the same.
SOURCES = (
    "evaluate.py", "measured.py", "mesh.py", "meshoptimizer.mjs", "package-lock.json", "peer.py", "ply.py",
    "programs.py", "requirements.txt", "search.py",
)  # fmt: skip


class Cache:
    def __init__(self, folder: Path, is_fresh: bool) -> None:
        """`is_fresh`: what was kept before is not used, only replaced."""
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self.is_fresh = is_fresh
        self.sources = hashlib.sha256(b"".join((HERE / name).read_bytes() for name in SOURCES)).hexdigest()[:16]
        self.in_this_comparison: set[Path] = set()

    def run(self, program: Program, dem: Dem, error: float, run: Callable[[], Run]) -> Run:
        """The kept run, or what `run` gives; that no setting gives the error is kept, too, and raised again."""
        if not program.is_cached:
            return run()
        # Ground distances decide what some peers do; two rasters may have the same heights at others.
        cell = "x".join(f"{side:.6g}" for side in dem.cell)
        name = program.name.replace(", ", "-")
        path = self.folder / f"{name}_{dem.digest}_{cell}_{error:g}_{self.sources}.json"
        is_kept = path.exists() and not self.is_fresh
        if not is_kept and path not in self.in_this_comparison:
            path.write_text(json.dumps(to_record(run)))
        self.in_this_comparison.add(path)
        return from_record(json.loads(path.read_text()))


def to_record(run: Callable[[], Run]) -> dict:
    try:
        return asdict(run())
    except NoSetting as reason:
        return {"no_setting": str(reason)}


def from_record(record: dict) -> Run:
    if "no_setting" in record:
        raise NoSetting(record["no_setting"])
    return Run(**{**record, "measures": Measures(**record["measures"])})
