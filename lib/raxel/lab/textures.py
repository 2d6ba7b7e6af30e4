"""Textures: radiance as a function of the surface coordinates uv in mm.

Radiance is linear. The scene is lit evenly from all sides, so a diffuse surface shows
its albedo from every direction (Lambert's law under ambient light): 1.0 is a white
surface in full light. Only a monitor's texture depends on the cosine of view.
"""

from __future__ import annotations

import abc

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError

# Rec. 709 luminance of linear red, green, blue.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# Ratio of the sides of a footprint below which one counts as that narrow.
MIN_SIDE_RATIO = 1e-6
# Minimal extent of a footprint, mm.
MIN_EXTENT_MM = 1e-30


class Texture(abc.ABC):
    """Represent an image on a surface; smooth, unless a subclass overrides it."""

    # Whether means over a pixel's footprint have a closed form.
    averages = False
    # True where radiance is constant in each region.
    regional = False
    # True where only the cosine changes radiance in a region.
    even_inside = False

    @abc.abstractmethod
    def radiance(self, uv, cosine):
        """Return radiance at points uv (N, 2) and cosine (N,): (N,) or (N, 3) RGB."""

    def average(self, uv, across, down, cosine):
        """Return the mean radiance over parallelograms; only if `averages` is True.

        uv: (N, 2) their centres; across, down: (N, 2) their sides, all in mm. NaN
        where a texture with regions has no closed form.
        """
        raise NotImplementedError

    def label(self, uv):
        """Return the number (N,) of the region of each point, int, 0 or more.

        Where two points have different numbers an edge may be between them.
        """
        return np.zeros(len(uv), np.int64)


class RegionTexture(Texture):
    """Represent constant radiance in each region; `label` is the index into `colours`.

    Regions of one colour that do not touch have different numbers, so that thin regions
    between them are not missed. `light`: light at each point, uv (N, 2) -> (N,), nearly
    constant over a pixel; None: full light.
    """

    regional = True
    colours: np.ndarray
    light = None

    def radiance(self, uv, cosine):
        """The colour of the region in its light; the cosine does not matter."""
        return self.lit(self.colours[self.label(uv)], uv)

    def lit(self, colours, uv):
        """Colours (N, [3]) in the light at uv (N, 2)."""
        if self.light is None:
            return colours
        light = self.light(uv).astype(np.float32)
        return colours * (light[:, None] if colours.ndim == 2 else light)


class GridTexture(RegionTexture):
    """Cells between lines u = const and v = const; a cell has one colour.

    lines: two rising arrays, of u and of v; colours: (cells of v * cells of u[, 3]),
    row by row, the outer cells without end.
    """

    averages = True

    def __init__(self, lines, colours):
        self.lines = tuple(np.asarray(axis, float) for axis in lines)
        self.colours = colours

    def label(self, uv):
        """Number of the cell, row by row."""
        return _cells(np.asarray(uv, float), *self.lines)

    def average(self, uv, across, down, cosine):
        """Exact where at most one line crosses the parallelogram, else NaN."""
        reach = (np.abs(across) + np.abs(down)) / 2
        low, high = self.label(uv - reach), self.label(uv + reach)
        step = high - low
        columns = len(self.lines[0]) + 1
        axis = (step == columns).astype(int)
        row, column = high // columns, high % columns
        number = np.where(axis == 1, row, column) - 1
        last = np.where(axis == 1, len(self.lines[1]), len(self.lines[0])) - 1
        number = np.clip(number, 0, last) + axis * len(self.lines[0])
        line = np.concatenate(self.lines)[number] if last.max() >= 0 else 0.0
        pick = np.arange(len(uv))
        share = share_beyond(
            uv[pick, axis] - line, across[pick, axis], down[pick, axis]
        )
        if self.colours.ndim == 2:
            share, step = share[:, None], step[:, None]
        mixed = (1 - share) * self.colours[low] + share * self.colours[high]
        known = (step == 0) | (step == 1) | (step == columns)
        return np.where(known, self.lit(mixed, uv), np.nan)


class Plain(RegionTexture):
    """One colour everywhere.

    Parameters
    ----------
    colour : float or (3,) array_like
        Radiance: a number, or red, green and blue.
    """

    def __init__(self, colour: ArrayLike) -> None:
        self.colours = as_colour(colour)[None]

    def label(self, uv: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return zero (N,) for positions uv (N, 2): one region."""
        return np.zeros(len(uv), np.int64)


class ChessboardTexture(GridTexture):
    """Represent a chessboard of columns x rows interior corners on a white border.

    uv is the frame of `raxel.sets.Chessboard.points()`: the first interior corner at
    (0, 0), x along a row of corners, y from row to row. The cell between the first
    corners is white, as in the standard order of detectors. The border is `border_mm`
    wide around the outer squares; `extent` gives the corner and size of the whole
    sheet.
    """

    def __init__(
        self, columns, rows, pitch_mm, border_mm, black=0.05, white=0.9, light=None
    ):
        self.light = light
        if columns < 1 or rows < 1 or not pitch_mm > 0 or not border_mm >= 0:
            raise InputError(
                f"chessboard: found {columns} x {rows} corners, pitch {pitch_mm}, "
                f"border {border_mm}; give positive counts and pitch, and a border "
                "that is not negative"
            )
        self.columns, self.rows = int(columns), int(rows)
        self.pitch_mm, self.border_mm = float(pitch_mm), float(border_mm)
        squares = np.add.outer(np.arange(rows + 1), np.arange(columns + 1)) % 2 == 0
        squares = np.pad(squares, 1, constant_values=True)
        lines = [self.pitch_mm * np.arange(-1, n + 1) for n in (columns, rows)]
        super().__init__(lines, colour_table(black, white)[squares.ravel().astype(int)])

    @property
    def extent(self):
        """(corner (2,), size (2,)) of the sheet in uv, mm."""
        margin = self.pitch_mm + self.border_mm
        size = self.pitch_mm * (np.array([self.columns, self.rows]) - 1) + 2 * margin
        return np.array([-margin, -margin]), size


class Tiles(Texture):
    """Tiles of two colours in turn with joints between them.

    size: (2,) mm from joint to joint; joint: its width in mm; shift: how far every
    second row is moved, as a share of the width (0.5: brickwork).
    """

    def __init__(self, size, colours, joint=0.0, joint_colour=0.5, shift=0.0):
        self.size = np.array(size, float)
        if self.size.shape != (2,) or not (self.size > joint).all() or joint < 0:
            raise InputError(
                f"tiles: found size {self.size.tolist()} and joint {joint}; give two "
                "lengths greater than the joint"
            )
        self.joint, self.shift = float(joint), float(shift)
        self.colours = colour_table(*colours, joint_colour)

    def _cells(self, uv):
        """Return column, row, and whether the point is in a joint."""
        row = np.floor(uv[:, 1] / self.size[1])
        x = uv[:, 0] / self.size[0] - self.shift * (row % 2)
        column = np.floor(x)
        in_joint = (x - column) * self.size[0] < self.joint
        in_joint |= uv[:, 1] - row * self.size[1] < self.joint
        return column, row, in_joint

    def label(self, uv):
        """Return the number of the tile; joints are counted separately."""
        column, row, in_joint = self._cells(uv)
        # 2^20 tiles each way from the origin are enough for any room.
        return _natural(column) * 2**22 + _natural(row) * 2 + in_joint

    def radiance(self, uv, cosine):
        """Return colours that alternate along both axes."""
        column, row, in_joint = self._cells(uv)
        count = len(self.colours) - 1
        which = ((column + row) % count).astype(np.int64)
        return self.colours[np.where(in_joint, count, which)]


class Panels(GridTexture):
    """Represent rectangles over a ground colour, later ones over earlier ones.

    patches: (x0, y0, x1, y1, colour) in mm. Their sides divide the surface into a grid
    whose cells are the regions.
    """

    def __init__(self, ground, patches):
        if any(not (p[0] < p[2] and p[1] < p[3]) for p in patches):
            raise InputError("panels: a patch has no area; give x0 < x1 and y0 < y1")
        x = np.unique([x for p in patches for x in (p[0], p[2])])
        y = np.unique([y for p in patches for y in (p[1], p[3])])
        on_top = np.zeros((len(y) + 1, len(x) + 1), int)
        for number, (x0, y0, x1, y1, _) in enumerate(patches, start=1):
            i0, i1 = np.searchsorted(x, (x0, x1)) + 1
            j0, j1 = np.searchsorted(y, (y0, y1)) + 1
            on_top[j0:j1, i0:i1] = number
        self.patches = tuple(patches)
        colours = colour_table(ground, *(p[4] for p in patches))
        super().__init__((x, y), colours[on_top.ravel()])


class ImageTexture(Texture):
    """An image of linear radiance on a surface.

    The outer corner of the first pixel is at uv = (0, 0); columns count along u, rows
    along v. Between pixel centres the radiance is bilinear, beyond the border
    constant. A pixel is shaded by its centre: give an image no finer than the pixels
    that see it.

    Parameters
    ----------
    array : (rows, columns) or (rows, columns, 3) array_like
        Linear radiance, row by row from the least v.
    mm_per_px : float
        Width of its pixels, mm.

    Raises
    ------
    InputError
        For another shape, an empty image, or a width that is not positive.
    """

    def __init__(self, array: ArrayLike, mm_per_px: float) -> None:
        self.array = np.array(array, np.float32)
        if self.array.ndim not in (2, 3) or 0 in self.array.shape or not mm_per_px > 0:
            raise InputError(
                f"image texture: found shape {self.array.shape} and {mm_per_px} mm per "
                "px; give rows x columns (x 3) and a positive size"
            )
        self.mm_per_px = float(mm_per_px)

    def radiance(
        self, uv: NDArray[np.float64], cosine: NDArray[np.float64]
    ) -> np.ndarray:
        """Return the radiance, (N,) or (N, 3), bilinear between pixel centres.

        Parameters
        ----------
        uv : (N, 2) array
            Positions on the surface, mm.
        cosine : (N,) array
            Cosine of the angle of view; without effect.
        """
        rows, columns = self.array.shape[:2]
        x = np.clip(uv[:, 0] / self.mm_per_px - 0.5, 0, columns - 1)
        y = np.clip(uv[:, 1] / self.mm_per_px - 0.5, 0, rows - 1)
        i, j = x.astype(int), y.astype(int)
        right, below = np.minimum(i + 1, columns - 1), np.minimum(j + 1, rows - 1)
        rest = (slice(None),) + (None,) * (self.array.ndim - 2)
        fx, fy = (x - i)[rest], (y - j)[rest]
        upper = (1 - fx) * self.array[j, i] + fx * self.array[j, right]
        lower = (1 - fx) * self.array[below, i] + fx * self.array[below, right]
        return (1 - fy) * upper + fy * lower


@numba.njit(cache=True)
def _cells(uv, lines_u, lines_v):
    """Return the numbers (N,) of the cells of points (N, 2), row by row."""
    cells = np.empty(len(uv), np.int64)
    column = row = 0
    for n in range(len(uv)):
        # The point before was in the same cell, or in one near by.
        column = interval(lines_u, uv[n, 0], column)
        row = interval(lines_v, uv[n, 1], row)
        cells[n] = row * (len(lines_u) + 1) + column
    return cells


@numba.njit(cache=True)
def interval(nodes, value, near):
    """Return the number of rising `nodes` up to a value, searched from `near` on."""
    while near > 0 and not nodes[near - 1] <= value:
        near -= 1
    while near < len(nodes) and nodes[near] <= value:
        near += 1
    return near


def as_colour(colour):
    """A number () or RGB (3,) as float32; InputError for anything else."""
    colour = np.array(colour, np.float32)
    if colour.shape not in ((), (3,)) or not (colour >= 0).all():
        raise InputError(
            f"texture: found colour {colour.tolist()}; give one radiance, or three, "
            "none negative"
        )
    return colour


def colour_table(*colours):
    """Colours as rows: (n,) if all are grey, else (n, 3)."""
    colours = [as_colour(colour) for colour in colours]
    if any(colour.ndim for colour in colours):
        colours = [np.broadcast_to(colour, 3) for colour in colours]
    return np.stack(colours)


def share_beyond(away, across, down):
    """Return the exact share of a parallelogram beyond a straight line.

    away: (N,) distance of its centre beyond the line; across, down: (N,) extent of its
    two sides in that direction, same unit.
    """
    a, b, reach = _sides(across, down)
    # Far from the line the ramps' difference would lose its digits.
    away = np.clip(away, -reach, reach)
    wide, narrow = (a + b) / 2, (a - b) / 2
    total = _ramp(away + wide) - _ramp(away + narrow)
    total += _ramp(away - wide) - _ramp(away - narrow)
    return np.clip(total / (a * b), 0, 1)


def _sides(across, down):
    """Return nonzero lengths of both sides, and the distance from centre to end.

    Where a side is parallel to the line its width does not matter.
    """
    a, b = np.abs(across), np.abs(down)
    smallest = MIN_SIDE_RATIO * (a + b) + MIN_EXTENT_MM
    a, b = np.maximum(a, smallest), np.maximum(b, smallest)
    return a, b, (a + b) / 2


def _ramp(x):
    return np.maximum(x, 0) ** 2 / 2


def share_in_bars(y, across, down, duty):
    """Return the exact share of a parallelogram in bars of period 1, [k, k + duty).

    y: (N,) its centre; across, down: (N,) extent of its sides.
    """
    past = y - np.floor(y)
    share = (past < duty).astype(float)
    reach = (np.abs(across) + np.abs(down)) / 2
    single = reach < min(duty, 1 - duty) / 4
    rise, fall = past - np.rint(past), past - duty
    near = np.flatnonzero(single & (np.abs(rise) <= reach))
    share[near] = share_beyond(rise[near], across[near], down[near])
    near = np.flatnonzero(single & (np.abs(fall) <= reach))
    share[near] = 1 - share_beyond(fall[near], across[near], down[near])
    many = np.flatnonzero(~single)
    a, b, wide = _sides(across[many], down[many])
    y, narrow = y[many], (a - b) / 2
    total = _bars_twice(y + wide, duty) - _bars_twice(y + narrow, duty)
    total += _bars_twice(y - wide, duty) - _bars_twice(y - narrow, duty)
    share[many] = np.clip(duty + total / (a * b), 0, 1)
    return share


def _bars_twice(y, duty):
    """Second antiderivative, without mean, of the bars less their mean."""
    r = y - np.floor(y)
    r, rise, sign = (
        np.where(r < duty, r, 1 - r),
        np.where(r < duty, 1 - duty, duty),
        np.where(r < duty, 1.0, -1.0),
    )
    return sign * r * (rise * r - duty * (1 - duty)) / 2


def _natural(numbers):
    """Return integers of any sign as numbers from 0 on with the same parity."""

    return numbers.astype(np.int64) + 2**20
