"""Run an experiment whole, or run its parts and gather them.

A job of the workflow (`repro.workflow.job`) does so with one BLAS thread.
"""

from __future__ import annotations

import datetime
import importlib
import json
import platform
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

import numpy as np

from repro.run import discover, marks, results
from repro.run.outcomes import Plan
from repro.run.rendered import declared, manifest

VERSIONS = ("numpy", "scipy", "opencv-python-headless", "matplotlib")
CODE = (("repro.run.marks", "run_trials"), ("repro.run.results", "gather"))


def producer(root: Path, kind: str, identifier: str) -> discover.Producer:
    """Return the producer of that kind and id."""
    for found in discover.producers(root):
        if (found.kind, found.id) == (kind, identifier):
            return found
    raise LookupError(f"no page makes {kind} {identifier}")


def function_of(found: discover.Producer):
    """Import the chapter and return the marked function, for a family with its id."""
    function = getattr(importlib.import_module(found.module), found.function)
    if not found.details.get("family"):
        return function

    def of_family(given: object, *more: object) -> object:
        return function(given, found.id, *more)

    return of_family


@dataclass(frozen=True)
class Size:
    """The size of a build: the effort, and what-if trials or a multiple of all."""

    effort: str
    trials: int | None = None
    scale: int = 1

    @property
    def name(self) -> str:
        """Folder below `figures`: what-if sizes are stored separately."""
        if self.trials is not None:
            return f"what-if/{self.effort}-trials-{self.trials}"
        if self.scale > 1:
            return f"what-if/{self.effort}-scale-{self.scale}"
        return self.effort

    @property
    def base(self) -> str:
        """Folder of results and figures."""
        return f"figures/{self.name}"

    @property
    def site(self) -> str:
        """Folder of the built site."""
        short = self.name.rpartition("/")[2]
        return "report/site" if short == "full" else f"report/site-{short}"

    def trials_of(self, found: discover.Producer, planned: int) -> int:
        """Trials per condition of an experiment that plans so many.

        A multiple holds for repeated trials only, and not where they are rendered sets,
        whose number is fixed.
        """
        if self.trials is not None:
            return self.trials
        fixed = planned == 1 or found.rendered(self.effort)
        return planned if fixed else planned * self.scale


@dataclass(frozen=True)
class Order:
    """The experiment to run: its name, the size, the folder of all results."""

    name: str
    size: Size
    results: Path

    def inputs(self, root: Path) -> dict[str, str]:
        """Return `input_hashes` of the experiment and of the manifests of rendered
        sets."""
        found = producer(root, "experiment", self.name)
        names = found.rendered(self.size.effort)
        sets = {name: results.hash_of(root / manifest(name)) for name in names}
        return input_hashes(root, found) | sets

    def plan(self, root: Path, found: discover.Producer) -> Plan:
        """Return the experiment's plan with the trials of the size."""
        more = [results.opened(self.results, found.needs)] if found.needs else []
        plan = function_of(found)(self.size.effort, *more)
        return replace(plan, trials=self.size.trials_of(found, plan.trials))


def run(root: Path, order: Order, shard: int, of: int, out: Path) -> None:
    """Run one shard of an experiment into ``out`` (JSON, with an .npz next to it)."""
    with _planned(root, order) as (found, plan):
        records, arrays, seconds = _trials(found, plan, shard, of)
    results.write_arrays(out.with_suffix(".npz"), arrays)
    results.write_json(out, {"records": records, "seconds": seconds})


def whole(root: Path, order: Order, code: str, out: Path) -> None:
    """Run an experiment that is one job into its result file and run record."""
    with _planned(root, order) as (found, plan):
        records, arrays, seconds = _trials(found, plan, 0, 1)
    _leave(root, found, order, plan, code, records, arrays, [seconds], out)


def gather(root: Path, order: Order, code: str, shards: list[Path], out: Path) -> None:
    """Join the shards of an experiment into its result file and run record."""
    with _planned(root, order) as (found, plan):
        contents = [json.loads(shard.read_text("utf-8")) for shard in shards]
    records = [record for content in contents for record in content["records"]]
    arrays = {}
    for shard in shards:
        with np.load(shard.with_suffix(".npz")) as stored:
            arrays |= {key: stored[key] for key in stored}
    seconds = [content["seconds"] for content in contents]
    _leave(root, found, order, plan, code, records, arrays, seconds, out)


@contextmanager
def _planned(root: Path, order: Order) -> Iterator[tuple[discover.Producer, Plan]]:
    """The experiment and its plan; inside, the rendered sets of its mark are open."""
    found = producer(root, "experiment", order.name)
    with declared(found.rendered(order.size.effort)):
        yield found, order.plan(root, found)


def _trials(
    found: discover.Producer, plan: Plan, shard: int, of: int
) -> tuple[list[dict], dict[str, np.ndarray], float]:
    """Records and arrays of one shard's trials, and the seconds that they took."""
    start = time.monotonic()
    pairs = marks.shard_pairs(plan, shard, of)
    records, arrays = marks.run_trials(found.details["artefact"], plan, pairs)
    return records, arrays, round(time.monotonic() - start, 3)


def _leave(
    root: Path,
    found: discover.Producer,
    order: Order,
    plan: Plan,
    code: str,
    records: Sequence[dict],
    arrays: Mapping[str, np.ndarray],
    seconds: Sequence[float],
    out: Path,
) -> None:
    """Write the result file, and a record of what differs between runs."""
    identity = {
        "experiment": order.name,
        "artefact": found.details["artefact"],
        "effort": order.size.effort,
        "code": code,
        "seed": marks.ROOT_SEED,
        "inputs": order.inputs(root),
    }
    results.gather(identity, plan, records, arrays, out)
    results.write_json(
        out.with_suffix(".run.json"),
        {
            "seconds": round(sum(seconds), 1),
            "jobs": len(seconds),
            "finished": datetime.datetime.now(datetime.UTC).isoformat("T", "seconds"),
            "host": platform.node(),
            "machine": platform.machine(),
            "python": platform.python_version(),
            "versions": {name: version(name) for name in VERSIONS},
        },
    )


def input_hashes(root: Path, found: discover.Producer) -> dict[str, str]:
    """Return name -> SHA-256 of the declared inputs."""
    return {Path(path).name: results.hash_of(root / path) for path in found.inputs}
