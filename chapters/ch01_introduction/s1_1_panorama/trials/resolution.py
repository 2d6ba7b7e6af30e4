"""Source pixels per unwrapped pixel, for mirrors of several shapes."""

from __future__ import annotations

import numpy as np

from chapters.ch01_introduction.s1_1_panorama.trials.panorama import (
    AHEAD,
    DOWN,
    laboratory,
    view_of,
)
from raxel.cameras import PerspectiveCamera
from raxel.cameras.orthographic import OrthographicCamera
from raxel.cameras.quadric_mirror import QuadricMirrorCamera
from raxel.multiview.cylindrical_view import cylindrical_view
from raxel.multiview.perspective_view import FAR

RIG_MIRROR = "rig"
# Other mirrors of the same rim, by their eccentricity; 1 is a paraboloid.
ECCENTRICITIES = {
    "paraboloid": 1.0,
    "hyperboloid 1.05": 1.05,
    RIG_MIRROR: None,
    "hyperboloid 1.25": 1.25,
}
HIGHEST_DEG = 50.0
RIM_MM, RIM_PX = 37.5, 475.0
WIDTH, HEIGHT = 1280, 960
MIDDLE = (WIDTH - 1) / 2, (HEIGHT - 1) / 2
STEP_PX = 0.05
BANDS_DEG = np.arange(0.1, 45.0, 0.1)
LEAST_RATIO = 1.5


def mirror_camera(name):
    """A central camera whose rim is at the rig's highest elevation.

    The rig itself, or a mirror of the same rim radius that fills as much of
    the picture. In polar form about the inner focus a mirror is at
    R / (1 + e cos psi), psi being the angle from straight down.
    """
    e = ECCENTRICITIES[name]
    if e is None:
        return laboratory(1.0).camera
    psi = np.radians(90 + HIGHEST_DEG)
    R = RIM_MM * (1 + e * np.cos(psi)) / np.sin(psi)
    if e == 1:
        scale = RIM_PX / RIM_MM
        viewer = OrthographicCamera(scale, MIDDLE, WIDTH, HEIGHT)
        return QuadricMirrorCamera.aligned(
            viewer, "paraboloid", [R / 2], RIM_MM
        )
    a = R / (e * e - 1)
    b = a * np.sqrt(e * e - 1)
    focal = RIM_PX / np.tan(viewer_angle(e, psi))
    K = [[focal, 0, MIDDLE[0]], [0, focal, MIDDLE[1]], [0, 0, 1]]
    viewer = PerspectiveCamera(K, [], WIDTH, HEIGHT)
    return QuadricMirrorCamera.aligned(
        viewer, "hyperboloid", [a, b], RIM_MM
    )


def viewer_angle(e, psi):
    """Angle (rad) at the viewer of a direction psi from straight down."""
    return 2 * np.arctan((e - 1) / (e + 1) * np.tan(psi / 2))


def jacobians(camera, view, pixels):
    """Derivatives (N, 2, 2) of source pixels by unwrapped pixels (N, 2)."""
    columns = []
    for step in STEP_PX * np.eye(2):
        ahead, behind = (
            camera.project(
                view.centre + FAR * view.directions(pixels + side * step)
            ).pixels
            for side in (1, -1)
        )
        columns.append((ahead - behind) / (2 * STEP_PX))
    return np.stack(columns, axis=-1)


def scales(camera, view, elevations):
    """Source px per unwrapped px, (N,) each: area, along row and column.

    At the elevations (N,), radians, in the middle column: the mirror is a
    surface of revolution, and so every column is like that one.
    """
    v = view.horizon - view.radius * np.tan(elevations)
    J = jacobians(
        camera, view, np.column_stack([np.full_like(v, view.middle), v])
    )
    along = np.linalg.norm(J, axis=1)
    return np.abs(np.linalg.det(J)), along[:, 0], along[:, 1]


def resolution_trial(condition, rng):
    """Scales in every row, and the ratio of the top row to the bottom."""
    camera = mirror_camera(condition["mirror"])
    # The rows of Fig. 1.1(b), for every mirror.
    rig = view_of(laboratory(1.0).camera)
    view = cylindrical_view(camera, DOWN, AHEAD, WIDTH)
    view = view._replace(horizon=rig.horizon, height=rig.height)
    elevations = view.elevations(np.arange(rig.height))
    area, row, column = scales(camera, view, elevations)
    # A horizontal band from -x to x degrees: where does 1.5 begin?
    ends = np.radians(np.stack([BANDS_DEG, -BANDS_DEG]))
    top, bottom = (scales(camera, view, end)[0] for end in ends)
    wide = BANDS_DEG[top / bottom > LEAST_RATIO]
    return {
        "eccentricity": camera.mirror.eccentricity,
        "elevation_deg": np.degrees(elevations),
        "area": area,
        "along_row": row,
        "along_column": column,
        "top": area[0],
        "bottom": area[-1],
        "ratio": area[0] / area[-1],
        "ratio_row": row[0] / row[-1],
        "ratio_column": column[0] / column[-1],
        "band_deg": wide[0] if len(wide) else np.nan,
    }
