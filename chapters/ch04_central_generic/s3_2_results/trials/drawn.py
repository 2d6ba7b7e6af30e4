"""Grids set up anew before a rig, and what is decoded of them."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from chapters.shared.central_sets import LINEAR_GRIDS
from chapters.shared.decoding_errors import drawn_again, lattice_rays, true_lattice
from chapters.shared.rigs import rig_named

# px between the rays of a trial: some thousand of them meet all three grids.
STEPS = {"quick": 4, "full": 9}


class DrawnGrids(NamedTuple):
    """Three grids, and where the rays of a lattice of pixels meet them.

    true, decoded: (3, N, 2) mm, NaN beside a grid; pixels: (N, 2); T_camera_grid:
    (3, 4, 4).
    """

    true: np.ndarray
    decoded: np.ndarray
    pixels: np.ndarray
    T_camera_grid: np.ndarray


@cache
def _rays_of(rig, step):
    camera = rig_named(rig).camera
    return camera, *lattice_rays(camera, step)


def drawn_grids(rig, step, rng, errors=None):
    """The DrawnGrids of a rig; decoded with `DecodingErrors`, or as they are."""
    camera, rays, shape = _rays_of(rig, step)
    setup = rig_named(rig)
    poses = setup.draw_poses(rng, LINEAR_GRIDS)
    true, decoded = [], []
    for T in poses:
        points, cosine = true_lattice(rays, shape, T, setup.target.monitor_mm)
        seen = points
        if errors is not None:
            seen = drawn_again(errors, points, cosine, rng, step)
        true.append(points.reshape(-1, 2))
        decoded.append(seen.reshape(-1, 2))
    v, u = np.mgrid[step // 2 : camera.height : step, step // 2 : camera.width : step]
    pixels = np.column_stack([u.ravel(), v.ravel()]).astype(float)
    return DrawnGrids(np.array(true), np.array(decoded), pixels, poses)
