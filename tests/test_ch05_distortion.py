"""Section 5.3.4: claims about circle and face can fail, and refused seeds count."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_4_distortion import claims
from chapters.ch05_flexible_mirror.s3_4_distortion.results import (
    exact,
    predicates,
    runs,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.trials import face, target
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_rigs import mirror_rig
from raxel.geometry.homography import apply_homography
from tests.exercise_answers import misjudged
from tests.judged_claims import readings_of
from tests.made_results import ROOT, of_columns

SEEDS, LOST = 40, 5
ANGLES = 2 * np.pi * np.arange(target.PLACES) / target.PLACES


def profile(stage, common):
    """Residuals around the circle: waves of a stage's own, or the same at all."""
    return 0.2 * np.sin((3 if common else 3 + stage) * ANGLES)


TRUE = {"radius_mm": 87.0, "residual_mm": 0.2, "angle_deg": 0.2}
FACE = {"raw_px": 20.0, "corrected_px": 2.0}


def of_bench(bench, seeds, other, common=False):
    """Columns of a bench: true of all claims but for {(stage, name): value}."""
    rng, out = np.random.default_rng(5), {}

    def near(value):
        return value * (1 + 1e-5 * rng.standard_normal(seeds))

    for stage in runs.STAGES:
        at = f"{bench}.published.stage{stage}"
        for name, value in TRUE.items():
            out[f"{at}.{name}"] = near(other.get((stage, name), value))
        out[f"{at}.profile"] = [profile(stage, common)] * seeds
        conic = other.get((stage, "conic_px"), 2.0 + stage)
        for name in ("conic_px", "conic_no_lens_px"):
            out[f"{bench}.picture.stage{stage}.{name}"] = near(conic)
    for camera in ("calibrated", "true"):
        for name, value in FACE.items():
            out[f"{bench}.face.{camera}.{name}"] = near(other.get(name, value))
    return out


def made(other=None, swept=None, seeds=SEEDS):
    """The results of both experiments, with what is otherwise at each kind of bench."""
    results = {}
    for name, benches, count, changed in (
        (runs.RUNS, BENCHES, seeds, other or {}),
        (runs.SWEPT_RUNS, SWEPT, 4, swept or other or {}),
    ):
        columns = {}
        for bench in benches:
            columns |= of_bench(bench, count, changed, "common" in changed)
        results[name] = of_columns(({"geometry": "A"}, columns))
    return results


FALSE = {
    claims.judge_radius: [{(2, "radius_mm"): 88.6}, {(0, "radius_mm"): 85.8}],
    claims.judge_conic: [{(2, "conic_px"): 2.9}],
    claims.judge_system: [{"common": True}],
    claims.judge_face: [{"corrected_px": 4.2}],
    claims.judge_growth: [{(3, "residual_mm"): 0.23}],
}


@pytest.fixture(autouse=True)
def flat_mirror(monkeypatch):
    monkeypatch.setattr(claims, "conic_of_flat_mirror", lambda: 1e-10)


@pytest.mark.parametrize("judge", FALSE, ids=lambda judge: judge.__name__)
def test_a_claim_holds_where_it_is_true_and_fails_where_it_is_not(judge):
    assert [r.verdict for r in readings_of(judge, made())] == ["reproduced"] * 2
    for other in FALSE[judge]:
        found = readings_of(judge, made(other))
        assert [r.verdict for r in found] == ["differs"] * 2
        bench, laboratory = readings_of(judge, made({}, other))
        assert (bench.verdict, laboratory.verdict) == ("undecided", "reproduced")


def test_seeds_that_were_refused_count_against_a_claim():
    results = made()
    columns = of_bench("bench", SEEDS, {}) | of_bench("laboratory", SEEDS, {})
    for name, values in columns.items():
        if "bench.published.stage3" in name:
            columns[name] = np.empty(SEEDS, object)
            columns[name][:] = list(values)
            columns[name][:LOST] = None
    refused = [f"stage 3: {seed}" if seed < LOST else None for seed in range(SEEDS)]
    columns["bench.refused"] = refused
    results[runs.RUNS] = of_columns(({"geometry": "A"}, columns))
    for judge in (claims.judge_radius, claims.judge_system):
        assert readings_of(judge, results)[0].verdict != "reproduced"
    found = runs.CircleRuns(results)
    assert found.refused() == LOST
    assert np.isnan(predicates.alike(found)).sum() == LOST


def test_a_flat_mirror_that_bends_a_conic_fails_the_claim(monkeypatch):
    monkeypatch.setattr(claims, "conic_of_flat_mirror", lambda: 1e-3)
    found = readings_of(claims.judge_conic, made())
    assert [r.verdict for r in found] == ["differs"] * 2


def test_the_ring_hides_corners_and_leaves_enough():
    board = mirror_rig("A").board
    kept, ring = target.off_ring(board), target.ring_on(board)
    apart = np.linalg.norm(board.points() - ring.centre, axis=1)
    assert np.abs(apart[kept] - ring.radius).min() > ring.line / 2 + ring.margin
    assert 120 < kept.sum() < 182


def test_a_homography_is_no_distortion_and_a_bend_is():
    rng = np.random.default_rng(2)
    places = rng.uniform(0, 100, (20, 2))
    H = np.array([[1.1, 0.1, 3], [-0.1, 0.9, 5], [1e-3, 2e-3, 1]])
    assert face.off_homography(places, apply_homography(H, places)) < 1e-6
    bent = places + 1e-3 * (places - 50) ** 2 * [1, 0]
    assert face.off_homography(places, bent) > 0.1


def test_a_circle_is_exact_on_its_plane_and_a_flat_mirror_makes_a_conic(monkeypatch):
    monkeypatch.setattr(exact, "STAGES_MM", (15.0,))
    exact.exact_radii.cache_clear()
    assert claims.judge_exact({}).verdict == "reproduced"
    exact.exact_radii.cache_clear()
    assert exact.conic_of_flat_mirror() < claims.EXACT_PX


def test_exercises_are_judged_rightly():
    assert misjudged(ROOT, "ch05_flexible_mirror/s3_4_distortion") == []
