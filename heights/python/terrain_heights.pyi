"""Heights of terrain at places, each with its certified error: docs/heights.md."""

from os import PathLike
from typing import final

import numpy
from numpy.typing import NDArray

MEASURED: int
"""There is ground, and its error is certified."""
VOID: int
"""Within the archive's bounds, but its source has no samples there."""
OUTSIDE: int
"""Out of the archive's bounds, or no place on the Earth."""
FILLED: int
"""There is ground, but it was not measured: a void of the source was filled there."""

@final
class Ground:
    """What there is at a place. Numbers are NaN where there is no ground."""

    status: int
    height: float
    """Metres above what `Heights.above` says."""
    error: float
    """Metres along the vertical that the source may be from that, certified; NaN where it was not measured."""
    normal: tuple[float, float, float]
    """Unit normal of the surface: east, north, up."""

@final
class Grounds:
    """The same at many places, in their order."""

    status: NDArray[numpy.uint8]
    height: NDArray[numpy.float64]
    error: NDArray[numpy.float64]
    normal: NDArray[numpy.float64]
    """One row a place."""

@final
class Heights:
    """An open archive. Any number of threads may ask it at a time."""

    def __init__(self, path: str | PathLike[str], cache_bytes: int = ...) -> None:
        """Decoded surfaces take `cache_bytes` of memory at most. OSError where the archive cannot be read."""

    above: str
    """What heights are above, in words."""
    finest_zoom: int

    def at(self, longitude: float, latitude: float, zoom: int | None = None) -> Ground:
        """The ground at degrees of longitude and latitude, on the surface of `zoom`, or of the finest."""

    def at_many(
        self, longitudes: NDArray[numpy.float64], latitudes: NDArray[numpy.float64], zoom: int | None = None
    ) -> Grounds:
        """The same at as many places as both arrays have; other threads of Python go on meanwhile."""
