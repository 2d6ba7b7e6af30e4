"""A bust: the object of Fig. 5.19."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.geometry import pose
from raxel.lab import ImageTexture, Relief, TexturedScene

# A head in low relief, described by formula: what stands in for the face of Fig.
# 5.19. All shapes are in units of half the plate's width: x right, y down, origin
# mid-plate, heights towards who looks at it, 1 the highest point's nominal height.
# The plate reaches to +-1 across and +-1.35 down. Nothing is drawn by chance, and
# every form has a second derivative but where head, hair and shoulders meet the
# plate.


EARS = 0.0  # y at which the hair ends
TALL = 1.35  # half the plate's height over half its width
# (x, y, reach across, reach down, height) of hills and hollows on the face; those with
# x > 0 stand on both sides.
FORMS = (
    (0.0, -0.06, 0.075, 0.20, 0.20),  # bridge of the nose
    (0.0, 0.10, 0.105, 0.085, 0.20),  # its tip
    (0.085, 0.13, 0.05, 0.045, 0.07),  # nostrils
    (0.25, -0.31, 0.17, 0.05, 0.07),  # brows
    (0.24, -0.19, 0.13, 0.075, -0.12),  # sockets
    (0.24, -0.185, 0.075, 0.05, 0.09),  # eyeballs
    (0.33, 0.10, 0.15, 0.15, 0.06),  # cheeks
    (0.0, 0.305, 0.15, 0.035, 0.06),  # upper lip
    (0.0, 0.385, 0.13, 0.04, 0.07),  # lower lip
    (0.0, 0.345, 0.17, 0.016, -0.05),  # between them
    (0.0, 0.58, 0.14, 0.09, 0.10),  # chin
)
# Landmarks on the face: (name, x, y).
LANDMARKS = (
    ("left eye, outer corner", -0.34, -0.185),
    ("left eye, inner corner", -0.14, -0.185),
    ("left pupil", -0.24, -0.185),
    ("right pupil", 0.24, -0.185),
    ("right eye, inner corner", 0.14, -0.185),
    ("right eye, outer corner", 0.34, -0.185),
    ("left brow", -0.25, -0.31),
    ("right brow", 0.25, -0.31),
    ("forehead", 0.0, -0.5),
    ("bridge", 0.0, -0.2),
    ("tip of the nose", 0.0, 0.10),
    ("left nostril", -0.085, 0.13),
    ("right nostril", 0.085, 0.13),
    ("left cheek", -0.36, 0.10),
    ("right cheek", 0.36, 0.10),
    ("left corner of the mouth", -0.17, 0.345),
    ("right corner of the mouth", 0.17, 0.345),
    ("middle of the mouth", 0.0, 0.345),
    ("chin", 0.0, 0.58),
    ("throat", 0.0, 0.85),
    ("left shoulder", -0.65, 1.15),
    ("right shoulder", 0.65, 1.15),
)
PLATE, SKIN, HAIR = (0.42, 0.47, 0.55), (0.80, 0.58, 0.46), (0.20, 0.12, 0.07)
CLOTH, LIPS, BROW = (0.16, 0.26, 0.45), (0.58, 0.22, 0.20), (0.16, 0.09, 0.05)
EYE, IRIS, PUPIL = (0.90, 0.90, 0.88), (0.20, 0.34, 0.40), (0.03, 0.03, 0.03)
# Direction of the sculptor's lamp, and share of ambient light.
LAMP, AMBIENT = np.array([-0.45, -0.55, 0.70]), 0.40


@dataclass(frozen=True)
class Bust:
    """A head in low relief on a plate.

    Frame: origin mid-plate, x right, y down, z into the plate, away from the observer.
    The relief has negative z.

    Attributes
    ----------
    width : float
        Width of the plate, mm.
    relief : float
        How far a height of 1 projects from the plate, mm.

    Raises
    ------
    InputError
        For lengths that are not positive.
    """

    width: float = 160.0
    relief: float = 20.0

    def __post_init__(self):
        if not (0 < self.width < np.inf and 0 < self.relief < np.inf):
            raise InputError(
                f"bust: width {self.width} and relief {self.relief} are invalid; give "
                "positive mm"
            )

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the plate, mm."""
        return self.width, TALL * self.width

    def points(self, landmarks: ArrayLike) -> NDArray[np.float64]:
        """Return points (N, 3) of the surface at positions (N, 2) on the plate, mm."""
        landmarks = np.asarray(landmarks, float)
        x, y = (2 / self.width * landmarks).T
        return np.column_stack([landmarks, -self.relief * heights(x, y)])

    def landmarks(self) -> tuple[tuple[str, ...], NDArray[np.float64]]:
        """Return the names of the landmarks and their points (n, 3), mm."""
        names, x, y = zip(*LANDMARKS, strict=True)
        return names, self.points(self.width / 2 * np.column_stack([x, y]))

    def part(
        self, T_world_bust: NDArray[np.float64], pitch: float = 0.5, px_mm: float = 0.4
    ) -> tuple[Relief, ImageTexture]:
        """Return surface and texture for a `TexturedScene`.

        Parameters
        ----------
        T_world_bust : (4, 4) array
            Pose of the bust, mm.
        pitch : float
            Distance between heights, mm.
        px_mm : float
            Size of the texture's pixels, mm; no finer than the pixels that will see it.

        Returns
        -------
        (Relief, ImageTexture)
            One part of a scene.
        """
        width, height = self.size
        columns, rows = (round(length / pitch) + 1 for length in (width, height))
        x, y = np.linspace(-1, 1, columns), np.linspace(-TALL, TALL, rows)
        field = heights(*np.meshgrid(x, y))
        corner = pose(np.eye(3), [-width / 2, -height / 2, 0])
        pitch = width / (columns - 1)
        surface = Relief(T_world_bust @ corner, -self.relief * field, pitch)
        steepness = 2 * self.relief / self.width
        return surface, ImageTexture(*_picture(steepness, width, px_mm))

    def scene(
        self,
        T_world_bust: NDArray[np.float64],
        background: float = 0.1,
        **fineness: float,
    ) -> TexturedScene:
        """Return the bust alone in front of an even background.

        Parameters
        ----------
        T_world_bust : (4, 4) array
            Pose of the bust, mm.
        background : float
            Radiance of rays that meet nothing.
        **fineness
            `pitch` and `px_mm` as in `part`.
        """
        return TexturedScene((self.part(T_world_bust, **fineness),), background)


def heights(x, y):
    """Heights above the plate at x, y (any one shape)."""
    face = _dome(x, y, 0.0, -0.08, 0.56, 0.78, 0.82)
    hair = _dome(x, y, 0.0, -0.26, 0.70, 0.78, 0.66)
    # The face rises out of the hair, not the hair out of the face.
    head = np.where(y < EARS, np.maximum(hair, face), np.maximum(face, 0))
    neck = 0.42 * np.maximum(1 - (x / 0.34) ** 2, 0) ** 1.5 * _rising(y, 0.35, 0.6)
    chest = (
        0.46 * np.maximum(1 - (x / 1.02) ** 2, 0) * _rising(y - 0.22 * x**2, 0.72, 1.18)
    )
    body = _blended(neck, chest)
    return _blended(head + _forms(x, y) * (face > 0), body)


def _forms(x, y):
    total = np.zeros(np.shape(x))
    for landmark, down, across, along, high in FORMS:
        bell = np.exp(-(((y - down) / along) ** 2) - ((x - landmark) / across) ** 2)
        if landmark:
            bell = bell + np.exp(
                -(((y - down) / along) ** 2) - ((x + landmark) / across) ** 2
            )
        total = total + high * bell
    return total


def _dome(x, y, middle, down, across, along, high):
    inside = 1 - ((x - middle) / across) ** 2 - ((y - down) / along) ** 2
    return high * np.maximum(inside, 0) ** 0.75


def _rising(y, low, high):
    """From 0 at low to 1 at high, with level ends."""
    t = np.clip((y - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def _blended(one, two, width=0.06):
    """The higher of two heights, rounded where they meet."""
    distance_direction = np.maximum(width - np.abs(one - two), 0) / width
    return np.maximum(one, two) + np.where(
        np.minimum(one, two) > 0, width * distance_direction**2 / 4, 0
    )


@lru_cache(maxsize=4)
def _picture(steepness, width, px_mm):
    """The painted and lit surface: image (rows, columns, 3), mm of its pixels."""
    columns = max(round(width / px_mm), 2)
    rows = round(TALL * columns)
    x = (np.arange(columns) + 0.5) * 2 / columns - 1
    y = (np.arange(rows) + 0.5) * 2 / columns - rows / columns
    x, y = np.meshgrid(x, y)
    field = steepness * heights(x, y)
    down, across = np.gradient(field, 2 / columns)
    normal = np.stack([-across, -down, np.ones_like(field)], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    lamp = np.maximum(normal @ (LAMP / np.linalg.norm(LAMP)), 0)
    light = AMBIENT + (1 - AMBIENT) * lamp
    return (_paint(x, y) * light[..., None]).astype(np.float32), width / columns


def _paint(x, y):
    """Colours (..., 3) of the surface, the later over the earlier."""
    face = _oval(x, y, 0.0, -0.08, 0.55, 0.77)
    hair = _oval(x, y, 0.0, -0.26, 0.70, 0.78)
    side = np.abs(x)
    layers = (
        (np.ones(x.shape, bool), PLATE),
        ((np.maximum(1 - (x / 0.34) ** 2, 0) > 0) & (y > 0.4) & (y < 1.1), SKIN),
        (y - 0.22 * x**2 > 0.86, CLOTH),
        (hair & (y < EARS), HAIR),
        (face & (y > -0.60 + 0.6 * x**2), SKIN),
        (_oval(side, y - 0.10 * (side - 0.25), 0.25, -0.32, 0.14, 0.028), BROW),
        (_oval(side, y, 0.24, -0.185, 0.10, 0.048), EYE),
        (_oval(side, y, 0.24, -0.185, 0.042, 0.042), IRIS),
        (_oval(side, y, 0.24, -0.185, 0.018, 0.018), PUPIL),
        (_oval(x, y, 0.0, 0.345, 0.17, 0.075), LIPS),
        (_oval(x, y, 0.0, 0.345, 0.17, 0.008), BROW),
    )
    paint = np.empty((*x.shape, 3))
    for where, colour in layers:
        paint[where] = colour
    return paint


def _oval(x, y, middle, down, across, along):
    return ((x - middle) / across) ** 2 + ((y - down) / along) ** 2 < 1
