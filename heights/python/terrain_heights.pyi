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
    """Metres above what `Heights.above` says; in a frame, metres up of its origin."""
    error: float
    """Metres along the vertical that the source may be from that, certified; in a frame, along its up. NaN where it was not measured."""
    normal: tuple[float, float, float]
    """Unit normal of the surface: east, north, up, of the place or of the frame."""

@final
class Grounds:
    """The same at many places, in their order."""

    status: NDArray[numpy.uint8]
    height: NDArray[numpy.float64]
    error: NDArray[numpy.float64]
    normal: NDArray[numpy.float64]
    """One row a place."""

@final
class Frame:
    """A local frame: metres east, north and up of a place, flat in space, so that the Earth curves away below."""

    def __init__(self, longitude: float, latitude: float, height: float = 0.0) -> None:
        """Degrees, and metres above the ellipsoid. ValueError where there is no such place."""

    origin: list[float]
    """Earth-centred metres."""
    axes: list[list[float]]
    """Unit vectors east, north and up, Earth-centred."""

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

    def in_frame(self, frame: Frame, east: float, north: float, zoom: int | None = None) -> Ground:
        """The ground at metres east and north in a frame: where its vertical meets the surface, the highest such point. Heights of the
        archive are taken as above the ellipsoid. The error is infinite where the ground is too steep for a vertical that leans so."""

    def in_frame_many(
        self, frame: Frame, easts: NDArray[numpy.float64], norths: NDArray[numpy.float64], zoom: int | None = None
    ) -> Grounds:
        """The same at as many places as both arrays have."""
