"""Finds the setting of a program that takes none in metres, so that the error which is measured meets the asked one."""

import math
from collections.abc import Callable
from typing import TypeVar

Result = TypeVar("Result")

# Settings are found to this ratio.
PRECISION = 1.02


def coarsest(
    run: Callable[[float], Result], meets: Callable[[Result], bool], fine: float, coarse: float
) -> Result | None:
    """Bisects, on a logarithmic scale, settings between a `fine` one, which may meet the asked error, and a `coarse`
    one, which is taken not to. Returns what the coarsest tried setting that does meet it gave, None where not even
    `fine` does.
    """
    best = None
    while max(fine, coarse) / min(fine, coarse) > PRECISION:
        setting = math.sqrt(fine * coarse)
        result = run(setting)
        if meets(result):
            best, fine = result, setting
        else:
            coarse = setting
    if best is None:
        result = run(fine)
        best = result if meets(result) else None
    return best
