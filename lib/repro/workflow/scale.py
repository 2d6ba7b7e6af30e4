"""The cost model: processor time and memory against trials and against image size.

An experiment with repeated trials takes time in proportion to them; everything else is
fixed. A job starts in `STARTING_S`. The factors are the stored costs of a full build
(`make costs`). Costs of image sizes are from `tests/bench/large_images.py`.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path

import numpy as np

from repro.run.jobs import Size
from repro.site.sphinx import make_site
from repro.workflow.costs import costs
from repro.workflow.plan import (
    COMPUTING,
    GATHERED_MB,
    SCALED_S,
    STARTING_S,
    BuildPlan,
    BuildTask,
    planned,
)

SCALES = (1, 10, 100)
IMAGES = Path(__file__).with_name("image_costs.csv")
SETS, REST, STARTS = "image sets", "figures, pages and site", "starts of the jobs"


def site(root: Path, *given: object) -> None:
    """Make the site (`repro.site.sphinx`) with the page of the model."""
    make_site(
        root,
        *given,
        {
            "scales": SCALES,
            "jobs": [len(plan.jobs) for plan in _plans(root)],
            "longest_s": SCALED_S,
            "gathered_mb": GATHERED_MB,
            "parts": parts(root),
            "checks": checks(root),
            "images": images(),
        },
    )


def _plans(root: Path) -> list[BuildPlan]:
    """Plans of a full build at each of `SCALES`."""
    sizes = [Size("full", None, scale) for scale in SCALES]
    return [planned(root, size, "", "report", "open") for size in sizes]


def parts(root: Path) -> dict[str, tuple[list[float], float]]:
    """Return part of the report -> processor hours at each of `SCALES`, peak MB."""
    hours: dict[str, list[float]] = defaultdict(lambda: [0.0] * len(SCALES))
    peaks: dict[str, float] = defaultdict(float)
    for column, plan in enumerate(_plans(root)):
        for task in plan.wanted:
            name, cost = _part(plan, task), plan.cost(task)
            hours[name][column] += plan.seconds(task) / 3600
            peaks[name] = max(peaks[name], cost.peak_mb if cost else 0.0)
        hours[STARTS][column] = STARTING_S * len(plan.jobs) / 3600
    ordered = sorted(hours, key=lambda name: (not name.startswith("ch"), name))
    return {name: (hours[name], peaks[name]) for name in ordered}


def _part(plan: BuildPlan, task: BuildTask) -> str:
    """The chapter of an experiment, or what else a task belongs to."""
    kind, _, name = task.name.partition("/")
    if kind in ("experiment", "part"):
        page = plan.producers["experiment", name.partition("/")[0]].page
        return page.partition("/")[0]
    return SETS if task.stage in COMPUTING else REST


def checks(root: Path) -> list[tuple[str, int, float, float, float]]:
    """Return the experiments whose costs with more trials are stored.

    Of each: name, multiple of the trials, predicted and measured seconds, peak MB.
    """
    known = costs(root)
    return [
        (name, scale, known["full"][name].seconds * scale, cost.seconds, cost.peak_mb)
        for scale in SCALES[1:]
        for name, cost in known.get(Size("full", None, scale).name, {}).items()
        if cost.trials == scale * known["full"][name].trials
    ]


def images() -> list[tuple[str, float, float, float, float | None]]:
    """Return the costs of each step of `raxel` on images of each size.

    Of each: step, megapixels, seconds, peak MB, and for the largest size the MB that a
    line through the others predicts.
    """
    with IMAGES.open(encoding="utf-8", newline="") as file:
        rows = [
            (row[1], *map(float, (row[0], *row[2:]))) for row in [*csv.reader(file)][1:]
        ]
    found = []
    for step in dict.fromkeys(row[0] for row in rows):
        *others, last = (row for row in rows if row[0] == step)
        line = np.polyfit([row[1] for row in others], [row[3] for row in others], 1)
        found += [(*row, None) for row in others]
        found.append((*last, float(np.polyval(line, last[1]))))
    return found
