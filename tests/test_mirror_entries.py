"""Entries of the mirror benchmark: the ways, what is recorded of them, the tables."""

from types import SimpleNamespace

import numpy as np
import pytest

from chapters.guides.mirror_benchmark import trials
from chapters.guides.mirror_benchmark.results import TITLES, entry_facts
from chapters.guides.mirror_benchmark.tables import entries_table, stages_table
from chapters.guides.mirror_benchmark.trials import (
    LEVELS,
    METHODS,
    RECORD,
    RIGS,
    SEEDS,
    all_at_once,
    as_published,
    as_result,
    entries,
    stage_by_stage,
    two_places,
)
from chapters.shared.records import record
from raxel.errors import InputError
from raxel.evaluation.mirror_benchmark import stage_scores
from raxel.evaluation.mirror_result import read_mirror_result, write_mirror_result
from tests.bench.mirror_entries import kept
from tests.made_mirror_views import VIEWER, made_views, sheet
from tests.made_results import plan_of, written

SIZE = VIEWER.width, VIEWER.height


@pytest.fixture(scope="module")
def views():
    return made_views((0.0, 5.0))


@pytest.fixture(scope="module")
def mirror_set():
    return SimpleNamespace(name="made", size=SIZE, steps=(None,))


@pytest.fixture(scope="module")
def results():
    return {"ext_mirror_entries_record": written(plan_of("ext_mirror_entries_record"))}


@pytest.mark.parametrize(
    ("way", "most_deg"),
    [(as_published, 0.2), (stage_by_stage, 0.1), (all_at_once, 0.1)],
)
def test_ways_answer_every_stage(way, most_deg, views, mirror_set, tmp_path):
    answer = way(views)
    assert answer.refused == ""
    assert len(answer.stages) == 2
    write_mirror_result(
        tmp_path / "r.npz", as_result(mirror_set, views, answer, "made")
    )
    result = read_mirror_result(tmp_path / "r.npz")
    for stage, deflection in zip(result.stages, (0.0, 5.0), strict=True):
        scored = stage_scores(stage, sheet(deflection), SIZE)
        assert len(scored.angles) > 0.7 * scored.scored
        assert np.median(scored.angles) < most_deg
        assert len(scored.heights) > 200
        assert np.abs(scored.heights).max() < 1


def test_two_places_give_rays_towards_the_scene_and_no_shape(views, mirror_set):
    answer = two_places(views)
    assert len(answer.stages) == 1
    result = as_result(mirror_set, views, answer, "two places")
    first, second = result.stages
    assert first.points is None
    assert len(second.rays.pixels) == len(second.points) == 0
    # Away from the mirror, whichever place comes first.
    exchanged = [p._replace(position=1 - p.position) for p in views.platter[::-1]]
    turned = views._replace(grids=views.grids[::-1], platter=tuple(exchanged))
    for one in (first, two_places(turned).stages[0]):
        scored = stage_scores(one, sheet(0.0), SIZE)
        assert len(scored.angles) > 100
        assert np.median(scored.angles) < 0.1


def test_an_early_end_keeps_what_came_before(views, mirror_set, monkeypatch):
    def refuse(*_, **__):
        raise InputError("no corner is left")

    monkeypatch.setattr(trials, "update_mirror", refuse)
    answer = as_published(views)
    assert answer.refused == "no corner is left"
    result = as_result(mirror_set, views, answer, "published")
    assert [len(stage.points) > 0 for stage in result.stages] == [True, False]


def test_each_stage_starts_from_the_one_before(views, monkeypatch):
    starts = []

    def found(before, *_, **__):
        starts.append(before)
        return SimpleNamespace(camera=len(starts))

    monkeypatch.setattr(trials, "update_mirror", found)
    answer = as_published(views._replace(steps=2 * views.steps))
    assert answer.stages[1:] == (1, 2)
    assert starts == [answer.stages[0], 1]


def test_pictures_that_are_refused_are_entries_that_say_so(monkeypatch, tmp_path):
    def refuse(mirror_set):
        raise InputError(f"{mirror_set.folder}/plate/near.png: no board")

    monkeypatch.setattr(trials, "mirror_views", refuse)
    found = entries(SimpleNamespace(name="dark", folder=tmp_path / "dark"))
    assert list(found) == list(METHODS)
    for entry in found.values():
        assert kept(entry) == {
            "answered": 0,
            "refused": "dark/plate/near.png: no board",
        }


def test_the_record_has_every_set_and_way():
    sets = record(RECORD)["sets"]
    assert [(one["rig"], one["level"], one["seed"]) for one in sets] == [
        (rig, level, seed) for rig in RIGS for level in LEVELS for seed in SEEDS
    ]
    for one in sets:
        assert [entry["method"] for entry in one["scores"]] == list(METHODS)
        for entry in one["scores"]:
            assert bool(entry["refused"]) == (entry["answered"] < 4)
            scored = [k for k in range(5) if f"stage{k}" in entry]
            assert scored == list(range(entry["answered"]))
            assert ("all" in entry) == (entry["answered"] > 0)
            assert "/" not in entry["refused"]


def test_tables_show_the_record(results):
    whole, stages = entries_table(results).columns, stages_table(results).columns
    assert list(METHODS) == list(TITLES)
    assert len(whole["Rig"]) == len(RIGS) * len(LEVELS) * len(METHODS)
    assert len(stages["Rig"]) == len(RIGS) * len(METHODS)
    at = whole["Way"].index("at once")
    own = [one["scores"][3]["all"] for one in record(RECORD)["sets"][:3]]
    found = whole["Height (mm)"][at]
    assert found.value == pytest.approx(np.median([o["height.rms_mm"] for o in own]))
    two = whole["Way"].index("two places")
    assert whole["Stages"][two] == 1
    assert whole["Height (mm)"][two] is whole["Deflection (mm)"][two] is None
    assert stages["Ray, 3 (deg)"][stages["Way"].index("two places")] is None


def test_every_fact_of_the_prose_has_a_number(results):
    facts = entry_facts(results["ext_mirror_entries_record"])
    assert facts["sets"] == 36
    assert facts["seeds"] == 3
    unknown = [name for name, fact in facts.items() if fact == "(no number)"]
    # A deflection needs all stages.
    assert {name.split(".")[0] for name in unknown} == {"published", "two_places"}
