"""Exercises of an image set's page: data and expected answers."""

import numpy as np

from raxel.cameras import PerspectiveCamera
from raxel.geometry import pose, rotation_from_vector, transform

MADE_UP = {"fx": 500.0, "fy": 502.0, "u0": 322.0, "v0": 238.0, "k1": -0.25, "k2": 0.08}


def exercise_camera(study):
    """Return the set's Zhang camera as plain numbers, or an invented one."""
    size = {k: study.settings[f"{k}_px"] for k in ("width", "height")}
    if study.failure("zhang"):
        return size | MADE_UP
    numbers = {
        name: study.fit("zhang", f"{name}_px") for name in ("fx", "fy", "u0", "v0")
    }
    numbers |= {name: study.fit("zhang", name) for name in ("k1", "k2")}
    return size | {name: round(x, 6) for name, x in numbers.items()}


def exercise_corner(study):
    """Return a corner: pose of its board, position on the board, detected pixel."""
    camera = _camera(exercise_camera(study))
    if study.failure("zhang"):
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
    """The sum of two angles, from the principal point to each edge. The edge is half a
    pixel outside the centre of the last pixel."""
    return {
        "expected": lambda: field_of_view_deg(camera),
        "hint": "the edges are half a pixel outside; add one angle per side",
        "slips": {
            "That is in radians.": lambda: np.radians(field_of_view_deg(camera)),
            "That is half of it.": lambda: field_of_view_deg(camera) / 2,
        },
    }


def residual_task(camera, corner):
    """Pose, division by z, radial factor and calibration matrix give the predicted
    pixel. The residual is the detected pixel minus this one."""
    return {
        "expected": lambda: residual_of(camera, corner),
        "tolerance": 0.02,
        "hint": "x / z and y / z first, then the radial factor, then K",
        "slips": {
            "That is predicted minus detected.": lambda: -residual_of(camera, corner),
            "The radial terms are missing.": lambda: residual_of(
                camera | {"k1": 0.0, "k2": 0.0}, corner
            ),
        },
    }


def field_of_view_deg(camera):
    """Return the horizontal field of view without distortion, edge to edge."""
    left = (camera["u0"] + 0.5) / camera["fx"]
    right = (camera["width"] - 0.5 - camera["u0"]) / camera["fx"]
    return float(np.degrees(np.arctan(left) + np.arctan(right)))


def residual_of(camera, corner):
    """Return the detected corner minus the prediction (2,) in px."""
    predicted = _predicted(_camera(camera), corner["T_camera_grid"], corner["point"])
    return corner["found"] - predicted


def _predicted(camera, T_camera_grid, point):
    """Return the pixel (2,) of a point of the board."""
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
