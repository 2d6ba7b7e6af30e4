"""Where the time of a build goes: processor seconds of each page, from its jobs.

A job leaves `<label>.json` in `figures/<effort>/times` (`repro.workflow.job`). What was
kept from an earlier build counts with the time it took then; a record that no job of
this build leaves any more does not count.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from repro.run.discover import Producer

SLOWEST = 10


@dataclass
class PageTimes:
    """Processor seconds of a page's jobs: experiments, figures and tables, the rest."""

    page: str
    computed: float = 0.0
    drawn: float = 0.0
    rest: float = 0.0

    @property
    def total(self) -> float:
        """All of them."""
        return self.computed + self.drawn + self.rest


@dataclass(frozen=True)
class Times:
    """The times of a build: of each page, its slowest experiments, and what is of no
    page: the rendered sets, which several may share, and the scoreboard.
    """

    pages: Sequence[PageTimes]
    slowest: Sequence[tuple[str, str, float]]
    rendered: float
    scoreboard: float

    @property
    def total(self) -> float:
        """Processor seconds of all of these jobs."""
        return self.rendered + self.scoreboard + sum(page.total for page in self.pages)


def times_of(
    folder: Path,
    sets: Path,
    effort: str,
    made: Iterable[Producer],
    pages: Sequence[str],
) -> Times:
    """Add up the records below ``folder`` for the ``pages`` of a build.

    Parameters
    ----------
    sets : folder of the records of rendered sets.
    made : the producers of all chapters.
    pages : ids of the pages; one of an image set ends with the set's name.
    """
    sums = {page: PageTimes(page) for page in pages}
    experiments: list[tuple[str, str, float]] = []
    rendered: set[str] = set()
    for producer in made:
        for page, name in _editions(producer, pages):
            seconds = sum(map(seconds_kept, _records(folder, producer, name, effort)))
            rendered |= set(producer.rendered(effort))
            if producer.kind == "experiment":
                sums[page].computed += seconds
                experiments.append((name, page, seconds))
            elif producer.kind in ("figure", "table"):
                sums[page].drawn += seconds
    for page, times in sums.items():
        for kind in ("judge", "page"):
            times.rest += seconds_kept(folder / kind / f"{page}.json")
    experiments.sort(key=lambda found: -found[2])
    scoreboard = seconds_kept(folder / "scoreboard.json")
    made_sets = sum(seconds_kept(sets / f"{name}.json") for name in sorted(rendered))
    return Times(list(sums.values()), experiments[:SLOWEST], made_sets, scoreboard)


def _editions(producer: Producer, pages: Sequence[str]) -> list[tuple[str, str]]:
    """(page, name) of a producer; one that stands once per set has several."""
    if not producer.details.get("per_set"):
        return [(producer.page, producer.id)] if producer.page in pages else []
    chapter = producer.page.partition("/")[0]
    named = {
        page.rpartition("/")[2]: page for page in pages if page.startswith(chapter)
    }
    return [(page, f"{producer.id}@{name}") for name, page in named.items()]


def _records(folder: Path, producer: Producer, name: str, effort: str) -> list[Path]:
    """Records of a producer's jobs, of the number of shards that it has now."""
    own = folder / producer.kind / f"{name}.json"
    shards = producer.shards(effort)
    if shards == 1:
        return [own]
    parts = [own.with_suffix("") / f"{i}-of-{shards}.json" for i in range(shards)]
    return [*parts, folder / "result" / own.name]


def seconds_kept(path: Path) -> float:
    """Processor seconds of a record; none where the job has not run, or it was cut."""
    try:
        return float(json.loads(path.read_text("utf-8"))["processor_seconds"])
    except (OSError, ValueError):
        return 0.0
