"""3.3.2: how grids are scored, why they fail, and that images follow their seeds."""

import numpy as np
import pytest

from chapters.ch03_planar_grids.s3_2_grid_sets import experiment
from chapters.ch03_planar_grids.s3_2_grid_sets.claims import (
    judge_same_after_loc,
    run_by_run,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.experiment import (
    CLICKS,
    CONTOUR,
    FALSE,
    MEASURES,
    MERGED,
    METHODS,
    MISPLACED,
    MISSED,
    REFERENCE,
    REST,
    SNAP,
    SPLIT,
    SPOTLESS,
    cause_of,
    errors_of,
    from_smallest,
    grid_view,
    min_spacing,
    min_step_over_merging,
    spacing_trial,
    stacked,
    stream,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.report import (
    CLEAN,
    EXPERIMENTS,
    SPACING,
    Which,
    errors,
    right,
    seeds_of,
)
from chapters.shared.grids.detectors import CELECT, OPENCV, OPENCV_SB, is_right
from chapters.shared.grids.rigs import HARD, WHOLE, rig_of, wiped
from chapters.shared.grids.synthetic_board import SyntheticBoard, clockwise, outer
from chapters.shared.rigs import rig_named
from raxel.features.celect import OUTER_CORNER, TOO_FEW, TRACING
from raxel.features.celect.algorithm import (
    TOO_MANY,
    CelectResult,
    ContourFailure,
    ContourTrace,
)
from repro.run.outcomes import Plan
from tests.judged_claims import readings_of
from tests.made_results import written

COLUMNS, ROWS = 5, 4
LATTICE = np.stack(
    np.meshgrid(100.0 + 30 * np.arange(COLUMNS), 60.0 + 30 * np.arange(ROWS)), axis=-1
)
TRUTH = LATTICE.reshape(-1, 2)


def test_grid_is_correct_within_8_px():
    assert is_right(TRUTH + [5, 5], TRUTH)
    assert not is_right(TRUTH + [6, 6], TRUTH)


def test_clicks_start_at_the_smallest_square_clockwise():
    lattice = LATTICE.copy()
    lattice[0, -1] -= [12, -12]
    begun = from_smallest(lattice)
    np.testing.assert_array_equal(begun[0, 0], lattice[0, -1])
    assert begun.shape == (COLUMNS, ROWS, 2)
    np.testing.assert_array_equal(clockwise(begun), begun)
    np.testing.assert_array_equal(clockwise(begun[:, ::-1]), begun)
    np.testing.assert_array_equal(outer(LATTICE)[2], LATTICE[-1, -1])


def failed(stage, merged=(), inliers=()):
    """A run that failed on side 1, with these corners on it."""
    merged, inliers = (np.reshape(p, (-1, 2)).astype(float) for p in (merged, inliers))
    failure = ContourFailure("side 1", stage, "", len(merged), COLUMNS)
    none = np.empty((0, 2))
    trace = ContourTrace("side 1", none, none[:, 0], 12.0, inliers, inliers, merged)
    corners = np.full((ROWS, COLUMNS, 2), np.nan)
    return CelectResult(
        False, corners, COLUMNS, ROWS, outer(LATTICE), (failure,), (trace,)
    )


def test_failure_cause_is_that_of_the_failed_contour():
    side = LATTICE[0]
    between = side[1:2] + [15, 0]
    twice = np.vstack([side, side[2:3] + [5, 3]])
    cases = [
        (failed(OUTER_CORNER), SNAP),
        (failed(TRACING), CONTOUR),
        (failed(TOO_FEW, side[[0, 1, 3, 4]], side[[0, 1, 3, 4]]), MISSED),
        (failed(TOO_FEW, side[[0, 1, 3, 4]], side), MERGED),
        (failed(TOO_MANY, twice, twice), SPLIT),
        (failed(TOO_MANY, np.vstack([side, between]), side), FALSE),
        (failed(TOO_FEW)._replace(found=True), MISPLACED),
    ]
    assert [cause_of(result, LATTICE) for result, _ in cases] == [c for _, c in cases]


def test_errors_are_reported_for_both_windows():
    board = SyntheticBoard()
    image, truth = board.image(), board.corners
    # More than the full window reaches, less than the half window does; OpenCV returns
    # what it gives up in single precision.
    start = truth + [6.0, 0.0]
    found = dict(zip(MEASURES, errors_of(image, start, truth), strict=True))
    np.testing.assert_allclose(found["before", "truth", None], 6)
    np.testing.assert_allclose(found["after", "truth", "full window"], 6, atol=1e-4)
    assert np.median(found["after", "truth", "half window"]) < 0.1
    assert np.median(found["after", REFERENCE, "half window"]) < 0.1
    stack = stacked({CELECT: errors_of(image, start, truth)}, METHODS, len(truth))
    assert stack.shape == (len(METHODS), len(MEASURES), len(truth))
    assert np.isfinite(stack).all(axis=(1, 2)).tolist() == [
        method == CELECT for method in METHODS
    ]


def test_min_steps_are_in_merging_distances():
    over, reach = min_step_over_merging(LATTICE)
    # t8 = 0.8 s, s = chord / (1.9 corners): Tables 3.1 and 3.2.
    assert reach == pytest.approx([0.8 * 120 / 9.5, 0.8 * 90 / 7.6] * 2)
    assert over == pytest.approx(30 / reach)
    bent = LATTICE.copy()
    bent[0, 1, 0] += 10
    assert min_step_over_merging(bent)[0][0] == pytest.approx(20 / reach[0])


def test_wiping_removes_one_kind_of_blemish():
    rig = rig_named("hyperboloidal")
    assert wiped(rig, None) is rig
    clean = wiped(rig, "spots").blemishes
    assert clean.spot_cover == (0.0, 0.0)
    assert clean.glare_radiance == rig.blemishes.glare_radiance != (0.0, 0.0)
    assert clean.spots == rig.blemishes.spots


def two_seeds():
    """A result of the ball: two seeds of the whole range, one of the hard one."""

    def trial(condition, rng):
        good = {"success": condition["poses"] == WHOLE}
        seen = {CELECT: good, OPENCV: good}
        lost = {CELECT: {"success": False}, OPENCV: {"success": False}}
        spotless = lost | {"errors": every(SPOTLESS, condition)}
        return seen | {"errors": every(METHODS, condition), "spotless": spotless}

    def every(methods, condition):
        return np.full((len(methods), len(MEASURES), 4), float(condition["seed"]))

    conditions = [
        {"set": "spherical", "poses": poses, "image": 0, "seed": seed}
        for poses, seed in ((WHOLE, 1), (WHOLE, 2), (HARD, 1))
    ]
    return written(Plan(trial, conditions, 1, {"set": "spherical"}))


def test_reading_counts_its_own_images():
    result = two_seeds()
    ball = {"table_3_4_grids": result}
    assert seeds_of(ball) == [1, 2]
    assert seeds_of(ball, Which(HARD)) == seeds_of(ball, Which(spots=CLEAN)) == [1]
    assert right(result, CELECT).tolist() == [True, True]
    assert right(result, CELECT, Which(HARD)).tolist() == [False]
    assert right(result, CELECT, Which(WHOLE, CLEAN)).tolist() == [False]
    found = errors(result, OPENCV, "after", REFERENCE)
    assert [e.tolist() for e in found] == [[1.0] * 4, [2.0] * 4]
    assert errors(result, OPENCV, "before", "truth", Which(WHOLE, CLEAN)) == []


def grids_near_and_far(near_px, far_px):
    """Results of the four sets: image 0 with these errors has corners 9.5 px apart,
    image 1 has them 20 px apart.
    """

    def of_grids(condition, rng):
        error = near_px if condition["image"] == 0 else far_px
        good = {method: {"success": True} for method in (CELECT, OPENCV, OPENCV_SB)}
        every = {
            name: {"errors": np.full((len(methods), len(MEASURES), 4), error)}
            for name, methods in (("all", METHODS), ("spotless", SPOTLESS))
        }
        return good | every["all"] | {"spotless": good | every["spotless"]}

    def of_spacing(condition, rng):
        return {"least_px": 9.5 if condition["image"] == 0 else 20.0}

    def conditions(name):
        return [
            {"set": name, "poses": poses, "image": image, "seed": 1}
            for poses in (WHOLE, HARD)
            for image in (0, 1)
        ]

    results = {
        EXPERIMENTS[name]: written(Plan(of_grids, conditions(name), 1, {"set": name}))
        for name in EXPERIMENTS
    }
    every = [c for name in EXPERIMENTS for c in conditions(name)]
    return results | {SPACING: written(Plan(of_spacing, every, 1))}


@pytest.mark.parametrize(("far_px", "apart"), [
    (0.1, "reproduced"), (0.3, "differs"),
])  # fmt: skip
def test_close_corners_count_in_one_reading_only(far_px, apart):
    results = grids_near_and_far(near_px=5.0, far_px=far_px)
    found = readings_of(judge_same_after_loc, results)
    assert (len(found), found[0].reading["corner_spacing"]) == (64, "9 px or more")
    expected = {"9 px or more": "differs", "15 px or more": apart}
    for one in found:
        assert one.verdict == expected[one.reading["corner_spacing"]]


def test_spacing_trial_measures_its_image():
    view = grid_view("fisheye", 7, 11, WHOLE)
    lattice = view.corners.reshape(view.rows, view.columns, 2)
    where = {"set": "fisheye", "poses": WHOLE, "image": 7, "seed": 11}
    assert spacing_trial(where, None)["least_px"] == pytest.approx(min_spacing(lattice))
    bent = LATTICE.copy()
    bent[1, 2] += [0, -12]
    assert min_spacing(bent) == pytest.approx(18)


def test_image_is_reproducible_and_clockwise():
    one, two = (grid_view("fisheye", 7, 11, WHOLE) for _ in range(2))
    np.testing.assert_array_equal(one.image, two.image)
    assert (one.image.shape, one.columns, one.rows) == ((768, 1024), 12, 9)
    u, v = one.outer_corners.T
    assert np.sum(u * np.roll(v, -1) - np.roll(u, -1) * v) > 0
    first, again = (stream("fisheye", 7, 11, CLICKS).random(3) for _ in range(2))
    np.testing.assert_array_equal(first, again)


def test_flaws_depend_on_set_and_seed_and_noise_on_the_image(monkeypatch):
    rig = rig_of("fisheye", 0)
    pose = rig.draw_poses(np.random.default_rng(0), 1)[0]

    def taken(set_name, image, seed, poses):
        return rig, pose, None, stream(set_name, image, seed, REST)

    def saved(rig, light, draws, specimen):
        return np.array([[specimen.random(), draws.random()]])

    monkeypatch.setattr(experiment, "taken", taken)
    monkeypatch.setattr(experiment, "saved", saved)
    which = [
        ("fisheye", 0, 1),
        ("fisheye", 1, 1),
        ("fisheye", 0, 2),
        ("spherical", 0, 1),
    ]
    flaws, noise = np.array([grid_view(*w, HARD).image[0] for w in which]).T
    assert flaws[0] == flaws[1]
    assert len(set(flaws)) == 3
    assert len(set(noise)) == 4


def test_predicate_without_runs_is_undecided():
    found = [
        run_by_run(holds, 1.0, "why")
        for holds in ([], [True, True, True], [True, False, True])
    ]
    assert [(one.verdict, one.reason) for one in found] == [
        ("undecided", "why; it applies to no run"),
        ("reproduced", "why; true of 3 of 3 simulated runs"),
        ("differs", "why; true of 2 of 3 simulated runs"),
    ]
