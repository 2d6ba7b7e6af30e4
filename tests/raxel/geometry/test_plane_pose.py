"""The pose of a plane from its homography: exact, and free of scale and sign."""

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.geometry import pose, pose_from_homography, rotation_from_vector


@pytest.mark.parametrize("scale", [1.0, -1.0, 3.7e-3, -250.0])
def test_a_pose_comes_back_whatever_the_scale(scale):
    T = pose(rotation_from_vector(np.array([0.3, -0.5, 1.1])), [20.0, -30.0, 400.0])
    H = scale * np.column_stack([T[:3, 0], T[:3, 1], T[:3, 3]])
    assert np.allclose(pose_from_homography(H), T, atol=1e-9)


def test_a_homography_that_is_nearly_one_gives_a_rotation():
    rng = np.random.default_rng(0)
    T = pose_from_homography(rng.standard_normal((3, 3)))
    assert np.allclose(T[:3, :3].T @ T[:3, :3], np.eye(3), atol=1e-12)
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1)
    assert T[2, 3] > 0


def test_columns_without_a_plane_are_refused():
    for H in (np.zeros((3, 3)), np.full((3, 3), np.nan)):
        with pytest.raises(InputError, match="columns are zero"):
            pose_from_homography(H)
    with pytest.raises(InputError, match="rank below 2"):
        pose_from_homography(np.ones((3, 3)))


def test_both_axes_of_the_plane_count_alike():
    T = pose(rotation_from_vector(np.array([0.3, -0.5, 1.1])), [20.0, -30.0, 400.0])
    H = np.column_stack([T[:3, 0], 1.1 * T[:3, 1], T[:3, 3]])
    found, swapped = (
        pose_from_homography(H[:, order]) for order in ([0, 1, 2], [1, 0, 2])
    )
    np.testing.assert_allclose(found[:3, 3], swapped[:3, 3], rtol=1e-12)
    np.testing.assert_allclose(found[:3, 3], T[:3, 3] / 1.05, rtol=1e-12)
