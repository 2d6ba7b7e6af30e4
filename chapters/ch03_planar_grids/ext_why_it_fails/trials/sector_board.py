"""A chessboard bent into a sector of a ring, drawn so that its bends are known.

A curved mirror shows a board like this: its rows become arcs, its columns radii. Arc,
growth of the squares and bow of the columns are free, so that each thing that CELECT
stumbles over can be had alone. Lattice coordinates: x along the rows, y from the outer
arc inwards, 0 at the first corner, 1 per square.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

SAMPLES = 4
WHITE, BLACK = 255.0, 0.0
# An odd number: the parity of a square is that of x + PERIOD y.
PERIOD = 1001
BEYOND = 1e9


@dataclass(frozen=True)
class SectorBoard:
    """A board on a ring's sector, in a square picture.

    radius_px: of the outermost row; depth_px: from there to the innermost; arc_deg:
    from the first column to the last. growth: size of the innermost square over the
    outermost, along a column. bow_deg: how far the middle of a column is turned
    about the ring's centre. ring: how many squares the pattern goes on beyond the
    outermost corners; surround: grey level beyond. turn_deg, shift_px: of the whole.
    """

    columns: int = 9
    rows: int = 6
    arc_deg: float = 60.0
    radius_px: float = 450.0
    depth_px: float = 200.0
    growth: float = 1.0
    bow_deg: float = 0.0
    ring: float = 1.0
    surround: float = 127.0
    turn_deg: float = 0.0
    shift_px: tuple[float, float] = (0.0, 0.0)
    size_px: int = 600

    def place(self, points):
        """Pixels (N, 2) of points (N, 2) of the lattice."""
        x, y = np.asarray(points, float).T
        angle = self._angle(x) + self._bow(y)
        radius = self.radius_px - self._depth(y)
        flat = np.column_stack((radius * np.sin(angle), -radius * np.cos(angle)))
        return (flat - self._middle) @ self._turn.T + self._centre

    def lattice_of(self, pixels):
        """Lattice points (N, 2) of pixels (N, 2): the inverse of `place`."""
        flat = (pixels - self._centre) @ self._turn + self._middle
        radius = np.hypot(*flat.T)
        y = self._row(self.radius_px - radius)
        angle = np.arctan2(flat[:, 0], -flat[:, 1]) - self._bow(y)
        step = math.radians(self.arc_deg) / (self.columns - 1)
        return np.column_stack((angle / step + (self.columns - 1) / 2, y))

    @property
    def coordinates(self):
        """Lattice points (rows, columns, 2) of the corners."""
        y, x = np.mgrid[: self.rows, : self.columns].astype(float)
        return np.stack((x, y), axis=2)

    @property
    def lattice(self):
        """Pixels (rows, columns, 2) of the corners, rows clockwise."""
        points = self.coordinates
        return self.place(points.reshape(-1, 2)).reshape(points.shape)

    def image(self, blur_px, noise_sd, rng):
        """The picture, uint8 (size_px, size_px), blurred, then with noise."""
        grey = cv2.GaussianBlur(self._drawn(), (0, 0), blur_px)
        grey = grey + rng.normal(0.0, noise_sd, grey.shape)
        return np.clip(np.rint(grey), 0, 255).astype(np.uint8)

    def _drawn(self):
        """Mean grey of every pixel; those that an edge crosses are sampled."""
        n = self.size_px
        steps = np.arange(n + 1) - 0.5
        cells = self._cells(_pairs(steps, steps)).reshape(n + 1, n + 1)
        first = cells[:-1, :-1]
        edge = (cells[1:, :-1] != first) | (cells[:-1, 1:] != first)
        edge |= cells[1:, 1:] != first
        v, u = np.nonzero(edge)
        inside = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
        places = np.column_stack((u, v))[:, None] + _pairs(inside, inside)
        sampled = self._grey(self._cells(places.reshape(-1, 2)))
        picture = self._grey(first)
        picture[edge] = sampled.reshape(-1, SAMPLES**2).mean(axis=1)
        return picture

    def _cells(self, pixels):
        """The square (N,) that each of the pixels (N, 2) sees; BEYOND off the board."""
        x, y = self.lattice_of(pixels).T
        columns, rows = self.columns - 1, self.rows - 1
        beyond = np.maximum(
            np.abs(x - columns / 2) - columns / 2, np.abs(y - rows / 2) - rows / 2
        )
        square = np.floor(x) + PERIOD * np.floor(y)
        return np.where(beyond <= self.ring, square, BEYOND)

    def _grey(self, cells):
        """Grey levels of the squares: their parity says which are black."""
        grey = np.where(np.mod(cells, 2) == 0, BLACK, WHITE)
        return np.where(cells == BEYOND, self.surround, grey)

    def _angle(self, x):
        last = self.columns - 1
        return math.radians(self.arc_deg) * (x / last - 0.5)

    def _bow(self, y):
        share = y / (self.rows - 1)
        return math.radians(self.bow_deg) * 4 * share * (1 - share)

    @property
    def _rate(self):
        """Size of a square over that of the one outside it."""
        return self.growth ** (1 / max(self.rows - 2, 1))

    def _depth(self, y):
        """Depth (px) below the outer arc: the squares are a geometric series."""
        if self._rate == 1:
            return self.depth_px * y / (self.rows - 1)
        whole = self._rate ** (self.rows - 1) - 1
        return self.depth_px * (self._rate**y - 1) / whole

    def _row(self, depth):
        """y of a depth; far below the pattern where the series never gets there."""
        if self._rate == 1:
            return depth / self.depth_px * (self.rows - 1)
        whole = self._rate ** (self.rows - 1) - 1
        power = np.maximum(1 + depth / self.depth_px * whole, 1e-9)
        return np.log(power) / math.log(self._rate)

    @property
    def _turn(self):
        c, s = (
            math.cos(math.radians(self.turn_deg)),
            math.sin(math.radians(self.turn_deg)),
        )
        return np.array([[c, -s], [s, c]])

    @property
    def _centre(self):
        return (self.size_px - 1) / 2 + np.array(self.shift_px)

    @cached_property
    def _middle(self):
        """Middle of the corners' bounding box before turning."""
        angle = self._angle(np.linspace(0, self.columns - 1, 181))
        inner = self.radius_px - self.depth_px
        across = self.radius_px * np.sin(angle)
        down = np.concatenate([-r * np.cos(angle) for r in (self.radius_px, inner)])
        return np.array(
            [(across.min() + across.max()) / 2, (down.min() + down.max()) / 2]
        )


def _pairs(across, down):
    """All (u, v) of two lists, row by row: (N, 2)."""
    u, v = np.meshgrid(across, down)
    return np.column_stack((u.ravel(), v.ravel()))


def clicked_from(grid, start, clockwise):
    """A lattice (rows, columns, k) as seen by a user who begins elsewhere.

    start: 0 to 3, which outer corner is clicked first, counted clockwise;
    clockwise: which way round the clicks go.
    """
    turned = np.rot90(grid, start)
    return turned if clockwise else turned.swapaxes(0, 1)
