"""`make where`: from an id to the files and lines behind it."""

import shutil
import subprocess
from pathlib import Path

import pytest

from repro.judge.ledger import load
from repro.run import where
from repro.run.discover import page_files, page_id

ROOT = Path(__file__).resolve().parents[1]
ATLAS = where.Whereabouts(ROOT)


def words(identifier):
    """(word, file, line) of what stands behind an id."""
    found = []
    for line in ATLAS.lines(identifier):
        path, _, number = line.place.rpartition(":")
        found.append((line.word, path, int(number)))
    return found


def source_line(path, number):
    return (ROOT / path).read_text("utf-8").splitlines()[number - 1]


def test_a_table_leads_to_its_trial():
    found = [n for n in words("table_3_4") if n[0] != "data"]
    kinds = [word for word, _, _ in found]
    assert kinds[:5] == ["page", "trial", "experiment", "table", "numbers"]
    assert set(kinds[5:]) == {"claim"}
    lines = [source_line(path, number) for _, path, number in found]
    assert lines[1].startswith("def grid_trial(")
    assert lines[2].startswith("def spherical(")
    assert lines[3].startswith("def table_3_4(")
    assert all(line.startswith("def ") for line in lines[1:])


def test_a_claim_leads_to_its_test_and_what_it_read():
    found = [n for n in words("c2_noise_linear_generic") if n[0] != "data"]
    assert [word for word, _, _ in found] == ["page", "trial", "experiment", "claim"]
    assert found[0][1].endswith("s5_1_synthetic_data/page.py")
    assert "judge_noise_linear_generic" in source_line(*found[-1][1:])


def test_a_number_leads_to_the_function_that_gives_it():
    found = words("t2_2_persp_rms_set1")
    (given,) = [n for n in found if n[0] == "numbers"]
    assert "def values_of_table_2_2(" in source_line(*given[1:])
    assert [n for n in found if n[0] == "trial"]


def test_a_page_and_an_experiment_have_a_place():
    page = "ch03_planar_grids/s3_2_grid_sets"
    whole = words(page)
    assert whole[0] == ("page", f"chapters/{page}/page.py", 1)
    assert whole == words("s3_2_grid_sets")
    one = [word for word, _, _ in words("table_3_4_grids") if word != "data"]
    assert one == ["page", "trial", "experiment"]


def test_every_experiment_has_a_trial():
    made = [p for p in ATLAS.made if p.kind == "experiment"]
    lost = [p.id for p in made if ATLAS.trial_of(p) is None]
    assert not lost


def test_everything_of_the_thesis_that_is_made_has_a_page_and_lines_that_exist():
    book = load(ROOT)
    made = {p.id for p in ATLAS.made}
    pages = {page_id(ROOT, path) for path in page_files(ROOT)}
    asked = [i for i in (*book.artefacts, *book.claims) if i in made]
    asked += [i for i, entry in book.numbers.items() if entry["artefact"] in made]
    assert len(asked) > 100
    lengths = {}
    for identifier in asked:
        found = words(identifier)
        assert found[0][0] == "page", identifier
        assert found[0][1].removeprefix("chapters/").removesuffix("/page.py") in pages
        for _, path, number in found:
            if path not in lengths:
                text = (ROOT / path).read_bytes()
                lengths[path] = text.count(b"\n") + 1
            assert 1 <= number <= lengths[path], (identifier, path, number)


def test_what_nothing_has_is_told_with_what_is_near(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    assert where.main(["table_3_44"]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("make where: table_3_44: no such id; did you mean ")
    assert "table_3_4" in said.err
    assert said.err.count("\n") == 1
    assert where.main(["fig_5_1"]) == 1
    assert "the thesis has it, and no page makes it yet" in capsys.readouterr().err
    assert where.main([]) == 1


def test_words_and_places_stand_below_each_other(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    assert where.main(["table_3_4"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert len({row.index("chapters/") for row in rows if "chapters/" in row}) == 1


TRIALS = """
from functools import partial


def inner(condition, rng):
    return {}


def built(effort):
    return Plan(partial(inner, 3), [{}], 1)
"""
PAGE = """
from chapters.shared import trials
from chapters.shared.trials import inner


@experiment("plain", artefact="ext_a", shards={"quick": 1, "full": 1})
def plain(effort):
    return Plan(trial=inner, conditions=[{}], trials=1)


@experiment("by_module", artefact="ext_a", shards={"quick": 1, "full": 1})
def by_module(effort):
    return Plan(trials.inner, [{}], 1)


@experiment("elsewhere", artefact="ext_a", shards={"quick": 1, "full": 1})
def elsewhere(effort):
    return trials.built(effort)


@experiment("closed", artefact="ext_a", shards={"quick": 1, "full": 1})
def closed(effort):
    def trial(condition, rng):
        return inner(condition, rng)

    return Plan(trial, [{}], 1)


@experiment("unnamed", artefact="ext_a", shards={"quick": 1, "full": 1})
def unnamed(effort):
    return Plan(lambda condition, rng: {}, [{}], 1)
"""


@pytest.fixture
def checkout(tmp_path):
    shutil.copytree(ROOT / "data/published", tmp_path / "data/published")
    for name, text in (("shared/trials.py", TRIALS), ("ch02_x/s1_a/page.py", PAGE)):
        path = tmp_path / "chapters" / name
        path.parent.mkdir(parents=True)
        path.write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("experiment", "place"),
    [
        ("plain", "chapters/shared/trials.py:5"),
        ("by_module", "chapters/shared/trials.py:5"),
        ("elsewhere", "chapters/shared/trials.py:5"),
        ("closed", "chapters/ch02_x/s1_a/page.py:23"),
        ("unnamed", "chapters/ch02_x/s1_a/page.py:31"),
    ],
)
def test_a_trial_is_found_however_the_plan_names_it(checkout, experiment, place):
    found = where.Whereabouts(checkout).lines(experiment)
    assert [line.place for line in found if line.word == "trial"] == [place]


def test_built_files_of_the_full_report_are_listed(checkout):
    results = checkout / "figures/full/results"
    results.mkdir(parents=True)
    for name in ("plain.json", "plain.npz", "plain.run.json", "plainer.json"):
        (results / name).write_text("{}")
    found = where.Whereabouts(checkout).lines("plain")
    assert [line.place for line in found if line.word == "data"] == [
        "figures/full/results/plain.json:1",
        "figures/full/results/plain.npz:1",
    ]


def test_make_takes_an_id_for_a_question_and_not_for_an_order():
    done = subprocess.run(
        ["make", "--dry-run", "where", "table_3_4"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "repro.run.where table_3_4" in done.stdout
    assert "repro.run.build" not in done.stdout
