"""Scenes of the wide-angle camera of chapter 4, and errors of what is made of them."""

import numpy as np
from scipy.spatial.transform import Rotation

from chapters.shared.central.camera import CENTRE_MM, SIDE, draw_scene, radial_lens
from raxel.calibration import linear_well_conditioned

LENS = radial_lens()


def drawn(seed, camera=LENS, *, noise=0.5, **more):
    """A Scene, and the linear stage's solution of its noisy points."""
    scene = draw_scene(camera, noise, np.random.default_rng(seed), **more)
    return scene, linear_well_conditioned(scene.noisy, side=SIDE)


def centre_error(centre):
    return float(np.linalg.norm(centre - CENTRE_MM))


def plain_error(result, scene):
    """Estimate less truth in the unknowns of ConsistentResult.covariance."""
    parts = [result.centre - CENTRE_MM]
    for found, true in zip(result.T_base_grid[1:], scene.T_base_grid[1:], strict=True):
        R = found[:3, :3].T @ true[:3, :3]
        parts += [-Rotation.from_matrix(R).as_rotvec(), found[:3, 3] - true[:3, 3]]
    return np.concatenate(parts)
