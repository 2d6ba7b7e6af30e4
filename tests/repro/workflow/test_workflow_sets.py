"""What shows every image set reads those of this build, and of no earlier one."""

import csv
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from repro.run import discover
from repro.run.sets_of_report import (
    faulty_sets,
    folders_of_sets,
    name_of,
    set_files,
    sets_of_report,
)
from repro.workflow import build as orders
from repro.workflow.terminal import say
from repro.workflow.work import Work
from tests import mirror_sets
from tests.image_sets import description, write_description
from tests.repro.workflow.test_workflow import ROOT, build, jobs, small_checkout

ODD = "b {set}; $x 'q"
IMAGE_NAME = "shots {0}/-left ${HOME}; 'a' \"b\" é"
FOLDER = "chapters/ch03_pictures"
PAGE = f"{FOLDER}/all/page.py"
ALL = '''
# %% [markdown]
# # All images
#
# There are {glue:text}`count` sets: {glue:text}`names`.

# %%
from repro.run.marks import claim, experiment, numbers, table
from repro.run.outcomes import Plan, Reading, Table, Value
from repro.page.reader import results_behind, show_table, value


def sizes(results):
    """Bytes of every set, by its name."""
    found = results["picture_size"]
    return {name: int(one.column("bytes")[0]) for name, one in found.items()}


@experiment(
    "all_sizes", artefact="ext_all", shards={"quick": 2, "full": 2},
    needs=("picture_size",),
)
def all_sizes(effort, results):
    total = sum(sizes(results).values())
    return Plan(lambda condition, rng: {"total": total}, [{}], 2)


@table("ext_all", needs=("picture_size", "all_sizes"), evidence="photograph")
def ext_all(results):
    found = sizes(results)
    total = int(results["all_sizes"].column("total")[0])
    columns = {"set": list(found), "bytes": list(found.values())}
    return Table(columns | {"total": [total] * len(found)}, "Sizes.")


@claim("c_pictures", needs=("picture_size",), evidence="photograph")
def judge_pictures(results):
    return Reading("undecided", " ".join(sizes(results)))


@numbers("n_pictures", needs=("picture_size",), evidence="photograph")
def count_pictures(results):
    return {"n_pictures": Value(len(sizes(results)))}


# %% tags=["active-ipynb"]
# found = results_behind("ext_all")["picture_size"]

# %% tags=["active-ipynb"]
# value("count", len(found))

# %% tags=["active-ipynb"]
# value("names", ", ".join(found))

# %% tags=["active-ipynb"]
# show_table("ext_all")
'''
ONE = """
# %% [markdown]
# # A set of images
#
# %%
from pathlib import Path

from raxel.sets import load_set
from repro.run.marks import experiment, table
from repro.run.outcomes import Plan, Table
from repro.page.reader import show_table


@experiment(
    "picture_size", artefact="ext_one", shards={"quick": 1, "full": 1}, per_set=True
)
def picture_size(effort, folder):
    size = (Path(folder) / load_set(folder).views[0].image).stat().st_size
    return Plan(lambda condition, rng: {"bytes": size}, [{}], 1)


@experiment(
    "picture_share", artefact="ext_one", shards={"quick": 1, "full": 1}, per_set=True,
    needs=("picture_size",),
)
def picture_share(effort, folder, results):
    size = results["picture_size"].column("bytes")[0]
    return Plan(lambda condition, rng: {"kilobytes": size / 1000}, [{}], 1)


@table("ext_one", needs=("picture_size", "picture_share"), evidence="photograph",
       per_set=True)
def ext_one(results):
    return Table(
        {
            "bytes": results["picture_size"].column("bytes"),
            "kilobytes": results["picture_share"].column("kilobytes"),
        },
        "Its size.",
    )


# %% tags=["active-ipynb"]
# show_table("ext_one")
"""


@pytest.fixture(scope="module")
def checkout(tmp_path_factory) -> Path:
    """A small checkout with two image sets, a page for each and one for both."""
    root = small_checkout(tmp_path_factory.mktemp("sets") / "work")
    for name, text in (("all", ALL), ("one", ONE)):
        (root / FOLDER / name).mkdir(parents=True)
        (root / FOLDER / name / "page.py").write_text(text.lstrip())
    (root / FOLDER / "__init__.py").write_text("")
    add_set(root, ODD, 7)
    add_set(root, "a-set", 5)
    return root


def add_set(root: Path, name: str, size: int) -> Path:
    """A set of one image with an unusual name, in its own folder."""
    folder = root / "data" / "recorded" / name
    (folder / IMAGE_NAME).parent.mkdir(parents=True)
    (folder / IMAGE_NAME).write_bytes(b"x" * size)
    write_description(folder, description(0, views=[{"image": IMAGE_NAME}]))
    return folder


def work(root: Path) -> Work:
    return Work(root, "quick", None, sets_of_report(root, ""))


def rows(root: Path) -> list[list[str]]:
    with (root / "figures/quick/ext_all.csv").open(newline="") as file:
        return list(csv.reader(file))[1:]


def judged(root: Path) -> dict:
    path = root / "figures/quick/judged/ch03_pictures/all.json"
    return json.loads(path.read_text())


def page(root: Path) -> str:
    return (root / "report/build/quick/pages/ch03_pictures/all.ipynb").read_text()


def size_of(name: str) -> set[str]:
    return {f"experiment picture_size@{name}"}


OF_ALL = {
    "experiment all_sizes, part 0 of 2",
    "experiment all_sizes, part 1 of 2",
    "result all_sizes",
    "table ext_all",
}
PAGE_OF_ALL = {"claims and numbers of ch03_pictures/all", "page ch03_pictures/all"}


def test_producer_reads_own_or_all_sets():
    def read(own):
        return discover.results_read(("one", "two"), {"two"}, own, ("b", "a"))

    assert read("a") == {"one": "one", "two": "two@a"}
    assert read("") == {"one": "one", "two": {"b": "two@b", "a": "two@a"}}
    assert discover.result_ids(read("")) == ["one", "two@b", "two@a"]


def test_inputs_name_all_sets(checkout):
    planned = work(checkout)
    assert list(planned.sets) == ["a-set", "b-set-x-q"]
    both = ["picture_size@a-set", "picture_size@b-set-x-q"]
    assert planned.needed("table", "ext_all") == [*both, "all_sizes"]
    assert planned.needed("experiment", "all_sizes") == both
    own = ["picture_size@a-set", "picture_share@a-set"]
    assert planned.needed("table", "ext_one@a-set") == own
    read = set(planned.page_results("ch03_pictures/all"))
    assert {f"figures/quick/results/{name}.json" for name in both} <= read
    assert set(planned.page_results("ch03_pictures/a-set")) == {
        f"figures/quick/results/{name}.json" for name in own
    }


def test_only_sets_of_build_are_used(checkout):
    status, text = build(checkout, "ch03")
    assert status == 0, text
    assert jobs(text) > size_of("a-set") | size_of("b-set-x-q") | OF_ALL
    assert rows(checkout) == [["a-set", "5", "12"], ["b-set-x-q", "7", "12"]]
    assert "There are 2 sets: a-set, b-set-x-q." in page(checkout)
    claim = judged(checkout)["claims"]["c_pictures"]
    assert claim["readings"][0]["regenerated"] == "a-set b-set-x-q"
    assert claim["data"] == [
        f"results/picture_size@{name}.json" for name in ("a-set", "b-set-x-q")
    ]

    # The result of the set that goes away stays where it is, and is not read.
    shutil.rmtree(checkout / "data" / "recorded" / "a-set")
    status, text = build(checkout, "ch03")
    assert status == 0, text
    assert jobs(text) == OF_ALL | PAGE_OF_ALL, text
    assert (checkout / "figures/quick/results/picture_size@a-set.json").is_file()
    assert rows(checkout) == [["b-set-x-q", "7", "7"]]
    assert judged(checkout)["numbers"]["n_pictures"]["value"] == 1
    assert "There are 1 sets: b-set-x-q." in page(checkout)
    assert "a-set" not in page(checkout)

    _, text = build(checkout, "ch03")
    assert jobs(text) == set(), text


def test_files_of_set_are_inputs(tmp_path):
    folder = add_set(tmp_path, "odd", 3)
    for name in ("corners.txt", "black", "truth/a/b.npz", "not named.png"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("{}")
    named = {"reference": "corners.txt", "truth": "truth"}
    write_description(folder, description(0, views=[{"image": IMAGE_NAME}], **named))
    expected = {"set.yaml", IMAGE_NAME, "corners.txt", "truth/a/b.npz"}
    assert set(set_files(folder)) == expected


def test_invalid_set_stops_only_its_pages(checkout, capsys):
    folder = add_set(checkout, "wrong", 3)
    (folder / "set.yaml").write_text("raxel_set: 1\nname: [")
    planned = work(checkout)
    assert "wrong" not in planned.sets
    orders._mind_faulty_sets(planned, "fig_2_1")
    output = capsys.readouterr().err
    assert re.fullmatch(r"left out: [^\n]*\n", output)
    assert "wrong/set.yaml: line" in output
    for target in ("report", "quick", "ch03", "ext_all", "ext_one@wrong"):
        with pytest.raises(orders.OrderError, match=r"^[^\n]*wrong/set.yaml[^\n]*$"):
            orders._mind_faulty_sets(planned, target)
    shutil.rmtree(folder)


def test_control_characters_are_not_printed(capsys):
    say("left out: \x1b[2Ja\u202eb\x07: é")
    assert capsys.readouterr().err == "left out:  [2Ja b : é\n"


def test_sets_with_equal_page_name_are_reported(tmp_path):
    add_set(tmp_path, "a b", 3)
    add_set(tmp_path, "a+b", 3)
    assert list(sets_of_report(tmp_path, "")) == ["a-b"]
    assert "rename one" in "".join(faulty_sets(tmp_path).values())


@pytest.mark.parametrize("name", ["index", "set", "写真"])
def test_set_cannot_use_existing_page_name(tmp_path, name):
    assert name_of(tmp_path / name) not in ("index", "set", "")


@pytest.mark.parametrize(
    "name", ["a: b", "a #b", "{x}", "$HOME `id` \"'", "[1]", "12", "~"]
)
def test_make_passes_set_folder_unchanged(tmp_path, name):
    from snakemake.cli import parse_config

    make = ["make", "-f", ROOT / "Makefile", "-o", "setup"]
    shown = 'BUILD=printf "%s\\n"'
    done = subprocess.run(
        [*make, shown, "quick", f"RECORDED={name}"],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert name in done.stdout.splitlines()
    assert parse_config(orders._config("quick", "", name))["recorded"] == name


def test_new_set_and_image_rebuild_pages_of_all_sets(checkout):
    add_set(checkout, "c-set", 3)
    changed = checkout / "data" / "recorded" / ODD / IMAGE_NAME
    changed.write_bytes(b"x" * 9)
    status, text = build(checkout, "ext_all")
    assert status == 0, text
    assert jobs(text) == size_of("c-set") | size_of("b-set-x-q") | OF_ALL, text
    assert rows(checkout) == [["b-set-x-q", "9", "12"], ["c-set", "3", "12"]]


def test_page_of_all_sets_is_built_without_sets(checkout):
    shutil.rmtree(checkout / "data" / "recorded")
    status, text = build(checkout, "ch03")
    assert status == 0, text
    assert rows(checkout) == []
    assert "There are 0 sets: ." in page(checkout)


def test_mirror_set_is_rejected_with_command(tmp_path):
    folder = tmp_path / "wing"
    mirror_sets.write_mirror_set(folder)
    for given in (folder, tmp_path):
        assert folders_of_sets(given) == []
        with pytest.raises(orders.OrderError, match=r"calibrate .*wing .*--report"):
            orders._checked_recorded(str(given))
