"""A mirror after bending, from matches and edges of a scene that is not known."""

import numpy as np
import pytest

from raxel.calibration.mirror.clamp import clamp_of_camera
from raxel.calibration.mirror.self_calibration import (
    feedback_updates,
    linear_update,
    met_points,
    one_depth_update,
    scene_matches,
)
from raxel.calibration.mirror.straight_edges import straight_edges_update
from raxel.calibration.mirror.update import MirrorSettings
from raxel.errors import CalibrationError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform
from tests.bent_mirror_scenes import (
    bent,
    edge_pixels,
    force_pixel,
    grid_pose,
    heights_at,
    spline_like,
    visible_pixels,
)

FLAT = spline_like(bent(0.0), 0.0)
CLAMP = clamp_of_camera(FLAT, edge_pixels())
PUSH = 2.5  # mm; after 5 no distant feature is left in the last knot interval
OUTLINE = visible_pixels(PUSH, 2, 2)
PRIOR = MirrorSettings(prior_sd=0.1)


def scene(depth_mm, rng=None, push=PUSH):
    """Pixels (N, 2) before and after of points so far along the rays before."""
    before = visible_pixels(0.0, 30, 12)
    rays = bent(0.0).rays(before)
    points = rays.origins + depth_mm * rays.directions
    after = bent(push).project(points).pixels
    if rng is not None:
        before = before + 0.2 * rng.standard_normal(before.shape)
        after = after + 0.2 * rng.standard_normal(after.shape)
    return before, after


def share(camera):
    """Of the push, how much was found."""
    return heights_at(camera, force_pixel(PUSH))[0] / PUSH


@pytest.mark.parametrize("depth", [800.0, 4000.0])
def test_the_linear_stage_finds_its_share_of_the_deflection(depth):
    found = linear_update(FLAT, *scene(depth), CLAMP, outline=OUTLINE)
    assert share(found.camera) == pytest.approx(depth / (depth + 410), abs=0.04)
    assert found.depth_mm == np.inf


def test_a_scene_at_infinity_is_found_whole():
    found = linear_update(FLAT, *scene(1e7), CLAMP, outline=OUTLINE)
    assert share(found.camera) == pytest.approx(1, abs=0.01)


def test_feedback_stays_about_where_the_linear_stage_put_it():
    """The points that it feeds back lie on the rays of the shape that made them."""
    rng = np.random.default_rng(0)
    found = feedback_updates(FLAT, *scene(800.0, rng), CLAMP, outline=OUTLINE)
    assert len(found) > 1
    assert share(found[-1].camera) < 0.85
    assert found[-1].rms < 3


def test_one_depth_is_found_with_the_shape():
    rng = np.random.default_rng(1)
    found = one_depth_update(FLAT, *scene(800.0, rng), CLAMP, PRIOR, outline=OUTLINE)
    linear = linear_update(FLAT, *scene(800.0, rng), CLAMP, outline=OUTLINE)
    assert found.depth_mm == pytest.approx(800, rel=0.3)
    assert abs(share(found.camera) - 1) < abs(share(linear.camera) - 1) / 2


@pytest.mark.parametrize("noise_px", [0.3, 0.6])
def test_features_that_only_noise_moves_miss_by_one_standard_deviation(noise_px):
    rng, push = np.random.default_rng(2), 0.3
    before, after = scene(800.0, push=push)
    after = after + noise_px * rng.standard_normal(after.shape)
    settings = MirrorSettings(prior_sd=0.1, noise_px=noise_px)
    outline = visible_pixels(push, 2, 2)
    found = one_depth_update(FLAT, before, after, CLAMP, settings, outline=outline)
    assert found.rms == pytest.approx(1, abs=0.12)


def test_depth_without_a_prior_is_refused():
    with pytest.raises(CalibrationError, match="without a prior"):
        one_depth_update(FLAT, *scene(800.0), CLAMP, MirrorSettings())


def test_too_few_and_unmatched_features_are_refused():
    before, after = scene(800.0)
    with pytest.raises(CalibrationError, match="5 features are matched"):
        scene_matches(FLAT, before[5:10], visible_pixels(0.0, 5, 1), CLAMP)
    with pytest.raises(CalibrationError, match="give matched ones"):
        scene_matches(FLAT, before, after[1:], CLAMP)
    with pytest.raises(CalibrationError, match="last knot interval along u"):
        linear_update(
            FLAT, *scene(4000.0, push=5.0), CLAMP, outline=visible_pixels(5.0)
        )
    half = np.where(before[:, :1] > before[:, 0].mean(), np.nan, before)
    with pytest.raises(CalibrationError, match="knot interval along u"):
        linear_update(FLAT, half, after, CLAMP, outline=OUTLINE)


def test_points_of_two_rays_lie_between_them_and_ahead():
    first = (np.zeros((2, 3)), np.array([[0, 0, 1.0], [0, 0, 1.0]]))

    class Second:
        origins = np.array([[1.0, 0.2, 0], [1.0, 0, 0]])
        directions = np.array([[-0.6, 0, 0.8], [0.6, 0, 0.8]])

    points, ahead = met_points(first, Second)
    np.testing.assert_allclose(points[0], [0, 0.1, 4 / 3], atol=1e-12)
    np.testing.assert_array_equal(ahead, [True, False])


def edges(camera, distance=1500.0):
    """Pixels of straight edges of a board so far away, seen in a true camera."""
    T = grid_pose(distance)
    length, made = np.linspace(-1, 1, 15), []
    for angle in np.linspace(0, np.pi, 5, endpoint=False):
        way = np.array([np.cos(angle), np.sin(angle)])
        for aside in (-0.12, 0.1):
            offset = aside * distance * np.array([-way[1], way[0]])
            made.append(117 + 0.2 * distance * length[:, None] * way + offset)
    points = transform(T, on_plane(np.vstack(made)))
    return np.split(camera.project(points).pixels, len(made))


def test_straight_edges_take_bends_out_of_a_wrong_shape():
    true = spline_like(bent(PUSH), PUSH)
    c = true.coefficients.copy()
    c[3] *= 1 - 1e-4
    wrong = type(true).on_grid(
        true.viewer, true.grid, c.ravel(order="F"), true.quantity
    )
    pixels = edges(bent(PUSH))
    known = (FLAT, edges(bent(0.0)))
    for before in (None, known):
        found = straight_edges_update(
            wrong, pixels, CLAMP, noise=1e-4, prior_sd=1.0, before=before
        )
        assert found.edges > 5
        assert found.rms < found.start_rms / 2


def test_what_edges_leave_are_angles_off_the_planes_of_their_rays():
    pixels, noise = edges(bent(PUSH)), 1e-4
    found = straight_edges_update(FLAT, pixels, CLAMP, noise=noise, prior_sd=1.0)
    off = []
    for edge in pixels:
        rays = FLAT.rays(edge)
        V = rays.directions[rays.valid]
        if len(V) >= 4:
            normal = np.linalg.eigh(V.T @ V)[1][:, 0]
            off.extend(np.arcsin(V @ normal))
    assert found.start_rms == pytest.approx(np.sqrt(np.mean(np.square(off))) / noise)


def test_edges_without_pixels_in_the_mirror_are_refused():
    with pytest.raises(CalibrationError, match="none of 1"):
        straight_edges_update(
            FLAT, [np.full((9, 2), np.nan)], CLAMP, noise=1e-4, prior_sd=0.1
        )


@pytest.mark.parametrize(
    ("words", "change"),
    [
        ("pixels before are", {"before": np.zeros((360, 3))}),
        ("pixels after are", {"after": np.zeros(360)}),
        ("no clamp", {"clamp": None}),
        ("outline", {"outline": np.full((3, 2), np.nan)}),
        ("must be above zero", {"settings": PRIOR._replace(noise_px=0.0)}),
        ("must be above zero", {"settings": PRIOR._replace(prior_sd=0.0)}),
    ],
)
def test_what_is_no_input_is_refused_in_a_line(words, change):
    before, after = scene(800.0)
    given = {"before": before, "after": after, "clamp": CLAMP, "settings": PRIOR}
    given = given | {"outline": OUTLINE} | change
    outline = given.pop("outline")
    for update in (linear_update, feedback_updates, one_depth_update):
        with pytest.raises(CalibrationError, match=words) as refusal:
            update(FLAT, *given.values(), outline=outline)
        assert str(refusal.value).isprintable()


def test_wrong_matches_are_flagged():
    rng = np.random.default_rng(2)
    before, after = scene(800.0, rng)
    right = one_depth_update(FLAT, before, after, CLAMP, PRIOR, outline=OUTLINE)
    assert not any("matched wrongly" in flag for flag in right.flags)
    after[::3] = rng.permutation(after[::3])
    wrong = one_depth_update(FLAT, before, after, CLAMP, PRIOR, outline=OUTLINE)
    assert any("matched wrongly" in flag for flag in wrong.flags)


def test_edges_that_are_none_are_refused_in_a_line():
    edge = visible_pixels(PUSH, 8, 8)
    size = {"noise": 1e-4, "prior_sd": 0.1}
    for words, edges, changed in (
        ("edge 1 is", [edge, np.zeros((9, 3))], {}),
        ("none of 1", [np.tile(edge[:1], (9, 1))], {}),
        ("must be above zero", [edge], {"noise": 0.0}),
        ("must be above zero", [edge], {"prior_sd": -1.0}),
        ("0 before and 1 after", [edge], {"before": (FLAT, [])}),
    ):
        with pytest.raises(CalibrationError, match=words) as refusal:
            straight_edges_update(FLAT, edges, CLAMP, **size | changed)
        assert str(refusal.value).isprintable()
