"""A mirror after bending, from matches of a scene that was not measured."""

import numpy as np
import pytest

from raxel.calibration import clamp_of_camera, linear_update, met_points
from tests.bent_mirror_scenes import (
    bent,
    edge_pixels,
    force_pixel,
    heights_at,
    spline_like,
    visible_pixels,
)
from tests.raised import raises_code

FLAT = spline_like(bent(0.0), 0.0)
CLAMP = clamp_of_camera(FLAT, edge_pixels())
PUSH = 2.5  # mm; after 5 no distant feature is left in the last knot interval
OUTLINE = visible_pixels(PUSH, 2, 2)


def scene(depth_mm, push=PUSH):
    """Pixels (N, 2) before and after of points so far along the rays before."""
    before = visible_pixels(0.0, 30, 12)
    rays = bent(0.0).rays(before)
    return before, bent(push).project(rays.origins + depth_mm * rays.directions).pixels


def share(camera):
    """Of the push, how much was found."""
    return heights_at(camera, force_pixel(PUSH))[0] / PUSH


@pytest.mark.parametrize(("depth", "tol"), [(800.0, 0.04), (4000.0, 0.04), (1e7, 0.01)])
def test_linear_update_finds_expected_share_of_deflection(depth, tol):
    found = linear_update(FLAT, *scene(depth), CLAMP, outline=OUTLINE)
    assert share(found.camera) == pytest.approx(depth / (depth + 410), abs=tol)


BEFORE, AFTER = scene(800.0)
HALF = np.where(BEFORE[:, :1] > BEFORE[:, 0].mean(), np.nan, BEFORE)


@pytest.mark.parametrize(
    ("code", "change"),
    [
        ("wrong-shape", {"before": np.zeros((360, 3))}),
        ("wrong-shape", {"after": np.zeros(360)}),
        ("unmatched-features", {"after": AFTER[1:]}),
        ("no-clamp", {"clamp": None}),
        ("wrong-shape", {"outline": np.full((3, 2), np.nan)}),
        (
            "too-few-features",
            {"before": BEFORE[5:10], "after": visible_pixels(0.0, 5, 1)},
        ),
    ],
)
def test_self_calibration_rejects_invalid_input(code, change):
    given = {"before": BEFORE, "after": AFTER, "clamp": CLAMP, "outline": OUTLINE}
    given |= change
    outline = given.pop("outline")
    with raises_code(code):
        linear_update(FLAT, *given.values(), outline=outline)


@pytest.mark.parametrize(
    ("pixels", "outline"),
    [(scene(4000.0, push=5.0), visible_pixels(5.0)), ((HALF, AFTER), OUTLINE)],
)
def test_outermost_interval_without_features_is_rejected(pixels, outline):
    with raises_code("no-feature-at-end"):
        linear_update(FLAT, *pixels, CLAMP, outline=outline)


def test_met_points_are_between_rays_and_in_front():
    first = (np.zeros((2, 3)), np.array([[0, 0, 1.0], [0, 0, 1.0]]))

    class Second:
        origins = np.array([[1.0, 0.2, 0], [1.0, 0, 0]])
        directions = np.array([[-0.6, 0, 0.8], [0.6, 0, 0.8]])

    points, ahead = met_points(first, Second)
    np.testing.assert_allclose(points[0], [0, 0.1, 4 / 3], atol=1e-12)
    np.testing.assert_array_equal(ahead, [True, False])
