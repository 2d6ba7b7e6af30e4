"""Viewpoint and scale of a scene, determined from its points."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from raxel.geometry.poses import transform
from raxel.lab.textures import ChessboardTexture
from raxel.sets.model import ActiveGrid, Chessboard
from raxel.show.scene import (
    ASPECT,
    CLEAR,
    Labels,
    Part,
    Polyline,
    Scene,
    SceneError,
    Segments,
    Surface,
    finite_points,
)

# Targets in space: chessboards and monitors with their patterns, sheets, polygons.


# Pixels of a board's image along one square; a border that is not a multiple of a
# square is met to the nearest of them.
TEXELS = 12
BACK, BACK_OPACITY = "#aeb6c0", 0.3
MONITOR_DARK, MONITOR_BRIGHT, MONITOR_CELLS = 40, 205, (16, 10)


def plate(
    T_frame_target: ArrayLike,
    corner: Sequence[float] | np.ndarray,
    size: Sequence[float] | np.ndarray,
    **more: Any,
) -> Surface:
    """Return a flat sheet in the plane z = 0 of a frame.

    The front is visible from negative z, with x right and y down.

    Parameters
    ----------
    T_frame_target : array_like of shape (4, 4)
        Pose of the sheet.
    corner : sequence of two floats
        Upper left corner, mm.
    size : sequence of two floats
        Width and height, mm.
    **more
        Arguments of `Surface`.

    Returns
    -------
    Surface
        The sheet.
    """
    x, y = np.meshgrid(*(corner[k] + np.array([0.0, size[k]]) for k in range(2)))
    flat = np.stack([x, y, np.zeros_like(x)], axis=-1)
    return Surface(transform(T_frame_target, flat), **more)


def polygon(points, **more):
    """A flat Surface inside a convex outline (n, 3), given in order."""
    points = np.asarray(points, float)
    ring = np.concatenate([points, points[:1]])
    middle = np.broadcast_to(points.mean(axis=0), ring.shape)
    return Surface(np.stack([ring, middle]), **more)


def board(
    target: Chessboard | ActiveGrid,
    T_frame_target: ArrayLike,
    border_mm: float | None = None,
    label: str = "",
    colour: str = BACK,
) -> list[Surface | Polyline]:
    """Return a target of an image set or rig: its front, edge and transparent back.

    A chessboard of unknown pitch has squares of one unit.

    Parameters
    ----------
    target : Chessboard or ActiveGrid
        Target; a chessboard of known counts.
    T_frame_target : array_like of shape (4, 4)
        Pose of the target.
    border_mm : float, optional
        White margin of a chessboard, mm. None: one pitch.
    label, colour : str
        Label, and colour (hexadecimal) of edge and back.

    Returns
    -------
    list
        Three parts.
    """
    texture, corner, size = face(target, border_mm)
    front = plate(T_frame_target, corner, size, texture=texture, back=CLEAR)
    flat = np.asarray(front.points)
    ring = np.stack([flat[0, 0], flat[0, 1], flat[1, 1], flat[1, 0], flat[0, 0]])
    return [
        replace(front, label=label, colour=colour),
        # The same sheet from the other side.
        Surface(flat[:, ::-1], colour, BACK_OPACITY, label, back=CLEAR),
        Polyline(ring, colour, label, 1.5),
    ]


@functools.lru_cache(maxsize=32)
def face(target, border_mm=None):
    """(texture, corner (2,), size (2,)) of a target's front in its plane, mm.

    Equal targets share one texture, which is then stored once.
    """
    if isinstance(target, ActiveGrid):
        size = target.monitor_mm or target.monitor_px
        return _stripes(), np.zeros(2), np.array(size, float)
    pitch = float(target.pitch_mm or 1)
    border = pitch if border_mm is None else border_mm
    squares = ChessboardTexture(target.columns, target.rows, pitch, border)
    corner, size = squares.extent
    return surface_texture(squares, corner, size, pitch / TEXELS), corner, size


def surface_texture(texture, corner, size, mm_per_px):
    """Return an image (h, w) or (h, w, 3), uint8, of a texture of the simulator.

    texture: `raxel.lab` Texture; corner, size: (2,) of the displayed part, mm.
    """
    shape = np.maximum(1, np.round(np.divide(size, mm_per_px)).astype(int))
    u, v = (
        corner[k] + size[k] * (np.arange(shape[k]) + 0.5) / shape[k] for k in range(2)
    )
    uv = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    radiance = texture.radiance(uv, np.ones(len(uv)))
    shown = np.clip(radiance, 0, 1) ** (1 / 2.2)
    pixels = np.round(255 * shown).astype(np.uint8)
    return pixels.reshape(shape[1], shape[0], *pixels.shape[1:])


def _stripes():
    """Return a coarse image of a Gray code for the monitor of an active grid."""
    across, down = MONITOR_CELLS
    bright = (np.arange(down)[:, None] + np.arange(across)) // 2 % 2 == 0
    cells = np.where(bright, MONITOR_BRIGHT, MONITOR_DARK).astype(np.uint8)
    return np.kron(cells, np.ones((TEXELS, TEXELS), np.uint8))


# Vertical angle of view of every image and page, degrees: VTK's and vtk.js's own.
VIEW_ANGLE_DEG = 30.0
# Height of the image, px, that sizes and widths of parts refer to.
NOMINAL_PX = 480
# Share of the image's height and width that the parts fill.
FILL_SHARE = 0.9
INK = "#1b1f24"
# View forward, slightly down and to the right: camera frames have y downwards, so the
# viewpoint is behind the camera, to its left and above, in front of the targets.
VIEW_DIRECTION = (0.62, 0.42, 0.66)
ROUND_LENGTHS = (1.0, 2.0, 5.0, 10.0)
# Distance of a scale bar below the parts, and of its label below the bar, in diagonals
# of the scene.
GAP, BELOW = 0.06, 0.06


def framed(
    parts: Sequence[Part],
    sight: ArrayLike = VIEW_DIRECTION,
    up: ArrayLike = (0.0, -1.0, 0.0),
    note: str = "",
    scale: str = "mm",
    aspect: float = ASPECT,
) -> Scene:
    """Return a scene of parts with a viewpoint that shows them whole.

    Parameters
    ----------
    parts : sequence of parts
        Parts in one frame.
    sight : array_like of shape (3,)
        Direction of view.
    up : array_like of shape (3,)
        Upright direction.
    note : str
        Text below the scene.
    scale : str
        Unit of a scale bar below the parts, '' for none.
    aspect : float
        Width over height of the image that is filled.

    Returns
    -------
    Scene
        Scene of the parts and the scale bar.

    Raises
    ------
    SceneError
        If no part has a finite point.

    Examples
    --------
    >>> from raxel.show import axes, framed
    >>> len(framed(axes(100.0), scale="").parts)
    6
    """
    parts = list(parts)
    finite = [finite_points(part) for part in parts]
    points = np.concatenate(finite) if finite else np.empty((0, 3))
    if not len(points):
        raise SceneError("Scene: no part has a finite point; check the parts")
    axes = view_axes(sight, up)
    if scale:
        bar = scale_bar(points, axes, scale)
        parts += bar
        points = np.concatenate([points, *map(finite_points, bar)])
    look_at, distance = _fitted(points @ axes.T, aspect)
    look_at = look_at @ axes
    return Scene(parts, look_at - distance * axes[2], look_at, up, note, aspect)


def view_axes(sight, up):
    """Rows right, down and ahead (3, 3) of a view along `sight` with `up` upright."""
    ahead = np.asarray(sight, float) / np.linalg.norm(sight)
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(ahead, right), ahead])


def _fitted(seen, aspect):
    """Return (look_at (3,), distance) for points (N, 3) in the axes of the view.

    Each point is inside both pairs of planes of the view's pyramid: for a pair,
    |x - c| <= t (z - e) with c, e the eye across and along, so the two planes that
    touch the points from outside give c and the greatest e.
    """
    half = FILL_SHARE * np.tan(np.radians(VIEW_ANGLE_DEG / 2))
    x, y, z = seen.T
    middles, eyes = [], []
    for across, slope in ((x, half * aspect), (y, half)):
        low, high = (across + slope * z).min(), (across - slope * z).max()
        middles.append((low + high) / 2)
        eyes.append((low - high) / (2 * slope))
    eye, deep = min(eyes), (z.min() + z.max()) / 2
    # A single point has no size: it is viewed from 1 mm.
    return np.array([*middles, deep]), (deep - eye) or 1.0


def mm_per_px(scene):
    """Length that one px of a nominal image has at the distance of `look_at`."""
    distance = np.linalg.norm(np.subtract(scene.look_at, scene.view_from))
    return 2 * distance * np.tan(np.radians(VIEW_ANGLE_DEG / 2)) / NOMINAL_PX


def view_angle_deg(scene, width, height):
    """Return the vertical angle of view of an image, wider for narrow images.

    Points that are visible at the scene's aspect are visible at any other one.
    """
    half = np.tan(np.radians(VIEW_ANGLE_DEG / 2))
    return 2 * np.degrees(np.arctan(half * max(1.0, scene.aspect * height / width)))


def projected(scene, points, width, height):
    """Return pixels (N, 2) of points (N, 3) in an image; NaN behind the viewpoint.

    width, height: of the image, px; pixel centres are at integers.
    """
    axes = view_axes(np.subtract(scene.look_at, scene.view_from), scene.up)
    x, y, z = axes @ np.subtract(points, scene.view_from).astype(float).T
    focal = height / 2 / np.tan(np.radians(view_angle_deg(scene, width, height) / 2))
    z = np.where(z > 0, z, np.nan)
    return np.column_stack(
        [focal * x / z + (width - 1) / 2, focal * y / z + (height - 1) / 2]
    )


def scale_bar(points, axes, unit):
    """Return a bar of a round length below points (N, 3), with its length as a label.

    It is parallel to the axis of the frame that is most perpendicular to the view, at
    the nearest edge of the points' box, below all points in the view.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    length = round_below(np.linalg.norm(high - low) / 4)
    if not length > 0:
        return []
    along = int(np.argmax(np.abs(axes[0])))
    corner = np.where(axes[1] - 0.5 * axes[2] > 0, high, low)
    corner[along] = (low[along] + high[along] - length) / 2
    # Perpendicular to the bar in the view, and downwards.
    across = np.cross(axes[2], np.eye(3)[along])
    across *= np.sign(across @ axes[1]) / np.linalg.norm(across)
    lowest = (points @ across).max() + GAP * np.linalg.norm(high - low)
    corner += (lowest - corner @ across) / (axes[1] @ across) * axes[1]
    end = corner.copy()
    end[along] += length
    # Ticks perpendicular to the bar mark its ends.
    tick = 0.06 * length * np.eye(3)[int(np.argmax(np.abs(axes[1])))]
    starts = np.stack([corner, corner - tick, end - tick])
    ends = np.stack([end, corner + tick, end + tick])
    below = (corner + end) / 2 + BELOW * np.linalg.norm(high - low) * axes[1]
    return [
        Segments(starts, ends, INK, width=2.5),
        Labels(below[None], [_length_text(length, unit)], INK),
    ]


def _length_text(length, unit):
    """Return a length as text; in metres if millimetres have four digits."""
    whole = unit == "mm" and length >= 1000
    return f"{length / 1000:g} m" if whole else f"{length:g} {unit}"


def round_below(length):
    """The largest of 1, 2, 5 times a power of ten that is not above `length`."""
    if not 0 < length < np.inf:
        return 0.0
    power = 10.0 ** np.floor(np.log10(length))
    return max(
        power * step for step in ROUND_LENGTHS if power * step <= length * (1 + 1e-12)
    )
