"""Chessboards drawn with known corners: a homography, a radial bend, soft edges.

The pattern is evaluated at each pixel's centre; an edge crosses a pixel as a ramp one
pixel wide. Every corner is a saddle that its own symmetry centres, so the corners of
the formula are the corners of the image.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Board:
    """A board of columns x rows interior corners before a bent pinhole.

    `homography` maps the board (unit squares, first interior corner at 0, 0) to bent-
    free pixels; `bend` is the radial term k of `straight = centre + d (1 + k |d|^2)`
    with d from the image centre in units of half the diagonal.
    """

    columns: int
    rows: int
    homography: np.ndarray
    width: int = 640
    height: int = 480
    bend: float = 0.0

    def corners(self):
        """The interior corners in the image, (rows * columns, 2), row by row."""
        y, x = np.mgrid[0 : self.rows, 0 : self.columns]
        board = np.stack((x.ravel(), y.ravel(), np.ones(x.size)))
        straight = (self.homography @ board).T
        return self._bent(straight[:, :2] / straight[:, 2:])

    def image(self, dark=40, bright=210, ground=120):
        """The image, (height, width) uint8."""
        v, u = np.mgrid[0 : self.height, 0 : self.width].astype(float)
        x, y = self._board(u, v)
        pattern = _wave(x, self.columns) * _wave(y, self.rows)
        inside = _within(x, self.columns) * _within(y, self.rows)
        margin = _within(x, self.columns, 1) * _within(y, self.rows, 1)
        board = inside * (dark + (bright - dark) * (1 + pattern) / 2)
        board += (1 - inside) * bright
        return np.rint(margin * board + (1 - margin) * ground).astype(np.uint8)

    def _board(self, u, v):
        du, dv = self._from_centre(u, v)
        stretch = 1 + self.bend * (du**2 + dv**2) / self._radius**2
        centre = self._centre
        straight = np.stack(
            (centre[0] + du * stretch, centre[1] + dv * stretch, np.ones_like(u))
        )
        board = np.tensordot(np.linalg.inv(self.homography), straight, 1)
        before = np.where(board[2] > 0, board[2], np.inf)
        far = np.where(np.isinf(before), 1e6, 0.0)
        return board[0] / before + far, board[1] / before + far

    def _bent(self, straight):
        """Newton's method on r (1 + k r^2) = s, along each ray from the centre."""
        ahead = (straight - self._centre) / self._radius
        goal = np.linalg.norm(ahead, axis=1)
        r = goal.copy()
        for _ in range(50):
            r -= (r * (1 + self.bend * r**2) - goal) / (1 + 3 * self.bend * r**2)
        ratio = np.divide(r, goal, out=np.ones_like(r), where=goal > 0)
        return self._centre + ahead * ratio[:, None] * self._radius

    def _from_centre(self, u, v):
        return u - self._centre[0], v - self._centre[1]

    @property
    def _centre(self):
        return np.array([(self.width - 1) / 2, (self.height - 1) / 2])

    @property
    def _radius(self):
        return np.hypot(self.width, self.height) / 2


def facing(columns, rows, square, tilt=(0.0, 0.0), turn=0.0, centre=(319.5, 239.5)):
    """A homography with the board's middle at `centre`, squares about `square` px.

    `turn` rotates in the image (radians); `tilt` foreshortens along u and v.
    """
    middle = np.array([[1, 0, -(columns - 1) / 2], [0, 1, -(rows - 1) / 2], [0, 0, 1]])
    cos, sin = np.cos(turn), np.sin(turn)
    scaled = square * np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1 / square]])
    tilted = np.eye(3)
    tilted[2, :2] = np.array(tilt) / square
    moved = np.array([[1, 0, centre[0]], [0, 1, centre[1]], [0, 0, 1]])
    return moved @ tilted @ scaled @ middle


def _wave(x, count):
    """+1 and -1 in turn over unit squares, ramped over one pixel at `count` edges."""
    edge = np.clip(np.rint(x), 0, count - 1)
    side = np.where(edge % 2 == 0, 2.0, -2.0)
    return side * np.clip((x - edge) / _pixel(x), -0.5, 0.5)


def _within(x, count, margin=0):
    """1 inside the squares around `count` corners (and a margin), 0 outside, ramped."""
    low, high = -1 - margin, count + margin
    change = _pixel(x)
    near = np.clip((x - low) / change + 0.5, 0, 1) * np.clip(
        (high - x) / change + 0.5, 0, 1
    )
    return near


def _pixel(x):
    """How far x goes across one pixel."""
    down, across = np.gradient(x)
    return np.maximum(np.hypot(down, across), 1e-9)
