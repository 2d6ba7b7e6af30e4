"""`make where` in a checkout that is made up: how plans, quotes and orders name it."""

import shutil
import subprocess
from pathlib import Path

import pytest

from repro.run import where
from repro.run.where.scopes import displayed

ROOT = Path(__file__).resolve().parents[1]

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


QUOTING = """
# %% [markdown]
# {glue:text}`count` of {glue:text}`far.rms:.2f` px, {glue:text}`near.rms`,
# {glue:text}`best.share`, {glue:text}`sharp.most` {glue:text}`pages`,
# {glue:text}`law` {glue:text}`on_page`, {glue:text}`any.thing`
# {glue:text}`any.share` {glue:text}`early` {glue:text}`late`
# {glue:text}`first.size` {glue:text}`second.size` {glue:text}`step.07`

# %%
from chapters.ch02_x.s2_b.results import LIMIT, facts, name_values
from repro.page.reader import open_results, value

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% tags=["active-ipynb"]
# opened = open_results("by_module")

# %% tags=["active-ipynb"]
# for name, x in facts(opened).items(): value(name, x)

# %% tags=["active-ipynb"]
# value("on_page", opened.trials_per_condition)

# %% tags=["active-ipynb"]
# value("law", LIMIT)
"""
RESULTS = """
from chapters.shared import trials
from repro.page.reader import value

WAYS = {"far": 1, "near": 2}
FIRST, SECOND = "plain", "closed"
LIMIT, STEP = 4, 7


def name_values(open_results):
    result = open_results(FIRST)
    value("count", len(result))
    for way, level in WAYS.items():
        value(f"{way}.rms", result.column("rms", level=level))
    _named("best", open_results(SECOND))
    for name in result.levels("kind"):
        value(f"any.{name}", result.column(name))
    for way in ("share", "most"):
        value(f"any.{way}", result.column(way))
    found = open_results(FIRST)
    value("early", len(found))
    found = open_results(SECOND)
    value("late", len(found))
    for width in (".2f", "02d"):
        value(f"step.{STEP:{width}}", len(found))
    sizes = {
        "first.size": len(open_results(FIRST)),
        "second.size": len(open_results(SECOND)),
    }
    for name, number in sizes.items():
        value(name, number)


def _named(stem, result):
    for part in ("share", "rms"):
        value(f"{stem}.{part}", result.column(part))


def facts(result):
    found = {f"{name}.most": result.column(name) for name in ("sharp", "dull")}
    found["pages"] = len(result)
    return found
"""
FILES = {
    "shared/trials.py": TRIALS,
    "ch02_x/s1_a/page.py": PAGE,
    "ch02_x/s2_b/page.py": QUOTING,
    "ch02_x/s2_b/results.py": RESULTS,
}


@pytest.fixture
def checkout(tmp_path):
    shutil.copytree(ROOT / "data/published", tmp_path / "data/published")
    for name, text in FILES.items():
        path = tmp_path / "chapters" / name
        path.parent.mkdir(parents=True, exist_ok=True)
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


@pytest.mark.parametrize(
    ("name", "line", "experiments"),
    [
        ("count", 'value("count"', ["plain"]),
        ("far.rms", 'value(f"{way}.rms"', ["plain"]),
        ("near.rms", 'value(f"{way}.rms"', ["plain"]),
        ("best.share", 'value(f"{stem}.{part}"', ["closed"]),
        ("any.thing", 'value(f"any.{name}"', ["plain"]),
        ("any.share", 'value(f"any.{way}"', ["plain"]),
        ("early", 'value("early"', ["plain"]),
        ("late", 'value("late"', ["closed"]),
        ("step.07", 'value(f"step.{STEP', ["closed"]),
        ("first.size", '"first.size"', ["plain"]),
        ("second.size", '"second.size"', ["closed"]),
        ("sharp.most", 'found = {f"{name}.most"', ["by_module"]),
        ("pages", 'found["pages"]', ["by_module"]),
        ("on_page", '# value("on_page"', ["by_module"]),
        ("law", '# value("law"', []),
    ],
)
def test_a_quoted_name_leads_to_what_makes_it(checkout, name, line, experiments):
    lines = where.Whereabouts(checkout).lines(name)
    assert [n.word for n in lines[:2]] == ["quoted", "value"]
    assert lines[0].name == f"s2_b:{name}"
    texts = []
    for found in lines[:2]:
        path, _, number = found.place.rpartition(":")
        texts.append((checkout / path).read_text().splitlines()[int(number) - 1])
    assert f"`{name}" in texts[0]
    assert texts[1].strip().startswith(line)
    named = [n.name.split()[0] for n in lines if n.word == "experiment"]
    assert named == experiments


def test_what_the_thesis_has_and_no_page_makes(checkout, capsys, monkeypatch):
    monkeypatch.chdir(checkout)
    assert where.main(["fig_5_27"]) == 1
    assert "the thesis has it, and no page makes it yet" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"claims:\n- id: c2_x\n  words: \xff\xfe", "save it as UTF-8"),
        (b"claims:\n- id: c2_x\n  words: " + b"[" * 100_000, "nested too deeply"),
        (b"claims:\n- id: c2_x\n  words: !!python/name:os.system", "tag"),
    ],
)
def test_a_ledger_that_cannot_be_read_is_named_in_one_line(
    checkout, capsys, monkeypatch, content, reason
):
    monkeypatch.chdir(checkout)
    (checkout / "data/published/claims.yaml").write_bytes(content)
    assert where.main(["c2_x"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "data/published/claims.yaml: " in line
    assert reason in line


def test_a_constant_is_shown_where_it_stands(checkout):
    found = where.Whereabouts(checkout).lines("law")
    assert [(n.place, n.name) for n in found if n.word == "constant"] == [
        ("chapters/ch02_x/s2_b/results.py:7", "LIMIT")
    ]


def test_a_name_that_pages_share_is_told_apart(checkout):
    other = checkout / "chapters/ch02_x/s3_c/page.py"
    other.parent.mkdir()
    other.write_text(QUOTING)
    atlas = where.Whereabouts(checkout)
    both = [n.name for n in atlas.lines("count") if n.word == "quoted"]
    assert both == ["s2_b:count", "s3_c:count"]
    for page in ("s3_c", "ch02_x/s3_c"):
        one = [n for n in atlas.lines(f"{page}:count") if n.word == "quoted"]
        assert [n.place.partition(":")[0] for n in one] == [
            "chapters/ch02_x/s3_c/page.py"
        ]
    with pytest.raises(where.UnknownId):
        atlas.lines("s3_c:counted")


def test_a_name_with_blanks_is_put_together_again():
    words = ["three", "grids.linear_mm", "table_3_4", "svd.noisy,", "normalised"]
    assert where.joined(where.Whereabouts(ROOT), words) == [
        "three grids.linear_mm",
        "table_3_4",
        "svd.noisy, normalised",
    ]


def test_display_lines_are_code_and_keep_their_lines():
    shown = displayed(QUOTING).splitlines()
    assert shown.index("name_values(open_results)") == QUOTING.splitlines().index(
        "# name_values(open_results)"
    )
    assert "# {glue:text}`law` {glue:text}`on_page`, {glue:text}`any.thing`" in shown


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
        ["make", "--dry-run", "where", "table_3_4", "s3_2_results:omni.left_out"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "repro.run.where 'table_3_4' 's3_2_results:omni.left_out'" in done.stdout
    assert not done.stderr
    assert "repro.run.build" not in done.stdout
