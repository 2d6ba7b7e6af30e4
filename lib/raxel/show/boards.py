"""Targets in space: chessboards and monitors with what they show, sheets, polygons."""

import functools
from dataclasses import replace

import numpy as np

from raxel.geometry.poses import transform
from raxel.lab.textures import ChessboardTexture
from raxel.sets.model import ActiveGrid
from raxel.show.scene import CLEAR, Polyline, Surface

# Pixels of a board's picture along one square; a border that is no multiple of a square
# is met to the nearest of them.
TEXELS = 12
BACK, BACK_OPACITY = "#aeb6c0", 0.3
MONITOR_DARK, MONITOR_BRIGHT, MONITOR_CELLS = 40, 205, (16, 10)


def plate(T_frame_target, corner, size, **more):
    """A flat sheet: Surface from `corner` (2,) by `size` (2,), mm, in its plane z = 0.

    T_frame_target: (4, 4). Its front is seen from negative z, x right and y down.
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


def board(target, T_frame_target, border_mm=None, label="", colour=BACK):
    """A target of an image set or rig: its front, its rim, and a back to look through.

    target: Chessboard of known counts, or ActiveGrid; T_frame_target: (4, 4);
    border_mm: white margin of a chessboard, a pitch if not given; colour: of rim and
    back. A board of unknown pitch has squares of one unit. Returns three parts.
    """
    texture, corner, size = face(target, border_mm)
    front = plate(T_frame_target, corner, size, texture=texture, back=CLEAR)
    flat = front.points
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
    """Picture (h, w) or (h, w, 3), uint8, of a texture of the laboratory.

    texture: `raxel.lab` Texture; corner, size: (2,) of the piece shown, mm.
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
    """A coarse picture of a Gray code: what a monitor of an active grid looks like."""
    across, down = MONITOR_CELLS
    bright = (np.arange(down)[:, None] + np.arange(across)) // 2 % 2 == 0
    cells = np.where(bright, MONITOR_BRIGHT, MONITOR_DARK).astype(np.uint8)
    return np.kron(cells, np.ones((TEXELS, TEXELS), np.uint8))
