"""The page of the rigs: each file has its figure, and the numbers are the rig's."""

import re
from pathlib import Path

import numpy as np
import pytest

from chapters.guides.rigs import figures, trials
from chapters.guides.rigs import page as rigs_page
from chapters.guides.rigs.results import facts, uses_of
from raxel.geometry import pose, rotation_from_vector
from raxel.io.files import read_json
from raxel.lab import load_rig, render_set
from repro.page.space import available
from repro.run.outcomes import Plan
from tests.made_results import written

ROOT = Path(__file__).resolve().parents[1]
# Those for quick builds are smaller ones of others; they may be left out.
RIGS = [
    path
    for path in sorted((ROOT / "data" / "rigs").glob("*.yaml"))
    if path.stem in trials.NAMES or not path.stem.endswith("-small")
]
PAGE = Path(rigs_page.__file__).read_text("utf-8")
SMALL = "active-grid-demo"


@pytest.fixture(scope="module")
def ran():
    """The experiment of the page."""
    return written(rigs_page.ext_rigs("quick"), "ext_rigs", "quick")


def test_every_rig_is_an_input_and_has_its_figure_on_the_page():
    assert [ROOT / name for name in trials.FILES] == RIGS
    assert isinstance(rigs_page.ext_rigs("full"), Plan)
    shown = re.findall(r'^# show\("(ext_rig_\w+)"\)$', PAGE, re.MULTILINE)
    wanted = sorted("ext_rig_" + path.stem.replace("-", "_") for path in RIGS)
    assert sorted(shown) == wanted
    assert sorted(mark["id"] for mark in figures.drawn_rig.repro_marks) == wanted


def test_every_number_of_the_page_is_named(ran):
    used = set(re.findall(r"\{glue:text\}`([\w.]+)", PAGE)) - {"seed"}
    named = set(facts(ran))
    assert used == named


def test_poses_are_those_of_a_rendered_set(ran, tmp_path):
    (path,) = [path for path in RIGS if path.stem == SMALL]
    render_set(load_rig(path), tmp_path / "set", trials.SEED)
    truth = read_json(tmp_path / "set" / "truth" / "poses.json")["T_camera_target"]
    (shown,) = ran.arrays("T_camera_target", rig=SMALL)
    assert np.array_equal(shown, list(truth.values()))


def test_distances_and_tilts_are_told_from_the_centre(monkeypatch):
    rig = load_rig(ROOT / "data/rigs/ordinary-lens.yaml")
    corner, size = rig.extent
    R = rotation_from_vector([np.radians(20), 0, 0])
    T = pose(R, [0, 0, 500] - R @ [*(corner + size / 2), 0])
    monkeypatch.setattr(trials, "rig_named", lambda name: rig)
    monkeypatch.setattr(trials, "drawn_poses", lambda rig, seed: T[None])
    found = trials.rig_trial({"rig": "ordinary-lens"}, None)
    assert found["middle_mm"] == pytest.approx(np.array([[0, 0, 500]]), abs=1e-9)
    assert found["distance_mm"] == pytest.approx([500])
    assert found["tilt_deg"] == pytest.approx([20])
    assert found["whole"] == 1


def test_the_angle_seen_is_that_of_the_camera():
    rig = load_rig(ROOT / "data/rigs/coolpix-fce8-zoom-3.yaml")
    assert trials.angle_seen(rig.camera) == pytest.approx(
        2 * np.degrees(rig.camera.max_angle), abs=0.1
    )


@pytest.mark.skipif(not available().works, reason="no OpenGL")
def test_the_numbers_beside_a_figure_are_the_poses(ran):
    drawing = figures.drawn_rig({"ext_rigs": ran}, "ext_rig_ordinary_lens")
    (middles,) = ran.arrays("middle_mm", rig="ordinary-lens")
    table = np.column_stack([drawing.data[f"{x}_mm"] for x in "xyz"])
    assert np.array_equal(table, middles)
    rig = load_rig(ROOT / "data/rigs/ordinary-lens.yaml")
    uses = ["calibrate"] * rig.count + ["evaluate"] * rig.evaluate
    assert list(drawing.data["use"]) == uses == uses_of(ran, "ordinary-lens")
    assert drawing.check.holds
