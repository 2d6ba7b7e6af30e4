"""The pose of a plane from its homography: exact, and free of scale and sign."""

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.geometry import pose, pose_from_homography, rotation_from_vector


@pytest.mark.parametrize("scale", [1.0, -1.0, 3.7e-3, -250.0])
def test_pose_from_homography_ignores_scale(scale):
    T = pose(rotation_from_vector(np.array([0.3, -0.5, 1.1])), [20.0, -30.0, 400.0])
    H = scale * np.column_stack([T[:3, 0], T[:3, 1], T[:3, 3]])
    assert np.allclose(pose_from_homography(H), T, atol=1e-9)


def test_noisy_homography_gives_rotation():
    T = pose_from_homography(np.random.default_rng(0).standard_normal((3, 3)))
    assert np.allclose(T[:3, :3].T @ T[:3, :3], np.eye(3), atol=1e-12)
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1)
    assert T[2, 3] > 0


def test_degenerate_columns_are_rejected():
    for H in (np.zeros((3, 3)), np.full((3, 3), np.nan)):
        with pytest.raises(InputError, match="columns are zero"):
            pose_from_homography(H)
    with pytest.raises(InputError, match="rank below 2"):
        pose_from_homography(np.ones((3, 3)))


def test_pose_from_homography_weighs_axes_equally():
    T = pose(rotation_from_vector(np.array([0.3, -0.5, 1.1])), [20.0, -30.0, 400.0])
    H = np.column_stack([T[:3, 0], 1.1 * T[:3, 1], T[:3, 3]])
    found, swapped = (
        pose_from_homography(H[:, order]) for order in ([0, 1, 2], [1, 0, 2])
    )
    np.testing.assert_allclose(found[:3, 3], swapped[:3, 3], rtol=1e-12)
    np.testing.assert_allclose(found[:3, 3], T[:3, 3] / 1.05, rtol=1e-12)
