"""Motion from matched rays: linear, whatever the field of view."""

import numpy as np

from raxel.geometry.poses import (
    angle_between_rotations,
    cross_matrix,
    pose,
    rotation_from_vector,
    transform,
)
from raxel.multiview.motion_samples import (
    _whitening,
    depths,
    epipolar_angles,
    motion_of_essential,
    relative_pose,
)
from tests.raised import raises_code
from tests.ray_scenes import unit

SHIFT = np.array([0.6, -0.3, 0.2])
T_TRUE = pose(rotation_from_vector([0.1, 0.25, -0.15]), SHIFT / np.linalg.norm(SHIFT))


def all_around(seed, count=100, noise=0.0, scale=5.0):
    """Points in every direction about the camera, and their rays in both views."""
    rng = np.random.default_rng(seed)
    X = scale * rng.standard_normal((count, 3))
    near = [np.linalg.norm(x, axis=1) < 1 for x in (X, transform(T_TRUE, X))]
    X = X[~np.any(near, axis=0)]
    views = [unit(X), unit(transform(T_TRUE, X))]
    return X, [unit(v + noise * rng.standard_normal(v.shape)) for v in views], rng


def ahead(seed, count=100):
    """Points within 40 degrees of the axis of both views."""
    rng = np.random.default_rng(seed)
    X = rng.uniform([-2, -2, 4], [2, 2, 9], (count, 3))
    return X, unit(X), unit(transform(T_TRUE, X)), rng


def errors(T):
    turn = angle_between_rotations(T[:3, :3], T_TRUE[:3, :3])
    return turn, np.arccos(np.clip(T[:3, 3] @ T_TRUE[:3, 3], -1, 1))


def test_relative_pose_is_exact_all_around():
    X, (d_1, d_2), _ = all_around(0)
    assert np.degrees(np.arccos((d_1 @ d_1.T).min())) > 170
    found = relative_pose(d_1, d_2)
    assert np.abs(found.T_2_1 - T_TRUE).max() < 1e-10
    assert found.ahead == 1.0
    assert found.rms < 1e-12
    true = cross_matrix(T_TRUE[:3, 3]) @ T_TRUE[:3, :3]
    sign = np.sign(np.sum(true * found.essential))
    np.testing.assert_allclose(sign * found.essential, true, atol=1e-10)
    np.testing.assert_allclose(
        depths(found.T_2_1, d_1, d_2)[:, 0], np.linalg.norm(X, axis=1), rtol=1e-6
    )


def test_points_in_front_are_along_the_ray():
    # Everything lies behind the plane through the centre that a pinhole looks from.
    _, d_1, d_2, _ = ahead(1)
    flip = np.diag([1.0, -1.0, -1.0])
    found = relative_pose(d_1 @ flip, d_2 @ flip).T_2_1
    assert np.abs(flip @ found[:3, :3] @ flip - T_TRUE[:3, :3]).max() < 1e-10
    assert np.abs(flip @ found[:3, 3] - T_TRUE[:3, 3]).max() < 1e-10


def test_essential_system_is_normalised():
    """A target in a small part of the field, seen along an axis of any direction."""
    rng = np.random.default_rng(4)
    X = np.array([0.0, 0.0, 9.0]) + rng.uniform(-1, 1, (80, 3))
    clean = unit(X), unit(transform(T_TRUE, X))
    plain, ours = [], []
    for _ in range(30):
        d_1, d_2 = (unit(d + 3e-4 * rng.standard_normal(d.shape)) for d in clean)
        rows = (d_2[:, :, None] * d_1[:, None, :]).reshape(-1, 9)
        E = np.linalg.svd(rows)[2][8].reshape(3, 3)
        plain.append(errors(motion_of_essential(E, d_1, d_2)[0])[0])
        ours.append(errors(relative_pose(d_1, d_2).T_2_1)[0])
    assert np.median(ours) < 0.7 * np.median(plain)


def test_epipolar_angle_is_rotation_of_both_rays():
    # One pair, its rays turned by known angles out of the epipolar plane.
    d_1, d_2 = np.array([[0.0, 0.0, 1.0]]), unit(np.array([[0.3, 0.0, 1.0]]))
    T = pose(np.eye(3), [1.0, 0.0, 0.0])
    missed = epipolar_angles(T, d_1, unit(d_2 + 1e-4 * np.array([0.0, 1.0, 0.0])))[0]
    # Least squares shares it out: the root of the sum of squares is smaller.
    assert 0.5 * 1e-4 < abs(missed) < 1e-4
    assert epipolar_angles(T, d_1, d_2)[0] == 0


def test_relative_pose_rejects_degenerate_pairs():
    rng = np.random.default_rng(8)
    flat = rng.uniform([-2, -2, 5], [2, 2, 5], (50, 3))
    turn = pose(T_TRUE[:3, :3], np.zeros(3))
    X = rng.standard_normal((50, 3))
    rejected = [
        ("degenerate-points", unit(flat), unit(transform(T_TRUE, flat))),
        ("degenerate-points", unit(X), unit(transform(turn, X))),
        ("too-few-rays", unit(X[:7]), unit(X[:7])),
        ("shape", unit(X[:9]), unit(X[:8])),
        ("not-finite", np.where(np.arange(50)[:, None] == 3, np.nan, X), X),
    ]
    for code, d_1, d_2 in rejected:
        with raises_code(code):
            relative_pose(d_1, d_2)


def test_whitened_directions_have_unit_second_moment():
    _, d, _, _ = ahead(3)
    white = d @ _whitening(d).T
    np.testing.assert_allclose(white.T @ white / len(d), np.eye(3), atol=1e-10)
