"""Image sets in memory: target, views and files, all immutable."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError

DESCRIPTION = "set.yaml"


@dataclass(frozen=True)
class Chessboard:
    """Describe a chessboard by its interior corners.

    Attributes
    ----------
    columns, rows : int or None
        Number of interior corners along each direction; None where unknown.
    pitch_mm : float or None
        Side of a square, mm; None where unknown.

    Examples
    --------
    >>> from raxel.sets import Chessboard
    >>> board = Chessboard(columns=3, rows=2, pitch_mm=20.0)
    >>> board.points().tolist()
    [[0.0, 0.0], [20.0, 0.0], [40.0, 0.0], [0.0, 20.0], [20.0, 20.0], [40.0, 20.0]]
    >>> board.unit
    'mm'
    """

    columns: int | None
    rows: int | None
    pitch_mm: float | None = None

    @property
    def unit(self) -> str:
        """Return the unit of `points`: 'mm', or 'pitch' where the pitch is unknown."""
        return "pitch" if self.pitch_mm is None else "mm"

    def points(
        self, columns: int | None = None, rows: int | None = None
    ) -> NDArray[np.float64]:
        """Return the corners on the plane of the chessboard.

        The order is row by row; x runs along the columns, y along the rows.

        Parameters
        ----------
        columns, rows : int or None
            Counts that apply where those of the chessboard are unknown.

        Returns
        -------
        ndarray, shape (rows * columns, 2)
            Corners in `unit`.

        Raises
        ------
        ValueError
            If neither source gives the counts.
        """
        columns, rows = self.columns or columns, self.rows or rows
        if columns is None or rows is None:
            raise ValueError("columns and rows of the board are unknown; give both")
        y, x = np.mgrid[0:rows, 0:columns]
        return np.column_stack((x.ravel(), y.ravel())) * float(self.pitch_mm or 1)


@dataclass(frozen=True)
class Charuco(Chessboard):
    """Describe a chessboard whose white squares carry ArUco markers.

    The counts of corners are known.

    Attributes
    ----------
    dictionary : str
        Name of a dictionary of OpenCV, without ``DICT_``.
    marker_mm : float
        Side of a marker, mm.
    legacy : bool
        Whether the board is drawn as OpenCV did before version 4.6. Such boards begin
        with a marker where their number of squares along a column is even.

    Examples
    --------
    >>> from raxel.sets import Charuco
    >>> Charuco(columns=4, rows=3, pitch_mm=20.0, marker_mm=15.0).marker_count
    10
    """

    dictionary: str = "4X4_50"
    marker_mm: float = 0.0
    legacy: bool = False

    @property
    def marker_count(self) -> int:
        """Return the number of markers on the board: one in each white square."""
        return (self.columns + 1) * (self.rows + 1) // 2  # type: ignore[operator]


@dataclass(frozen=True)
class AprilGrid(Chessboard):
    """Describe a grid of AprilTags with black squares at their corners, as of Kalibr.

    The lattice is that of the corners of the tags, row by row from the upper left one.
    The numbers of tags count from `first_id` at the lower left tag along its row, then
    upwards.

    Attributes
    ----------
    columns, rows : int
        Numbers of corners along each direction: twice those of tags.
    pitch_mm : float
        Distance between the same corner of neighbouring tags, mm.
    tag_mm : float
        Side of a tag with its black border, mm.
    family : str
        Family of the tags: 16h5, 25h9, 36h10 or 36h11.
    first_id : int
        Number of the lower left tag.

    Examples
    --------
    >>> from raxel.sets import AprilGrid
    >>> AprilGrid(columns=4, rows=2, pitch_mm=13.0, tag_mm=10.0).points()[:, 0].tolist()
    [0.0, 10.0, 13.0, 23.0, 0.0, 10.0, 13.0, 23.0]
    """

    tag_mm: float = 0.0
    family: str = "36h11"
    first_id: int = 0

    @property
    def tags(self) -> tuple[int, int]:
        """Return the numbers of tags along a row and a column."""
        return self.columns // 2, self.rows // 2  # type: ignore[operator]

    def points(
        self, columns: int | None = None, rows: int | None = None
    ) -> NDArray[np.float64]:
        """Return the corners of the tags in mm, as `Chessboard.points`."""
        cell, part = np.divmod(Chessboard(self.columns, self.rows).points(), 2)
        return cell * float(self.pitch_mm or 1) + part * self.tag_mm


@dataclass(frozen=True)
class CircleGrid(Chessboard):
    """Describe a grid of circles.

    Attributes
    ----------
    columns, rows : int
        Numbers of circles along each direction.
    pitch_mm : float or None
        Distance between neighbouring rows, mm; None where unknown.
    staggered : bool
        Whether circles of a row are two pitches apart, and every second row is shifted
        by one pitch: OpenCV's asymmetric grid.

    Examples
    --------
    >>> from raxel.sets import CircleGrid
    >>> CircleGrid(2, 2, 10.0, staggered=True).points().tolist()
    [[0.0, 0.0], [20.0, 0.0], [10.0, 10.0], [30.0, 10.0]]
    """

    staggered: bool = False

    def points(
        self, columns: int | None = None, rows: int | None = None
    ) -> NDArray[np.float64]:
        """Return the centres of the circles, as `Chessboard.points`."""
        x, y = Chessboard(self.columns, self.rows).points(columns, rows).T
        if self.staggered:
            x = 2 * x + y % 2
        return np.column_stack([x, y]) * float(self.pitch_mm or 1)


@dataclass(frozen=True)
class MonitorChessboard:
    """Describe a chessboard that a monitor shows in place of its patterns.

    Lengths are in px of the monitor. The square before the first corner is white. So is
    the area that the squares leave free.

    Attributes
    ----------
    columns, rows : int
        Number of interior corners along each direction.
    pitch_px : float
        Side of a square, monitor px.
    origin_px : tuple of float
        First corner (x, y) from the upper left corner of the lit area, monitor px.
    """

    columns: int
    rows: int
    pitch_px: float
    origin_px: tuple[float, float]

    def points_px(self) -> NDArray[np.float64]:
        """Return the corners, (rows * columns, 2) in monitor px, row by row."""
        board = Chessboard(self.columns, self.rows, self.pitch_px)
        return self.origin_px + board.points()


@dataclass(frozen=True)
class ActiveGrid:
    """Describe a monitor that shows coded patterns; sizes are (width, height).

    Attributes
    ----------
    monitor_px : tuple of int
        Size of the lit area, px.
    monitor_mm : tuple of float or None
        Size of the lit area, mm; None where unknown.
    chessboard : MonitorChessboard or None
        Chessboard that the monitor shows in addition, in the same pose; None if none.

    Examples
    --------
    >>> from raxel.sets import ActiveGrid
    >>> ActiveGrid((1920, 1080), (480.0, 270.0)).unit
    'mm'
    >>> ActiveGrid((1920, 1080)).unit
    'pitch'
    """

    monitor_px: tuple[int, int]
    monitor_mm: tuple[float, float] | None = None
    chessboard: MonitorChessboard | None = None

    def chessboard_points(self) -> NDArray[np.float64]:
        """Return the corners of the chessboard, row by row.

        Returns
        -------
        ndarray, shape (rows * columns, 2)
            Corners in mm, or in px of the monitor where its size in mm is unknown.
        """
        points = self.chessboard.points_px()  # type: ignore[union-attr]
        if self.monitor_mm is None:
            return points
        return points * np.divide(self.monitor_mm, self.monitor_px)

    @property
    def unit(self) -> str:
        """Return the unit of decoded points: 'mm', or 'pitch' if unknown.

        The pitch is that of the monitor's pixels, assumed to be square, where the size
        in mm is unknown.
        """
        return "pitch" if self.monitor_mm is None else "mm"


@dataclass(frozen=True)
class Pattern:
    """Describe one image of an active grid.

    A phase pattern shows ``sin(2 pi (periods x / width + step / of + offset))``.

    Attributes
    ----------
    image : str
        Name of the image file.
    axis : str
        'x' or 'y'.
    kind : str
        'gray' (with `bit`, `inverse`, `cell_px`) or 'phase' (with `step`, `periods`,
        `offset`).
    of : int
        Number of bits or of phase steps.
    bit : int or None
        Bit of the Gray code, 0 = most significant.
    inverse : bool
        Whether black and white are exchanged.
    step : int or None
        Number of the phase step.
    periods : float or None
        Sinusoidal periods across the monitor.
    cell_px : float or None
        Width of a cell of the Gray code, monitor px. None: 2^of cells fill the monitor.
    offset : float
        Phase of the first step in periods; 0.25 gives a cosine.
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
    """Describe the known motion of the stage since the first view, from its scales.

    Attributes
    ----------
    translation_mm : tuple of float
        Translation, mm.
    rotation_deg : tuple of float
        Rotation, degrees.
    """

    translation_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class View:
    """Describe one pose of the target.

    Attributes
    ----------
    image : str or None
        Image of a chessboard.
    name : str or None
        Name of a view of an active grid.
    white, black, chessboard : str or None
        Images of a monitor that shows these instead of its patterns.
    patterns : tuple of Pattern
        Images of an active grid.
    outer_corners : tuple or None
        Four pixels (u, v), clockwise from the first corner.
    contours : tuple
        Corners picked by hand where CELECT lost a contour: pairs ``(name, ((u, v),
        ...))``.
    use : str
        'calibrate' or 'evaluate'.
    motion : Motion or None
        Known motion of the stage; None where unknown.
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
    def label(self) -> str:
        """Return the name of this view in messages: its image or its name."""
        return self.image or self.name  # type: ignore[return-value]

    @property
    def main_image(self) -> str:
        """Return the name of an image that shows the target: lit for a monitor."""
        return self.image or self.white or self.patterns[0].image

    @property
    def files(self) -> tuple[str, ...]:
        """Return the names of all images of this view."""
        single = (self.image, self.white, self.black, self.chessboard)
        return tuple(f for f in single if f) + tuple(p.image for p in self.patterns)


@dataclass(frozen=True)
class ImageSet:
    """Hold the content of set.yaml. Names of files are relative to `folder`.

    Attributes
    ----------
    name : str
        Name of the set.
    width, height : int
        Size of its images, px.
    target : Chessboard or ActiveGrid
        What the images show.
    views : tuple of View
        Poses of the target, in the order of the file.
    folder : Path
        Folder of the images.
    camera : str
        Description of the camera.
    origin : dict
        Source of the images.
    reference : str or None
        File of reference corners.
    truth : str or None
        Folder of the truth of a rendered set.
    described_in : Path or None
        The set.yaml, or the folder of a set without one; None: set.yaml in `folder`.
    unused : tuple of (str, str)
        Images of the folder that are no views, each with the reason.
    """

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
    described_in: Path | None = None
    unused: tuple[tuple[str, str], ...] = ()

    @property
    def description(self) -> Path:
        """Return the path of set.yaml, as messages name it."""
        return self.described_in or self.folder / DESCRIPTION

    def views_for(self, use: str) -> tuple[View, ...]:
        """Return the views for one use, in the order of the file.

        Parameters
        ----------
        use : {'calibrate', 'evaluate'}
            The use.

        Returns
        -------
        tuple of View
            The views.
        """
        return tuple(view for view in self.views if view.use == use)


# Standard deviations of corners, from the detector to the calibration. One rule for
# every `sd` of corners (N, 2): an array (N,) in px, the standard deviation of the
# position along each axis (root mean square of both); NaN where it is unknown; 0 where
# the corner is exact by construction; None in place of the array without any. It
# describes noise and is not a weight. In files it is a list of numbers and nulls, one
# number for all corners, or null.


def check_sd(where: object, sd: ArrayLike | None, count: int) -> NDArray[np.float64]:
    """Return standard deviations as float64 (count,), all NaN for None.

    Parameters
    ----------
    where : object
        What messages name as the source.
    sd : array_like, shape (count,), or None
        Standard deviation of each corner, px; NaN where unknown.
    count : int
        Number of corners.

    Returns
    -------
    ndarray, shape (count,)
        Standard deviations, px.

    Raises
    ------
    InputError
        If the shape differs or a value is negative. The message names `where`.
    """
    if sd is None:
        return np.full(count, np.nan)
    sd = np.asarray(sd, float)
    if sd.shape != (count,) or (sd < 0).any():
        raise InputError(
            f"{where}: sd: array {sd.shape} or a negative value; give {count} standard "
            "deviations in px, one per corner, NaN where unknown"
        )
    return sd


def sd_from_plain(
    where: object, value: object, count: int
) -> NDArray[np.float64] | None:
    """Return the standard deviations of `count` corners from the content of a file.

    Parameters
    ----------
    where : object
        What messages name as the source.
    value : list, float or None
        One number for all corners, or a list of numbers and None, px.
    count : int
        Number of corners.

    Returns
    -------
    ndarray, shape (count,), or None
        Standard deviations, px; NaN where unknown; None where the file has none.

    Raises
    ------
    InputError
        If `value` has another form. The message names `where`.
    """
    if value is None:
        return None
    values = value if isinstance(value, list) else [value] * count
    good = all(one is None or _is_spread(one) for one in values)
    if len(values) != count or not good:
        raise InputError(
            f"{where}: invalid standard deviations; give one number in px, or a list "
            f"of {count}, null where unknown"
        )
    return np.array(values, dtype=float)


def plain_sd(sd: Iterable[float] | None) -> list[float | None] | None:
    """Return standard deviations as a file holds them.

    A value that is not finite becomes null, as no file can hold it.

    Parameters
    ----------
    sd : iterable of float, or None
        Standard deviations, px.

    Returns
    -------
    list or None
        Numbers rounded to 1e-6 px, and None.
    """
    if sd is None:
        return None
    return [round(float(one), 6) if np.isfinite(one) else None for one in sd]


def _is_spread(value):
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return number and 0 <= value < 1e9


# Words of messages for a target and its detected points.


class Words(NamedTuple):
    """Hold the words of messages for a kind of target.

    target: its name; point: of a detected point; found: state of a usable view; images:
    of several views; check: what to do if too few views are usable.
    """

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
MARKED_BOARDS = BOARDS._replace(
    check="check target.dictionary, columns, rows and legacy"
)
TAG_GRIDS = BOARDS._replace(check="check target.family, columns, rows and first_id")
CIRCLE_GRIDS = BOARDS._replace(
    point="circle", check="check target.columns, rows and staggered"
)
GRIDS = Words(
    "grid",
    "point",
    "grid decoded",
    "views",
    "check exposure and order of the images (raxel decode plots the positions)",
)

WORDS = {
    ActiveGrid: GRIDS,
    Charuco: MARKED_BOARDS,
    AprilGrid: TAG_GRIDS,
    CircleGrid: CIRCLE_GRIDS,
    Chessboard: BOARDS,
}


def words_of(target: Chessboard | ActiveGrid) -> Words:
    """Return the Words for a target of an image set."""
    return WORDS[type(target)]
