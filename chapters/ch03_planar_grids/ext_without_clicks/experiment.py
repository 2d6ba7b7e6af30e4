"""Trials of this page, their conditions and constants."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from chapters.shared.general import ZOO
from chapters.shared.general import camera as zoo_camera
from raxel.evaluation import corner_errors, share_in_order
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.lab import Sensor, Visibility, board_scene, outline_of, render
from raxel.sets import Chessboard, ReferenceCorners

# Random chessboards in front of the cameras of the zoo, with true corners.


# Two plane mirrors show two parts of a board, which no lattice connects.
ANIMALS = tuple(name for name in ZOO if name != "two plane mirrors")
LARGER = 3
DRAWN = {
    "columns": (4, 12),
    "rows": (3, 9),
    "square_px": (12.0, 45.0),
    "tilt_deg": (0.0, 50.0),
    "blur_px": (0.4, 1.2),
    "gamma": (1.0, 2.2),
    "white": (0.5, 0.95),
    "black": (0.02, 0.2),
    "background": (0.05, 0.6),
    "white_e": (2000.0, 20000.0),
}
TRIES = 2000


class Larger:
    """A camera of the zoo with more pixels over the same field of view."""

    def __init__(self, camera, times):
        self.camera, self.times = camera, times
        self.width, self.height = (camera.width * times, camera.height * times)

    @property
    def continuous(self):
        """As the camera's."""
        return self.camera.continuous

    @property
    def central(self):
        """As the camera's."""
        return self.camera.central

    def rays(self, pixels):
        """Return rays of pixels (N, 2)."""
        return self.camera.rays((np.asarray(pixels) + 0.5) / self.times - 0.5)

    def project(self, points):
        """Return pixels of points (N, 3)."""
        seen = self.camera.project(points)
        return seen._replace(pixels=(seen.pixels + 0.5) * self.times - 0.5)


class ZooBoard(NamedTuple):
    """An image (height, width) uint8, its corners (rows * columns, 2), the counts."""

    image: np.ndarray
    corners: np.ndarray
    columns: int
    rows: int


def zoo_board(name, rng):
    """Return a ZooBoard of camera `name` with random board, pose, light and noise."""
    camera = Larger(zoo_camera(name), LARGER)
    board, T = _drawn(camera, rng)
    scene = board_scene(
        board,
        T,
        black=rng.uniform(*DRAWN["black"]),
        white=rng.uniform(*DRAWN["white"]),
        background=rng.uniform(*DRAWN["background"]),
    )
    image = render(camera, np.eye(4), scene, samples=32)
    image = cv2.GaussianBlur(image, (0, 0), rng.uniform(*DRAWN["blur_px"]))
    white_e = rng.uniform(*DRAWN["white_e"])
    sensor = Sensor(
        white_e=white_e,
        full_well_e=white_e,
        read_noise_e=15.0,
        gamma=rng.uniform(*DRAWN["gamma"]),
    )
    corners = camera.project(transform(T, on_plane(board.points()))).pixels
    return ZooBoard(sensor.expose(image, rng), corners, board.columns, board.rows)


def _drawn(camera, rng):
    """Return a random visible (Chessboard, T_camera_board), squares from 9 px."""
    view = Visibility(margin_px=3.0, least_spacing_px=9.0)
    for _ in range(TRIES):
        columns, rows = (
            int(rng.integers(low, high + 1))
            for low, high in (DRAWN["columns"], DRAWN["rows"])
        )
        size = np.array([camera.width, camera.height])
        middle = rng.uniform(0.15 * size, 0.85 * size)
        steps = np.array([[0, 0], [2, 0], [-2, 0], [0, 2], [0, -2]])
        origins, directions, valid = camera.rays(middle + steps)
        if not valid.all():
            continue
        points = origins + rng.uniform(300, 900) * directions
        across, down = ((points[1] - points[2]) / 4, (points[3] - points[4]) / 4)
        z = directions[0]
        x = across - (across @ z) * z
        x /= np.linalg.norm(x)
        pixel_mm = np.sqrt(np.linalg.norm(np.cross(across, down)))
        pitch = float(rng.uniform(*DRAWN["square_px"]) * pixel_mm)
        axis, turn = rng.uniform(0, 2 * np.pi, 2)
        tilt = np.radians(rng.uniform(*DRAWN["tilt_deg"]))
        R = np.column_stack([x, np.cross(z, x), z])
        R = R @ rotation_from_vector([tilt * np.cos(axis), tilt * np.sin(axis), 0])
        R = R @ rotation_from_vector([0, 0, turn])
        board = Chessboard(columns, rows, pitch)
        lattice = board.points()
        T = pose(R, points[0] - R @ [*lattice.mean(axis=0), 0])
        sheet = pitch * np.array([columns + 3, rows + 3])
        outline = outline_of([-2 * pitch] * 2, sheet)
        if not view.fault(camera, T, outline, lattice.reshape(rows, columns, 2)):
            return board, T
    raise ValueError("no pose shows the complete board")


# Requests to the detectors, and scores of their results.


RIGHT_PX = 1.0
COUNTING = ("raxel", "opencv-sb")
NAMES = {"known": "size given", "counted": "size not given"}
SETTINGS = {
    "right_px": RIGHT_PX,
    "larger": LARGER,
    "drawn": {name: list(limits) for name, limits in DRAWN.items()},
}


def scored(found, corners, columns, rows):
    """Return {found, right, wrong, worst_px} of a Detection."""
    certain = np.ones(len(corners), bool)
    truth = ReferenceCorners(corners, certain, columns, rows, RIGHT_PX)
    errors = corner_errors(found, truth)
    right = errors is not None and bool(errors.max() <= RIGHT_PX)
    return {
        "found": bool(found.found),
        "right": right,
        "wrong": bool(found.found) and not right,
        "worst_px": float(errors.max()) if right else None,
    }


def handed_over(found, corners, columns, shape):
    """Return the share of visible true corners that a rejection reports in order."""
    return share_in_order(found.partial, corners, columns, shape, RIGHT_PX)
