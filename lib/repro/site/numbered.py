"""Numbered artefacts of the thesis: their pages, and short lists of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby

from repro.judge.scoreboard import natural
from repro.page.wording import label
from repro.run.discover import Producer


def by_page(
    made: Iterable[Producer], artefacts: Mapping[str, dict]
) -> dict[str, list[str]]:
    """Return page -> ids of its artefacts of the thesis, in the order of `natural`.

    ``artefacts`` are those of the ledger.
    """
    found: dict[str, list[str]] = {}
    for producer in made:
        if producer.kind in ("figure", "table") and producer.id in artefacts:
            found.setdefault(producer.page, []).append(producer.id)
    return {page: sorted(own, key=natural) for page, own in found.items()}


def listed(identifiers: Sequence[str]) -> str:
    """Return a short list of sorted artefacts: Fig. 4.7 to 4.9, Table 4.4."""
    parts = []
    for _, own in groupby(identifiers, key=_kind):
        runs = _runs(list(own))
        word = label(runs[0][0]).rpartition(" ")[0]
        parts.append(f"{word} {', '.join(map(_numbers, runs))}")
    return ", ".join(parts)


def _kind(identifier: str) -> str:
    return identifier.partition("_")[0]


def _numbers(run: Sequence[str]) -> str:
    """The numbers of a run; the ends of three or more."""
    numbers = [label(identifier).rpartition(" ")[2] for identifier in run]
    return f"{numbers[0]} to {numbers[-1]}" if len(run) > 2 else ", ".join(numbers)


def _runs(identifiers: Sequence[str]) -> list[list[str]]:
    """Groups of consecutive numbers."""
    runs: list[list[str]] = []
    for identifier in identifiers:
        before, _, last = identifier.rpartition("_")
        previous = f"{before}_{int(last) - 1}" if last.isdigit() else None
        if runs and runs[-1][-1] == previous:
            runs[-1].append(identifier)
        else:
            runs.append([identifier])
    return runs


def entry(title: str, identifiers: Sequence[str]) -> str:
    """Return the navigation entry of a page: its title up to a colon, and its
    artefacts.

    Artefacts in the title are not repeated; without artefacts the title is unchanged.
    """
    short = title.partition(":")[0]
    held = [i for i in identifiers if label(i) not in short]
    return f"{short}: {listed(held)}" if held else title
