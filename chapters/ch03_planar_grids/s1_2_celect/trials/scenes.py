"""Images of a chessboard with four distorting cameras (section 3.1.2)."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import cv2
import numpy as np

from chapters.shared.lattices import steps_between
from raxel.cameras import FisheyeCamera, QuadricMirrorCamera, camera_from
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.lab import board_scene, render
from raxel.sets import Chessboard

# Side of the image (px) -> minimum length of a square's side in it (px).
MIN_SQUARE_PX = {900: 15, 600: 10}
CAMERAS = ("fisheye", "sphere", "hyperboloid", "bent sheet")
FISHEYE_DEG = 160
BOARD = Chessboard(9, 7, 30.0)
BLACK, WHITE, BACKGROUND = 25.0, 215.0, 120.0
BLUR_PX, NOISE_SD = 1.0, 4.0
DISTANCE_MM = (130, 330)
TILT_DEG = 40
MAX_SIDE_RATIO = 3
DRAWS = 2000


class BoardPicture(NamedTuple):
    """An image uint8 (h, w) and the true corners (rows, columns, 2) px."""

    image: np.ndarray
    lattice: np.ndarray


def viewer(focal, size):
    """The pinhole camera that views a mirror; focal length in image sides."""
    middle, f = (size - 1) / 2, focal * size
    K = [[f, 0, middle], [0, f, middle], [0, 0, 1]]
    fields = {"K": K, "radial": [], "width": size, "height": size}
    return camera_from("perspective", fields)


@cache
def camera_of(name, size):
    """The camera of this name, with images of size x size px; mm."""
    if name == "fisheye":
        half, middle = np.radians(FISHEYE_DEG) / 2, (size - 1) / 2
        return FisheyeCamera(
            "equidistance", middle / half, [middle] * 2, size, size, half
        )
    if name == "sphere":
        return QuadricMirrorCamera.on_axis(viewer(1.8, size), "sphere", (30,), 25, 100)
    if name == "hyperboloid":
        return QuadricMirrorCamera.aligned(
            viewer(1.4, size), "hyperboloid", (30, 20), 25
        )
    heights = [[0, 0, 6], [0, 4, 0], [20, 0, 0], [5, 0, 0]]
    sheet = {"size": (400, 400), "heights": heights, "offset": (0, 0, 180)}
    return camera_from("bent mirror", {"viewer": viewer(0.65, size)} | sheet)


def drawn_pose(camera, rng):
    """T_camera_board (4, 4): around a random pixel's ray, tilted and rotated."""
    pixel = rng.uniform(0.25, 0.75, (1, 2)) * camera.width
    rays = camera.rays(pixel)
    if not rays.valid[0]:
        return None
    towards = rays.directions[0]
    across = np.cross(towards, rng.normal(size=3))
    across /= np.linalg.norm(across)
    R = np.column_stack((across, np.cross(towards, across), towards))
    tilt = np.radians(rng.uniform(-TILT_DEG, TILT_DEG, 2))
    R = R @ rotation_from_vector(np.append(tilt, 0.0))
    centre = rays.origins[0] + rng.uniform(*DISTANCE_MM) * towards
    middle = np.append(BOARD.points().mean(axis=0), 0.0)
    return pose(R, centre - R @ middle)


def lattice_at(camera, T_camera_board):
    """True corners (rows, columns, 2) px, None if a square is not visible."""
    rim = Chessboard(BOARD.columns + 2, BOARD.rows + 2, BOARD.pitch_mm)
    points = on_plane(rim.points() - BOARD.pitch_mm)
    seen = camera.project(transform(T_camera_board, points))
    inside = (seen.pixels > 4) & (seen.pixels < camera.width - 5)
    if not (seen.valid.all() and inside.all()):
        return None
    return seen.pixels.reshape(rim.rows, rim.columns, 2)[1:-1, 1:-1]


def board_view(name, size, least_px, rng):
    """Return a moderately distorted BoardPicture of camera `name`, random pose.

    Moderate: every side of a square is at least least_px long, and none more
    than MAX_SIDE_RATIO times as long as another.
    """
    camera = camera_of(name, size)
    for _ in range(DRAWS):
        T_camera_board = drawn_pose(camera, rng)
        if T_camera_board is None:
            continue
        lattice = lattice_at(camera, T_camera_board)
        if lattice is None:
            continue
        sides = steps_between(lattice)
        even = sides.max() <= MAX_SIDE_RATIO * sides.min()
        if even and sides.min() >= least_px:
            return BoardPicture(picture(name, size, T_camera_board, rng), lattice)
    raise ValueError(f"no pose with the whole board in sight of {name}")


def picture(name, size, T_camera_board, rng):
    """The image, uint8, blurred and noisy."""
    scene = board_scene(
        BOARD, T_camera_board, black=BLACK, white=WHITE, background=BACKGROUND
    )
    radiance = render(camera_of(name, size), np.eye(4), scene)
    return photographed(radiance, rng)


def photographed(grey, rng, blur_px=BLUR_PX, noise_sd=NOISE_SD):
    """Grey levels (h, w) after blur, noise and rounding, uint8."""
    soft = cv2.GaussianBlur(grey, (0, 0), blur_px)
    noisy = soft + rng.normal(0.0, noise_sd, grey.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
