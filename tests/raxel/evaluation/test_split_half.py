"""Split-half test: halves of the images disagree only where there is a fault."""

import numpy as np
import pytest

from raxel.calibration import calibrate_generic, calibrate_zhang
from raxel.calibration.views.correspondence import BoardShape, BoardView
from raxel.cameras.lenses.perspective import PerspectiveCamera
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.distortion import image_equations, within_groups
from raxel.evaluation.misfit import correction_fields
from raxel.evaluation.split_half import (
    MIN_DIFFERENCE_PX,
    P_THRESHOLD,
    Division,
    _judged,
    split_half,
)
from raxel.geometry import on_plane, rotation_from_vector, transform
from tests.board_scenes import BOARD, COLUMNS, ROWS, board_poses

SIZE = 640, 480
COUNT, NOISE_PX = 14, 0.1


def lens(focal_px):
    K = [[focal_px, 0, 322.0], [0, focal_px, 236.0], [0, 0, 1]]
    return PerspectiveCamera(K, [-0.1, 0.02], *SIZE)


CAMERA, OTHER = lens(350.0), lens(357.0)  # 2 % apart


def views_of(
    cameras, seed, noise=NOISE_PX, poses=None, solid=None, shift=(0.0, 0.0, 0.0)
):
    """Views by cameras in turn; solid: where the board's points are, None for flat;
    shift: motion in mm of each board from the first row of its image to the last."""
    rng = np.random.default_rng(seed)
    poses = board_poses(seed, COUNT) if poses is None else poses
    shifts = np.broadcast_to(shift, (len(poses), 3))
    views = []
    for k, (T, camera) in enumerate(zip(poses, cameras, strict=True)):
        points = transform(T, on_plane(BOARD) if solid is None else solid)
        pixels = camera.project(points).pixels
        for _ in range(5):
            time = pixels[:, 1:] / SIZE[1] - 0.5
            pixels = camera.project(points + time * shifts[k]).pixels
        pixels = pixels + noise * rng.normal(size=pixels.shape)
        pixels[np.any((pixels < 0) | (pixels > np.subtract(SIZE, 1)), axis=1)] = np.nan
        views.append(BoardView(pixels, BOARD, COLUMNS, ROWS, f"{k}.png"))
    return views


def found_in(views, camera=None):
    camera = camera or calibrate_zhang(views, *SIZE).camera
    return split_half(camera, evaluate_camera(camera, views).images, views)


def by_name(found, name):
    (division,) = (d for d in found.divisions if d.name == name)
    return division


def test_disagreement_of_two_cameras_is_that_of_their_rays():
    found = found_in(views_of(7 * [CAMERA] + 7 * [OTHER], 1))
    assert not found.stable
    halves = by_name(found, "order of the images")
    assert halves.halves[0] == tuple(f"{k}.png" for k in range(7))
    there = np.isfinite(halves.field[:, 0])
    assert there.mean() > 0.4
    pixels = found.pixels[there]
    rays = CAMERA.rays(pixels).directions
    apart = OTHER.project(rays).pixels - pixels
    turns = rotation_from_vector(1e-5 * np.eye(3))
    of_turns = np.stack([OTHER.project(rays @ R.T).pixels.ravel() for R in turns], 1)
    of_turns = of_turns - OTHER.project(rays).pixels.reshape(-1, 1)
    share = np.linalg.lstsq(of_turns, apart.ravel(), rcond=None)[0]
    apart = apart - (of_turns @ share).reshape(-1, 2)
    size = np.sqrt(np.mean(np.sum(apart**2, axis=1)))
    assert size > 10 * halves.allowed_px
    assert halves.disagreement_px == pytest.approx(size, abs=2 * halves.allowed_px)
    rest = np.sum((halves.field[there] - apart) ** 2, axis=1)
    assert np.sqrt(rest.mean()) < 3 * halves.allowed_px


def test_scatter_alone_has_the_predicted_disagreement():
    # The camera is the true one: only noise lies between the halves.
    found = [
        found_in(views_of(COUNT * [CAMERA], seed), CAMERA) for seed in range(20, 30)
    ]
    divisions = [d for each in found for d in each.divisions]
    assert all(each.stable for each in found)
    assert len(divisions) == 110
    assert 0.35 < np.mean([d.p_value for d in divisions]) < 0.65
    ratio = np.mean([d.times**2 for d in divisions])
    assert 0.6 < ratio < 1.6


def test_other_poses_and_exact_corners_are_stable():
    poses = board_poses(5, 4 * COUNT, spread=(70.0, 30.0))
    aside = np.argsort(transform(poses, np.array([[72.0, 54.0, 0.0]]))[:, 0, 0])
    chosen = poses[np.concatenate([aside[:7], aside[-7:]])]
    assert found_in(views_of(COUNT * [CAMERA], 5, poses=chosen)).stable
    exact = found_in(views_of(COUNT * [CAMERA], 6, noise=0.0))
    assert exact.stable
    assert max(d.disagreement_px for d in exact.divisions) < MIN_DIFFERENCE_PX / 10


def test_wrong_corners_do_not_affect_halves():
    views = views_of(COUNT * [CAMERA], 8)
    clean = by_name(found_in(views, CAMERA), "near and far")
    rng = np.random.default_rng(8)
    for view in views[:7]:
        wrong = rng.random(len(view.pixels)) < 0.05
        view.pixels[wrong] += 5 * rng.normal(size=(wrong.sum(), 2))
    found = found_in(views, CAMERA)
    assert found.stable
    allowed = by_name(found, "near and far").allowed_px
    assert allowed == pytest.approx(clean.allowed_px, rel=0.15)


def test_correlated_errors_within_images_are_stable():
    # Each board is off by a quadratic of its own, as large as single corners' noise.
    rng = np.random.default_rng(11)
    x, y = ((BOARD - BOARD.mean(axis=0)) / np.ptp(BOARD, axis=0)).T * 2
    shapes = np.stack([x**2, x * y, y**2], axis=1) - [1 / 3, 0, 1 / 3]
    fields = 0.2 * rng.normal(size=(COUNT, 2, 3))
    views = [
        view._replace(pixels=view.pixels + shapes @ field.T)
        for view, field in zip(views_of(COUNT * [CAMERA], 11), fields, strict=True)
    ]
    found = found_in(views, CAMERA)
    assert found.same_camera
    assert min(division.p_value for division in found.divisions) > 1e-3
    assert found.factor > 1.5
    for division in found.divisions:
        assert division.allowed_px > 1.3 * division.scatter_px
    assert found_in(views_of(COUNT * [CAMERA], 11), CAMERA).factor < 1.3


def test_bent_board_of_known_shape_is_stable():
    half = np.ptp(BOARD, axis=0) / 2
    shape = BoardShape(BOARD.mean(axis=0), half, np.array([1.5, 0.0, 0.5, 0.004]))
    views = views_of(COUNT * [CAMERA], 12, solid=shape.points(BOARD))
    scores = evaluate_camera(CAMERA, views, shape)
    assert scores.rms_px == pytest.approx(np.sqrt(2) * NOISE_PX, rel=0.1)
    assert split_half(CAMERA, scores.images, views, shape).stable
    flat = evaluate_camera(CAMERA, views)
    assert flat.rms_px > 3 * scores.rms_px
    assert flat.mean_deg > 2 * scores.mean_deg
    assert split_half(CAMERA, flat.images, views).factor > 2


def test_tables_are_compared_with_their_own_errors():
    views = views_of(7 * [CAMERA] + 7 * [OTHER], 3)
    camera = calibrate_generic(views, *SIZE, rng=np.random.default_rng(0)).camera
    found = found_in(views, camera)
    assert not found.same_camera
    assert found.steady


@pytest.mark.parametrize("times", [0.5, 2.0])
def test_p_threshold_is_divided_by_the_number_of_divisions(times):
    """P_THRESHOLD is the rate at which any of them disagrees by chance."""
    count = 11
    p_values = [times * P_THRESHOLD / count, *np.linspace(0.1, 0.9, count - 1)]
    divisions = [
        Division(f"{k}", ((), ()), 1.0, 0.1, 0.1, p, np.zeros((4, 2)))
        for k, p in enumerate(p_values)
    ]
    found = _judged(divisions, np.zeros((4, 2)), 1.0, table=False)
    assert found.same_camera == (times > 1)
    if times < 1:
        assert found.p_value == pytest.approx(times * P_THRESHOLD)


def equations(rng, boards, ways, sd):
    """Of corrections that are nought, from 30 numbers of each board."""
    shapes = rng.normal(size=(boards, 30, ways))
    off = sd * rng.normal(size=(boards, 30))
    return np.einsum("nmk,nml->nkl", shapes, shapes), np.einsum(
        "nmk,nm->nk", shapes, off
    )


def test_scatter_excludes_poses_and_corrections():
    """Of few corners: three boards of eight each."""
    rng, found = np.random.default_rng(20), []
    views = views_of(3 * [CAMERA], 21, noise=0.0, poses=board_poses(21, 3))
    chosen = [0, 6, 12, 52, 58, 117, 123, 129]
    views = [
        view._replace(
            pixels=view.pixels[chosen], points=view.points[chosen], columns=4, rows=2
        )
        for view in views
    ]
    pairs = list(zip(evaluate_camera(CAMERA, views).images, views, strict=True))
    fields = correction_fields(CAMERA, pairs)._replace(mixing=np.eye(20)[:, :4])
    for _ in range(300):
        noisy = [
            (score._replace(residuals_px=0.3 * rng.normal(size=(8, 2))), view)
            for score, view in pairs
        ]
        corners = [np.isfinite(view.pixels[:, 0]) for _, view in pairs]
        found.append(image_equations(CAMERA, noisy, None, corners, fields)[2])
    assert np.mean(found) == pytest.approx(0.3**2, rel=0.08)


@pytest.mark.parametrize("parts", [1, 2])
def test_degrees_of_freedom_are_boards_minus_parts(parts):
    """In one direction; each board then is a number, and each part takes one."""
    rng, sd = np.random.default_rng(22), 0.3
    first = np.arange(7) < 7 // parts
    halves = [first] if parts == 1 else [first, ~first]
    found = [within_groups(*equations(rng, 7, 1, sd), halves) for _ in range(200)]
    variances, freedoms = np.transpose(found)
    np.testing.assert_allclose(freedoms, 7 - parts)
    assert np.mean(variances) == pytest.approx(sd**2, rel=0.15)
