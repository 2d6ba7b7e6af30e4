"""Section 5.3.5, a moving cylinder: its measures and its claims."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_5_motion import claims, experiment, report
from chapters.shared.mirror.levels import ABERRATION_UM, BENCHES, LEVEL, SWEPT
from chapters.shared.mirror.rigs import mirror_rig
from raxel.geometry import transform
from repro.run.outcomes import NOT_COMPARABLE
from tests.judged_claims import of_rejected, verdicts
from tests.made_results import of_columns

SEEDS = 40


@pytest.fixture(scope="module")
def bent():
    return mirror_rig("A", small=True).camera(15.0)


def test_exact_images_recover_motion_and_cylinder(bent):
    rng = np.random.default_rng(3)
    seen = experiment.moved_cylinder(bent, rng)
    found = experiment.motion_and_shape(bent, seen, seen.pixels, rng)
    for way in ("open", "given"):
        assert found[way]["radius_mm"] == pytest.approx(experiment.RADIUS_MM, abs=0.01)
        last = found[way]["step5"]
        assert last["length_mm"] == pytest.approx(125, abs=0.01)
        assert max(last["turn_deg"], last["off_mm"]) < 0.01
        assert found[way]["missed"] == 0
    assert found["together"]["length_mm"] == pytest.approx(125, abs=0.01)


def test_marks_lie_on_the_cylinder_and_stay_in_the_mirror(bent):
    seen = experiment.moved_cylinder(bent, np.random.default_rng(4))
    points = seen.points @ np.eye(3)
    fit = experiment.cylinder_through(points)
    assert fit["radius_mm"] == pytest.approx(experiment.RADIUS_MM, abs=1e-6)
    assert abs(fit["cylinder"][3:6] @ seen.axis) == pytest.approx(1)
    for T, pixels in zip(seen.T, seen.pixels, strict=True):
        again = bent.project(transform(T, points))
        np.testing.assert_allclose(again.pixels, pixels, atol=1e-9)
        assert experiment.shown(bent, pixels).all()


def test_lost_mark_is_counted_and_flat_scene_has_no_cylinder(bent):
    seen = experiment.moved_cylinder(bent, np.random.default_rng(5))
    points = seen.points.copy()
    points[0] = np.nan
    assert experiment.cylinder_through(points)["missed"] == 1
    flat = points * [1.0, 1.0, 0.0]
    assert "no_shape" in experiment.cylinder_through(flat)


def test_longer_path_determines_a_length_better(bent):
    seen = experiment.moved_cylinder(bent, np.random.default_rng(6))
    found = experiment.length_bounds(bent, seen)
    one, five = found["told1"], found["told5"]
    assert five["length_percent"] < one["length_percent"] / 2


def test_known_length_is_kept_by_every_step():
    uneven = mirror_rig("A", small=True).camera(15.0, ABERRATION_UM, 2)
    seen = experiment.moved_cylinder(uneven, np.random.default_rng(9))
    rng = np.random.default_rng(10)
    noisy = seen.pixels + 0.05 * rng.standard_normal(seen.pixels.shape)
    marks = experiment.seen_by(uneven, noisy, 0.05)
    for T in experiment.pairwise(marks.rays[:2], rng, experiment.STEP_MM):
        assert np.linalg.norm(marks.shift(T)) == pytest.approx(
            experiment.STEP_MM, rel=1e-3
        )
        assert experiment.turn_between(T, seen.T[1]) < 0.5


TRUE = {f"published.open.step{k}.length_mm": 25.0 * k + 0.5 for k in report.EACH_STEP}
TRUE |= {f"published.open.step{k}.off_mm": 4.0 for k in report.EACH_STEP}
TRUE |= {name.replace("published", "true"): value for name, value in TRUE.items()}
TRUE |= {"published.given.step5.off_mm": 1.0, "published.open.scaled_mm": 60.0,
         "published.open.radius_mm": 66.0, "published.given.radius_mm": 63.0,
         "published.open.missed": 1, "published.open.fit_mm": 0.9}  # fmt: skip


def of_level(level, other):
    """Columns of a level at which all is as TRUE but for some names, `__` a dot."""
    rng = np.random.default_rng(7)
    values = TRUE | {name.replace("__", "."): value for name, value in other.items()}
    values = {
        name: value if isinstance(value, list) else [value] * SEEDS
        for name, value in values.items()
    }
    sds = {"stage0.mean_mm": 1.0, "stage1.mean_mm": 0.5, "stage2.mean_mm": 0.2,
           "published.open.mean_mm": 0.05}  # fmt: skip
    for name, sd in sds.items():
        if name not in values:
            values[name] = list(25 * np.exp(sd * rng.standard_normal(SEEDS)))
    return {f"{level}.{name}": column for name, column in values.items()}


def made(**other):
    """MotionRuns of the primary level, TRUE but for some names."""
    columns = of_level(LEVEL, other)
    return report.MotionRuns({report.RUNS: of_columns(({"geometry": "A"}, columns))})


def all_made(swept=None, longer=None, **other):
    """The results of all experiments; swept, longer: what is otherwise there."""
    return {
        name: of_columns(
            (
                {"geometry": "A"},
                {k: v for at in levels for k, v in of_level(at, changed).items()},
            )
        )
        for name, levels, changed in (
            (report.RUNS, BENCHES, other),
            (report.SWEPT_RUNS, SWEPT, other if swept is None else swept),
            (report.LONGER, {LEVEL}, other if longer is None else longer),
        )
    }


@pytest.mark.parametrize(
    ("predicate", "wrong"),
    [
        (report.follows, {"published__open__step2__length_mm": 53.0}),
        (report.follows, {"published__open__step5__off_mm": 8.1}),
        (report.follows, {"published__open__step5__off_mm": None}),
        (report.radius_found, {"published__open__scaled_mm": 56.0}),
        (report.radius_found, {"published__open__radius_mm": 76.0}),
    ],
)
def test_run_predicate_holds_and_fails(predicate, wrong):
    assert predicate(made())[0].all()
    assert not predicate(made(**wrong))[0].any()


ALL = np.ones(SEEDS, bool)


def test_two_missed_markers_fail_the_claim():
    assert report.markers_meet(made(), ALL).verdict == "reproduced"
    two = made(published__open__missed=2)
    assert report.markers_meet(two, ALL).verdict == "differs"


def test_scale_has_to_settle_and_to_be_correct():
    assert report.scale_tells(made(), ALL).verdict == "reproduced"
    assert report.scale_right(made(), ALL)
    off = made(published__open__mean_mm=31.34)
    assert not report.scale_right(off, ALL)
    # One that is wrong, and one whose scatter grows.
    for wrong in (off, made(stage0__mean_mm=25.0, stage1__mean_mm=25.0)):
        assert report.scale_tells(wrong, ALL).verdict == "differs"
    lost = report.log_scales(made(stage0__mean_mm=None))
    assert np.all(lost[0] == np.log(report.MAX_FACTOR))


MISSES_END = {"published__open__step5__off_mm": 8.1}
BOTH_MISS_END = MISSES_END | {"true__open__step5__off_mm": 8.1}


def test_motion_that_the_true_mirror_misses_is_not_comparable():
    judge = claims.judge_motion
    assert verdicts(judge, all_made()) == ("reproduced", {"reproduced"})
    assert verdicts(judge, all_made(**MISSES_END)) == ("differs", {"differs"})
    assert verdicts(judge, all_made(**BOTH_MISS_END)) == (
        NOT_COMPARABLE,
        {NOT_COMPARABLE},
    )
    # On the longer mirror alone, and at an end of the sweep.
    found = verdicts(judge, all_made(longer=BOTH_MISS_END))
    assert found == ("reproduced", {"reproduced", NOT_COMPARABLE})
    assert verdicts(judge, all_made(swept=MISSES_END)) == ("undecided", {"reproduced"})


def test_rejected_motions_are_excluded_and_reported():
    lost = {
        "published__open__step5__off_mm": [None] * 5 + [4.0] * (SEEDS - 5),
        "published__open__missed": [None] * 5 + [1] * (SEEDS - 5),
        "published__open__mean_mm": [None] * 5 + [25.0] * (SEEDS - 5),
    }
    none = dict.fromkeys(lost)
    for judge, missed in (
        (claims.judge_motion, "undecided"),
        (claims.judge_markers, "reproduced"),
        (claims.judge_scale, "differs"),
    ):
        expected = {("reproduced", "5 of 40", missed)}
        assert of_rejected(judge, all_made(**lost)) == expected
        assert verdicts(judge, all_made(none)) == ("undecided", {"reproduced"})


def test_congruence_claim_holds():
    assert claims.judge_congruence({}).verdict == "reproduced"
