"""Sections 4.1.1 and 4.1.2: trials that show what they say, claims that can fail."""

import numpy as np
import pytest

from chapters.ch04_central_generic.s1_1_synthetic_pinhole import (
    experiment,
    page,
    report,
)
from chapters.ch04_central_generic.s1_2_linear_stage import experiment as linear
from chapters.ch04_central_generic.s1_2_linear_stage import report as s1_2_claims
from chapters.shared.central import camera as wide_angle
from raxel.geometry import homography_dlt
from tests.judged_claims import readings_of
from tests.made_results import of_columns


def verdicts(judge, experiment, *made):
    return [
        reading.verdict
        for reading in readings_of(judge, {experiment: of_columns(*made)})
    ]


# 4.1.1


@pytest.mark.parametrize("name", experiment.CAMERAS)
def test_rays_of_every_camera_meet_in_its_centre(name):
    rng = np.random.default_rng(0)
    origins, directions = experiment.camera_of(name)(rng)
    off = np.cross(directions, origins - wide_angle.CENTRE_MM)
    assert np.abs(off).max() < 1e-9
    found = page.exact_trial({"camera": name}, rng)
    assert max(found.values()) < 1e-8
    assert experiment.image_trial({"camera": name}, rng)["residual"] < 1e-11


def test_camera_without_distortion_is_interpolated_exactly():
    pixels = np.random.default_rng(1).integers(150, 490, (500, 2))
    T = np.eye(4)[None]
    for k1, bound in ((0.0, 1e-9), (-0.1, 1.0)):
        camera = wide_angle.radial_lens(k1=k1)
        exact = wide_angle.back_project(camera, pixels + 0.0, T)[0][0]
        guessed = experiment.interpolated(camera, T[0], pixels, 40.0)
        gap = np.linalg.norm(guessed - exact, axis=1)
        assert gap.max() < bound
    assert gap.max() > 0.01


def test_claims_of_4_1_1_hold_and_fail():
    exact = [
        ({"camera": name}, {"CGSP": [1e-9], "CGSP circle": [1e-9]})
        for name in experiment.CAMERAS
    ]
    judge = report.judge_centres
    assert verdicts(judge, "exp_c4_any_pinhole", *exact) == ["reproduced"]
    exact[1][1]["CGSP circle"] = [1e-3]
    assert verdicts(judge, "exp_c4_any_pinhole", *exact) == ["differs"]
    for base, noise, verdict in (
        (0.5, 0.1, "reproduced"),
        (0.5, 0.9, "differs"),
        (0.05, 0.01, "differs"),
    ):
        spread = np.linspace(0.95, 1.05, 20)
        values = {"base_mm": base * spread, "noise_mm": noise * spread[::-1]}
        values |= {"all_mm": spread, "gap_mm": spread}
        judge = report.judge_interpolation
        found = verdicts(judge, "exp_c4_interp_bias_centre", ({}, values))
        assert found == [verdict]


# 4.1.2


def test_four_rays_have_full_rank_and_three_do_not():
    rng = np.random.default_rng(2)
    four, three = (linear.minimal_trial({"rays": n}, rng) for n in (4, 3))
    assert (four["rank"], three["rank"]) == (8, 6)
    assert four["length_mm"] < 1e-6
    assert three["length_mm"] is None
    assert linear.parameters_trial({}, rng)["determined"] == 15


def test_plain_svd_gives_the_homography_of_the_library():
    sight = wide_angle.draw_scene(
        wide_angle.radial_lens(), 0.5, np.random.default_rng(6), grids=2
    )
    base, own = sight.noisy
    H = linear.homography_in(np.float64, own, base, normalised=True)
    np.testing.assert_allclose(H / H[2, 2], _unit(homography_dlt(own, base)), rtol=1e-9)
    single = linear.homography_in(np.float32, own, base, normalised=True)
    assert 0 < np.abs(_unit(single) / _unit(H) - 1).max() < 1e-2


def _unit(H):
    return H / H[2, 2]


def test_claims_of_4_1_2_hold_and_fail():
    spread = np.linspace(0.99, 1.01, 60)
    values = {"clean_mm": spread, "ransac_mm": 1.05 * spread}
    judge, name = s1_2_claims.judge_ransac, "exp_c4_ransac_h"
    for robust, plain, verdict in (
        (1.05, 50.0, "reproduced"),
        (1.5, 50.0, "differs"),
        (1.05, 2.0, "differs"),
    ):
        values = {"clean_mm": spread, "ransac_mm": robust * spread}
        values["spoilt_mm"] = plain * spread
        found = verdicts(judge, name, ({"noise_px": 0.5}, values))
        assert found == [verdict]
    made = [
        (
            condition,
            {"single_residual_mm": factor * spread, "double_residual_mm": spread},
        )
        for condition, factor in zip(
            s1_2_claims.SVD_CONDITIONS.values(), (1.0, 20.0, 5.0, 1e6), strict=True
        )
    ]
    judge = s1_2_claims.judge_precision
    expected = ["differs", "reproduced", "differs", "reproduced"]
    assert verdicts(judge, "exp_c4_svd_precision", *made) == expected
