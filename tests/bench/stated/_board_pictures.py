"""Pictures of drawn boards and of patterns that are none, by random numbers.

What lies on a plane is a function of its coordinates in squares, seen through a
homography and a radial bend, sampled finer than the pixels, lit, blurred, and made
noisy, sharp or a JPEG.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from tests.chessboards import Board, facing

WIDTH, HEIGHT, FINER = 640, 480, 2
MIDDLE = np.array([WIDTH - 1, HEIGHT - 1]) / 2
BENDS = 0.0, 0.0, 0.8, 2.0


@dataclass(frozen=True)
class Plane:
    """A plane before the camera: a Board, whose pattern is not used."""

    board: Board

    @classmethod
    def drawn(cls, rng, columns, rows):
        """One on which this many corners fill 35 to 80 per cent of the picture."""
        square = rng.uniform(0.35, 0.8) * min(
            WIDTH / (columns + 1), HEIGHT / (rows + 1)
        )
        tilt = rng.uniform(-0.5, 0.5, 2) / max(columns, rows)
        turn = rng.uniform(-0.4, 0.4) + np.pi * rng.integers(2)
        centre = MIDDLE + rng.uniform(-30, 30, 2)
        plane = facing(columns, rows, square, tuple(tilt), turn, tuple(centre))
        return cls(Board(columns, rows, plane, WIDTH, HEIGHT, float(rng.choice(BENDS))))

    @property
    def square_px(self):
        """The shortest side of a square, px."""
        lattice = self.board.corners().reshape(self.board.rows, self.board.columns, 2)
        sides = [np.diff(lattice, axis=axis) for axis in (0, 1)]
        return min(np.linalg.norm(side, axis=2).min() for side in sides)

    def inside(self):
        """Whether every corner lies in the picture."""
        corners = self.board.corners()
        return bool(((corners > 2) & (corners < [WIDTH - 3, HEIGHT - 3])).all())

    def picture(self, tone, rng):
        """uint8 (HEIGHT, WIDTH) of tone(x, y), in uneven light, not sharp, noisy."""
        v, u = (np.mgrid[0 : HEIGHT * FINER, 0 : WIDTH * FINER] + 0.5) / FINER - 0.5
        grey = tone(*self.board._board(u, v)).astype(np.float32)
        grey = cv2.resize(grey, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
        grey = grey * light(rng)
        blur = min(rng.choice([0.5, 0.8, 1.2, 2.0, 3.0, 4.0]), 0.12 * self.square_px)
        grey = cv2.GaussianBlur(grey, (0, 0), max(blur, 0.4))
        grey = np.clip(grey, 0, 255) + rng.normal(0, rng.uniform(0.5, 4), grey.shape)
        if rng.random() < 0.3:
            grey += rng.uniform(0.3, 1) * (grey - cv2.GaussianBlur(grey, (0, 0), 2))
        image = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
        if rng.random() < 0.4:
            jpeg = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(50, 95))]
            image = cv2.imdecode(cv2.imencode(".jpg", image, jpeg)[1], 0)
        return image


def light(rng):
    """Even light, a slope, or a soft shadow: (HEIGHT, WIDTH) or 1."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    turn = rng.uniform(0, 2 * np.pi)
    along = ((u - MIDDLE[0]) * np.cos(turn) + (v - MIDDLE[1]) * np.sin(turn)) / WIDTH
    kind = rng.integers(3)
    if kind == 0:
        return 1.0
    if kind == 1:
        slope = np.exp(rng.uniform(0.3, 1.8) * along)
        return 1.2 * slope / slope.max()
    edge = (along - rng.uniform(-0.2, 0.2)) / rng.uniform(0.005, 0.05)
    return 1 - rng.uniform(0.3, 0.75) / (1 + np.exp(-edge))


def chessboard(columns, rows, rng, margin, ground):
    """tone(x, y) of a board with a white margin, in squares, on ground(x, y)."""
    dark, bright = rng.uniform(15, 60), rng.uniform(160, 230)
    gap = rng.choice([0.0, 0.0, 0.04, 0.08])

    def tone(x, y):
        a, b = x - np.floor(x), y - np.floor(y)
        full = np.minimum.reduce([a, 1 - a, b, 1 - b]) >= gap / 2
        odd = (np.floor(x) + np.floor(y)) % 2 == 0
        board = np.where(odd & full & within(x, y, 0), dark, bright)
        return np.where(within(x, y, margin), board, ground(x, y))

    def within(x, y, by):
        across = (x > -1 - by) & (x < columns + by)
        return across & (y > -1 - by) & (y < rows + by)

    return tone


def table(rng):
    """Even grey, dark, or a soft pattern."""
    grey, soft = rng.uniform(0, 180), rng.uniform(0, 60)
    a, b = rng.uniform(0.2, 2, 2)
    return lambda x, y: grey + soft * (1 + np.sin(a * x + b * y)) / 2


def cloth(rng):
    """Random patches, a quarter to half a square wide, along the squares or turned."""
    patches = rng.uniform(20, 230, (64, 64))
    size, turn = rng.uniform(2, 4), rng.choice([0.0, 0.0, 0.5])

    def ground(x, y):
        x, y = np.clip(x, -1e4, 1e4), np.clip(y, -1e4, 1e4)
        a, b = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
        return patches[(size * b).astype(int) % 64, (size * a).astype(int) % 64]

    return ground


def hidden(image, plane, rng):
    """The picture with a hand, a strip, or a shadow over one end of the board."""
    board = plane.board
    lattice = board.corners().reshape(board.rows, board.columns, 2)
    side = [lattice[0], lattice[-1], lattice[:, 0], lattice[:, -1]][rng.integers(4)]
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    grey, kind = image.astype(float), rng.integers(3)
    if kind == 0:
        p = side[rng.integers(len(side))] + rng.uniform(-1, 1, 2) * plane.square_px
        a, b = rng.uniform(1, 3, 2) * plane.square_px
        where = ((u - p[0]) / a) ** 2 + ((v - p[1]) / b) ** 2 < 1
    else:
        along = side[-1] - side[0]
        out = np.array([-along[1], along[0]]) / np.linalg.norm(along)
        out *= -np.sign(out @ (lattice.mean(axis=(0, 1)) - side[0]))
        off = (u - side[0, 0]) * out[0] + (v - side[0, 1]) * out[1]
        where = off > rng.uniform(-1.2, 0.8) * plane.square_px
    if kind == 2:
        grey[where] *= rng.uniform(0.1, 0.6)
    else:
        grey[where] = rng.uniform(20, 220)
    return np.rint(cv2.GaussianBlur(grey, (0, 0), 0.6)).astype(np.uint8)


def discs(rng):
    """Dense discs in the places of dark squares, dark or bright."""
    radius, tones = rng.uniform(0.45, 0.72), rng.permutation([40.0, 210.0])

    def tone(x, y):
        apart = np.full(x.shape, np.inf)
        for i, j in np.ndindex(3, 3):
            a, b = np.floor(x) + i - 1, np.floor(y) + j - 1
            off = np.hypot(x - a - 0.5, y - b - 0.5)
            apart = np.where((a + b) % 2 == 0, np.minimum(apart, off), apart)
        return np.where(apart < radius, *tones)

    return tone


def _share(x):
    return x - np.floor(x)


PATTERNS = {
    "brick": lambda x, y: np.where(
        (_share(y) < 0.12) | (_share(x / 2 + (np.floor(y) % 2) / 2) < 0.06), 180, 110
    ),
    "tiles": lambda x, y: np.where((_share(x) < 0.1) | (_share(y) < 0.1), 60, 190),
    "gingham": lambda x, y: (
        210 - 80 * (_share(x / 2) < 0.5) - 80 * (_share(y / 2) < 0.5)
    ),
    "weave": lambda x, y: np.where(
        (np.floor(x) + np.floor(y)) % 2 == 0,
        60 + 120 * np.abs(np.sin(np.pi * x)),
        60 + 120 * np.abs(np.sin(np.pi * y)),
    ),
    "halftone": lambda x, y: np.where(
        np.sin(np.pi * x) * np.sin(np.pi * y) > np.clip(0.9 - 0.15 * x, -0.9, 0.9),
        40,
        210,
    ),
    "windows": lambda x, y: np.where(
        (_share(x) > 0.2) & (_share(x) < 0.8) & (_share(y) > 0.2) & (_share(y) < 0.8),
        40 + 30 * (_share(4 * x) < 0.5),
        180,
    ),
    "squares with spots": lambda x, y: np.where(
        ((np.floor(x) + np.floor(y)) % 2 == 0)
        != (np.hypot(_share(x) - 0.5, _share(y) - 0.5) < 0.3),
        40,
        210,
    ),
}
