"""The cost model: processor time and memory against trials and against image size.

An experiment with repeated trials takes time in proportion to them; everything else is
fixed. A job starts in `STARTING_S`. The factors are the stored costs of a full build
(`make costs`). Costs of image sizes are from `tests/bench/large_images.py`.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import numpy as np

from repro.run.jobs import Size
from repro.workflow.costs import costs
from repro.workflow.plan import COMPUTING, STARTING_S, BuildPlan, BuildTask, planned

SCALES = (1, 10, 100)
IMAGES = Path(__file__).with_name("image_costs.csv")
SETS, REST, STARTS = "image sets", "figures, pages and site", "starts of the jobs"


class Part(NamedTuple):
    """Processor hours of a part of the report at each of `SCALES`, and peak MB."""

    name: str
    hours: list[float]
    peak_mb: float


class Check(NamedTuple):
    """An experiment that ran with more trials: seconds predicted and measured."""

    experiment: str
    scale: int
    predicted: float
    measured: float
    peak_mb: float


class ImageCost(NamedTuple):
    """A step of `raxel` on images of one size; predicted: MB, of the largest size."""

    step: str
    megapixels: float
    seconds: float
    peak_mb: float
    predicted_mb: float | None


def plans(root: Path) -> list[BuildPlan]:
    """Return the plans of a full build at each of `SCALES`."""
    sizes = [Size("full", None, scale) for scale in SCALES]
    return [planned(root, size, "", "report", "open") for size in sizes]


def parts(root: Path) -> list[Part]:
    """Return the model of the chapters, the rest, and the starts of the jobs."""
    hours: dict[str, list[float]] = defaultdict(lambda: [0.0] * len(SCALES))
    peaks: dict[str, float] = defaultdict(float)
    for column, plan in enumerate(plans(root)):
        for task in plan.wanted:
            name, cost = _part(plan, task), plan.cost(task)
            hours[name][column] += plan.seconds(task) / 3600
            peaks[name] = max(peaks[name], cost.peak_mb if cost else 0.0)
        hours[STARTS][column] = STARTING_S * len(plan.jobs) / 3600
    return [Part(name, hours[name], peaks[name]) for name in sorted(hours)]


def _part(plan: BuildPlan, task: BuildTask) -> str:
    """The chapter of an experiment, or what else a task belongs to."""
    kind, _, name = task.name.partition("/")
    if kind in ("experiment", "part"):
        page = plan.producers["experiment", name.partition("/")[0]].page
        return page.partition("/")[0]
    return SETS if task.stage in COMPUTING else REST


def checks(root: Path) -> list[Check]:
    """Return the experiments whose costs are stored for a full build with a SCALE."""
    known, found = costs(root), []
    for scale in SCALES[1:]:
        for name, cost in known.get(Size("full", None, scale).name, {}).items():
            kind, _, experiment = name.partition("/")
            usual = known["full"].get(name)
            if kind == "experiment" and usual and cost.trials > usual.trials:
                predicted = usual.seconds * cost.pairs / usual.pairs
                found.append(
                    Check(experiment, scale, predicted, cost.seconds, cost.peak_mb)
                )
    return found


def images() -> list[ImageCost]:
    """Return the measured costs; a line through the others predicts the last MB."""
    with IMAGES.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    found = []
    for step in dict.fromkeys(row["step"] for row in rows):
        own = np.array(
            [
                [float(row[name]) for name in ("megapixels", "seconds", "peak_mb")]
                for row in rows
                if row["step"] == step
            ]
        )
        line = np.polyfit(own[:-1, 0], own[:-1, 2], 1)
        predicted = [None] * (len(own) - 1) + [float(np.polyval(line, own[-1, 0]))]
        found += [
            ImageCost(step, *map(float, row), mb)
            for row, mb in zip(own, predicted, strict=True)
        ]
    return found
