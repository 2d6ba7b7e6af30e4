"""What an image set is in memory: target, views, files, all unchangeable."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from raxel.errors import InputError

DESCRIPTION = "set.yaml"


@dataclass(frozen=True)
class Chessboard:
    """A chessboard with `columns` x `rows` interior corners; None where unknown."""

    columns: int | None
    rows: int | None
    pitch_mm: float | None = None

    @property
    def unit(self):
        """The unit of `points`: 'mm', or 'pitch' where the pitch is unknown."""
        return "pitch" if self.pitch_mm is None else "mm"

    def points(self, columns=None, rows=None):
        """The corners on the board's plane, (rows * columns, 2) in `unit`.

        Row by row; x runs along the columns, y along the rows. `columns` and `rows`
        stand in where the board's own counts are unknown. Raises ValueError if
        neither is given.
        """
        columns, rows = self.columns or columns, self.rows or rows
        if columns is None or rows is None:
            raise ValueError("the board's columns and rows are unknown")
        y, x = np.mgrid[0:rows, 0:columns]
        return np.column_stack((x.ravel(), y.ravel())) * float(self.pitch_mm or 1)


@dataclass(frozen=True)
class Charuco(Chessboard):
    """A chessboard of known counts whose white squares carry ArUco markers.

    `dictionary` is one of OpenCV's, without DICT_; `marker_mm` the side of a marker;
    `legacy` for boards drawn as OpenCV did before version 4.6, which begin with a
    marker where their number of squares along a column is even.
    """

    dictionary: str = "4X4_50"
    marker_mm: float = 0.0
    legacy: bool = False

    @property
    def marker_count(self):
        """The number of markers on the board: one in each white square."""
        return (self.columns + 1) * (self.rows + 1) // 2


@dataclass(frozen=True)
class MonitorChessboard:
    """A chessboard that a monitor shows in the place of its patterns, in monitor px.

    `columns` x `rows` interior corners, squares `pitch_px` wide; the first corner is at
    `origin_px` (x, y) from the upper left corner of the lit area. The square before it
    is white, and so is what the squares leave free.
    """

    columns: int
    rows: int
    pitch_px: float
    origin_px: tuple[float, float]

    def points_px(self):
        """The corners, (rows * columns, 2) monitor px, row by row."""
        board = Chessboard(self.columns, self.rows, self.pitch_px)
        return self.origin_px + board.points()


@dataclass(frozen=True)
class ActiveGrid:
    """A monitor that shows coded patterns; sizes are (width, height).

    `chessboard`: what it shows beside them, in the same pose; None: nothing.
    """

    monitor_px: tuple[int, int]
    monitor_mm: tuple[float, float] | None = None
    chessboard: MonitorChessboard | None = None

    def chessboard_points(self):
        """The chessboard's corners, (rows * columns, 2), row by row: in mm, or in px of
        the monitor where its size in mm is unknown."""
        points = self.chessboard.points_px()
        if self.monitor_mm is None:
            return points
        return points * np.divide(self.monitor_mm, self.monitor_px)

    @property
    def unit(self):
        """The unit of decoded points: 'mm', or 'pitch' (of the monitor's pixels, which
        are taken for square) where the size in mm is unknown."""
        return "pitch" if self.monitor_mm is None else "mm"


@dataclass(frozen=True)
class Pattern:
    """One photograph of an active grid.

    `kind` 'gray' has `bit` (0 = most significant), `inverse` and `cell_px`, the width
    of a cell in monitor px (None: 2^of cells fill it); 'phase' has `step`, `periods`
    and `offset`, in periods: sin(2 pi (periods x / width + step / of + offset)), so
    that 0.25 is a cosine. `axis` is 'x' or 'y'.
    """

    image: str
    axis: str
    kind: str
    of: int
    bit: int | None = None
    inverse: bool = False
    step: int | None = None
    periods: float | None = None
    cell_px: float | None = None
    offset: float = 0.0


@dataclass(frozen=True)
class Motion:
    """Known motion of the stage since the first view, as its scales read."""

    translation_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class View:
    """One pose of the target: one `image` (chessboard) or `patterns` (active grid).

    `white`, `black`, `chessboard`: pictures of a monitor that shows these instead.

    `outer_corners` are four pixels (u, v), clockwise from the first corner; `contours`
    corners by hand, (name, ((u, v), ...)) pairs, where CELECT lost a contour.
    """

    image: str | None = None
    name: str | None = None
    white: str | None = None
    black: str | None = None
    chessboard: str | None = None
    patterns: tuple[Pattern, ...] = ()
    outer_corners: tuple[tuple[float, float], ...] | None = None
    contours: tuple[tuple[str, tuple[tuple[float, float], ...]], ...] = ()
    use: str = "calibrate"
    motion: Motion | None = None

    @property
    def label(self):
        """What people and results call this view: its image or its name."""
        return self.image or self.name

    @property
    def photograph(self):
        """The name of an image that shows the target: lit, if it is a monitor."""
        return self.image or self.white or self.patterns[0].image

    @property
    def files(self):
        """The names of all images of this view."""
        single = (self.image, self.white, self.black, self.chessboard)
        return tuple(f for f in single if f) + tuple(p.image for p in self.patterns)


@dataclass(frozen=True)
class ImageSet:
    """What set.yaml says. Names of files are relative to `folder`."""

    name: str
    width: int
    height: int
    target: Chessboard | ActiveGrid
    views: tuple[View, ...]
    folder: Path
    camera: str = ""
    origin: dict = field(default_factory=dict)
    reference: str | None = None
    truth: str | None = None

    @property
    def description(self):
        """The path of set.yaml, as messages name it."""
        return self.folder / DESCRIPTION

    def views_for(self, use):
        """The views for 'calibrate' or 'evaluate', in the order of the file."""
        return tuple(view for view in self.views if view.use == use)


# How sure is a corner? Its standard deviation, from the detector to the calibration.
# One rule for every `sd` beside corners (N, 2): an array (N,) in px, the standard
# deviation of the position along each axis (root mean square of both); NaN for a
# corner whose own nobody knows; 0 where the corner is true by construction; None in
# place of the array where nobody states any. It says what noise does and is no weight
# yet. In files it is a list of numbers and nulls, one number for all corners, or
# null.


def check_sd(where, sd, count):
    """`sd` as float64 (count,), all NaN for None. Raises InputError naming `where`."""
    if sd is None:
        return np.full(count, np.nan)
    sd = np.asarray(sd, float)
    if sd.shape != (count,) or (sd < 0).any():
        raise InputError(
            f"{where}: sd: found an array {sd.shape}; give one standard deviation for "
            f"each of {count} corners, px, not negative, NaN where it is unknown"
        )
    return sd


def sd_from_plain(where, value, count):
    """`sd` of `count` corners as a file gives it. Raises InputError naming `where`."""
    if value is None:
        return None
    values = value if isinstance(value, list) else [value] * count
    good = all(one is None or _is_spread(one) for one in values)
    if len(values) != count or not good:
        raise InputError(
            f"{where}: give one number for all corners, or a list of {count} numbers "
            "of 0 px or more, null where it is unknown"
        )
    return np.array(values, dtype=float)


def plain_sd(sd):
    """`sd` as a file takes it; not finite becomes null, as no file can hold it."""
    if sd is None:
        return None
    return [round(float(one), 6) if np.isfinite(one) else None for one in sd]


def _is_spread(value):
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return number and 0 <= value < 1e9


# What messages call a target and what is found on it.


class Words(NamedTuple):
    """target: what stands before the camera; point: what is found on it; found: what
    became of a view that can be used; images: what a view is; check: where to look when
    too few can."""

    target: str
    point: str
    found: str
    images: str
    check: str


BOARDS = Words(
    "board",
    "corner",
    "board found",
    "images",
    "check target.columns and target.rows, or try another --detector",
)
GRIDS = Words(
    "grid",
    "point",
    "grid decoded",
    "views",
    "check exposure and order of the pictures; raxel decode draws what each pixel sees",
)


def words_of(target):
    """The Words for a target of an image set."""
    return GRIDS if isinstance(target, ActiveGrid) else BOARDS
