"""The page of a mirror set says what came of it, whatever it is; which sets have it."""

import numpy as np
import pytest

from chapters.photographs.mirror import exercises, figures, results, tables, trials
from chapters.shared.photographs import notes
from raxel.sets import load_mirror_set
from repro.page.exercise import check
from repro.page.style import check_axes
from repro.run import sets_of_report
from repro.run.discover import MIRROR, Producer
from tests import mirror_sets
from tests.made_results import of_columns

SENTENCES = (notes.title, notes.origin, results.about, results.found, results.flagged)
ALONG = np.linspace(0, 120.0, 81)
SETTINGS = {
    "set": "wing-mirror", "camera": "A compact camera, zoomed in", "width_px": 80,
    "height_px": 60, "steps": [["b1.png", "a1.png"]], "stated_mm": [5.0],
    "places": ["near", "far"], "licence": "", "source": "",
}  # fmt: skip


def of_set(values):
    """The Result of a study of one set."""
    return of_columns(({}, {n: [one] for n, one in values.items()}), settings=SETTINGS)


def calibrated():
    bent = 5.0 * (ALONG / 150) ** 2 * (3 - ALONG / 150) / 2
    values = {
        "reason": None, "flags": "stage 1: few features", "meet_mm": 0.1,
        "apart_mm": 100.02, "apart_sd_mm": 0.1, "along": np.stack([ALONG, ALONG]),
        "height": np.stack([0 * ALONG, -bent]),
    }  # fmt: skip
    for stage in range(2):
        sheet = np.tile(np.linspace(0, -4 * stage, 40), (30, 1))
        sheet[:, :3] = np.nan
        own = {
            "shown": "a_1.png", "corners": 140, "residual_mm": 0.04, "wrong": stage,
            "predicted_deg": 0.02, "picture": np.full((30, 40), 90, np.uint8),
            "heights": sheet, "pixels": np.array([[20.0, 20], [60, 40], [np.nan] * 2]),
            "residuals": np.array([[0.1, 0], [0, -0.2], [np.nan] * 2]),
        }  # fmt: skip
        values |= {f"stage{stage}.{name}": one for name, one in own.items()}
    return of_set(values)


@pytest.mark.parametrize("result", [calibrated(), of_set({"reason": "no board found"})])
def test_every_sentence_figure_and_table_stands(result):
    study = results.MirrorStudy(result)
    for sentence in SENTENCES:
        assert "nan" not in sentence(study)
    given = {results.STUDY: result}
    for draw in (figures.ext_mirror_profiles, figures.ext_mirror_stages):
        drawing = draw(given)
        check_axes(drawing.figure, drawing.caption)
        drawing.figure.draw_without_rendering()
    table = tables.ext_mirror_found(given)
    assert {len(column) for column in table.columns.values()} == {study.stages}


def test_the_end_of_a_profile_is_compared_where_it_is():
    study = results.MirrorStudy(calibrated())
    moved = study.moved_mm(1)
    assert moved == pytest.approx(-exercises.end_task()["expected"]())
    assert "no board found" in results.found(
        results.MirrorStudy(of_set({"reason": "no board found"}))
    )
    assert "few features" in results.flagged(study)


def test_a_set_that_is_refused_says_why(tmp_path):
    mirror_sets.write_mirror_set(tmp_path)
    found = trials.calibration_of(load_mirror_set(tmp_path), 80)
    assert "board found in 0 of 4 images" in found["reason"]


def test_a_mirror_set_is_found_with_all_its_files_and_has_its_own_page(tmp_path):
    folder = tmp_path / "wing"
    mirror_sets.write_mirror_set(folder)
    for given in (folder, tmp_path):
        assert sets_of_report.folders_of_sets(given) == [folder]
        assert sets_of_report.sets_of_report(tmp_path, str(given)) == {
            "wing": folder.as_posix()
        }
    assert sets_of_report.target_kind(folder) == MIRROR
    names = sets_of_report.set_files(folder)
    assert "mirror.yaml" in names
    assert {name.split("/")[0] for name in names} >= {"stages.set", "primary.grids"}
    assert all(path.is_file() for path in names.values())
    for per_set, takes in (
        (True, False),
        (("mirror",), True),
        (("active_grid",), False),
    ):
        made = Producer("figure", "f", "m", "f", "p", 1, {"per_set": per_set})
        assert made.takes(MIRROR) is takes


def test_its_exercise_takes_the_right_answer_alone():
    task = exercises.end_task()
    assert check(task["expected"](), **task).right is True
