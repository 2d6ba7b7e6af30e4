"""The exercises of an image set's page: their data and their right answers."""

import numpy as np

from raxel.cameras import PerspectiveCamera
from raxel.geometry import pose, rotation_from_vector, transform

MADE_UP = {"fx": 500.0, "fy": 502.0, "u0": 322.0, "v0": 238.0, "k1": -0.25, "k2": 0.08}


def exercise_camera(study):
    """The set's Zhang camera as plain numbers, or a made-up one."""
    size = {k: study.settings[f"{k}_px"] for k in ("width", "height")}
    if study.refusal("zhang"):
        return size | MADE_UP
    numbers = {name: study.fit(f"zhang.{name}_px") for name in ("fx", "fy", "u0", "v0")}
    numbers |= {name: study.fit(f"zhang.{name}") for name in ("k1", "k2")}
    return size | {name: round(x, 6) for name, x in numbers.items()}


def exercise_corner(study):
    """A corner: pose of its board, place on the board, and where it was found."""
    camera = _camera(exercise_camera(study))
    if study.refusal("zhang"):
        T = pose(rotation_from_vector([0.3, -0.2, 0.1]), [-2.0, -1.0, 12.0])
        point = np.array([4.0, 3.0])
        pixel = _predicted(camera, T, point) + [0.21, -0.13]
    else:
        index = int(study.array("calibrated", part="fit")[0])
        image = study.image(index)
        T = study.array("zhang.T_camera_grid", part="fit")[0]
        k = np.flatnonzero(np.isfinite(image.corners[:, 0]))[-1]
        pitch = study.settings["pitch_mm"] or 1.0
        point = pitch * np.array([k % image.columns, k // image.columns], float)
        pixel = image.corners[k]
    return {
        "T_camera_grid": np.round(T, 6),
        "point": point,
        "found": np.round(pixel, 3),
    }


def field_of_view_task(camera):
    """One angle to each side, from the principal point to the rim, half a pixel
    outside the centre of the last pixel; their sum."""
    return {
        "expected": lambda: field_of_view_deg(camera),
        "hint": "the rims are half a pixel outside; one angle to each side",
        "slips": {
            "That is in radians.": lambda: np.radians(field_of_view_deg(camera)),
            "That is half of it.": lambda: field_of_view_deg(camera) / 2,
        },
    }


def residual_task(camera, corner):
    """Pose, division by z, the radial factor, the calibration matrix: that is the
    predicted pixel, and it is subtracted from the found one."""
    return {
        "expected": lambda: residual_of(camera, corner),
        "tolerance": 0.02,
        "hint": "x / z and y / z first, then the radial factor, then K",
        "slips": {
            "That is predicted less found.": lambda: -residual_of(camera, corner),
            "The radial terms are missing.": lambda: residual_of(
                camera | {"k1": 0.0, "k2": 0.0}, corner
            ),
        },
    }


def field_of_view_deg(camera):
    """Horizontal field of view without distortion, from rim to rim of the image."""
    left = (camera["u0"] + 0.5) / camera["fx"]
    right = (camera["width"] - 0.5 - camera["u0"]) / camera["fx"]
    return float(np.degrees(np.arctan(left) + np.arctan(right)))


def residual_of(camera, corner):
    """Found corner less prediction (2,) in px."""
    predicted = _predicted(_camera(camera), corner["T_camera_grid"], corner["point"])
    return corner["found"] - predicted


def _predicted(camera, T_camera_grid, point):
    """Pixel (2,) of a point of the board."""
    return camera.project(transform(T_camera_grid, np.array([[*point, 0.0]]))).pixels[0]


def _camera(numbers):
    K = [
        [numbers["fx"], 0, numbers["u0"]],
        [0, numbers["fy"], numbers["v0"]],
        [0, 0, 1],
    ]
    return PerspectiveCamera(
        np.array(K, float),
        [numbers["k1"], numbers["k2"]],
        numbers["width"],
        numbers["height"],
    )
