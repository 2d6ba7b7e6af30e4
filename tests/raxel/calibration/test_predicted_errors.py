"""Predicted errors of rays equal actual errors, and those of parameters their own."""

import numpy as np
import pytest

from raxel.calibration import BoardView, adjust_spline, calibrate_lens
from raxel.calibration.parametric.lens_bundle import (
    LensFormula,
    adjusted,
    imaged_points,
    stacked,
)
from raxel.calibration.parametric.lens_fit import (
    FormulaFit,
    covariance_of,
    error_covariance,
)
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.misfit import seen_on
from raxel.evaluation.split_half import split_half
from tests.smooth_fields import LENS, H, W, bent, boards, misfit_px, positions, rms

SD_PX = 0.1


def errors_of_spline(seed, amplitude):
    """Errors (N, 2) under boards, their variances (N,), and RMS SD under boards."""
    rng = np.random.default_rng(seed)
    true = bent(amplitude, seed)
    seen, _ = boards(true, rng, 14, SD_PX)
    views = [BoardView(*each, 8, 6, f"{k}") for k, each in enumerate(seen)]
    lens = calibrate_lens(views, W, H, "kannala-brandt", pupil="fixed", board="flat")

    def slopes(points):
        return imaged_points(lens.formula, lens.values, points).by_values

    found = adjust_spline(lens.camera, lens.T_camera_grid, seen, W, H, slopes).camera
    pixels = np.clip(positions(rng, 400), 0, [W - 1, H - 1])
    pixels = pixels[np.any([seen_on(view, found, pixels) for view in views], axis=0)]
    variance = np.trace(found.pixel_covariance(pixels), axis1=1, axis2=2)
    halves = split_half(found, evaluate_camera(found, views).images, views)
    return misfit_px(found, true, pixels), variance, halves.beyond.under_px


@pytest.mark.parametrize("amplitude", [0.0, 1.5])
def test_spline_predicts_its_errors(amplitude):
    """Of a lens that the trend describes, and of one with a smooth warp."""
    ratios, of_boards = [], []
    for seed in range(4):
        errors, variance, under_px = errors_of_spline(seed, amplitude)
        squares = np.sum(errors**2, axis=1)
        ratios.append(np.sqrt(squares.mean() / variance.mean()))
        of_boards.append(under_px / np.sqrt(squares.mean()))
    assert 0.7 < rms(ratios) < 1.35
    assert 0.7 < np.median(of_boards) < 1.6


@pytest.fixture(scope="module")
def fits():
    """Fits of a lens with k1 and k2, by models with one term and with two."""
    rng = np.random.default_rng(1)
    seen, poses = boards(LENS, rng, 14, SD_PX)
    stack, fits = stacked(seen), {}
    for radial in (1, 2):
        formula = LensFormula("kannala-brandt", radial, 0, 0)
        values = np.array([120, 120, 162, 118, -0.03, 0.004])[: 4 + radial]
        result = adjusted(formula, values, poses, stack, "tukey")
        fits[radial] = FormulaFit(formula, result)
    return fits, stack


def test_next_radial_term_counts_by_its_probability(fits):
    """A term that corners refute adds little, one that they prove its whole effect."""
    fits, stack = fits
    k1 = 4
    narrow, wide = (error_covariance(fits[radial], stack)[0] for radial in (1, 2))
    own = covariance_of(fits[2], stack).covariance
    assert own[k1, k1] < wide[k1, k1] < 1.5 * own[k1, k1]
    missed = fits[1].result.values[k1] + 0.03
    assert abs(missed) > 10 * np.sqrt(covariance_of(fits[1], stack).covariance[k1, k1])
    assert np.sqrt(narrow[k1, k1]) == pytest.approx(abs(missed), rel=0.2)
