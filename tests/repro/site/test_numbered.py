"""Artefacts of the thesis by number: in few words, by page, and in the navigation."""

import pytest

from repro.run.discover import Producer
from repro.site.numbered import by_page, entry, listed


@pytest.mark.parametrize(
    ("identifiers", "words"),
    [
        ("fig_4_6 table_4_2 table_4_3", "Fig. 4.6, Table 4.2, 4.3"),
        (
            "alg_1 fig_4_8 fig_4_9 fig_4_10 fig_4_12",
            "Algorithm 1, Fig. 4.8 to 4.10, 4.12",
        ),
        ("app_a", "Appendix A"),
    ],
)
def test_artefact_list_is_short(identifiers, words):
    assert listed(identifiers.split()) == words


def test_navigation_lists_artefacts_of_page():
    title = "4.3.2 A mirror and a fisheye, rendered: parameters, errors"
    held = ["fig_4_6", "table_4_3"]
    assert entry(title, held) == (
        "4.3.2 A mirror and a fisheye, rendered: Fig. 4.6, Table 4.3"
    )
    assert entry(title, []) == title
    named = "2.4.1 Algorithm 1: its linear stage"
    assert entry(named, ["alg_1"]) == named


def test_page_artefacts_are_in_order():
    made = [
        Producer(kind, name, "m", "f", "ch/page", 1, {})
        for kind, name in (
            ("table", "table_3_1"), ("figure", "fig_3_10"), ("figure", "fig_3_2"),
            ("figure", "ext_more"), ("numbers", "table_3_2"),
        )
    ]  # fmt: skip
    thesis = {n: {} for n in ("fig_3_2", "fig_3_10", "table_3_1", "table_3_2")}
    found = by_page(made, thesis)
    assert list(found.values()) == [["fig_3_2", "fig_3_10", "table_3_1"]]
