"""Bad input of raxel.multiview: a line that says what was found and what to do."""

import numpy as np
import pytest

from raxel.cameras import PerspectiveCamera, Rays
from raxel.geometry import pose, rotation_from_vector
from raxel.multiview import (
    RayView,
    algebraic_conic,
    bundle_rays,
    circle_outline,
    facing_plane,
    fit_circle,
    fit_conic,
    fit_cylinder,
    fit_plane,
    measured_circle,
    plane_image,
    points_on_plane,
    triangulate,
    view_of_plane,
)
from raxel.multiview.generalised_motion import (
    generalised_pose_ransac,
    motion_information,
    refine_generalised_pose,
)
from raxel.multiview.ray_noise import angular_rays, rays_of_pixels
from tests.raised import raises_line

RNG = np.random.default_rng(5)
COUNT = 60
T = pose(rotation_from_vector(np.array([0.02, 0.1, -0.05])), np.array([60.0, 10, -20]))
STAND = np.stack([np.eye(4), T])
POINTS = RNG.uniform([-200, -200, 500], [200, 200, 900], (COUNT, 3))


def rays_to(points, motion):
    """Rays (N,) from places of their own to points, in a moved frame, with noise."""
    seen = points @ motion[:3, :3].T + motion[:3, 3]
    origins = RNG.uniform(-40, 40, seen.shape)
    d = seen - origins
    d = d / np.linalg.norm(d, axis=1, keepdims=True)
    d = d + 2e-4 * RNG.standard_normal(d.shape)
    d = d / np.linalg.norm(d, axis=1, keepdims=True)
    return Rays(origins, d, np.ones(len(d), bool))


def only(rays, which):
    return Rays(*(field[which] for field in rays))


def robust(A, B, seed=0):
    return generalised_pose_ransac(A, B, np.random.default_rng(seed), 2e-3)


def mismatched(right, seed):
    """Rays of the second view of which so many are matched rightly."""
    which, rng = np.arange(COUNT), np.random.default_rng(seed)
    which[right:] = rng.permutation(which[right:])
    return only(B, which)


A, B = rays_to(POINTS, np.eye(4)), rays_to(POINTS, T)
VIEWS = [RayView(A), RayView(B)]
FOUR = np.arange(COUNT) % 4
FAR = A._replace(origins=1e200 * A.origins)
KNOWN = angular_rays(A, 1e-3)
SCALED = T * [[2, 2, 2, 1]] * 1.0
CAMERA = PerspectiveCamera([[500, 0, 160], [0, 500, 120], [0, 0, 1]], [-0.1], 320, 240)
PLANE = pose(np.eye(3), np.array([0.0, 0, 500]))
PIXELS = RNG.uniform([60, 60], [260, 180], (COUNT, 2))
IMAGE = np.zeros((240, 320), np.uint8)
RING = np.column_stack([np.cos(np.arange(30)), np.sin(np.arange(30))])


def at_view(index):
    return [RayView(A), RayView(B, index)]


@pytest.mark.parametrize(
    ("words", "call"),
    [
        ("found none", lambda: robust(only(A, FOUR[:0]), only(B, FOUR[:0]))),
        ("found ndarray", lambda: robust(A.origins, B)),
        ("found NoneType", lambda: triangulate([RayView(None)] * 2, STAND)),
        ("4 distinct of 60 pairs", lambda: robust(only(A, FOUR), only(B, FOUR))),
        ("by chance", lambda: robust(A, mismatched(10, 2), 2)),
        ("origin at", lambda: robust(FAR, B)),
        ("origin at", lambda: triangulate([RayView(FAR), RayView(B)], STAND)),
        ("no rigid motion", lambda: refine_generalised_pose(A, B, None)),
        ("no rigid motion", lambda: refine_generalised_pose(A, B, SCALED)),
        ("no rigid motion", lambda: motion_information(T[:3], A, B)),
        ("about: invalid; give", lambda: angular_rays(A, about=[np.nan, 0, 0])),
        ("deviations: found shape", lambda: angular_rays(A, [1.0, 2.0])),
        ("finite and above 0", lambda: angular_rays(A, np.inf)),
        ("found pixels", lambda: rays_of_pixels(CAMERA, np.zeros((5, 3)))),
        ("give one, or one", lambda: rays_of_pixels(CAMERA, PIXELS, -1.0)),
        (
            "covariance: found",
            lambda: robust(KNOWN._replace(covariance=np.eye(6)), B),
        ),
        (
            "covariance: found",
            lambda: motion_information(
                T, KNOWN._replace(covariance=np.nan * KNOWN.covariance), B
            ),
        ),
        (
            "negative variances",
            lambda: robust(KNOWN._replace(covariance=-KNOWN.covariance), B),
        ),
        ("must be rigid", lambda: triangulate(VIEWS, np.stack([T, SCALED]))),
        ("must be rigid", lambda: bundle_rays(VIEWS, np.stack([T, SCALED]))),
        ("give an integer", lambda: triangulate(at_view(np.arange(60) / 2), STAND)),
        ("give an integer", lambda: bundle_rays(at_view(np.arange(60) + 1e9), STAND)),
        ("below 10000000", lambda: triangulate(at_view(10**9 + np.arange(60)), STAND)),
        ("found 0 views", lambda: bundle_rays([], np.zeros((0, 4, 4)))),
        ("found view 1.5", lambda: bundle_rays(VIEWS, STAND, held=1.5)),
        ("found view True", lambda: bundle_rays(VIEWS, STAND, held=True)),
        ("distance of 0", lambda: bundle_rays(VIEWS, [T, T], held=1)),
        ("found pixels", lambda: points_on_plane(CAMERA, PIXELS[0], PLANE)),
        ("no rigid motion", lambda: points_on_plane(CAMERA, PIXELS, None)),
        ("no rigid motion", lambda: points_on_plane(CAMERA, PIXELS, 2 * PLANE)),
        ("no rigid motion", lambda: plane_image(CAMERA, IMAGE, PLANE * np.nan, 0,
                                                  (9, 9), 1.0)),
        ("no rigid motion", lambda: view_of_plane(CAMERA, PLANE[:3], 1.0)),
        ("no rigid motion", lambda: facing_plane(None, np.zeros(3), 5.0)),
        ("sigma", lambda: measured_circle(CAMERA, PIXELS, PLANE, [0.1, 0.2])),
        ("covariance", lambda: measured_circle(CAMERA, PIXELS, PLANE, 0.1, np.eye(3))),
        ("radius -1", lambda: circle_outline(CAMERA, PLANE, np.zeros(2), -1.0)),
        ("centre", lambda: circle_outline(CAMERA, PLANE, np.zeros(3), 9.0)),
        ("size of", lambda: plane_image(CAMERA, IMAGE, PLANE, 0, (9, 9), 0.0)),
        ("size of", lambda: plane_image(CAMERA, IMAGE, PLANE, 0, (1e9, 1e9), 1.0)),
        ("a scale of -1", lambda: view_of_plane(CAMERA, PLANE, -1.0)),
        ("at most 268435456 pixels", lambda: view_of_plane(CAMERA, PLANE, 1e-9)),
        ("give both", lambda: view_of_plane(CAMERA, PLANE, 1.0, np.zeros(2))),
        ("3 distinct of 30", lambda: fit_circle(np.repeat(RING[:3], 10, axis=0))),
        ("3 distinct of 30", lambda: fit_plane(np.repeat(POINTS[:3], 10, axis=0))),
        ("5 distinct of 50", lambda: algebraic_conic(np.repeat(RING[:5], 10, axis=0))),
        ("7 distinct of 70", lambda: fit_cylinder(np.repeat(POINTS[:7], 10, axis=0))),
        ("near infinity", lambda: fit_circle(1e180 * RING)),
        ("near infinity", lambda: fit_conic(1e180 * RING)),
        ("near infinity", lambda: fit_plane(1e180 * POINTS)),
    ],
)  # fmt: skip
def test_bad_input_is_rejected_in_one_line(words, call):
    with raises_line(words):
        call()


def test_significant_few_inliers_are_accepted():
    found = robust(A, mismatched(25, 0))
    assert found.inliers[:25].sum() > 22
    assert found.inliers[25:].sum() < 4
    assert robust(only(A, slice(8)), only(B, slice(8))).inliers.all()


def test_start_at_infinity_is_accepted():
    starts = np.where(np.arange(COUNT)[:, None] < 5, np.inf, POINTS)
    found = bundle_rays(VIEWS, STAND, points=starts)
    same = bundle_rays(VIEWS, STAND, points=POINTS)
    assert found.rms == pytest.approx(same.rms, rel=1e-6)
