"""Chessboards bent at random: pictures without any camera behind them.

Board coordinates are smooth functions of the pixel: a row is moved along itself by a
wave that depends on where it is, and so is a column. Their corners are solved for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from chapters.shared.lattices import outer

SIZE_PX = 720
SQUARE_PX = 60.0
CORNERS = 7
SLOPES = (0.2, 0.8)
WAVELENGTHS = (4.0, 9.0)
SAMPLES = 4


@dataclass(frozen=True)
class BentBoard:
    """A board of 7 x 7 corners with squares of 60 px before it is bent.

    slopes: (2,) largest slope of either wave, below 1 so that nothing folds;
    wavelengths: (2,) in squares; phases: (2,) in radians.
    """

    slopes: tuple[float, float]
    wavelengths: tuple[float, float]
    phases: tuple[float, float]

    columns = rows = CORNERS

    def _shift(self, across):
        """How far points (..., 2) are moved, by where they are across, in squares."""
        number = 2 * math.pi / np.array(self.wavelengths)
        wave = np.sin(across * number + self.phases)
        return wave * self.slopes / number

    @property
    def corners(self):
        """True corners (49, 2) px, row by row."""
        lattice = np.indices((CORNERS, CORNERS)).reshape(2, -1).T[:, ::-1]
        wanted = lattice - (CORNERS - 1) / 2
        at = wanted.copy()
        # A wave moves a point by less than its slope times the other's move.
        for _ in range(200):
            at = wanted - self._shift(at[:, ::-1])
        return at * SQUARE_PX + (SIZE_PX - 1) / 2

    @property
    def lattice(self):
        """The true corners as (7, 7, 2)."""
        return self.corners.reshape(CORNERS, CORNERS, 2)

    @property
    def outer_corners(self):
        """True outer corners (4, 2), clockwise from the upper left."""
        return outer(self.lattice)

    def image(self, blur_px, noise_sd, rng):
        """The picture, uint8 (720, 720): black beyond a ring of squares."""
        fine = (np.arange(SIZE_PX * SAMPLES) + 0.5) / SAMPLES - SIZE_PX / 2
        place = (fine / SQUARE_PX).astype(np.float32)
        shift = self._shift(np.stack((place, place), axis=-1))
        x = place[None] + shift[:, 0].astype(np.float32)[:, None]
        y = place[:, None] + shift[:, 1].astype(np.float32)[None]
        half = (CORNERS + 1) / 2
        on_board = (np.abs(x) < half) & (np.abs(y) < half)
        x, y = np.floor(x + half), np.floor(y + half)
        white = on_board & ((x + y) % 2 == 0)
        grey = 255 * cv2.resize(
            white.astype(np.float32), (SIZE_PX, SIZE_PX), interpolation=cv2.INTER_AREA
        )
        if blur_px:
            grey = cv2.GaussianBlur(grey, (0, 0), blur_px)
        grey = grey + rng.normal(0.0, noise_sd, grey.shape)
        return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def bent_at_random(rng):
    """A BentBoard with both waves drawn from their ranges."""
    return BentBoard(
        tuple(rng.uniform(*SLOPES, 2)),
        tuple(rng.uniform(*WAVELENGTHS, 2)),
        tuple(rng.uniform(0, 2 * math.pi, 2)),
    )
