"""How far an updated calibration is trusted: what the page's tables count."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.ext_trust import results
from chapters.ch05_flexible_mirror.ext_trust.tables import coverage_table, targets
from chapters.ch05_flexible_mirror.ext_trust.trials import course, lesson, sweeps
from chapters.ch05_flexible_mirror.ext_trust.trials.scene import SureViewer
from chapters.shared.gaussian_errors import CORNER_PX, DECODED_MM, GaussianErrors
from chapters.shared.mirror_errors import MirrorErrors, pool_of
from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import lattice
from raxel.calibration.mirror.clamp import clamp_of_camera
from tests.bent_mirror_scenes import VIEWER, bent, edge_pixels, spline_like
from tests.exercise_answers import misjudged
from tests.made_results import ROOT, as_planned

SEEDS = 20


def runs(**changed):
    """A Result of `ext_mirror_trust_runs` in which every error is a third of what is
    wanted, but for what is changed."""
    values = {
        f"{way}.{name}": np.full(SEEDS, target.bound / 3)
        for target in reversed(results.TARGETS)
        for way in results.WAYS
        for name in target.names
    }
    values |= {
        f"{way}.{kind}stage{k}.{part}coverage": np.full(SEEDS, 1.0)
        for way in results.WAYS
        for k in results.STAGES
        for kind, part in (("", ""), ("bundle.", "among."), ("bundle.", "whole."))
    }
    values |= {"separation_mm": np.full(SEEDS, 0.01), "separation_deg": 0.01}
    return as_planned("ext_mirror_trust_runs", values | changed)


def table_of(result):
    columns = targets({"ext_mirror_trust_runs": result}).columns
    return dict(zip(columns["Error"], columns["A"], strict=True))


def test_targets_are_met_by_medians_and_missed_by_them():
    assert set(table_of(runs()).values()) == {"met"}
    half = np.where(np.arange(SEEDS) < 9, 2.0, 1.0)
    found = table_of(runs(**{"prior.single_percent": half, "prior.loop_mm": 0.1}))
    assert found["Deflection, 15 mm at a stroke (%)"] == "met, not surely"
    assert found["Height after three steps out and back (mm)"] == "not met"
    assert found["Grid separation (mm)"] == "met"


def test_the_worst_stage_counts_and_a_refused_seed_is_worst():
    worst = np.full(SEEDS, 0.3)
    found = runs(**{"prior.stage2.residual_mm": worst})
    assert table_of(found)["Residual, worst stage (mm)"] == "not met"
    refused = np.where(np.arange(SEEDS) < 15, np.nan, 0.01)
    found = runs(**{"prior.stage3.residual_mm": refused})
    assert table_of(found)["Residual, worst stage (mm)"] == "not met"


def test_seeds_that_went_astray_are_counted_on_both_surfaces():
    angles = np.full(SEEDS, 0.1)
    angles[3], angles[5] = 1.5, np.nan
    result = runs(**{"prior.stage2.angle_deg": angles})
    # Two of the smooth and two of the uneven mirror.
    assert results.astray(result, "A", "prior") == 4
    assert results.astray(result, "A", "plain") == 0


def test_coverage_is_a_mean_of_seeds_in_the_row_of_its_prediction():
    values = np.array([0.5, 3.5] * (SEEDS // 2))
    result = runs(**{"prior.bundle.stage2.among.coverage": values})
    # A seed that was refused does not count.
    parts = {
        f"stage{k}.{part}.coverage": np.append(np.ones(SEEDS - 1), np.nan)
        for k in results.STAGES
        for part in ("among", "whole")
    }
    own = as_planned("ext_mirror_own_space", parts)
    sure = as_planned(
        "ext_mirror_known_viewer",
        {
            f"stage{k}.{part}.coverage": np.full(8, k / 2)
            for k in results.STAGES
            for part in ("among", "whole")
        },
    )
    found = {
        "ext_mirror_trust_runs": result,
        "ext_mirror_own_space": own,
        "ext_mirror_known_viewer": sure,
    }
    named = results.of_coverage(result, own, sure)
    assert named["B.known_viewer"].startswith("0.5")
    assert named["known_viewer.seeds"] == 8
    columns = coverage_table(found).columns
    names = (columns[k] for k in ("Rig", "Mirror", "Prediction", "Rays"))
    at = list(zip(*names, strict=True)).index(
        ("A", "smooth", "bundle", "among the corners")
    )
    assert columns["Stage 2 (1)"][at].value == pytest.approx(2.0)
    assert columns["Stage 1 (1)"][at].value == 1.0
    assert columns["Stage 1 (1)"][0].value == 1.0
    assert columns["Mirror"][-1] == "smooth, viewer exact"
    assert [columns[f"Stage {k} (1)"][-1].value for k in results.STAGES] == [
        0.5, 1.0, 1.5
    ]  # fmt: skip


def test_an_exact_viewer_has_errors_in_the_platter_and_the_mirror_all_the_same():
    pixels, rng = np.zeros((50, 2)), np.random.default_rng(0)
    sure = SureViewer()
    assert np.all(sure.corners(pixels, rng) == 0)
    assert np.std(sure.plate_corners(pixels, rng)) > 0.5 * CORNER_PX
    assert np.std(sure.in_mirror(pixels, rng)) > 0.5 * DECODED_MM


def test_the_prior_is_chosen_by_medians_in_which_refused_seeds_are_worst():
    def values(condition):
        size = 0.1 if condition["geometry"] == "A" else 0.4
        good = np.full(8, size)
        return {
            "0.1.angle_deg": np.where(np.arange(8) < 3, 9.0, good),
            "none.angle_deg": np.where(np.arange(8) < 5, np.nan, good),
        }

    result = as_planned("ext_mirror_prior_runs", values)
    assert results.typical_angle(result, "0.1") == pytest.approx(0.2)
    assert results.typical_angle(result, "none") == np.inf


def test_predicted_errors_are_held_against_true_ones():
    rig = mirror_rig("A")
    true, off = rig.camera(5.0), rig.camera(5.2)
    pixels = lattice(true, 200)
    sd = np.full(len(pixels), 1e-3)
    same = course.predicted(true, true, pixels, sd)
    assert same["coverage"] == pytest.approx(0, abs=1e-12)
    assert same["predicted_deg"] == pytest.approx(np.degrees(np.sqrt(2) * 1e-3))
    found = course.predicted(off, true, pixels, sd)
    right = np.full(len(pixels), np.radians(found["true_deg"]) / np.sqrt(2))
    again = course.predicted(off, true, pixels, right)
    assert again["coverage"] == pytest.approx(1)
    assert again["predicted_deg"] == pytest.approx(found["true_deg"])


def test_the_field_widens_by_a_little_less_than_the_beam_says():
    for geometry in "AB":
        exact = np.array(lesson.widening(geometry))
        by_beam = np.array(lesson.beam_widenings(geometry))
        assert np.all(exact < by_beam)
        np.testing.assert_allclose(exact, by_beam, rtol=0.15)
    rig = mirror_rig("A")
    camera = rig.camera(5.0)
    straight = lesson.field_of_view(camera, camera) - lesson.field_of_view(
        rig.camera(0.0), rig.camera(0.0)
    )
    assert straight == pytest.approx(lesson.widening("A")[0])


def test_corners_are_told_by_their_place_next_to_the_free_edge():
    camera = spline_like(bent(0.0), 0.0)
    clamp = clamp_of_camera(camera, edge_pixels())
    assert sweeps.free_end(camera, clamp) in (0, -1)
    near, far = edge_pixels(-79.0), edge_pixels(79.0)
    assert np.all(sweeps.places_in_last(camera, clamp, near) < 0)
    edge = sweeps.places_in_last(camera, clamp, far)
    assert np.all((edge > 0.8) & (edge < 1.01))
    assert np.isnan(sweeps.places_in_last(camera, clamp, np.full((1, 2), np.nan)))[0]
    assert VIEWER.in_image(near).all()


def test_errors_of_the_scene_are_as_large_as_stated():
    errors, rng = GaussianErrors(), np.random.default_rng(0)
    assert np.std(errors.corners(np.zeros((5000, 2)), rng)) == pytest.approx(
        errors.plate_sd_px, rel=0.03
    )
    assert np.std(errors.in_platter(np.zeros((5000, 2)), rng)) == pytest.approx(
        errors.platter_sd_mm, rel=0.03
    )


def test_measured_errors_are_drawn_as_large_as_stated_at_any_noise_of_the_bench():
    rng = np.random.default_rng(1)
    true = rng.uniform(0, 300, (4000, 2))
    error = 0.03 * np.sin(2 * np.pi * true / 40) + rng.normal(0, 0.02, true.shape)
    pool = pool_of(error, true, [40.0, 40.0])
    pixels = rng.normal(0, 0.1, (4000, 2))
    for factor in (1.0, 2.5):
        errors = MirrorErrors(pixels, 3 * pixels, pool, pool, factor)
        stated = errors.platter_sd_mm
        assert stated == pytest.approx(factor * np.sqrt(np.mean(error**2)), rel=0.02)
        for drawn in (errors.in_platter(true, rng), errors.in_mirror(true, rng)):
            assert np.std(drawn - true) == pytest.approx(stated, rel=0.03)
        assert errors.plate_sd_px == pytest.approx(0.3, rel=0.03)


def test_exercises_tell_right_from_wrong():
    assert misjudged(ROOT, "ch05_flexible_mirror/ext_trust") == []
