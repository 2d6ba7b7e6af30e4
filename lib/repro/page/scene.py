"""3-D scenes that a reader can turn around: plain parts in one frame, lengths in mm.

A figure hands its scene over with the drawing (`repro.run.outcomes.Drawing.scene`);
the drawing stays the picture of the page, and `repro.page.scene_page` writes the scene
as a page of its own. Rows with a value that is not finite are left out, so that an
invalid ray needs no case of its own in a chapter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


class SceneError(ValueError):
    """A scene that cannot be drawn; one line says which part and what is wrong."""


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight pieces from ``starts`` (N, 3) to ``ends`` (N, 3); ``width`` in px."""

    starts: ArrayLike
    ends: ArrayLike
    colour: str
    label: str = ""
    width: float = 2.0

    def __post_init__(self) -> None:
        _shaped(self, "starts", 2)
        _shaped(self, "ends", 2)
        if np.shape(self.starts) != np.shape(self.ends):
            _refuse(self, f"{len(self.starts)} starts, {len(self.ends)} ends")


@dataclass(frozen=True, eq=False)
class Polyline:
    """A line through ``points`` (N, 3); ``width`` in px. A row of NaN breaks it."""

    points: ArrayLike
    colour: str
    label: str = ""
    width: float = 2.0

    def __post_init__(self) -> None:
        _shaped(self, "points", 2)


@dataclass(frozen=True, eq=False)
class Points:
    """Round dots at ``points`` (N, 3); ``size`` is their diameter in px."""

    points: ArrayLike
    colour: str
    label: str = ""
    size: float = 8.0

    def __post_init__(self) -> None:
        _shaped(self, "points", 2)


@dataclass(frozen=True, eq=False)
class Surface:
    """A sheet through a lattice of ``points`` (rows, columns, 3).

    ``texture``, uint8 (h, w) or (h, w, 3), is stretched over the lattice: its first row
    lies along the lattice's first row, its first column along the first column.
    """

    points: ArrayLike
    colour: str = "#9aa5b1"
    opacity: float = 1.0
    label: str = ""
    texture: np.ndarray | None = None

    def __post_init__(self) -> None:
        _shaped(self, "points", 3)
        if not 0 < self.opacity <= 1:
            _refuse(self, f"opacity {self.opacity}, above 0 and at most 1 is needed")
        if self.texture is not None:
            _textured(self)


Part = Segments | Polyline | Points | Surface


@dataclass(frozen=True, eq=False)
class Scene:
    """Parts in one frame, seen first from ``view_from`` towards ``look_at``.

    Turning goes about ``look_at``; ``up`` is what stays upright (camera frames have y
    downwards, hence the default). ``note`` says under the scene what to look for.
    """

    parts: Sequence[Part]
    view_from: ArrayLike
    look_at: ArrayLike
    up: ArrayLike = (0.0, -1.0, 0.0)
    note: str = ""

    def __post_init__(self) -> None:
        if not self.parts:
            raise SceneError("Scene: no parts; give it something to show")
        for name in ("view_from", "look_at", "up"):
            given = np.asarray(getattr(self, name), dtype=float)
            if given.shape != (3,) or not np.isfinite(given).all():
                _refuse(
                    self, f"{name} is {given.tolist()}, three finite numbers needed"
                )
        sight = np.subtract(self.look_at, self.view_from).astype(float)
        across = np.linalg.norm(np.cross(sight, self.up))
        if across <= 1e-6 * np.linalg.norm(sight) * np.linalg.norm(self.up):
            _refuse(self, "view_from, look_at and up lie on one line; move one of them")


def _shaped(part: Part, name: str, dimensions: int) -> None:
    shape = np.shape(getattr(part, name))
    if len(shape) != dimensions or shape[-1] != 3:
        wanted = "(rows, columns, 3)" if dimensions == 3 else "(N, 3)"
        _refuse(part, f"{name} has shape {shape}, {wanted} is needed")


def _textured(part: Surface) -> None:
    texture = np.asarray(part.texture)
    grey_or_rgb = texture.ndim == 2 or (texture.ndim == 3 and texture.shape[2] == 3)
    if texture.dtype != np.uint8 or not grey_or_rgb:
        _refuse(
            part,
            f"texture is {texture.dtype} {texture.shape}, uint8 (h, w) or (h, w, 3) "
            "is needed",
        )


def _refuse(part: object, what: str) -> None:
    name = type(part).__name__
    label = getattr(part, "label", "")
    raise SceneError(f"{name}{f' {label!r}' if label else ''}: {what}")
