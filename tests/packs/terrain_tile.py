"""Terrain tiles, read by what docs/formats/spt.md and spm.md say and by nothing else.

Slow, and in the order of the text: what a tile claims is measured with it by code that shares nothing with what wrote it.
"""

import struct
import zlib
from dataclasses import dataclass

import numpy

EVEN = 32_768
RATES = [1] + 2 * [2] + 4 * [3] + 8 * [4] + 16 * [5]
LAST_RATE = 6
UNKNOWN_SIGN = 4
SAME, FREE = 0, 4
INNER, FRONT, BACK, OUTER, HOLE_FIRST, HOLE_SECOND = range(6)
LEADS = [0.25, 0.5, 1, 2, 5, 1e20]


class Numbers:
    """Numbers of seven bits a byte, the lowest first."""

    def __init__(self, file: bytes, at: int):
        self.file, self.at = file, at

    def next(self) -> int:
        number = shift = 0
        while True:
            byte = self.file[self.at]
            self.at += 1
            number |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return number

    def signed(self) -> int:
        number = self.next()
        return -(number + 1) // 2 if number % 2 else number // 2

    def fields(self, layout: str) -> tuple:
        values = struct.unpack_from("<" + layout, self.file, self.at)
        self.at += struct.calcsize("<" + layout)
        return values


class RangeDecoder:
    """Bits of one level. `statistics` go on from level to level: of each kind of answer how likely 1 is, and how many there were."""

    def __init__(self, run: bytes, statistics: dict):
        self.run, self.statistics = run, statistics
        self.range, self.code, self.at = 2**48 - 1, 0, 0
        for _ in range(3):
            self.shift()

    def shift(self) -> None:
        high, low = (self.run[place] if place < len(self.run) else 0 for place in (self.at, self.at + 1))
        self.code = self.code << 16 | high << 8 | low
        self.at += 2

    def widen(self) -> None:
        while self.range < 2**32:
            self.range <<= 16
            self.shift()

    def bit(self, *kind) -> int:
        one, answers = self.statistics.get(kind, (EVEN, 0))
        bound = (self.range >> 16) * one
        answer = int(self.code < bound)
        if answer:
            self.range = bound
        else:
            self.code -= bound
            self.range -= bound
        rate = RATES[answers] if answers < len(RATES) else LAST_RATE
        one += ((65_504 if answer else 32) - one) >> rate
        self.statistics[kind] = (one, answers + 1)
        self.widen()
        return answer

    def even_bits(self, count: int) -> int:
        value = 0
        while count > 0:
            part = min(count, 16)
            self.range >>= part
            digits = min(self.code // self.range, 2**part - 1)
            self.code -= digits * self.range
            self.widen()
            value = value << part | digits
            count -= part
        return value

    def symbol(self, bits: int, *kind) -> int:
        node = 1
        for _ in range(bits):
            node = 2 * node + self.bit(*kind, node)
        return node - 2**bits

    def number(self, kind, guess: float, sign: int = UNKNOWN_SIGN) -> int:
        expected = int(guess).bit_length()
        size = self.symbol(4, kind, "class", min(expected, 7))
        length = self.even_bits(6) if size in (0, 15) else max(size + expected - 9, 0)
        if length == 0:
            return 0
        magnitude = 1
        if length > 1:
            magnitude = 2 + self.bit(kind, "second", size)
            magnitude = magnitude << (length - 2) | self.even_bits(length - 2)
        return -magnitude if self.bit(kind, "sign", sign) else magnitude


@dataclass
class Level:
    length: int
    vertex_end: int
    triangle_end: int
    error: float
    outline_error: float


class Header:
    """What stands before the levels."""

    def __init__(self, file: bytes):
        numbers = Numbers(file, 0)
        magic, version, zoom, extent_bits, exponent, x, y, lowest, highest, flags = numbers.fields("4sBBBbIIiiB")
        assert magic == b"SPTL" and 3 <= version <= 6, (magic, version)
        self.name, self.parent_error, self.parent_outline = numbers.fields("16sff")
        self.address = (zoom, x, y)
        self.extent = 2**extent_bits
        self.step = 2.0**exponent
        self.heights = (lowest, highest)
        self.opens_holes = version == 4 or (version >= 5 and flags & 2 != 0)
        count = numbers.next()
        self.base = (numbers.next(), numbers.next())
        self.sampling = numbers.fields("4d") if flags & 1 else None
        if version >= 5:
            for _ in range(4 * numbers.next()):
                numbers.signed()
        self.filled = None
        if version == 6:
            (cells,) = numbers.fields(f"{numbers.next()}s")
            bits = numpy.frombuffer(zlib.decompress(cells, -15), numpy.uint8)
            self.filled = numpy.unpackbits(bits, bitorder="little").reshape(256, 256).astype(bool)
        self.levels = []
        vertices = triangles = bits = outline_bits = 0
        for _ in range(count):
            length, added = numbers.next(), numbers.next()
            vertices += added
            triangles += 2 * added - numbers.signed()
            bits += numbers.signed()
            outline_bits += numbers.signed()
            error, outline_error = struct.unpack("<2f", struct.pack("<2I", bits, outline_bits))
            self.levels.append(Level(length, vertices, triangles, error, outline_error))
        self.end = numbers.at


class Surface:
    """Triangles, and the walk around each vertex. Half-edge 3t + k leaves the kth corner of triangle t."""

    def __init__(self):
        self.origin: list[int] = []
        self.twin: list[int | None] = []
        self.begin: list[int | None] = []

    def add_triangle(self, *corners: int) -> int:
        edge = len(self.origin)
        self.origin += corners
        self.twin += [None] * 3
        return edge

    def join(self, edge: int, twin: int | None) -> None:
        self.twin[edge] = twin
        if twin is not None:
            self.twin[twin] = edge

    def begin_base(self, vertices: int) -> None:
        along: dict[tuple, list[int]] = {}
        for edge, start in enumerate(self.origin):
            end = self.origin[following(edge)]
            along.setdefault((min(start, end), max(start, end)), []).append(edge)
        for edges in along.values():
            if len(edges) == 2 and self.origin[edges[0]] != self.origin[edges[1]]:
                self.join(*edges)
        self.begin = [None] * vertices
        for edge, vertex in enumerate(self.origin):
            if self.begin[vertex] is None or self.twin[edge] is None:
                self.begin[vertex] = edge

    def walk(self, vertex: int) -> tuple[list[int], list[int], bool]:
        """Half-edges that leave, the neighbours, and whether the vertex is inside the surface."""
        edges, neighbours = [], []
        edge = self.begin[vertex]
        while edge is not None:
            edges.append(edge)
            neighbours.append(self.origin[following(edge)])
            back = preceding(edge)
            edge = self.twin[back]
            if edge == edges[0]:
                return edges, neighbours, True
        if edges:
            neighbours.append(self.origin[back])
        return edges, neighbours, False

    def lead(self, edge: int) -> None:
        """Where nothing is to an edge's right, the walk around its vertex begins there."""
        if self.twin[edge] is None:
            self.begin[self.origin[edge]] = edge

    def split(self, red: int, blue: int, side: int, first: int, second: int) -> None:
        edges, neighbours, is_closed = self.walk(red)
        count = len(edges)
        # Along the spoke at a place: the half-edge that leaves red, and the one that comes back in the triangle before.
        leaving = edges + [None]
        coming = [preceding(edges[-1]) if is_closed else None] + [preceding(edge) for edge in edges]
        if is_closed or side == INNER:
            going = range(first, second) if first < second else [*range(first, count), *range(second)]
        else:
            going = {FRONT: range(second), BACK: range(first, count), OUTER: [*range(first), *range(second, count)]}[side]
        self.begin.append(None)
        for place in going:
            self.origin[edges[place]] = blue
        outer, inner = (blue, red) if side == OUTER else (red, blue)
        if side == OUTER:
            self.begin[blue] = self.begin[red]
        between = []
        if side not in (FRONT, HOLE_FIRST):
            edge = self.add_triangle(outer, neighbours[first], inner)
            self.join(edge, coming[first])
            self.join(edge + 1, leaving[first])
            self.lead(edge + 1)
            between.append(edge + 2)
            if first == 0 or is_closed:
                self.begin[outer] = edge
            self.begin[inner] = edge + 2
        if side not in (BACK, HOLE_SECOND):
            edge = self.add_triangle(outer, inner, neighbours[second])
            self.join(edge + 1, coming[second])
            self.join(edge + 2, leaving[second])
            self.lead(edge + 2)
            between.append(edge)
            if side == FRONT:
                self.begin[outer] = edge
                self.begin[inner] = edges[0] if second > 0 else edge + 1
        if len(between) == 2:
            self.join(*between)
        if side in (HOLE_FIRST, HOLE_SECOND):
            cut = first if side == HOLE_FIRST else second
            # The hole is to the right of one edge from each of its corners.
            for edge in (coming[cut], leaving[cut], between[0]):
                self.twin[edge] = None
                self.begin[self.origin[edge]] = edge


def following(edge: int) -> int:
    return edge - 2 if edge % 3 == 2 else edge + 1


def preceding(edge: int) -> int:
    return edge + 2 if edge % 3 == 0 else edge - 1


class Tile:
    """All levels of a tile. Positions are x, y in lattice units and heights in steps."""

    def __init__(self, file: bytes):
        self.header = header = Header(file)
        self.surface = Surface()
        self.statistics: dict = {}
        self.position: list[list] = []
        self.made: list[list] = []
        self.restored: list[list] = []
        self.representative: list[int] = []
        self.roughness: list[float] = []
        self.first_fit: list[int] = []
        start = header.end
        for index, level in enumerate(header.levels):
            run = RangeDecoder(file[start : start + level.length], self.statistics)
            if index == 0:
                self.read_base(run)
            self.read_level(run, index, level)
            start += level.length
        assert start == len(file), "bytes are left"

    def read_base(self, run: RangeDecoder) -> None:
        vertices, triangles = self.header.base
        place = [0, 0, self.header.heights[0]]
        for vertex in range(vertices):
            place = [number + run.number(("base", axis), 16_384, 0) for axis, number in enumerate(place)]
            self.add_vertex(place, vertex, place)
            self.roughness.append(0.0)
            self.first_fit.append(self.fit(0, place[0]))
        new = 0
        for _ in range(triangles):
            corners = []
            for _ in range(3):
                back = run.number("corner", 4, 0)
                corners.append(new - back)
                new += back == 0
            self.surface.add_triangle(*corners)
        self.surface.begin_base(vertices)

    def add_vertex(self, place: list, representative: int, restored: list) -> None:
        self.position.append(list(place))
        self.made.append(list(place))
        self.restored.append(list(restored))
        self.representative.append(representative)

    def read_level(self, run: RangeDecoder, index: int, level: Level) -> None:
        stage = 0 if index == 0 else 2 if index >= len(self.header.levels) - 4 else 1
        at_first = len(self.position)
        queue = list(range(at_first))
        queued = set(queue)
        asked = 0
        while len(self.position) < level.vertex_end:
            red = queue[asked]
            is_first_time = asked < at_first
            asked += 1
            queued.discard(red)
            _, neighbours, is_closed = self.surface.walk(red)
            if not 2 <= len(neighbours) <= 1_024 or (stage == 2 and is_closed):
                continue
            if run.bit("splits", stage, is_closed, is_first_time, min(len(neighbours), 11)):
                self.read_split(run, red, neighbours, is_closed, stage == 0)
                for vertex in (len(self.position) - 1, red, *neighbours):
                    if vertex not in queued:
                        queued.add(vertex)
                        queue.append(vertex)
        assert len(self.surface.origin) == 3 * level.triangle_end, "another number of triangles"

    def read_split(self, run: RangeDecoder, red: int, neighbours: list, is_closed: bool, is_base: bool) -> None:
        centre = self.position[red]
        spokes = [[a - b for a, b in zip(self.position[neighbour], centre)] for neighbour in neighbours]
        side = self.read_side(run, is_closed, is_base)
        blue = self.read_plan(run, red, spokes, side)
        ahead = [blue[axis] - centre[axis] for axis in (0, 1)]
        expected = height_at(spokes, ahead, side, is_closed)
        mean = sum(self.roughness[neighbour] for neighbour in neighbours) / len(neighbours)
        off = run.number(("height", is_base), 0.3 * self.roughness[red] + (1 - 0.3) * mean)
        blue.append(centre[2] + round(expected) + off)
        self.roughness[red] += (abs(off) - self.roughness[red]) * 0.6
        moved = list(centre) if is_base else self.read_red(run, centre, blue, 0.4 * self.roughness[red] + 0.4 * abs(off), off)
        if moved[0] != centre[0]:
            self.first_fit[red] = self.fit(0, moved[0])
        first, second = read_cuts(run, spokes, centre, moved, blue, side, is_closed)
        new = len(self.position)
        self.surface.split(red, new, side, first, second)
        self.position[red] = moved
        self.roughness.append(self.roughness[red])
        self.add_vertex(blue, new if is_base else red, blue if is_base else moved)

    def read_side(self, run: RangeDecoder, is_closed: bool, is_base: bool) -> int:
        if not is_closed:
            return run.symbol(2, "side")
        if not self.header.opens_holes or not run.bit("opens", is_base):
            return INNER
        return HOLE_SECOND if run.bit("second hole") else HOLE_FIRST

    def read_plan(self, run: RangeDecoder, red: int, spokes: list, side: int) -> list:
        is_open = side in (FRONT, BACK)
        hints = {FRONT: spokes[:1], BACK: spokes[-1:]}.get(side, spokes)
        centre, before = self.position[red], self.first_fit[red]
        blue = []
        for axis in (0, 1):
            fit = min(run.symbol(3, "fit", axis, is_open, before), FREE)
            if axis == 0:
                self.first_fit.append(before if fit == SAME else fit)
            before = fit
            blue.append(self.read_coordinate(run, axis, fit, centre[axis], hints))
            ahead = blue[0] - centre[0]
            hints = [hint for hint in hints if hint[0] * ahead > 0] or hints
        return blue

    def read_coordinate(self, run: RangeDecoder, axis: int, fit: int, centre: int, hints: list) -> int:
        if fit == SAME:
            return centre
        along = [hint[axis] for hint in hints]
        size = sum(map(abs, along))
        guess = size / len(along)
        sign = int(((sum(along) / size if size else 0.0) + 1) * 4 + 0.5)
        if fit == FREE or self.header.sampling is None:
            return centre + run.number(("free", axis), guess, sign)
        parts = 2 ** (fit - 1)
        origin, step = self.header.sampling[axis], self.header.sampling[2 + axis]
        index = round((centre - origin) * (1 / step) * parts) + run.number(("step", axis), guess * (1 / step) * parts, sign)
        return round(origin + step * (index / parts))

    def fit(self, axis: int, coordinate: int) -> int:
        if self.header.sampling is not None:
            origin, step = self.header.sampling[axis], self.header.sampling[2 + axis]
            for fit in (1, 2, 3):
                parts = 2 ** (fit - 1)
                index = round((coordinate - origin) * (1 / step) * parts)
                if round(origin + step * (index / parts)) == coordinate:
                    return fit
        return FREE

    @staticmethod
    def read_red(run: RangeDecoder, centre: list, blue: list, guess: float, off: int) -> list:
        red = list(centre)
        moves = run.bit("moves")
        if moves and run.bit("midway"):
            red = [2 * c - b for c, b in zip(centre, blue)]
            for axis in (0, 1):
                red[axis] -= run.bit("odd", axis)
        elif moves:
            for axis in (0, 1):
                red[axis] += run.number("distance of red", abs(blue[axis] - centre[axis]))
        sign = 1 if off < 0 else 2 if off > 0 else UNKNOWN_SIGN
        red[2] += run.number(("height of red", moves), guess, sign)
        return red

    def drawn(self, level: int) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Levels 0 to `level`: of each vertex x and y in lattice units from 180° W, 90° S, and its height in metres; three corners a triangle."""
        end, base = self.header.levels[level], self.header.levels[0].vertex_end
        places = numpy.array(self.made, float)
        roots = list(range(len(places)))
        for vertex in range(base, len(places)):
            if vertex < end.vertex_end:
                places[self.representative[vertex]] = self.restored[vertex]
            else:
                roots[vertex] = roots[self.representative[vertex]]
        corners = numpy.array(roots)[numpy.array(self.surface.origin[: 3 * end.triangle_end]).reshape(-1, 3)]
        _, x, y = self.header.address
        places += [x * self.header.extent, y * self.header.extent, 0]
        places[:, 2] *= self.header.step
        return places[: end.vertex_end], corners

    def degrees(self, places: numpy.ndarray) -> numpy.ndarray:
        """The same places as longitudes, latitudes and heights."""
        unit = 180 / 2 ** self.header.address[0] / self.header.extent
        return places * [unit, unit, 1] + [-180, -90, 0]


def height_at(spokes: list, place: list, side: int, is_closed: bool) -> float:
    """Of the star at a place, all less its middle's."""
    x, y = place
    if side in (FRONT, BACK):
        a = spokes[0] if side == FRONT else spokes[-1]
        length = a[0] * a[0] + a[1] * a[1]
        return (a[0] * x + a[1] * y) / length * a[2] if length else 0.0
    pairs = list(zip(spokes, spokes[1:]))
    if is_closed:
        pairs.insert(0, (spokes[-1], spokes[0]))
    for a, b in pairs:
        from_a, to_b, area = a[0] * y - a[1] * x, x * b[1] - y * b[0], a[0] * b[1] - a[1] * b[0]
        if from_a >= 0 and to_b > 0 and area > 0:
            return (float(from_a) * b[2] + float(to_b) * a[2]) / area
    return 0.0


def read_cuts(run: RangeDecoder, spokes: list, centre: list, red: list, blue: list, side: int, is_closed: bool) -> tuple[int, int]:
    if side == OUTER:
        red, blue = blue, red
    red, blue = ([place[axis] - centre[axis] for axis in (0, 1)] for place in (red, blue))
    count, first, second = len(spokes), 0, 0

    def misfit(place: int, is_second: bool) -> float:
        r, b = ([end[axis] - spokes[place][axis] for axis in (0, 1)] for end in (red, blue))
        area = b[0] * r[1] - b[1] * r[0]
        area = float(-area if is_second else area)
        dot = float(r[0] * b[0] + r[1] * b[1])
        return dot / area if area > 0 else 1e30 + abs(dot)

    def read(is_second: bool, candidates) -> int:
        ranked = sorted(((misfit(place, is_second), place) for place in candidates), key=lambda one: one[0])
        for rank, ((own, place), (following_one, _)) in enumerate(zip(ranked, ranked[1:])):
            lead = sum(limit < following_one - own for limit in LEADS)
            if run.bit("cut", is_second, min(rank, 7), lead):
                return place
        return ranked[-1][1]

    if side != FRONT:
        first = read(False, range(count))
    if side != BACK:
        places = range(count) if side == FRONT else range(first + 1, count)
        second = read(True, [place for place in range(count) if place != first] if is_closed else places)
    return first, second
