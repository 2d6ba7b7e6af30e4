"""Section 5.3.3 from pictures: what is read out of them, and what the tables count."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_3_rendered import results
from chapters.ch05_flexible_mirror.s3_3_rendered.tables import targets
from chapters.ch05_flexible_mirror.s3_3_rendered.trials.pictures import (
    MirrorRun,
    lit_outline,
    smaller,
)
from chapters.ch05_flexible_mirror.s3_3_rendered.trials.run import (
    scored,
    scoring_boards,
    separation,
)
from chapters.shared.mirror_bench import BENCHES
from chapters.shared.mirror_rigs import mirror_rig
from raxel.calibration.mirror.platter import PlatterPoses
from raxel.geometry import pose, rotation_from_vector
from tests.exercise_answers import misjudged
from tests.made_results import ROOT, as_planned


@pytest.fixture(scope="module")
def run():
    rig = mirror_rig("A", small=True)
    places = rig.monitor_poses(np.random.default_rng(0))
    T = rig.board_pose(np.random.default_rng(1), deflections=(0.0, 5.0))
    return MirrorRun(rig, BENCHES["laboratory"], rig.stages(), places, [T])


def test_a_true_camera_is_off_by_nothing_and_a_stale_one_by_its_deflection(run):
    held_out = scoring_boards(run, np.random.default_rng(2))
    true, stale = run.cameras[1], run.cameras[0]
    exact = scored(run, 1, true, held_out)
    assert exact["angle_deg"] < 1e-9
    assert exact["back_true_mm"] < 1e-6
    assert exact["reach_percent"] == 100
    off = scored(run, 1, stale, held_out)
    assert off["back_true_mm"] > off["back_own_mm"] > 1


def test_a_platter_that_gets_the_monitors_way_right_is_off_by_nothing(run):
    """Poses of what is seen as in a mirror, y upwards, are turned about x."""
    turned = np.diag([1.0, -1.0, -1.0, 1.0])
    found = np.stack([T @ turned for T in run.places])
    covariance = np.zeros((18, 18))

    def off(poses):
        return separation(run, PlatterPoses(poses, None, None, covariance, 0.0))

    assert off(found)["separation_mm"] == pytest.approx(0, abs=1e-9)
    assert off(found)["separation_deg"] == pytest.approx(0, abs=1e-6)
    wrong = found.copy()
    wrong[1] = wrong[1] @ pose(rotation_from_vector([0, 0, np.radians(0.3)]), [0, 0, 0])
    assert off(wrong)["separation_deg"] == pytest.approx(0.3, rel=1e-3)


def test_what_is_lit_is_traced_around_black_squares():
    v, u = np.mgrid[0:200, 0:300]
    inside = (u > 40) & (u < 260) & (v > 30) & (v < 170)
    squares = (u // 30 + v // 30) % 2
    picture = np.where(inside, 70 + 150 * squares, 0).astype(np.uint8)
    picture[5:8, 5:8] = 200
    around = lit_outline(picture)
    np.testing.assert_allclose(around.min(axis=0), [40, 30], atol=3)
    np.testing.assert_allclose(around.max(axis=0), [260, 170], atol=3)


def test_kept_corners_stay_on_their_squares():
    picture = np.zeros((480, 960), np.uint8)
    picture[:, 480:] = 200
    small = smaller(picture, np.array([[479.5, 100.0]]))
    assert small.picture.shape == (240, 480)
    assert small.corners[0, 0] == pytest.approx(239.5)
    assert small.picture[50, 239] < 100 < small.picture[50, 240]


def rendered(**changed):
    """A Result in which every aim is met by half, but for what is changed."""
    values = {
        f"aimed.{name}": aim.bound / 2 for aim in results.AIMS for name in aim.names
    }
    return as_planned(results.RENDERED, values | changed)


def table_of(result, rig="A"):
    seeds = np.full(20, 0.01)
    many = {name: seeds for aim in results.AIMS for name in aim.drawn}
    found = {results.RENDERED: result, results.AIMED: as_planned(results.AIMED, many)}
    columns = targets(found).columns
    return dict(zip(columns["Error"], columns[rig], strict=True)), columns


def test_aims_are_met_and_missed_and_a_refused_run_has_missed_them():
    found, columns = table_of(rendered())
    assert set(found.values()) == {"met"}
    assert columns["A, bench"][0].value == pytest.approx(0.5)
    assert columns["A, laboratory"][0] == pytest.approx(0.5)
    found, _ = table_of(rendered(**{"aimed.stage2.residual_mm": 0.5}), "B")
    assert found["Residual, worst stage (mm)"] == "not met"
    assert found["Grid separation (mm)"] == "met"
    ended = {f"aimed.stage3.{name}": np.nan for name in ("angle_deg", "residual_mm")}
    found, columns = table_of(rendered(**ended))
    assert found["Mean ray angle, stage 3 (degrees)"] == "not met"
    assert found["Residual, worst stage (mm)"] == "not met"
    assert columns["A, laboratory"][5] is None


def test_a_run_is_refused_as_a_whole_or_by_one_way():
    def values(condition):
        whole = condition["geometry"] == "B"
        return {"refused": "no board"} if whole else {"aimed.refused": "stage 2: open"}

    result = as_planned(results.RENDERED, values)
    of = {rig: result.select(geometry=rig, bench="bench") for rig in "AB"}
    assert results.refusals(of["A"]) == {"published": 0, "aimed": 3, "own": 0}
    assert set(results.refusals(of["B"]).values()) == {1}
    assert results.runs_of(result, "A", "laboratory").conditions[0]["run"] == 0
    assert results.runs_of(result, "C", "laboratory") is None


def test_exercises_tell_right_from_wrong():
    assert misjudged(ROOT, "ch05_flexible_mirror/s3_3_rendered") == []
