"""The guides: a table from made-up results, and exercises found in pages."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from chapters.guides.benchmarks.tables import ext_benchmarks
from chapters.guides.choose_a_method import page as choose_a_method
from chapters.guides.choose_a_method import tables
from chapters.guides.choose_a_method.results import named
from chapters.guides.choose_a_method.tables import COLUMNS, FAILED, NONE, costs
from chapters.guides.choose_a_method.trials import method_seconds
from chapters.guides.for_teachers import page as for_teachers
from chapters.guides.for_teachers import tables as class_tables
from chapters.guides.for_teachers.exercises import answers
from chapters.guides.for_teachers.exercises import on_pages as class_exercises
from chapters.guides.for_teachers.results import stated_times
from chapters.shared.run_times import rounded_seconds
from repro.page import reader
from repro.run.results import Result
from repro.workflow.work import Work

ROOT = Path(__file__).resolve().parents[1]
METHODS = ("parametric", "generic_well_conditioned")


def result(folder, name, settings, cases):
    """A result of three trials a condition: cases are (condition, values)."""
    path = folder / f"{name}.json"
    trials = [
        {"condition": i, "trial": t, "values": values(t)}
        for i, (_, values) in enumerate(cases)
        for t in range(3)
    ]
    content = {
        "experiment": name,
        "effort": "quick",
        "settings": settings,
        "conditions": [condition for condition, _ in cases],
        "trials_per_condition": 3,
        "trials": trials,
    }
    path.write_text(json.dumps(content))
    return Result(path)


def of_methods(*names, zhang, generic):
    """Values of a trial: the same names of both methods."""
    return lambda t: {
        f"{method}.{name}": level + 0.01 * t
        for method, level in zip(METHODS, (zhang, generic), strict=True)
        for name in names
    }


@pytest.fixture
def results(tmp_path):
    scores = of_methods("ray_deg", "clean.source.mean_px", zhang=0.5, generic=0.25)
    fov = [
        ({"fov_deg": f, "domain": "px", "extent": e}, scores)
        for f in (60, 120, 150)
        for e in ("unbounded", "finite")
    ]
    kept_out = "held_out.corrected.rms_px"
    zoom = [({"zoom": z}, of_methods(kept_out, zhang=z, generic=0.7)) for z in (1, 2)]
    stage = "stage.grid.deviation_mm"
    zoom.append(({"zoom": 3}, of_methods(kept_out, stage, zhang=3, generic=0.7)))
    wrong = [
        ({"kind": kind}, lambda t: {"ray_deg.1": 0.2})
        for kind in ("translation", "rotation")
    ]
    return {
        "fig_2_3_fov": result(
            tmp_path, "fig_2_3_fov", {"fov_sweep": {"noise": 0.5}}, fov
        ),
        "table_2_2_redrawn": result(
            tmp_path, "table_2_2_redrawn", {"calibration_images": 14}, zoom
        ),
        "fig_2_2_error": result(tmp_path, "fig_2_2_error", {"grids": "apart"}, wrong),
        "photograph_study": {},
    }


def test_the_table_has_a_row_for_everything_measured(results):
    table = tables.ext_methods(results)
    assert tuple(table.columns) == COLUMNS
    assert {len(cells) for cells in table.columns.values()} == {6 + 3 + 1 + 2}
    zhang, generic = table.columns["Zhang"], table.columns["Generic, unknown poses"]
    assert zhang[0].startswith("0.51 (")
    assert generic[0].startswith("0.26 (")
    motion = table.columns["General, known motion"]
    assert motion[:-2] == [NONE] * 10
    assert zhang[-2:] == generic[-2:] == [NONE] * 2
    assert motion[-1].startswith("0.2 (")


def test_a_method_that_never_worked_has_failed(results, tmp_path):
    cases = [
        ({"zoom": z}, of_methods("left_out", zhang=0.0, generic=0.0)) for z in (1, 2, 3)
    ]
    settings = {"calibration_images": 8}
    results["table_2_2_redrawn"] = result(tmp_path, "none", settings, cases)
    rows = tables.ext_methods(results).columns
    # Six simulated rows stand above the rendered ones.
    assert rows["Evidence"][6:10] == ["rendered"] * 4
    assert rows["Zhang"][6:10] == [FAILED] * 4
    assert rows["General, known motion"][6:10] == [NONE] * 4
    assert named(results)["zhang.stage"] == "∞"


def scores(**of_one):
    """Scores of one rig, as the experiment's result gives them."""
    return SimpleNamespace(
        conditions=[{"rig": "ordinary-lens"}],
        settings={"views": 5},
        column=lambda name, rig: [of_one.get(name.replace(".", "_"), np.nan)],
    )


def test_a_calibration_that_failed_is_told_from_one_that_was_not_tried():
    found = scores(
        **{"opencv_right": 5, "opencv_rms_px": 0.25},
        **{"opencv-sb_right": 0, "raxel_right": 5},
    )
    columns = ext_benchmarks({"ext_benchmark_scores": found}).columns
    rows = dict(zip(columns["Rig"], columns["Zhang (deg)"], strict=True))
    assert rows.pop("ordinary-lens") == "failed"
    assert set(rows.values()) == {NONE}
    rows = dict(zip(columns["Rig"], columns["opencv: right, RMS (px)"], strict=True))
    assert rows["ordinary-lens"] == "5 of 5, 0.25"


def test_a_detector_with_no_board_right_has_no_error():
    found = scores(
        **{"opencv_right": 0, "opencv-sb_right": 0, "raxel_right": 0},
        **{"zhang_rms_deg": 0.1},
    )
    columns = ext_benchmarks({"ext_benchmark_scores": found}).columns
    place = columns["Rig"].index("ordinary-lens")
    assert columns["opencv: right, RMS (px)"][place] == "0 of 5"
    assert columns["Zhang (deg)"][place] == "0.1"


def test_every_number_of_the_decision_page_is_named(results):
    text = Path(choose_a_method.__file__).read_text("utf-8")
    used = {part.split("`")[1] for part in text.split("{glue:text}")[1:]}
    assert used <= set(named(results))
    assert named(results)["general.zoom.2"] == "0.71"


def test_every_method_is_timed():
    took = method_seconds()
    assert set(took) == {"zhang", "general", "motion"}
    assert all(np.isfinite(list(took.values())))
    assert costs(took).markdown.count("\n") == 4


def test_run_times_are_coarse():
    assert [rounded_seconds(s) for s in (0.2, 1.4, 61.7)] == [
        "under 1 s",
        "1 s",
        "62 s",
    ]


def test_exercises_of_a_real_page_can_be_timed():
    pages = {page.id: page for page in class_exercises.pages_with_exercises()}
    page = pages["ch02_general_camera_model/s4_generic_calibration"]
    assert len(page.exercises) == 2
    assert class_exercises.timed_page(page).endswith(" s")
    assert page.title in class_exercises.exercise_list([page]).markdown


def test_the_routes_take_a_lesson_each():
    text = Path(for_teachers.__file__).read_text("utf-8")
    routes = text.split("# ## Route ")[1:]
    assert len(routes) == 8
    for route in routes:
        steps = [p.split()[0] for p in route.split("# - **")[1:] if " min.**" in p]
        assert sum(int(minutes) for minutes in steps) == 50


def test_every_route_leads_to_pages_with_exercises():
    text = Path(for_teachers.__file__).read_text("utf-8")
    found = {route.letter: route.pages for route in answers.routes(text)}
    assert "".join(found) == "ABCDEFGH"
    assert found["D"][-2:] == ["guides/choose_a_method", "guides/benchmarks"]
    for letter, pages in found.items():
        paths = [ROOT / "chapters" / page / "page.py" for page in pages]
        assert all(path.is_file() for path in paths), letter
        assert any(class_exercises.exercise_page(path).exercises for path in paths)


def test_the_guide_and_the_readme_state_the_same_times():
    times = stated_times()
    assert set(times) == {"quick", "report", "test"}
    assert all(time.endswith((" min", " s")) for time in times.values())


def test_an_answer_says_what_is_right_and_what_is_expected_to_be_wrong():
    page = class_exercises.exercise_page(
        ROOT / "chapters/ch02_general_camera_model/s3_general_camera/page.py"
    )
    names = reader.names_on_page(page.id)
    line, ray, _, table = (
        answers.answer(one, page.notebook, names) for one in page.exercises
    )
    assert "**Answer:** 6, 8, 0, 24, -18, 4. Any factor" in line
    assert "\n- 15, -10, 100: Its length is not 1." in ray
    assert "**Answer:** 770,048,000. A 4 x 4 matrix has 16 numbers" in table


def test_a_changed_page_of_a_chapter_rebuilds_the_page_that_counts_exercises():
    work = Work(ROOT, "quick", None, {})
    read = work.pages_read("guides/for_teachers")
    assert "chapters/ch02_general_camera_model/s4_generic_calibration/page.py" in read
    assert not any("guides" in name or "photographs" in name for name in read)
    assert "README.md" in read
    assert work.pages_read("guides/choose_a_method") == []


def test_runs_of_a_class(results):
    del results["photograph_study"]
    columns = class_tables.ext_class_runs(results).columns
    assert columns["Trials each"] == [3, 3, 3]
    assert columns["Conditions"] == [6, 3, 2]


def test_seconds_are_those_of_the_run_record(tmp_path, monkeypatch):
    for folder in ("chapters", "data/published", "figures/quick/results"):
        (tmp_path / folder).mkdir(parents=True)
    record = tmp_path / "figures/quick/results/fig_9_9.run.json"
    record.write_text('{"seconds": 12.5, "jobs": 2}')
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RAXEL_EFFORT", "quick")
    monkeypatch.delenv("RAXEL_SET", raising=False)
    assert reader.seconds("fig_9_9") == 12.5
    with pytest.raises(reader.Missing, match="make report"):
        reader.seconds("fig_9_8")
