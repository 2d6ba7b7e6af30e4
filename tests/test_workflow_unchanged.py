"""An order stays carried out until a file that it depends on is another one."""

import os
from types import SimpleNamespace

import pytest

from repro.workflow.unchanged import RECORD, is_done, note, sources_of

TARGET = "report/build/quick/site.done"
FILES = (
    "chapters/ch01_a/s1_b/page.py",
    "data/recorded/mine/set.yaml",
    "data/synthetic/.times/rig/3.json",
    "figures/quick/times/figure/x.json",
    TARGET,
)
ORDER = ("quick", "quick", None, "")


@pytest.fixture
def checkout(tmp_path):
    root = tmp_path / "checkout"
    for name in FILES:
        written(root / name)
    (root / RECORD).parent.mkdir()
    written(tmp_path / "elsewhere/set.yaml")
    return root


def written(path, text="x\n"):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def work(root):
    sets = {"mine": "data/recorded/mine", "theirs": str(root.parent / "elsewhere")}
    return SimpleNamespace(root=root, base="figures/quick", sets=sets)


def done(root, order=ORDER):
    return is_done(work(root), order, sources_of(root), [TARGET])


def noted(root):
    note(work(root), ORDER, sources_of(root))


def test_an_order_is_done_once_it_was_carried_out(checkout):
    assert not done(checkout)
    noted(checkout)
    assert done(checkout)
    assert not done(checkout, ("report", "full", None, ""))
    os.utime(checkout / FILES[0], ns=(1, 1))
    assert not done(checkout)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("chapters/ch01_a/s1_b/page.py", "another\n"),
        ("chapters/ch01_a/s1_b/page.py", None),
        ("chapters/ch01_a/s1_b/claims.py", "new\n"),
        ("data/recorded/mine/set.yaml", "another\n"),
        ("data/recorded/mine/view.png", "new\n"),
        ("../elsewhere/set.yaml", "another\n"),
        ("data/synthetic/.times/rig/3.json", "another\n"),
        ("figures/quick/times/figure/x.json", None),
        (TARGET, None),
        (RECORD, "[1]"),
    ],
)
def test_what_it_depends_on_makes_it_be_planned_again(checkout, name, text):
    noted(checkout)
    path = checkout / name
    path.unlink() if text is None else written(path, text)
    assert not done(checkout)


def test_what_builds_leave_and_what_is_hidden_is_no_source(checkout):
    noted(checkout)
    for name in ("figures/quick/x.svg", ".git/index", "lib/__pycache__/a.pyc"):
        written(checkout / name)
    assert done(checkout)


def test_an_edit_while_it_is_built_counts(checkout):
    before = sources_of(checkout)
    written(checkout / FILES[0], "edited meanwhile\n")
    note(work(checkout), ORDER, before)
    assert not done(checkout)


def test_linked_folders_are_looked_into_and_circles_are_not_followed(checkout):
    (checkout / "data/linked").symlink_to(checkout.parent / "elsewhere")
    (checkout / "data/around").symlink_to(checkout / "data")
    noted(checkout)
    assert done(checkout)
    written(checkout.parent / "elsewhere/view.png")
    before = sources_of(checkout)
    written(checkout.parent / "elsewhere/view.png", "another\n")
    assert sources_of(checkout) != before
