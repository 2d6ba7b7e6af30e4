"""Displaced corners of a board are estimated, and only these."""

import numpy as np
import pytest

from raxel.calibration.parametric.opencv_fits import calibrate_zhang
from raxel.calibration.views.correspondence import BoardShape
from raxel.cameras import Projection
from raxel.cli.calibrate import Fitting, _calibrated, _with_corners
from raxel.cli.models import FITS
from raxel.evaluation.board_corners import P_THRESHOLD, _displacements, board_corners
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.misfit import correction_fields, seen_on, without_turns
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import cross_matrix
from raxel.sets.model import BOARDS
from tests.board_scenes import BOARD, COLUMNS, PITCH, ROWS, board_poses
from tests.raxel.evaluation.test_split_half import CAMERA, COUNT, SIZE, views_of

HALF = np.ptp(BOARD, axis=0) / 2
X, Y = ((BOARD - BOARD.mean(axis=0)) / HALF).T


def found_in(views, shape=None):
    return board_corners(
        CAMERA, evaluate_camera(CAMERA, views, shape).images, views, shape
    )


def seen(offsets, seed, noise=0.1):
    solid = on_plane(BOARD) + offsets
    return views_of(COUNT * [CAMERA], seed, noise=noise, solid=solid)


def off_px(camera, views):
    """RMS over the pixels under boards between where a camera and CAMERA see rays,
    after the best rotation."""
    scores = evaluate_camera(camera, views).images
    fields = correction_fields(camera, list(zip(scores, views, strict=True)))
    seen = np.any([seen_on(view, camera, fields.pixels) for view in views], axis=0)
    pixels, turns = fields.pixels[seen], fields.turns[seen]
    moved = CAMERA.project(camera.rays(pixels).directions).pixels - pixels
    return rms(without_turns(turns, moved[..., None])[..., 0])


def detectable(offsets):
    """Return displacements (K, 3) without motion, scale and modelled shape."""
    solid = on_plane(BOARD - BOARD.mean(axis=0))
    moved = [np.broadcast_to(np.eye(3), (len(BOARD), 3, 3)), -cross_matrix(solid)]
    absorbed, _, _ = _displacements(views_of([CAMERA], 0, poses=np.eye(4)[None])[0])
    free = np.concatenate([*moved, solid[..., None], absorbed], axis=2)
    free = free.reshape(offsets.size, -1)
    share = np.linalg.lstsq(free, offsets.ravel())[0]
    return offsets - (free @ share).reshape(offsets.shape)


ALONG, OUT = np.eye(3)[0], np.eye(3)[2]
FORMS = {
    "wave": 0.5 * np.sin(np.pi * X)[:, None] * OUT,
    "misprinted row": 0.3 * (BOARD[:, 1] == 36.0)[:, None] * ALONG,
    "sheared print": 0.3 * Y[:, None] * ALONG,
    "lens of the printer": 0.3 * (X**3)[:, None] * ALONG,
}


def rms(offsets):
    return np.sqrt(np.mean(np.sum(offsets**2, axis=1)))


@pytest.mark.parametrize("form", FORMS)
def test_displaced_corners_are_estimated(form):
    found, true = found_in(seen(FORMS[form], 21)), detectable(FORMS[form])
    assert not found.as_stated
    assert found.p_value < 1e-9
    # Of a row most is beyond the smoothest polynomials.
    assert rms(detectable(found.offsets) - true) < (
        0.4 if "row" in form else 0.1
    ) * rms(true)
    assert found.used
    assert (found.columns, found.pitch) == (COLUMNS, PITCH)
    length, sd = found.distance
    assert length == pytest.approx(np.linalg.norm(found.offsets, axis=1).max())
    assert 0.002 < sd < 0.03


def test_fit_with_displaced_corners_is_nearer_to_the_truth():
    """Of a dent in a board by a printer with a lens."""
    dent = np.exp(-((X - 0.4) ** 2 + (Y + 0.3) ** 2) / 0.2)[:, None] * [0.2, 0.0, 0.8]
    views, others = (seen(FORMS["lens of the printer"] + dent, n) for n in (35, 36))
    plain = calibrate_zhang(views, *SIZE).camera
    task = Fitting(FITS, views, SIZE, "mm", BOARDS, lambda text: None)
    fitted = task.fitted("zhang", views)
    found, right, corners = _with_corners(task, "zhang", fitted)
    assert corners.used
    assert off_px(found.camera, views) < 0.5 * off_px(plain, views)
    before = evaluate_camera(plain, others).rms_px
    after = evaluate_camera(found.camera, others, found.shape).rms_px
    # Of 0.1 px along each axis.
    assert right.whole.rms_px < after < 0.16 < 0.8 * before


def test_errors_of_rays_with_displaced_corners_are_as_predicted():
    squares = []
    for seed in (35, 36, 37):
        views = seen(0.4 * FORMS["lens of the printer"], seed)
        result, _, found, *_ = _calibrated(
            "board",
            Fitting(FITS, views, SIZE, "mm", BOARDS, lambda text: None),
            "kannala-brandt",
            [],
        )
        squares.append(
            off_px(found.camera, views) ** 2
            / result["beyond_boards"]["sd_under_boards_px"] ** 2
        )
    assert 0.25 < np.mean(squares) < 2.25


class Wavy:
    """A lens with an error of a pixel that varies over the image."""

    def project(self, points):
        pixels = CAMERA.project(points).pixels
        u, v = (pixels / SIZE).T * 2 * np.pi
        wave = [np.sin(2 * v) * np.sin(1.5 * u), np.sin(1.5 * u + 1) * np.cos(2 * v)]
        return Projection(pixels + np.transpose(wave), np.isfinite(u))


def test_misfit_on_boards_in_similar_poses_is_not_the_board():
    """They are predicted better by displacements, which differ between halves."""
    poses = board_poses(0, COUNT, tilt=0.1, spread=(10, 8))
    found = found_in(views_of(COUNT * [Wavy()], 0, poses=poses))
    assert found.p_value < P_THRESHOLD
    assert found.held_out_px[1] < found.held_out_px[0]
    assert not found.used


def test_rays_px_is_the_effect_on_the_lens():
    """Of two radial terms, by a board that they can follow."""
    views = seen(2 * FORMS["wave"], 22, noise=0.02)
    camera = calibrate_zhang(views, *SIZE).camera
    found = board_corners(camera, evaluate_camera(camera, views).images, views)
    assert found.rays_px == pytest.approx(off_px(camera, views), rel=0.3)


def test_errors_in_all_images_belong_to_the_board():
    """However far: they count as wrong in none."""
    offsets = FLAT.copy()
    offsets[43] = [1.0, -0.5, 0.0]
    found = found_in(seen(offsets, 34))
    assert found.worst == 43
    assert not found.as_stated


FLAT = np.zeros((len(BOARD), 3))


def test_nominal_board_is_not_significant():
    """With noise, with none, and bent as a fit may take it to be."""
    shape = BoardShape(BOARD.mean(axis=0), HALF, np.array([0.5, 0.1, -0.4, 0.004]))
    bent = shape.points(BOARD) - on_plane(BOARD)
    sound = seen(FLAT, 24), seen(FLAT, 25), seen(FLAT, 30, noise=0.0), seen(bent, 31)
    assert min(found_in(views).p_value for views in sound) > 100 * P_THRESHOLD
    assert found_in(seen(bent, 31), shape).p_value > 100 * P_THRESHOLD


def test_correlated_errors_do_not_belong_to_the_board():
    """Each board is off by cubics of its own, as large as single corners' noise."""
    rng = np.random.default_rng(23)
    shapes = np.stack([X**2, X * Y, Y**2, X**3, Y**3], axis=1)
    views = [
        view._replace(pixels=view.pixels + shapes @ rng.normal(size=(5, 2)) / 5)
        for view in seen(FLAT, 24)
    ]
    assert found_in(views).p_value > 100 * P_THRESHOLD


def test_board_corners_is_none_without_enough_boards():
    views = seen(FORMS["wave"], 33)
    assert found_in(views[:5]) is None
    turned = views[0]._replace(columns=ROWS, rows=COLUMNS)
    assert (
        board_corners(
            CAMERA, evaluate_camera(CAMERA, views).images, [turned, *views[1:]]
        )
        is None
    )


def test_displacements_exclude_pose_and_scale():
    view = views_of([CAMERA], 0, poses=np.eye(4)[None])[0]
    absorbed, modes, degree = _displacements(view)
    flat = modes.reshape(-1, len(degree))
    assert np.sqrt(np.mean(np.sum(modes**2, axis=1), axis=0)) == pytest.approx(1)
    solid = on_plane(BOARD - BOARD.mean(axis=0))
    moves = [np.broadcast_to(np.eye(3), (len(BOARD), 3, 3)), -cross_matrix(solid)]
    whole = np.concatenate([*moves, solid[..., None], absorbed, modes], axis=2)
    size = np.linalg.svd(whole.reshape(len(flat), -1), compute_uv=False)
    assert size[-1] > 1e-3 * size[0]
