"""Section 5.4: its claims can fail, on the runs that were completed."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s4_self_calibration import claims, report
from chapters.ch05_flexible_mirror.s4_self_calibration.experiment import Field
from chapters.shared.mirror.levels import BENCHES, LEVEL, SWEPT
from tests.judged_claims import assert_verdicts, of_rejected, readings_of, verdicts
from tests.made_results import of_columns, of_levels

SEEDS = 40
X = np.linspace(0, 1, 30)
CUBIC, WAVE = X**2 * (3 - X), np.sin(6 * X)
TRUE = {
    "board": {"linear_mm": (2.1, 2.3, 2.9), "back_mm": (1.0, 1.0, 1.0)},
    "told": {"deflection_mm": (4.0, 3.5, 3.0), "back_mm": (2.0, 3.0, 4.0)},
    "clustered": {"sag_mm": (1.0, 5.0, 20.0)},
    "even": {"deflection_mm": (4.6, 4.4, 4.2), "sag_mm": (0.1, 0.2, 0.3),
             "back_mm": (2.0, 2.0, 2.0)},
    "near": {"deflection_mm": (4.0, 3.5, 3.0)},
}  # fmt: skip
PROFILES = {"told": CUBIC, "near": WAVE, "even": CUBIC}
ONCE = {
    "stereo.found.deflected": 0.5, "stereo.found.baseline": 0.05,
    "stereo.true.deflected": 0.01, "stereo.true.baseline": 0.001,
    "stereo.found.board": 0.04, "stereo.trend": -1.0,
    "stereo.sd_mm": np.array([100.0, 30, 5]),
    "multi.spread_mm": (2100.0, 3000.0, 3850.0),
    "multi.centroid_mm": (3247.0, 3268.0, 4104.0), "multi.ratio": (0.8, 0.7, 0.8),
}  # fmt: skip


def of_bench(bench, seeds, other):
    """Columns of a bench: all is true but for {name: value}."""
    out = {}
    for way, values in TRUE.items():
        for name, stages in values.items():
            for k, value in enumerate(other.get(f"{way}.{name}", stages), 1):
                out[f"{bench}.{way}.stage{k}.{name}"] = np.full(seeds, value)
    for way, profile in PROFILES.items():
        for k in report.STAGES[1:]:
            z = other.get(f"{way}.profile", profile)
            z = other.get(f"{way}.stage{k}.profile", z)
            out[f"{bench}.{way}.stage{k}.profile_mm"] = [z] * seeds
            out[f"{bench}.{way}.stage{k}.angle_deg"] = np.full(seeds, 0.5)
    for name, value in ONCE.items():
        value = other.get(name, value)
        if not name.startswith("multi"):
            full = [value] * seeds
            out[f"{bench}.{name}"] = full if np.ndim(value) else np.array(full)
            continue
        for cameras in ("found", "true"):
            for one, number in zip(report.OBJECTS, value, strict=True):
                end = name.split(".")[1]
                out[f"{bench}.multi.{cameras}.{one}.{end}"] = np.full(seeds, number)
    return out


def made(other=None, swept=None):
    other = other or {}
    swept = other if swept is None else swept
    return of_levels(
        (report.RUNS, BENCHES, lambda level: of_bench(level, SEEDS, other)),
        (report.SWEPT_RUNS, SWEPT, lambda level: of_bench(level, 4, swept)),
    )


FALSE = {
    claims.judge_better_early: [{"told.deflection_mm": (4.0, 1.9, 1.5)}],
    claims.judge_degrades: [
        {"told.deflection_mm": (4.0, 4.1, 3.0)},
        {"told.deflection_mm": (4.0, 3.5, 2.4)},
    ],
    claims.judge_vertical: [
        {"clustered.sag_mm": (1.0, 0.5, 20.0)}, {"even.sag_mm": (0.1, 0.2, 6.0)},
    ],
    claims.judge_inflexion: [{"near.profile": CUBIC}, {"even.profile": WAVE},
                             {"near.stage2.profile": CUBIC},
                             {"even.stage2.profile": WAVE},
                             {"even.stage3.profile": WAVE},
                             {"near.profile": np.where(X > 0.9, np.nan, WAVE)}],
    claims.judge_large_error: [{"stereo.found.deflected": 0.2}],
    claims.judge_fixed_edge: [{"stereo.trend": -0.7}],
    claims.judge_spread: [
        {"multi.spread_mm": (700.0, 3000.0, 3850.0)},
        {"multi.spread_mm": (3900.0, 3000.0, 3850.0)},
    ],
    claims.judge_order: [{"multi.centroid_mm": (3300.0, 3268.0, 4104.0)}],
    claims.judge_under: [{"multi.ratio": (0.8, 0.7, 1.1)}],
    claims.judge_impractical: [
        {"told.back_mm": (3.0, 3.0, 4.0)}, {"told.back_mm": (1.0, 2.0, 2.9)},
    ],
}  # fmt: skip


@pytest.fixture(scope="module")
def true():
    return made()


@pytest.mark.parametrize("judge", FALSE, ids=lambda judge: judge.__name__)
def test_self_calibration_claim_holds_and_fails(judge, true):
    assert_verdicts(judge, true, map(made, FALSE[judge]))


def test_large_error_claim_is_undecided_if_the_sweep_contradicts():
    results = made(swept={"stereo.found.deflected": 0.2})
    found = verdicts(claims.judge_large_error, results)
    assert found == ("undecided", {"reproduced"})


def first_lost(values, lost=15):
    """Three stages, the last without a value in so many of the seeds."""
    return (*values[:-1], np.where(np.arange(SEEDS) < lost, np.nan, values[-1]))


@pytest.mark.parametrize(
    ("judge", "lost"),
    [
        (claims.judge_degrades, "told.deflection_mm"),
        (claims.judge_inflexion, "near.deflection_mm"),
        (claims.judge_impractical, "board.back_mm"),
    ],
)
def test_rejected_runs_are_excluded_and_reported(judge, lost):
    way, name = lost.split(".")
    changed = {lost: first_lost(TRUE[way][name])}
    # The ends of the sweep have fewer seeds.
    found = of_rejected(judge, made(changed, swept={}))
    assert found == {("reproduced", "15 of 40", "differs")}


def test_impractical_claim_counts_rejected_self_calibrations():
    judge, good = claims.judge_impractical, (1.0, 1.0, 1.0)
    rejected = {"told.back_mm": first_lost(good, SEEDS)}
    assert of_rejected(judge, made(rejected, swept={})) == {("reproduced",)}
    # Where the boards were, there is nothing to hold it against.
    both = {f"{way}.back_mm": first_lost(good, SEEDS - 1) for way in ("told", "board")}
    assert of_rejected(judge, made(both, swept={})) == {
        (verdict, "39 of 40", "differs") for verdict in ("undecided", "differs")
    }


def steps(slope, seeds=40):
    """Results of runs whose errors rise by so many % for a step."""
    rng = np.random.default_rng(3)
    columns = {}
    for k in range(1, claims.STEPS + 1):
        error = (1 + slope / 100 * k) * (0.04 if k % 2 else 0.05)
        for way in ("known", "boards"):
            columns[f"{way}.step{k}"] = error * (1 + 0.01 * rng.standard_normal(seeds))
    return {"exp_c5_known_scene": of_columns(({"geometry": "A"}, columns))}


@pytest.mark.parametrize(
    ("slope", "verdict"), [(0.0, "reproduced"), (10.0, "differs"), (-1.0, "reproduced")]
)
def test_known_scene_claim_detects_accumulated_errors(slope, verdict):
    (found,) = readings_of(claims.judge_known, steps(slope))
    assert found.verdict == verdict


def test_field_ends_at_the_rays_of_near_and_far_points():
    """Rays start over 100 mm, straight on: near and far points are seen over as much,
    though far ones alone span hardly any angle."""
    side = np.linspace(-50.0, 50.0, 11)
    origins = np.column_stack([np.repeat(side, 11), np.tile(side, 11), np.zeros(121)])

    class Rays:
        directions = np.tile([0.0, 0.0, 1.0], (121, 1))

    field = object.__new__(Field)
    field.rays, field.middle = Rays, np.zeros(3)
    Rays.origins = origins
    points = np.array(
        [[49.0, 0, 1000], [52, 0, 1000], [0, -49, 5000], [0, -52, 5000], [40, 40, 5000]]
    )
    assert field.shows(points).tolist() == [True, False, True, False, True]


def test_figure_shows_one_run_where_others_were_rejected():
    """All four seeds have an array of their number here; `came` says which have one."""
    numbers = np.arange(4.0)
    columns = {f"{LEVEL}.here": [np.full((2, 2), k) for k in numbers]}
    columns[f"{LEVEL}.number"] = numbers
    courses = report.Courses({report.RUNS: of_columns(({"geometry": "A"}, columns))})
    assert courses.of_run(3, np.ones(4, bool), "here")[0, 0] == 3
    # Seeds 0 and 2 were rejected and have no array: those of 1 and 3 come first.
    came = np.array([False, True, False, True])
    assert courses.of_run(3, came, "here")[0, 0] == 1
    assert courses.of_run(None, came, "here").shape == (0, 2)
    assert report.first_run(came, np.array([True, False, True, True])) == 3
    assert report.first_run(came, ~came) is None
