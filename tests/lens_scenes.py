"""Boards as cameras of known formulas see them, about all of the field of view."""

import numpy as np

from raxel.calibration.views.correspondence import BoardView
from raxel.cameras import (
    KannalaBrandtCamera,
    MovingPupilCamera,
    PerspectiveCamera,
    UnifiedSphereCamera,
)
from raxel.geometry import on_plane, pose, rotation_from_vector, transform

COLUMNS, ROWS, PITCH = 10, 10, 20.0
BOARD = PITCH * np.stack(np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)), -1).reshape(
    -1, 2
)
SIZE = (1280, 960)
FISHEYE = KannalaBrandtCamera(
    [1.0, -0.03, 0.004, -0.001], (290.0, 289.0), (651.0, 470.0), *SIZE
)
K = np.array([[420.0, 0, 625], [0, 418, 492], [0, 0, 1]])
CAMERAS = {
    "fisheye of 183 degrees": (FISHEYE, (0.0, 1.35)),
    "mirror with a blind middle": (
        UnifiedSphereCamera(0.96, K, *SIZE, radial=[-0.02, 0.002]),
        (0.7, 1.4),
    ),
    "wide perspective": (
        PerspectiveCamera(
            [[640.0, 0, 630], [0, 644, 488], [0, 0, 1]], [-0.2, 0.03], *SIZE
        ),
        (0.0, 0.4),
    ),
    "decentred fisheye": (
        KannalaBrandtCamera(
            [1.0, -0.03, 0.004], (290.0, 289.0), (651.0, 470.0), *SIZE,
            tangential=(0.004, -0.002), prism=(-0.003, 0.005),
        ),
        (0.0, 1.2),
    ),
    "decentred mirror": (
        UnifiedSphereCamera(
            0.96, K, *SIZE, radial=[-0.02, 0.002], tangential=(-0.02, 0.006),
            prism=(-0.02, 0.03),
        ),
        (0.7, 1.3),
    ),
    "moving pupil": (MovingPupilCamera(FISHEYE, [4.0, 1.0]), (0.0, 1.35)),
}  # fmt: skip


def boards(camera, count, reach, seed, noise=0.0):
    """BoardViews at random poses whose middles lie in the range of angles ``reach``."""
    rng = np.random.default_rng(seed)
    middle = np.append(PITCH * np.array([COLUMNS - 1, ROWS - 1]) / 2, 0.0)
    views = []
    for _ in range(200 * count):
        polar, azimuth = rng.uniform(*reach), rng.uniform(0, 2 * np.pi)
        faced = rotation_from_vector(
            polar * np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        )
        spin = rotation_from_vector([0.0, 0.0, rng.uniform(-3, 3)])
        R = faced @ rotation_from_vector([*rng.uniform(-0.5, 0.5, 2), 0.0]) @ spin
        t = rng.uniform(220, 420) * faced[:, 2] - R @ middle
        points = transform(pose(R, t), on_plane(BOARD))
        pixels, valid = camera.project(points)
        if valid.all() and camera.in_image(pixels).all():
            pixels = pixels + noise * rng.normal(size=pixels.shape)
            name = f"{len(views)}.png"
            views.append(BoardView(pixels, BOARD, COLUMNS, ROWS, name))
        if len(views) == count:
            return views
    raise AssertionError(f"{len(views)} of {count} boards fit into the image")


class DrawnLens:
    """A lens seen along its axis: radius(theta), its pupil at a theta^2 mm on it."""

    def __init__(self, radius, focal, centre, reach, shift=0.0):
        self._radius, self._focal, self._centre = radius, focal, np.array(centre)
        self._reach, self._shift = reach, shift

    def project(self, points):
        """Pixels (N, 2) of points (N, 3) in the camera's frame, and which are seen."""
        rho = np.hypot(points[:, 0], points[:, 1])
        theta = np.arctan2(rho, points[:, 2])
        for _ in range(40):
            theta = np.arctan2(rho, points[:, 2] - self._shift * theta**2)
        along = points[:, :2] / np.maximum(rho, 1e-12)[:, None]
        pixels = self._focal * self._radius(theta)[:, None] * along + self._centre
        return pixels, theta < self._reach

    def in_image(self, pixels):
        """Which of the pixels (N, 2) are in the image."""
        return np.all((pixels > -0.5) & (pixels < np.array(SIZE) - 0.5), axis=1)
