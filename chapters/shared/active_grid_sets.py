"""Rendered sets of active grids: decoded as anybody's, and their truth for scoring."""

from __future__ import annotations

import json
from typing import NamedTuple

import numpy as np

from raxel.cameras import load_camera
from raxel.features.active_grid import decode
from raxel.sets import load_set, read_image


class ScoredGrid(NamedTuple):
    """What is decoded from a view, and what is true of it, for scoring alone.

    decoded: Decoded; points: (H, W, 2) mm, the true point of each pixel, NaN beside
    the monitor; T_camera_grid: (4, 4).
    """

    name: str
    decoded: object
    points: np.ndarray
    T_camera_grid: np.ndarray


def decoded_grids(folder, count=None, **options):
    """Yield (name, Decoded) of each view of a rendered set, or of the first `count`.

    options: of `decode`. As in the thesis, no response is measured or corrected.
    """
    image_set = load_set(folder)
    for view in image_set.views[:count]:
        pictures = np.array(
            [read_image(image_set, shown.image) for shown in view.patterns]
        )
        settings = {"linear": True, **options}
        yield view.label, decode(pictures, view.patterns, image_set.target, **settings)


def seen_grids(folder, count=None, **options):
    """Yield the `ScoredGrid` of each view of a rendered set, as `decoded_grids`."""
    poses = true_poses(folder)
    for name, found in decoded_grids(folder, count, **options):
        with np.load(folder / "truth" / f"{name}.npz") as truth:
            points = truth["points_mm"]
        yield ScoredGrid(name, found, points, poses[name])


def true_camera(folder):
    """The camera that took a rendered set, for scoring."""
    return load_camera(folder / "truth" / "camera.npz")


def true_poses(folder):
    """{view: T_camera_grid (4, 4)} of a rendered set, mm, for scoring."""
    text = (folder / "truth" / "poses.json").read_text("utf-8")
    poses = json.loads(text)["T_camera_target"]
    return {name: np.array(T) for name, T in poses.items()}
