"""The synthetic chessboard of 3.3.1: a square image of a board, bent by a fisheye.

Lengths of the board are in pixels of the image before it is bent. The board stands at
a distance of one focal length, so that seen by a pinhole, and not turned, its plane is
that image.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import cv2
import numpy as np

from raxel.cameras import FisheyeCamera, PerspectiveCamera
from raxel.geometry import on_plane, pose, transform
from raxel.lab import board_scene, render
from raxel.sets import Chessboard

SIZE_PX = 1000
FULL_RANGE = (0.0, 255.0)


@dataclass(frozen=True)
class SyntheticBoard:
    """A chessboard with squares of `square_px`, seen over a diagonal field of view.

    The field is that of the image's diagonal (E-3.15). yaw_deg turns the board
    about its own vertical middle line, towards the camera on its left. As many whole
    squares as the image holds are around its middle; the outermost ring of them is
    the clearance about the corners.
    """

    square_px: float = 100.0
    fov_deg: float = 134.0
    yaw_deg: float = 0.0

    @property
    def columns(self):
        """Interior corners along a row."""
        return int(SIZE_PX / self.square_px + 1e-9) - 1

    @property
    def rows(self):
        """Interior corners along a column: the board is square."""
        return self.columns

    @property
    def focal_px(self):
        """Focal length that spreads the image's diagonal over the field of view."""
        return SIZE_PX / math.sqrt(2) / math.tan(math.radians(self.fov_deg) / 2)

    @property
    def camera(self):
        """Equisolid fisheye (2.7); it sees less than 90 deg off, as a pinhole does."""
        middle = [(SIZE_PX - 1) / 2] * 2
        return FisheyeCamera(
            "equisolid", self.focal_px, middle, SIZE_PX, SIZE_PX, math.pi / 2
        )

    @property
    def chessboard(self):
        """The board as a target; its unit is a pixel of the image before bending."""
        return Chessboard(self.columns, self.rows, self.square_px)

    @property
    def T_camera_board(self):
        """Pose (4, 4) of the board: first interior corner at its origin."""
        yaw = math.radians(self.yaw_deg)
        R = np.array(
            [
                [math.cos(yaw), 0, -math.sin(yaw)],
                [0, 1, 0],
                [math.sin(yaw), 0, math.cos(yaw)],
            ]
        )
        middle = np.append(self.chessboard.points().mean(axis=0), 0.0)
        return pose(R, [0, 0, self.focal_px] - R @ middle)

    @cached_property
    def corners(self):
        """True corners (rows * columns, 2) row by row; NaN where out of sight."""
        points = on_plane(self.chessboard.points())
        return self.camera.project(transform(self.T_camera_board, points)).pixels

    @property
    def lattice(self):
        """The true corners as (rows, columns, 2)."""
        return self.corners.reshape(self.rows, self.columns, 2)

    @property
    def outer_corners(self):
        """True outer corners (4, 2), clockwise from the upper left."""
        return outer(self.lattice)

    @property
    def coordinates(self):
        """Lattice points (rows, columns, 2) of the corners: see `place`."""
        y, x = np.mgrid[: self.rows, : self.columns].astype(float)
        return np.stack((x, y), axis=2)

    def place(self, points):
        """Pixels (N, 2) of lattice points (N, 2): x along a row, 1 per square."""
        flat = on_plane(self.square_px * points)
        return self.camera.project(transform(self.T_camera_board, flat)).pixels

    @property
    def least_spacing(self):
        """Smallest distance in px between neighbouring corners."""
        return float(np.nanmin(steps_between(self.lattice)))

    @property
    def rim_spacing(self):
        """Distance in px from the last corner to the rim, at the middle of a side."""
        last = (self.columns - 1) * self.square_px / 2
        ends = np.array([[last + self.square_px, 0.0], [last, 0.0]])
        middle = self.chessboard.points().mean(axis=0)
        points = on_plane(ends + middle)
        pixels = self.camera.project(transform(self.T_camera_board, points)).pixels
        return float(np.linalg.norm(pixels[0] - pixels[1]))

    def image(self, blur_px=1.0, noise_sd=0.0, rng=None, levels=FULL_RANGE):
        """The image, uint8 (1000, 1000).

        blur_px: SD of the Gaussian blur; noise_sd: SD of the added noise in grey
        levels, drawn from `rng`; levels: grey of black and white before the noise.
        """
        black, white = levels
        grey = black + (white - black) * _blurred(self, blur_px)
        if noise_sd:
            grey = grey + rng.normal(0.0, noise_sd, grey.shape)
        return np.clip(np.rint(grey), 0, 255).astype(np.uint8)

    def flat_image(self):
        """The image before it is bent, uint8 (1000, 1000), without blur."""
        middle = (SIZE_PX - 1) / 2
        K = [[self.focal_px, 0, middle], [0, self.focal_px, middle], [0, 0, 1]]
        camera = PerspectiveCamera(np.array(K), (), SIZE_PX, SIZE_PX)
        return np.rint(255 * _rendered(self, camera)).astype(np.uint8)


def clicks(outer_corners, rng, sd=2.0, cap=4.0):
    """Where a user clicks (4, 2): Gaussian noise, no further off than `cap` px (3.3.1).

    A click beyond the cap is drawn again.
    """
    offsets = rng.normal(0.0, sd, (4, 2))
    while (far := np.linalg.norm(offsets, axis=1) > cap).any():
        offsets[far] = rng.normal(0.0, sd, (int(far.sum()), 2))
    return outer_corners + offsets


@lru_cache(maxsize=4)
def _radiance(board):
    return _rendered(board, board.camera)


def _rendered(board, camera):
    scene = board_scene(
        board.chessboard,
        board.T_camera_board,
        border_mm=0.0,
        black=0.0,
        white=1.0,
        background=0.0,
    )
    return render(camera, np.eye(4), scene)


@lru_cache(maxsize=4)
def _blurred(board, blur_px):
    radiance = _radiance(board)
    if not blur_px:
        return radiance
    return cv2.GaussianBlur(radiance, (0, 0), blur_px)


# Lattices of corners in an image: which way round they go, and their outer corners.


def clockwise(lattice):
    """The lattice (rows, columns, 2), its columns reversed where mirrored."""
    (ax, ay), (bx, by) = np.diff(outer(lattice)[[3, 0, 1]], axis=0)
    return lattice if ax * by > ay * bx else lattice[:, ::-1]


def outer(lattice):
    """Corners (4, 2) of a lattice (rows, columns, 2), around it by its rows."""
    return np.array([lattice[0, 0], lattice[0, -1], lattice[-1, -1], lattice[-1, 0]])


def steps_between(lattice):
    """Lengths (n,) px of the steps between neighbours of a lattice, nan as they are."""
    steps = (np.diff(lattice, axis=axis) for axis in (0, 1))
    return np.concatenate([np.linalg.norm(s, axis=2).ravel() for s in steps])


def corner_areas(lattice):
    """Area (4,) in px² of the squares at the four outer corners, as `outer`."""
    rows, columns = lattice.shape[:2]
    areas = []
    for r, c in ((0, 0), (0, columns - 2), (rows - 2, columns - 2), (rows - 2, 0)):
        (a, b), (d, e) = lattice[r : r + 2, c : c + 2]
        (x, y), (p, q) = e - a, d - b
        areas.append(abs(x * q - y * p) / 2)
    return np.array(areas)
