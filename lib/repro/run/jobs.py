"""The jobs of an experiment: run it in one job, or run its shards and gather them.

Each job is one process, `python -m repro JOB ...`, which Snakemake starts with one BLAS
thread. A job imports only its chapter.
"""

from __future__ import annotations

import datetime
import hashlib
import importlib
import json
import platform
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
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
class Order:
    """The experiment to run: name, size, what-if trials.

    ``results`` is the folder with the results of other experiments.
    """

    name: str
    effort: str
    trials: int | None
    results: Path

    def inputs(self, root: Path) -> dict[str, str]:
        """Return `input_hashes` of the experiment and of the manifests of rendered
        sets."""
        found = producer(root, "experiment", self.name)
        names = found.rendered(self.effort)
        sets = {name: _hash_now(root / manifest(name)) for name in names}
        return input_hashes(root, found) | sets

    def plan(self, root: Path, found: discover.Producer) -> Plan:
        """Return the experiment's plan, with the what-if number of trials if one is
        given."""
        more = [results.opened(self.results, found.needs)] if found.needs else []
        plan = function_of(found)(self.effort, *more)
        if self.trials is None:
            return plan
        return replace(plan, trials=self.trials)


def run(root: Path, order: Order, shard: int, of: int, out: Path) -> None:
    """Run one shard of an experiment into ``out`` (JSON, with an .npz next to it)."""
    with _planned(root, order) as (found, plan):
        records, arrays, seconds = _trials(found, plan, shard, of)
    results.write_arrays(out.with_suffix(".npz"), arrays)
    results.write_json(out, {"records": records, "seconds": seconds})


def whole(
    root: Path, order: Order, code: str, inputs: Mapping[str, str], out: Path
) -> None:
    """Run an experiment that is one job into its result file and run record."""
    with _planned(root, order) as (found, plan):
        records, arrays, seconds = _trials(found, plan, 0, 1)
    _leave(found, order, plan, code, inputs, records, arrays, [seconds], out)


def gather(
    root: Path,
    order: Order,
    code: str,
    inputs: Mapping[str, str],
    shards: list[Path],
    out: Path,
) -> None:
    """Join the shards of an experiment into its result file and run record."""
    with _planned(root, order) as (found, plan):
        contents = [json.loads(shard.read_text("utf-8")) for shard in shards]
    records = [record for content in contents for record in content["records"]]
    arrays = {}
    for shard in shards:
        with np.load(shard.with_suffix(".npz")) as stored:
            arrays |= {key: stored[key] for key in stored}
    seconds = [content["seconds"] for content in contents]
    _leave(found, order, plan, code, inputs, records, arrays, seconds, out)


@contextmanager
def _planned(root: Path, order: Order) -> Iterator[tuple[discover.Producer, Plan]]:
    """The experiment and its plan; inside, the rendered sets of its mark are open."""
    found = producer(root, "experiment", order.name)
    with declared(found.rendered(order.effort)):
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
    found: discover.Producer,
    order: Order,
    plan: Plan,
    code: str,
    inputs: Mapping[str, str],
    records: Sequence[dict],
    arrays: Mapping[str, np.ndarray],
    seconds: Sequence[float],
    out: Path,
) -> None:
    """Write the result file, and a record of what differs between runs."""
    identity = {
        "experiment": order.name,
        "artefact": found.details["artefact"],
        "effort": order.effort,
        "code": code,
        "seed": marks.ROOT_SEED,
        "inputs": inputs,
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
    return {Path(path).name: _hash_now(root / path) for path in found.inputs}


def _hash_now(path: Path) -> str:
    return _hash(path, path.stat().st_mtime_ns)


@cache
def _hash(path: Path, changed: int) -> str:
    """SHA-256 of a file with this modification time; an unchanged one is read once."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
