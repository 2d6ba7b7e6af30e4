"""Ready-made scenes: a chessboard, a monitor, a room, a building front."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.geometry import pose
from raxel.lab.scene import (
    AHEAD,
    DOWN,
    RIGHT,
    TexturedScene,
    patch_edges,
    shaded,
    wall,
    window,
)
from raxel.lab.surfaces import Cylinder, Rectangle, box
from raxel.lab.textures import (
    ChessboardTexture,
    GridTexture,
    Panels,
    Plain,
    Texture,
    Tiles,
    share_in_bars,
)
from raxel.sets.model import ActiveGrid, Chessboard, Pattern
from raxel.sets.patterns import advance, cell_width

# A building front with rows of windows and long vertical lines.


STONE, BRICK, TRIM = (0.72, 0.64, 0.50), (0.46, 0.20, 0.13), (0.85, 0.82, 0.74)
GLASS = [(0.10, 0.16, 0.24), (0.16, 0.24, 0.34)]
SLATE, DOOR, PAVING = (0.16, 0.18, 0.22), (0.10, 0.28, 0.16), (0.42, 0.42, 0.42)
FACADE_SKY = (0.55, 0.74, 1.0)


def facade(
    bays: int = 7, storeys: int = 4, bay: float = 3400.0, storey: float = 3600.0
) -> TexturedScene:
    """Return a building front of bays x storeys windows; the same at every call.

    World frame, mm: origin at the foot of the front's middle, x right, y down, z ahead.
    The house is at negative y, and z leads into it: a camera is at negative z.

    Parameters
    ----------
    bays, storeys : int
        Windows per row, and rows.
    bay, storey : float
        Width of a bay and height of a storey, mm.

    Returns
    -------
    TexturedScene
        Straight edges: sides of pilasters, cornices, windows, and of the front; those
        along (0, 1, 0) are vertical.
    """
    width, height = bays * bay, storeys * storey + 900
    corner = np.array([-width / 2, -height, 0.0])
    pilasters = _pilasters(bays, bay, height)
    cornices = [(0, 0, width, 350, TRIM)]
    for level in range(1, storeys):
        y = height - level * storey
        cornices.append((0, y - 130, width, y + 130, TRIM))  # type: ignore[arg-type]
    plinth = (0, height - 700, width, height, STONE)
    openings = _openings(bays, storeys, bay, storey, height)
    patches = [plinth, *cornices, *pilasters, *chain(*openings)]
    front = wall(corner, RIGHT, DOWN, width, height, BRICK, patches)
    outer = [opening[0] for opening in openings]
    edges = [patch_edges(front[0], pilasters + cornices + outer), front[0].outline]
    parts = [front, *_neighbours(width, height), _street()]
    return TexturedScene(tuple(parts), FACADE_SKY, np.concatenate(edges))


def _pilasters(bays, bay, height):
    """Light strips from plinth to cornice between the bays and at both ends."""
    half = 190.0
    middles = [min(max(k * bay, half), bays * bay - half) for k in range(bays + 1)]
    return [(x - half, 350, x + half, height - 700, TRIM) for x in middles]


def _openings(bays, storeys, bay, storey, height):
    openings = []
    for level in range(storeys):
        for k in range(bays):
            middle = (k + 0.5) * bay
            if level == 0 and k == bays // 2:
                openings.append(_door(middle, height))
                continue
            tall = 2000.0 - 150 * level
            sill = height - level * storey - 950
            frame = window(
                middle - 650, sill - tall, 1300, tall, (2, 3), 70, GLASS, TRIM
            )
            ledge = (middle - 800, sill, middle + 800, sill + 120, STONE)
            openings.append([*frame, ledge])
    return openings


def _door(middle, height):
    top = height - 2900
    leaves = [
        (middle - 640 + 660 * k, top + 500, middle - 20 + 660 * k, height, DOOR)
        for k in range(2)
    ]
    light = (middle - 640, top + 100, middle + 640, top + 440, GLASS[1])
    return [(middle - 760, top, middle + 760, height, TRIM), light, *leaves]


def _neighbours(width, height):
    """Return lower houses on both sides, slightly behind the front's line."""
    houses = []
    for side, colour, lower in ((-1, STONE, 2600.0), (1, (0.60, 0.46, 0.42), 4200.0)):
        tall, wide = height - lower, 14000.0
        x = -width / 2 - wide if side < 0 else width / 2
        frames = [
            window(1500 + 2800 * i, y, 1200, 1700, (1, 2), 80, GLASS, TRIM)
            for i in range(4)
            for y in np.arange(900.0, tall - 2600, 3300)
        ]
        patches = [(0, 0, wide, 260, SLATE), *chain(*frames)]
        corner = np.array([x, -tall, 400.0])
        houses.append(wall(corner, RIGHT, DOWN, wide, tall, colour, patches))
    return houses


def _street():
    """Paving in front of the houses, 30 m deep."""
    T = np.eye(4)
    T[:3, :3] = np.column_stack([RIGHT, -AHEAD, DOWN])
    T[:3, 3] = [-30000, 0, 600]
    slabs = Tiles(
        (1500, 1000), [PAVING, (0.50, 0.49, 0.47)], 30, (0.26, 0.26, 0.26), 0.5
    )
    return Rectangle(T, 60000, 30000), slabs


# A furnished room with many straight edges, viewed from its centre.


PLASTER, SKIRTING, WHITE = (0.86, 0.78, 0.62), (0.30, 0.17, 0.09), (0.90, 0.90, 0.88)
SKY = [(0.62, 0.82, 1.10), (0.66, 0.85, 1.12), (0.70, 0.88, 1.12)]
WOOD, DARK_WOOD, BRASS = (0.42, 0.22, 0.10), (0.20, 0.10, 0.05), (0.75, 0.55, 0.15)
BOOKS = [
    (0.50, 0.07, 0.06),
    (0.07, 0.20, 0.42),
    (0.10, 0.33, 0.14),
    (0.72, 0.52, 0.12),
    (0.36, 0.12, 0.32),
    (0.78, 0.74, 0.64),
    (0.08, 0.36, 0.38),
]
GOLDEN = (np.sqrt(5) - 1) / 2


def room(
    width: float = 5000.0,
    depth: float = 6000.0,
    height: float = 2700.0,
    eye: float = 1300.0,
) -> TexturedScene:
    """Return a furnished room with many straight edges; the same at every call.

    World frame, mm: origin in the middle of the room at `eye` above the floor, x right,
    y down, z ahead. Ahead: two windows; right: a bookcase; behind: images and a
    cupboard; left: a door and an image; tiles on the floor, a table, a column.

    Parameters
    ----------
    width, depth, height : float
        Size of the room along x, z and y, mm.
    eye : float
        Height of the origin above the floor, mm.

    Returns
    -------
    TexturedScene
        Straight edges: joints of the walls, window, door, image and shelf frames.
    """
    left, back, top = -width / 2, -depth / 2, eye - height
    walls = [
        _ahead(np.array([left, top, -back]), width, height),
        _right(np.array([-left, top, -back]), depth, height),
        _behind(np.array([-left, top, back]), width, height),
        _left(np.array([left, top, back]), depth, height),
    ]
    parts = [part for part, _ in walls]
    edges = [patch_edges(part[0], framed) for part, framed in walls]
    edges += [part[0].outline for part in parts]
    parts += [_floor(left, eye, back), _ceiling(left, top, back)]
    parts += _table(eye) + _column(np.array([1700.0, eye, -1500.0]), height)
    return TexturedScene(tuple(parts), 0.0, np.concatenate(edges))


def _ahead(corner, width, height):
    frames = [
        window(x, 600, 1300, 1300, (2, 3), 60, SKY, WHITE)
        for x in (0.14 * width, 0.86 * width - 1300)
    ]
    sills = [(f[0][0] - 80, 1900, f[0][2] + 80, 1960, SKIRTING) for f in frames]
    patches = [(0, height - 120, width, height, SKIRTING), *chain(*frames), *sills]
    part = wall(corner, RIGHT, DOWN, width, height, PLASTER, patches)
    return part, list(chain(*frames))


def _right(corner, depth, height):
    x, y, shelf = 900.0, 400.0, 380.0
    patches = [(0, height - 120, depth, height, SKIRTING)]
    patches.append((x, y, x + 4200, height, WOOD))
    niches = [
        (x + 40 + 1380 * i, y + 40 + shelf * j, x + 1380 * (i + 1), y + shelf * (j + 1))
        for i in range(3)
        for j in range(6)
    ]
    for number, niche in enumerate(niches):
        patches.append((*niche, DARK_WOOD))
        patches += _books(niche, number)
    patches = shaded(patches, 0.9)
    ground = tuple(0.9 * np.array(PLASTER))
    part = wall(corner, -AHEAD, DOWN, depth, height, ground, patches)
    return part, [patches[1], *niches]


def _books(niche, number):
    """Backs of books side by side, of widths and heights that vary without chance."""
    x0, y0, x1, y1 = niche
    x, books, k = x0 + 5, [], 31 * number
    # Every fifth niche is half empty.
    end = x1 if number % 5 else (x0 + x1) / 2
    while True:
        one, two = (k * GOLDEN) % 1.0, (k * GOLDEN * GOLDEN * 7) % 1.0
        wide = 40 + 60 * one
        if x + wide > end - 5:
            return books
        colour = BOOKS[int(len(BOOKS) * ((k * 0.7548777) % 1.0))]
        books.append((x, y1 - (y1 - y0) * (0.62 + 0.3 * two), x + wide, y1, colour))
        x, k = x + wide + 3, k + 1


def _behind(corner, width, height):
    images = [
        _picture(500, 600, 1100, 800, BOOKS[0], BOOKS[3]),
        _picture(width - 1500, 500, 900, 1100, BOOKS[1], BOOKS[6]),
    ]
    patches = [(0, height - 120, width, height, SKIRTING), *chain(*images)]
    base = height - 900
    doors = [(1900 + 600 * k, base, 2480 + 600 * k, height - 60) for k in range(2)]
    patches.append((1880, base - 40, 3100, height, WOOD))
    patches += [(*door, (0.52, 0.30, 0.15)) for door in doors]
    patches = shaded(patches, 0.72)
    ground = tuple(0.72 * np.array(PLASTER))
    part = wall(corner, -RIGHT, DOWN, width, height, ground, patches)
    return part, [image[0] for image in images] + doors


def _left(corner, depth, height):
    door = (900.0, height - 2050, 1800.0, height, (0.16, 0.34, 0.36))
    frame = (820.0, height - 2130, 1880.0, height, WHITE)
    fields = [
        (
            1000 + 370 * i,
            door[1] + 120 + 950 * j,
            1300 + 370 * i,
            door[1] + 900 + 950 * j,
        )
        for i in range(2)
        for j in range(2)
    ]
    fields = [(*f, (0.22, 0.46, 0.48)) for f in fields]
    handle = (1680.0, height - 1080, 1760.0, height - 1040, BRASS)
    image = _picture(2700, 600, 1500, 1000, BOOKS[2], SKY[0])
    patches = [(0, height - 120, depth, height, SKIRTING), frame, door, *fields]
    patches = shaded([*patches, handle, *image], 0.82)
    ground = tuple(0.82 * np.array(PLASTER))
    part = wall(corner, AHEAD, DOWN, depth, height, ground, patches)
    return part, [frame, door, *fields, image[0]]


def _picture(x, y, width, height, colour, other):
    """A gilt frame, a mount, and an image of horizontal bands."""
    inner = (x + 130, y + 130, x + width - 130, y + height - 130)
    third = (inner[3] - inner[1]) / 3
    return [
        (x, y, x + width, y + height, BRASS),
        (x + 50, y + 50, x + width - 50, y + height - 50, WHITE),
        (*inner, colour),
        (inner[0], inner[1] + third, inner[2], inner[1] + 2 * third, other),
    ]


def _floor(left, eye, back):
    T = np.eye(4)
    T[:3, :3] = np.column_stack([RIGHT, -AHEAD, DOWN])
    T[:3, 3] = [left, eye, -back]
    tiles = Tiles(
        (500, 500), [(0.55, 0.27, 0.17), (0.80, 0.72, 0.58)], 12, (0.3, 0.28, 0.25)
    )
    return Rectangle(T, -2 * left, -2 * back), tiles


def _ceiling(left, top, back):
    T = np.eye(4)
    T[:3, :3] = np.column_stack([RIGHT, AHEAD, -DOWN])
    T[:3, 3] = [left, top, back]
    width, depth = -2 * left, -2 * back
    lamps = [
        (width / 2 - 150, y - 700, width / 2 + 150, y + 700, (1.25, 1.22, 1.1))
        for y in (depth / 4, 3 * depth / 4)
    ]
    beams = [
        (0, y - 60, width, y + 60, (0.50, 0.33, 0.20))
        for y in (depth / 2, 0.02 * depth, 0.98 * depth)
    ]
    return Rectangle(T, width, depth), Panels((0.80, 0.80, 0.78), beams + lamps)


def _table(eye):
    """A table ahead on the left: top of one box, four round legs."""
    corner, size, legs = (
        np.array([-1900.0, eye - 740, 900.0]),
        (1500.0, 40.0, 850.0),
        35,
    )
    tones = {0: 0.75, 1: 1.25, 2: 0.9}
    parts = []
    for number, face in enumerate(box(pose(np.eye(3), corner), size)):
        tone = tones[number % 3]
        parts.append((face, Plain(tuple(tone * np.array(WOOD)))))
    upright = np.column_stack([RIGHT, AHEAD, -DOWN])
    for x in (60, size[0] - 60):
        for z in (60, size[2] - 60):
            foot = corner + [x, 740, z]
            parts.append((Cylinder(pose(upright, foot), legs, 700), Plain(DARK_WOOD)))
    return parts


def _column(foot, height):
    """Return a round column with stripes, to the right behind the camera."""
    upright = np.column_stack([RIGHT, AHEAD, -DOWN])
    radius = 170.0
    turn = np.pi * radius
    ribs = 12
    step = 2 * turn / ribs
    flutes = [
        (-turn + step * (k + 0.2), 150, -turn + step * (k + 0.8), height - 150)
        for k in range(ribs)
    ]
    flutes = [(*flute, (0.62, 0.60, 0.56)) for flute in flutes]
    return [
        (
            Cylinder(pose(upright, foot), radius, height),
            Panels((0.80, 0.78, 0.74), flutes),
        )
    ]


# Content of a monitor: coded patterns and even levels, as textures. uv is in mm from
# the upper left corner of the lit area, x right and y down. The value of a pattern
# runs from 0 to 1; `response(value, cosine)` makes it radiance, so gamma and the
# falloff with the viewing angle belong to the monitor (`raxel.lab.Monitor`). The lit
# area is drawn as a continuous image: the fine raster of its own pixels is left
# out, but a Gray code's edges lie on the borders of its cells exactly.


class MonitorLevel(Texture):
    """The whole monitor at one value, as for the white and the black image.

    Parameters
    ----------
    value : float
        Value of all pixels, 0 to 1.
    response : callable or None
        Turns (value, cosine), arrays (N,), into radiance; None: the value itself.
    """

    averages = True

    def __init__(
        self,
        value: float,
        response: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
    ) -> None:
        self.value = float(value)
        self.response = response or _linear

    def radiance(
        self, uv: NDArray[np.float64], cosine: NDArray[np.float64]
    ) -> np.ndarray:
        """Return the radiance (N,): the same everywhere but for the viewing angle."""
        return self.response(np.full(len(uv), self.value), cosine)

    def average(
        self,
        uv: NDArray[np.float64],
        across: NDArray[np.float64],
        down: NDArray[np.float64],
        cosine: NDArray[np.float64],
    ) -> np.ndarray:
        """Return the mean radiance (N,) over footprints, as `radiance`."""
        return self.radiance(uv, cosine)


class MonitorBoard(GridTexture):
    """The chessboard of a monitor (`raxel.sets.MonitorChessboard`)."""

    regional = False  # its radiance changes with the viewing angle
    even_inside = True

    def __init__(self, monitor_px, monitor_mm, board, response=None):
        pixel = np.divide(monitor_mm or monitor_px, monitor_px)
        counts = board.columns, board.rows
        lines = [
            mm * (first + board.pitch_px * np.arange(-1, count + 1))
            for mm, first, count in zip(pixel, board.origin_px, counts, strict=True)
        ]
        white = np.add.outer(np.arange(counts[1] + 1), np.arange(counts[0] + 1)) % 2 < 1
        super().__init__(lines, np.pad(white, 1, constant_values=True).ravel() * 1.0)
        self.response = response or _linear

    def radiance(self, uv, cosine):
        """At points."""
        return self.response(self.colours[self.label(uv)], cosine)

    def average(self, uv, across, down, cosine):
        """Exact where at most one line crosses the parallelogram, else NaN."""
        white = super().average(uv, across, down, cosine)
        return _two_levels(self.response, white, cosine)


class MonitorPattern(Texture):
    """One pattern of an active grid, Gray code or phase step.

    Gray code counts 2^of cells from the left or upper border, bit 0 is the most
    significant. Step k of a phase pattern has the value
    1/2 + 1/2 sin(phi + 2 pi (k / of + offset)). The phase
    phi = 2 pi periods x / width starts at 0 on the left or upper border.

    Means over a pixel's footprint are exact for Gray code, whose edges are parallel, if
    the map is affine within the pixel. Of a phase pattern the mean value is exact;
    `response` is applied to it, as the value hardly changes within a pixel.

    Parameters
    ----------
    monitor_px : (int, int)
        Width and height of the lit area, px.
    monitor_mm : (float, float) or None
        Width and height of the lit area, mm; None: a pixel is 1 mm wide.
    pattern : Pattern
        Axis, kind and number of the pattern.
    response : callable or None
        Turns (value, cosine), arrays (N,), into radiance; None: the value itself.

    Attributes
    ----------
    axis : int
        0 for patterns along x, 1 along y.
    frequency : float
        Periods of a phase pattern along `axis`, 1 / mm. For Gray code a half of its
        stripes: the brightness changes where frequency x + 1/2 is whole.

    Raises
    ------
    InputError
        For an axis other than x and y, or a kind other than gray and phase.

    References
    ----------
    Thesis (3.23) decodes the phase steps.
    """

    averages = True

    def __init__(
        self,
        monitor_px: tuple[int, int],
        monitor_mm: Sequence[float] | None,
        pattern: Pattern,
        response: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
    ) -> None:
        size_mm = np.array(monitor_mm or monitor_px, float)
        if pattern.axis not in ("x", "y") or pattern.kind not in ("gray", "phase"):
            raise InputError(
                f"pattern: found axis {pattern.axis!r} and kind {pattern.kind!r}; give "
                "axis x or y and kind gray or phase"
            )
        self.pattern = pattern
        self.axis = "xy".index(pattern.axis)
        self.response = response or _linear
        if pattern.kind == "gray":
            # Bit k changes at odd multiples of 2^(of - 1 - k) cells; so in units of
            # twice that, shifted by a half, it is whether the whole part is odd.
            code_px = cell_width(pattern, monitor_px) * 2.0**pattern.of
            code_mm = code_px * size_mm[self.axis] / monitor_px[self.axis]
            self.frequency = 2.0**pattern.bit / code_mm  # type: ignore[operator]
        else:
            self.frequency = pattern.periods / size_mm[self.axis]

    def radiance(
        self, uv: NDArray[np.float64], cosine: NDArray[np.float64]
    ) -> np.ndarray:
        """Return the radiance (N,) at points uv (N, 2), mm, seen under cosine (N,)."""
        x = uv[:, self.axis] * self.frequency
        if self.pattern.kind == "gray":
            return self._two_levels(np.floor(x + 0.5) % 2, cosine)
        return self.response(0.5 + 0.5 * self._sine(x), cosine)

    def average(
        self,
        uv: NDArray[np.float64],
        across: NDArray[np.float64],
        down: NDArray[np.float64],
        cosine: NDArray[np.float64],
    ) -> np.ndarray:
        """Return the mean radiance (N,) over footprints.

        Parameters
        ----------
        uv : (N, 2) array
            Middles of the footprints, mm.
        across, down : (N, 2) arrays
            Sides of the footprints, mm.
        cosine : (N,) array
            Cosine of the viewing angle.
        """
        x = uv[:, self.axis] * self.frequency
        a = across[:, self.axis] * self.frequency
        b = down[:, self.axis] * self.frequency
        if self.pattern.kind == "gray":
            return self._two_levels(odd_share(x, a, b), cosine)
        swing = 0.5 * np.sinc(a) * np.sinc(b)
        return self.response(0.5 + swing * self._sine(x), cosine)

    def _sine(self, periods):
        return np.sin(2 * np.pi * (periods + advance(self.pattern)))

    def _two_levels(self, share, cosine):
        if self.pattern.inverse:
            share = 1 - share
        return _two_levels(self.response, share, cosine)


def odd_share(x, across, down):
    """Share of a parallelogram where floor(x + 1/2) is odd: the bright of a Gray code.

    x: (N,) its middle; across, down: (N,) how far its sides reach, all as `frequency`.
    """
    return share_in_bars((x - 0.5) / 2, across / 2, down / 2, 0.5)


def monitor_scene(
    active_grid: ActiveGrid,
    T_world_target: NDArray[np.float64],
    texture: Texture | None = None,
    frame_mm: float = 20.0,
    frame: float = 0.03,
    background: float = 0.2,
) -> TexturedScene:
    """Return a monitor in its frame; part 0 is the lit area.

    Parameters
    ----------
    active_grid : ActiveGrid
        Gives the size of the lit area.
    T_world_target : (4, 4) array_like
        Pose of the lit area, mm: origin at its upper left corner, x right, y down.
    texture : Texture or None
        What the monitor shows; None: white. `Traced.shade` exchanges it.
    frame_mm : float
        Width of the frame, mm; 0: no frame.
    frame, background : float
        Radiance of the frame, and of rays that meet nothing.

    Returns
    -------
    TexturedScene
        The lit area and its frame.
    """
    size = np.array(active_grid.monitor_mm or active_grid.monitor_px, float)
    lit = Rectangle(T_world_target, *size)
    parts = [(lit, texture or MonitorLevel(1.0))]
    if frame_mm > 0:
        # Slightly behind the lit area, so that the nearer surface is well defined.
        behind = T_world_target @ pose(np.eye(3), [0, 0, 1e-3])
        rim = Rectangle(behind, *(size + 2 * frame_mm), (-frame_mm, -frame_mm))  # type: ignore[call-arg]
        parts.append((rim, Plain(frame)))
    return TexturedScene(tuple(parts), background)


def _two_levels(response, share, cosine):
    low = response(np.zeros_like(share), cosine)
    return low + share * (response(np.ones_like(share), cosine) - low)


def _linear(value, cosine):
    return value


__all__ = ["TexturedScene", "board_scene", "facade", "monitor_scene", "room"]


def board_scene(
    chessboard: Chessboard,
    T_world_target: ArrayLike,
    border_mm: float | None = None,
    black: float = 0.05,
    white: float = 0.9,
    background: float = 0.4,
    light: Callable[[np.ndarray], np.ndarray] | None = None,
) -> TexturedScene:
    """Return a chessboard on its sheet in front of an even background.

    Parameters
    ----------
    chessboard : Chessboard
        Corners and pitch; a board of unknown pitch has squares of one unit.
    T_world_target : (4, 4) array_like
        Pose of the board's frame, mm: the first interior corner is the origin.
    border_mm : float or None
        White margin around the squares; None: one pitch.
    black, white : float
        Radiance of the squares.
    background : float
        Radiance of rays that meet nothing.
    light : callable or None
        Turns positions uv (N, 2) on the board, mm, into shares (N,) of the light that
        reaches them; None: all of it.

    Returns
    -------
    TexturedScene
        One part: the sheet.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.lab import board_scene
    >>> from raxel.sets import Chessboard
    >>> board = Chessboard(columns=9, rows=6, pitch_mm=30.0)
    >>> sheet = board_scene(board, np.eye(4)).surfaces[0]
    >>> sheet.width, sheet.height
    (360.0, 270.0)
    """
    pitch = float(chessboard.pitch_mm or 1)
    border = pitch if border_mm is None else border_mm
    texture = ChessboardTexture(
        chessboard.columns, chessboard.rows, pitch, border, black, white, light
    )
    corner, size = texture.extent
    sheet = Rectangle(T_world_target, *size, corner)  # type: ignore[call-arg]
    return TexturedScene(((sheet, texture),), background)
