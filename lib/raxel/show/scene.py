"""Scenes: plain parts in one frame, lengths in mm.

A scene lists what is shown and the first viewpoint; `raxel.show.rendering` makes the
image of it and the page on which it turns. Rows with a value that is not finite are
excluded, so that an invalid ray needs no case of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from raxel.errors import InputError

# Back of a sheet: the colour of the front, or transparent.
SAME, CLEAR = "same", "clear"
# Width over height of a usual image.
ASPECT = 1.5


class SceneError(InputError):
    """Report a scene that cannot be shown; one line names the part and the problem."""


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight pieces from `starts` (N, 3) to `ends` (N, 3); `width` in px."""

    starts: ArrayLike
    ends: ArrayLike
    colour: str
    label: str = ""
    width: float = 2.0

    def __post_init__(self):
        _check_pairs(self)


@dataclass(frozen=True, eq=False)
class Arrows:
    """Straight pieces with a head at each of `ends` (N, 3); `width` in px."""

    starts: ArrayLike
    ends: ArrayLike
    colour: str
    label: str = ""
    width: float = 3.0

    def __post_init__(self):
        _check_pairs(self)


@dataclass(frozen=True, eq=False)
class Polyline:
    """A line through `points` (N, 3); `width` in px. A row of NaN breaks it."""

    points: ArrayLike
    colour: str
    label: str = ""
    width: float = 2.0

    def __post_init__(self):
        _check_shape(self, "points", 2)


@dataclass(frozen=True, eq=False)
class Points:
    """Balls at `points` (N, 3); `size` is their diameter in px."""

    points: ArrayLike
    colour: str
    label: str = ""
    size: float = 8.0

    def __post_init__(self):
        _check_shape(self, "points", 2)


@dataclass(frozen=True, eq=False)
class Labels:
    """Represent words next to `points` (N, 3), one of `texts` each.

    `size` of letters in px. They face the viewer and are never occluded.
    """

    points: ArrayLike
    texts: Sequence[str]
    colour: str
    label: str = ""
    size: float = 13.0

    def __post_init__(self):
        _check_shape(self, "points", 2)
        if len(self.points) != len(self.texts):
            _refuse(self, f"{len(self.points)} points, {len(self.texts)} texts")


@dataclass(frozen=True, eq=False)
class Surface:
    """Represent a sheet through a lattice of `points` (rows, columns, 3).

    `texture`, uint8 (h, w) or (h, w, 3), is stretched over the lattice: its first row
    is along the lattice's first row, its first column along the first column. On the
    front it has the orientation of the array, not mirrored. `back` is the colour of the
    other side, `SAME` for that of the front, or `CLEAR` for a transparent back.
    """

    points: ArrayLike
    colour: str = "#9aa5b1"
    opacity: float = 1.0
    label: str = ""
    texture: np.ndarray | None = None
    back: str = SAME

    def __post_init__(self):
        _check_shape(self, "points", 3)
        if not 0 < self.opacity <= 1:
            _refuse(self, f"opacity {self.opacity}, above 0 and at most 1 is needed")
        if self.texture is not None:
            _check_texture(self)


Part = Segments | Arrows | Polyline | Points | Labels | Surface


@dataclass(frozen=True, eq=False)
class Scene:
    """Hold parts in one frame, viewed first from `view_from` towards `look_at`.

    Rotation is about `look_at`; `up` stays upright (camera frames have y downwards,
    hence the default). `note` is the caption below the scene. Parts of one label are
    hidden together. An image whose width is less than `aspect` times its height has a
    wider angle of view, and so the same content. `raxel.show.framed` determines a view.
    """

    parts: Sequence[Part]
    view_from: ArrayLike
    look_at: ArrayLike
    up: ArrayLike = (0.0, -1.0, 0.0)
    note: str = ""
    aspect: float = ASPECT

    def __post_init__(self):
        if not self.parts:
            raise SceneError("Scene: no parts; add a part")
        for name in ("view_from", "look_at", "up"):
            given = np.asarray(getattr(self, name), dtype=float)
            if given.shape != (3,) or not np.isfinite(given).all():
                _refuse(
                    self, f"{name} is {given.tolist()}, three finite numbers needed"
                )
        sight = np.subtract(self.look_at, self.view_from).astype(float)
        across = np.linalg.norm(np.cross(sight, self.up))
        if across <= 1e-6 * np.linalg.norm(sight) * np.linalg.norm(self.up):
            _refuse(self, "view_from, look_at and up are collinear; move one of them")


def finite_points(part):
    """Return the finite points (N, 3) of any part."""
    if isinstance(part, (Segments, Arrows)):
        pairs = finite_pairs(part)
        return pairs.reshape(-1, 3)
    points = np.asarray(part.points, float).reshape(-1, 3)
    return points[np.isfinite(points).all(axis=1)]


def finite_pairs(part):
    """Starts and ends (N, 2, 3) of Segments or Arrows, both of them finite."""
    pairs = np.stack(
        [np.asarray(part.starts, float), np.asarray(part.ends, float)], axis=1
    )
    return pairs[np.isfinite(pairs).all(axis=(1, 2))]


def _check_pairs(part):
    _check_shape(part, "starts", 2)
    _check_shape(part, "ends", 2)
    if np.shape(part.starts) != np.shape(part.ends):
        _refuse(part, f"{len(part.starts)} starts, {len(part.ends)} ends")


def _check_shape(part, name, dimensions):
    shape = np.shape(getattr(part, name))
    if len(shape) != dimensions or shape[-1] != 3:
        wanted = "(rows, columns, 3)" if dimensions == 3 else "(N, 3)"
        _refuse(part, f"{name} has shape {shape}, {wanted} is needed")


def _check_texture(part):
    texture = np.asarray(part.texture)
    grey_or_rgb = texture.ndim == 2 or (texture.ndim == 3 and texture.shape[2] == 3)
    if texture.dtype != np.uint8 or not grey_or_rgb:
        _refuse(
            part,
            f"texture is {texture.dtype} {texture.shape}, uint8 (h, w) or (h, w, 3) "
            "is needed",
        )


def _refuse(part, what):
    name = type(part).__name__
    label = getattr(part, "label", "")
    raise SceneError(f"{name}{f' {label!r}' if label else ''}: {what}")
