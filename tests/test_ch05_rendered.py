"""Section 5.3.3 from pictures: what is read out of them, and what the tables count."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_3_rendered.results import aims, loop, prose, runs
from chapters.ch05_flexible_mirror.s3_3_rendered.tables import loop_table, targets
from chapters.ch05_flexible_mirror.s3_3_rendered.trials.loop import (
    read_picture,
    scene_of_loop,
    stages_of,
)
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
from raxel.errors import CalibrationError
from raxel.geometry import pose, rotation_from_vector
from raxel.lab.windowed import mirror_window
from tests.exercise_answers import misjudged
from tests.made_results import ROOT, as_planned, of_columns


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


def made_runs(stage_values=(), loop_values=()):
    """Results in which every aim is met by half, but for what is changed."""
    values = {
        "bundle.stage3.angle_deg": 0.09,
        "stage0.separation_mm": 0.05,
        "stage0.separation_deg": 0.02,
    }
    for k, percent, deg in ((1, 0.5, 0.04), (2, 1.0, 0.08), (3, 1.5, 0.14)):
        values |= {
            f"stage{k}.deflection_percent": percent,
            f"stage{k}.angle_deg": deg,
            f"stage{k}.residual_mm": 0.2,
            f"stage{k}.back_own_mm": 0.6,
            f"stage{k}.back_true_mm": 1.1,
        }
    steps = {f"step{k}.deflection_mm": 5.0 for k in range(1, 6)}
    ways = steps | {"step6.deflection_mm": 4.97, "single.deflection_mm": 15.225}
    aimed = {f"aimed.{name}": value for name, value in values.items()}
    looped = {f"aimed.{name}": value for name, value in ways.items()}
    seeds = np.full(20, 0.01)
    many = {name: seeds for aim in aims.AIMS for name in aim.drawn}
    return {
        runs.RENDERED: as_planned(runs.RENDERED, aimed | dict(stage_values)),
        aims.UNEVEN: as_planned(aims.UNEVEN, aimed),
        loop.LOOP: as_planned(loop.LOOP, looped | dict(loop_values)),
        runs.AIMED: as_planned(runs.AIMED, many),
    }


def table_of(made, rig="A"):
    columns = targets(made).columns
    return dict(zip(columns["Error"], columns[rig], strict=True)), columns


def test_aims_are_met_and_missed_and_a_refused_run_has_missed_them():
    found, columns = table_of(made_runs())
    assert set(found.values()) == {"met"}
    shown = dict(zip(columns["Error"], columns["A, laboratory"], strict=True))
    assert shown["Deflection, stage 1 (%)"] == pytest.approx(0.5)
    assert shown["Height after three steps out and back (mm)"] == pytest.approx(0.03)
    assert shown["Deflection, 15 mm at a stroke (%)"] == pytest.approx(1.5)
    assert columns["A, bench"][0].value == pytest.approx(0.5)
    found, _ = table_of(made_runs({"aimed.stage2.residual_mm": 0.5}), "B")
    assert found["Residual, worst stage (mm)"] == "not met"
    assert found["Grid separation (mm)"] == "met"
    ended = {f"aimed.stage3.{name}": np.nan for name in ("angle_deg", "residual_mm")}
    found, columns = table_of(made_runs(ended))
    assert found["Mean ray angle, stage 3 (degrees)"] == "not met"
    assert found["Residual, worst stage (mm)"] == "not met"
    assert columns["A, laboratory"][5] is None


def test_the_loop_and_the_single_step_have_aims_of_their_own():
    found, _ = table_of(made_runs((), {"aimed.step6.deflection_mm": 4.9}))
    assert found["Height after three steps out and back (mm)"] == "not met"
    assert found["Deflection, 15 mm at a stroke (%)"] == "met"
    found, _ = table_of(made_runs((), {"aimed.single.deflection_mm": np.nan}))
    assert found["Height after three steps out and back (mm)"] == "met"
    assert found["Deflection, 15 mm at a stroke (%)"] == "not met"


def test_a_mirror_uneven_by_10_um_was_not_run_at_the_bench():
    made = made_runs()
    aim = next(aim for aim in aims.AIMS if aim.aberration_um)
    assert aims.measured(made, aim, "B", "laboratory") == pytest.approx(0.04)
    assert aims.measured(made, aim, "B", "bench") is None
    assert aims.held(made, "A", "laboratory") == (len(aims.AIMS), len(aims.AIMS))
    assert aims.held(made, "A", "bench") == (len(aims.AIMS) - 3, len(aims.AIMS) - 3)


def test_a_run_is_refused_as_a_whole_or_by_one_way():
    def values(condition):
        whole = condition["geometry"] == "B"
        return {"refused": "no board"} if whole else {"aimed.refused": "stage 2: open"}

    result = as_planned(runs.RENDERED, values)
    of = {rig: result.select(geometry=rig, bench="bench") for rig in "AB"}
    assert runs.refusals(of["A"]) == {"published": 0, "aimed": 3, "own": 0}
    assert set(runs.refusals(of["B"]).values()) == {1}
    assert runs.runs_of(result, "A", "laboratory").conditions[0]["run"] == 0
    assert runs.runs_of(result, "C", "laboratory") is None


def test_the_board_of_the_loop_stays_and_is_seen_at_all_stages():
    assert stages_of(3) == [0, 1, 2, 3, 2, 1, 0]
    rng = np.random.default_rng(4)
    scene = scene_of_loop(mirror_rig("A", small=True), BENCHES["bench"], 3, rng)
    assert all(board is scene.boards[0] for board in scene.boards)
    for camera in scene.cameras:
        assert scene.rig.corners(camera, scene.boards[0])[1].sum() >= 90


def test_light_without_a_board_is_refused_by_the_number_of_its_picture(run):
    window = mirror_window(run.cameras[0])
    dark = np.zeros((window.height, window.width))
    with pytest.raises(CalibrationError, match="picture 6: no board"):
        read_picture(run, 0, dark, 6, np.random.default_rng(5))


STEPS_MM = (5.1, 5.0, 5.0, 5.05, 5.0, 4.9)


def looped(**changed):
    """The values of a loop of two ways that is open by 0.15 mm."""
    values = {"start.angle_deg": 0.1, "start.back_true_mm": 1.0} | {
        f"step{k}.deflection_mm": mm for k, mm in enumerate(STEPS_MM, 1)
    }
    values |= {"single.deflection_mm": 1.02 * sum(STEPS_MM[3:])}
    both = {
        f"{way}.{k}": v for way in ("published", "aimed") for k, v in values.items()
    }
    return both | changed


def loop_of(values):
    many = {
        f"{bench}.step{k}.deflection_mm": np.full(20, 5.0 if k < 4 else 4.9)
        for bench in BENCHES
        for k in range(1, 7)
    }
    made = {loop.LOOP: as_planned(loop.LOOP, values)}
    return made | {
        name: of_columns(({"geometry": geometry}, many))
        for geometry, name in loop.LOOP_DRAWN.items()
    }


def cell(made, way, words, column):
    found = loop_table(made).columns
    rows = zip(found["Way"], found["Measure"], found[column], strict=True)
    return {row[:2]: row[2] for row in rows}[runs.WAYS[way], words]


def test_a_loop_is_held_against_its_pushes_its_way_back_and_its_sum():
    made = loop_of(looped())
    for words, value in {
        "Largest error of a step out (%)": 2.0,
        "Largest error of a step back (%)": 2.0,
        "Equivalent steps apart (%)": 100 * (5.1 / 4.9 - 1),
        "Loop open by (mm)": 0.15,
        "Single step off the sum (%)": 2.0,
        "Ray angle, before (degrees)": 0.1,
        "True pose, before (mm)": 1.0,
    }.items():
        assert cell(made, "aimed", words, "A, bench").value == pytest.approx(value)
        # A single run is told to three digits.
        single = cell(made, "aimed", words, "B, laboratory")
        assert single == pytest.approx(value, rel=2e-3)
    drawn = cell(made, "published", "Loop open by (mm)", "B, bench, drawn")
    assert drawn.value == pytest.approx(0.3)
    assert cell(made, "aimed", "Loop open by (mm)", "A, bench, drawn") is None


def test_a_loop_that_ended_early_has_no_sum_and_is_counted():
    def values(condition):
        if condition["geometry"] == "B":
            return {"refused": "picture 3: no board is seen in the mirror"}
        ended = {"published.refused": "step 6", "aimed.single_refused": "single step"}
        lost = {"published.step6.deflection_mm": np.nan}
        return looped(**ended, **lost, **{"aimed.single.deflection_mm": np.nan})

    made = loop_of(values)
    assert cell(made, "published", "Loop open by (mm)", "A, bench") is None
    assert cell(made, "published", "Loops refused (runs)", "A, bench") == 3
    assert cell(made, "aimed", "Loops refused (runs)", "A, bench") == 0
    assert cell(made, "aimed", "Single steps not found (runs)", "A, bench") == 3
    assert cell(made, "aimed", "Loops refused (runs)", "B, bench") == 1
    assert cell(made, "aimed", "Single step off the sum (%)", "A, bench") is None
    assert cell(made, "aimed", "Loop open by (mm)", "A, bench").value > 0
    quoted = prose.of_loop(made)
    assert quoted["loop.refused.published"] == quoted["loop.refused.aimed"] == 6
    assert quoted["loop.A.bench.published.open"] == "(no number)"
    assert quoted["loop.A.bench.aimed.open"] != "(no number)"


def test_a_quick_build_has_a_word_for_every_number_of_the_loop():
    quick = {"geometry": "A", "bench": "bench", "run": 0}
    made = loop_of(looped()) | {loop.LOOP: of_columns((quick, looped()))}
    quoted = prose.of_loop(made)
    assert quoted.keys() == prose.of_loop(loop_of(looped())).keys()
    assert quoted["loop.A.laboratory.aimed.true.end"] == "(no number)"


def test_exercises_tell_right_from_wrong():
    assert misjudged(ROOT, "ch05_flexible_mirror/s3_3_rendered") == []
