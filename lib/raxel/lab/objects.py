"""A chessboard with a circle.

Its corners give the pose; the circle shows the remaining distortion (5.3.4, Fig. 5.14).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.errors import InputError
from raxel.lab.scene import TexturedScene
from raxel.lab.surfaces import Rectangle
from raxel.lab.textures import (
    ChessboardTexture,
    RegionTexture,
    colour_table,
    share_beyond,
)
from raxel.sets.model import Chessboard


class BoardRing(NamedTuple):
    """A circular line in the plane of a board, in the board's frame.

    Attributes
    ----------
    centre : (float, float)
        Centre, mm.
    radius : float
        Radius of the line's middle, mm.
    line : float
        Width of the line, mm.
    margin : float
        Width of the white on either side, mm; it separates line and squares.
    """

    centre: tuple
    radius: float
    line: float = 4.0
    margin: float = 3.0

    @property
    def edges(self) -> tuple[float, float]:
        """Radii of the line's inner and outer edge, mm."""
        return self.radius - self.line / 2, self.radius + self.line / 2


class RingedChessboard(RegionTexture):
    """Represent a `ChessboardTexture` with a dark `BoardRing` on white over it.

    Both greys are those of the board. Raises InputError for a ring without a width, or
    without room inside.
    """

    averages = True

    def __init__(self, board, ring, light=None):
        widths = ring.line, ring.margin, ring.edges[0] - ring.margin
        if not min(widths) > 0:
            raise InputError(
                f"ring: radius {ring.radius}, line {ring.line} and margin "
                f"{ring.margin} are invalid; give widths that leave room inside"
            )
        self.board, self.ring, self.light = board, ring, light
        inner, outer = ring.edges
        self.radii = np.array([inner - ring.margin, inner, outer, outer + ring.margin])
        tone = board.colours.reshape(len(board.colours), -1).mean(axis=1)
        white, black = board.colours[np.argmax(tone)], board.colours[np.argmin(tone)]
        self.tones = white, black, white
        self.colours = colour_table(*board.colours, *self.tones)

    def label(self, uv):
        """The board's cell, or one of the three parts of the ring."""
        part = np.searchsorted(self.radii, self._polar(uv)[0])
        ring = len(self.board.colours) + part - 1
        return np.where(part % 4 == 0, self.board.label(uv), ring)

    def average(self, uv, across, down, cosine):
        """Return exact means but for the circle's curvature within a footprint.

        NaN unless one edge of the line, or no edge of the ring, crosses the footprint.
        """
        distance_direction, outward = self._polar(uv)
        a, b = np.sum(across * outward, axis=1), np.sum(down * outward, axis=1)
        reach = (np.abs(a) + np.abs(b)) / 2
        low = np.searchsorted(self.radii, distance_direction - reach)
        high = np.searchsorted(self.radii, distance_direction + reach)
        off_ring = (low == high) & (low % 4 == 0)
        found = self.board.average(uv, across, down, cosine)
        known = (low >= 1) & (high <= 3) & (high - low <= 1)
        tones = colour_table(*self.tones)
        first, last = np.clip(low - 1, 0, 2), np.clip(high - 1, 0, 2)
        share = share_beyond(distance_direction - self.radii[np.clip(low, 0, 3)], a, b)
        share = np.where(low == high, 0.0, share).reshape(-1, *(1,) * (tones.ndim - 1))
        mixed = self.lit((1 - share) * tones[first] + share * tones[last], uv)
        rest = (slice(None),) + (None,) * (tones.ndim - 1)
        found = np.where(off_ring[rest], found, np.nan)
        return np.where(known[rest], mixed, found)

    def _polar(self, uv):
        """Return the distance (N,) from the ring's centre, and the direction (N, 2)."""
        deviation = np.asarray(uv, float) - self.ring.centre
        distance_direction = np.hypot(deviation[:, 0], deviation[:, 1])
        return distance_direction, deviation / np.maximum(distance_direction, 1e-300)[
            :, None
        ]


def ringed_board_scene(
    chessboard: Chessboard,
    ring: BoardRing,
    T_world_target: ArrayLike,
    border_mm: float | None = None,
    black: float = 0.05,
    white: float = 0.9,
    background: float = 0.4,
    light: Callable[[np.ndarray], np.ndarray] | None = None,
) -> TexturedScene:
    """Return a chessboard with a circle over it, in front of an even background.

    Parameters
    ----------
    chessboard : Chessboard
        Corners and pitch.
    ring : BoardRing
        The circle, in the board's frame.
    T_world_target, border_mm, black, white, background, light
        As in `raxel.lab.board_scene`.

    Returns
    -------
    TexturedScene
        One part: the sheet.

    Raises
    ------
    InputError
        For a ring without a width, or whose widths leave no room inside.

    References
    ----------
    Thesis 5.3.4, Fig. 5.14.
    """
    pitch = float(chessboard.pitch_mm or 1)
    border = pitch if border_mm is None else border_mm
    board = ChessboardTexture(
        chessboard.columns, chessboard.rows, pitch, border, black, white, light
    )
    corner, size = board.extent
    sheet = Rectangle(T_world_target, *size, corner)  # type: ignore[call-arg]
    return TexturedScene(((sheet, RingedChessboard(board, ring, light)),), background)
