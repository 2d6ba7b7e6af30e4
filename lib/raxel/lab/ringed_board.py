"""A chessboard with a circle drawn over it: its corners tell the pose, the circle what
is left of distortion (5.3.4, Fig. 5.14)."""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.lab.scene import TexturedScene
from raxel.lab.surfaces import Rectangle
from raxel.lab.textures import (
    ChessboardTexture,
    RegionTexture,
    colour_table,
    share_beyond,
)


class BoardRing(NamedTuple):
    """A circular line in the plane of a board, mm, in the board's frame.

    centre: (2,); radius: of the line's middle; line: its width; margin: width of the
    white on either side, which keeps it apart from the squares.
    """

    centre: tuple
    radius: float
    line: float = 4.0
    margin: float = 3.0

    @property
    def edges(self):
        """Radii of the line's inner and outer edge."""
        return self.radius - self.line / 2, self.radius + self.line / 2


class RingedChessboard(RegionTexture):
    """A `ChessboardTexture` with a dark `BoardRing` on white over it.

    Both greys are the board's. Raises InputError for a ring without a width, or whose
    widths leave no room inside.
    """

    averages = True

    def __init__(self, board, ring, light=None):
        widths = ring.line, ring.margin, ring.edges[0] - ring.margin
        if not min(widths) > 0:
            raise InputError(
                f"ring: found radius {ring.radius}, line {ring.line} and margin "
                f"{ring.margin}; give widths that leave room inside"
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
        part = np.searchsorted(self.radii, self._apart(uv)[0])
        ring = len(self.board.colours) + part - 1
        return np.where(part % 4 == 0, self.board.label(uv), ring)

    def average(self, uv, across, down, cosine):
        """Exact but for the circle's bend inside a footprint where one edge of the
        line, or none of the ring's, crosses it; else NaN."""
        apart, outward = self._apart(uv)
        a, b = np.sum(across * outward, axis=1), np.sum(down * outward, axis=1)
        reach = (np.abs(a) + np.abs(b)) / 2
        low = np.searchsorted(self.radii, apart - reach)
        high = np.searchsorted(self.radii, apart + reach)
        off_ring = (low == high) & (low % 4 == 0)
        found = self.board.average(uv, across, down, cosine)
        known = (low >= 1) & (high <= 3) & (high - low <= 1)
        tones = colour_table(*self.tones)
        first, last = np.clip(low - 1, 0, 2), np.clip(high - 1, 0, 2)
        share = share_beyond(apart - self.radii[np.clip(low, 0, 3)], a, b)
        share = np.where(low == high, 0.0, share).reshape(-1, *(1,) * (tones.ndim - 1))
        mixed = self.lit((1 - share) * tones[first] + share * tones[last], uv)
        rest = (slice(None),) + (None,) * (tones.ndim - 1)
        found = np.where(off_ring[rest], found, np.nan)
        return np.where(known[rest], mixed, found)

    def _apart(self, uv):
        """Distance (N,) from the ring's centre, and the direction (N, 2) from there."""
        off = np.asarray(uv, float) - self.ring.centre
        apart = np.hypot(off[:, 0], off[:, 1])
        return apart, off / np.maximum(apart, 1e-300)[:, None]


def ringed_board_scene(
    chessboard,
    ring,
    T_world_target,
    border_mm=None,
    black=0.05,
    white=0.9,
    background=0.4,
    light=None,
):
    """As `raxel.lab.board_scene`, with a `BoardRing` over the board."""
    pitch = float(chessboard.pitch_mm or 1)
    border = pitch if border_mm is None else border_mm
    board = ChessboardTexture(
        chessboard.columns, chessboard.rows, pitch, border, black, white, light
    )
    corner, size = board.extent
    sheet = Rectangle(T_world_target, *size, corner)
    return TexturedScene(((sheet, RingedChessboard(board, ring, light)),), background)
