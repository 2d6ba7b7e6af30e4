"""Predicted ray errors, with and without the camera's own uncertainty."""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from raxel.calibration.parametric.opencv_fits import calibrate_zhang
from raxel.evaluation import comparison as mirror_errors
from raxel.evaluation.comparison import predicted_errors, viewers_aside
from raxel.evaluation.diagnoses import stage_lines
from raxel.geometry.poses import rotation_from_vector
from tests.raxel.evaluation.test_split_half import CAMERA, COUNT, SIZE, views_of


def numbers(camera):
    return np.array([*np.diag(camera.K)[:2], *camera.K[:2, 2], *camera.radial])


def test_perturbed_cameras_scatter_as_calibrations_do():
    found = []
    for seed in range(12):
        views = views_of(COUNT * [CAMERA], seed)
        found.append((calibrate_zhang(views, *SIZE).camera, views))
    off = np.array([numbers(camera) - numbers(CAMERA) for camera, _ in found])
    stated = []
    for camera, views in found[:4]:
        aside = viewers_aside(camera, views)
        assert len(aside) == 6
        steps = np.array([numbers(one) - numbers(camera) for one in aside])
        stated.append(np.sqrt(np.sum(steps**2, axis=0)))
    happened = np.sqrt(np.mean(off**2, axis=0))
    # Twelve draws determine a deviation to a fifth; lens terms are correlated.
    assert np.log(happened / np.median(stated, axis=0)) == pytest.approx(0, abs=0.6)


PIXELS = np.random.default_rng(0).uniform(0, np.subtract(SIZE, 1), (400, 2))


class Seen(NamedTuple):
    """Of a StageView, what a prediction looks at."""

    stage: int
    view: object


class MirrorOf(NamedTuple):
    """Of MirrorViews, what a prediction looks at."""

    viewer: object


def directed(directions):
    return SimpleNamespace(directions=directions)


def calibration(sd, misfit, residuals_px=(), stated_px=None, off=()):
    """Of a MirrorCalibration of one stage, what a prediction looks at: sd and misfit
    in radians, of one component of a ray; off: radians, of corners from their rays."""
    stated = None if stated_px is None else np.full(len(residuals_px), stated_px)
    return SimpleNamespace(
        views=[Seen(0, SimpleNamespace(sd=stated))],
        bundle=SimpleNamespace(
            ray_sd=lambda stage, pixels: np.full(len(pixels), np.hypot(sd, misfit)),
            misfit=[misfit],
            residuals=[np.asarray(residuals_px)],
        ),
        cameras=[CAMERA],
        residuals_deg=lambda stage: np.degrees(off),
    )


def median_deg(rng, *sd):
    """Of the lengths of errors with two components of each deviation, added up."""
    parts = np.array(sd)[:, None, None] * rng.standard_normal((len(sd), 40_000, 2))
    return np.degrees(np.median(np.linalg.norm(parts.sum(axis=0), axis=1)))


@pytest.mark.parametrize(("noise", "misfit"), [(3e-4, 0.0), (3e-4, 4e-4)])
def test_predicted_median_combines_noise_and_misfit(noise, misfit):
    (predicted,) = predicted_errors(None, calibration(noise, misfit), [PIXELS])
    happens = median_deg(np.random.default_rng(1), noise, misfit)
    np.testing.assert_allclose(predicted, happens, rtol=0.02)


@pytest.mark.parametrize("misfit", [0.0, 1e-4, 5e-4])
def test_misfit_is_the_residual_beyond_the_stated_noise(misfit):
    """Of 1 mrad a pixel: what a bundle is not yet sure of counts, too."""
    rng, px = np.random.default_rng(2), 1e-3
    noise, bends = rng.standard_normal((2, 20_000, 2)) * [[[0.5]], [[misfit / px]]]
    off = np.linalg.norm(noise + bends, axis=1) * px
    found = calibration(3e-4, 0.0, noise + bends, 0.5, off)
    (predicted,) = predicted_errors(None, found, [PIXELS])
    assert predicted[0] == pytest.approx(median_deg(rng, 3e-4, misfit), rel=0.03)
    # Where the noise is not stated, the bundle's own is all that is known.
    unknown = calibration(3e-4, 2e-4, noise + bends, None, off)
    (predicted,) = predicted_errors(None, unknown, [PIXELS])
    assert predicted[0] == pytest.approx(median_deg(rng, 3e-4, 2e-4), rel=0.02)


def test_perturbed_camera_counts_up_to_a_choice_of_axes(monkeypatch):
    """A viewer turned as a whole moves no ray; one that sees a ray elsewhere does."""
    R = rotation_from_vector([0.02, -0.03, 0.4])
    turned = SimpleNamespace(rays=lambda p: directed(CAMERA.rays(p).directions @ R.T))
    narrow, views = calibration(1e-9, 0.0), MirrorOf(CAMERA)
    aside = np.array([2e-3, 0.0, 0.0])

    def calibrated(given):
        scene = CAMERA.rays(PIXELS).directions + shift
        rays = SimpleNamespace(rays=lambda p: directed(scene @ R.T))
        return SimpleNamespace(cameras=[rays], viewer=given.viewer)

    monkeypatch.setattr(mirror_errors, "calibrate_mirror", calibrated)
    for shift, viewers in ((0 * aside, [turned]), (aside, [turned, turned])):
        (predicted,) = predicted_errors(views, narrow, [PIXELS], viewers)
        length = np.linalg.norm(shift) * np.sqrt(len(viewers))
        expected = np.degrees(length) * np.sqrt(np.log(2))
        np.testing.assert_allclose(predicted, expected, atol=1e-7)


def test_camera_from_a_file_has_no_predicted_error():
    given = SimpleNamespace(viewer="camera.npz")
    assert mirror_errors._perturbed(given, None, None) == []
    stage = {"residual_mm": {"mean": 0.1, "sd": 0.1}}
    stage["predicted_ray_error_deg"] = {"median": 0.02, "largest": 0.03}
    result = {"stages": [stage], "viewer_error_counted": False}
    ((_, text),) = stage_lines(result)
    assert text.endswith(
        "0.030 deg (largest), without the error of the camera (unknown)"
    )
