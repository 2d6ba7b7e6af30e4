"""Targets of commands such as `make ch02`."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from repro.run import discover
from repro.workflow.build import OrderError, _targets
from repro.workflow.work import Work, planned

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def work():
    return Work(ROOT, effort="quick", trials=None, sets={})


@pytest.mark.parametrize("chapter", ["ch02", "appendix_a"])
def test_chapter_target_has_pages(work, chapter):
    pages = {Path(name).parent.name for name in _targets(work, chapter)}
    assert len(pages) == 1
    assert pages.pop().startswith(chapter)


@pytest.mark.parametrize(
    ("order", "reason"),
    [
        ("ch77", "no page of chapter 77"),
        ("appendix_z", "no page of appendix Z"),
        ("chapter", "chapter: no such figure or table"),
    ],
)
def test_unknown_target_is_rejected(work, order, reason):
    with pytest.raises(OrderError, match=reason):
        _targets(work, order)


def test_plan_lists_chapters_once(monkeypatch):
    listings = []
    producers = discover.producers
    monkeypatch.setattr(
        discover, "producers", lambda root: listings.append(root) or producers(root)
    )
    work = Work(ROOT, "quick", None, {})
    assert all(work.page_inputs(SimpleNamespace(page=page)) for page in work.pages)
    assert work.rendered.names
    assert listings == [ROOT]


def test_rules_share_plan_of_command():
    planned.cache_clear()
    assert planned(ROOT, "quick", None, "") is planned(ROOT, "quick", None, "")
    assert planned(ROOT, "full", None, "") is not planned(ROOT, "quick", None, "")
