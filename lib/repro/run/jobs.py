"""The jobs of the workflow: run a shard, gather, draw, judge.

Each is `python -m repro JOB ...`, one process, started by Snakemake with BLAS threads
pinned to one. A job imports the one chapter it works for.
"""

from __future__ import annotations

import datetime
import importlib
import json
import platform
import shutil
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

from repro.run import discover, experiment, results
from repro.run.outcomes import Check, Drawing, Plan, Table

VERSIONS = ("numpy", "scipy", "opencv-python-headless", "matplotlib")
CODE = (("repro.run.experiment", "run_trials"), ("repro.run.results", "gather"))


def producer(root: Path, kind: str, identifier: str) -> discover.Producer:
    """The one producer of that kind and id (``id@set`` for one that stands per set)."""
    for found in discover.producers(root):
        if (found.kind, found.id) == (kind, identifier.partition("@")[0]):
            return found
    raise LookupError(f"no page makes {kind} {identifier}")


def function_of(found: discover.Producer):
    """Import the chapter and return the marked function."""
    return getattr(importlib.import_module(found.module), found.function)


@dataclass(frozen=True)
class Order:
    """Which experiment to run: name, size, what-if trials, image set if any.

    ``results`` is the folder of the results that other experiments have left, and
    ``sets`` are the image sets of the build, for an experiment that reads every set's.
    """

    name: str
    effort: str
    trials: int | None
    set_folder: str | None
    results: Path
    sets: Sequence[str] = ()

    def plan(self, root: Path, found: discover.Producer) -> Plan:
        """The experiment's plan, with the what-if number of trials if one is given."""
        more = [] if self.set_folder is None else [self.set_folder]
        if found.needs:
            read = results_of(root, found, self.name, self.sets)
            more.append(results.opened(self.results, read))
        plan = function_of(found)(self.effort, *more)
        if self.trials is None:
            return plan
        return replace(plan, trials=self.trials)


def run(root: Path, order: Order, shard: int, of: int, out: Path) -> None:
    """Run one shard of an experiment into ``out`` (JSON, with an .npz beside it)."""
    found = producer(root, "experiment", order.name)
    plan = order.plan(root, found)
    start = time.monotonic()
    pairs = experiment.shard_pairs(plan, shard, of)
    records, arrays = experiment.run_trials(_seed_name(found, order), plan, pairs)
    results.write_arrays(out.with_suffix(".npz"), arrays)
    results.write_json(
        out,
        {"records": records, "seconds": round(time.monotonic() - start, 3)},
    )


def _seed_name(found: discover.Producer, order: Order) -> str:
    _, at, set_name = order.name.partition("@")
    return found.details["artefact"] + at + set_name


def gather(
    root: Path,
    order: Order,
    code: str,
    inputs: dict[str, str],
    shards: list[Path],
    out: Path,
) -> None:
    """Join the shards of an experiment into its result file and run record."""
    import numpy as np

    found = producer(root, "experiment", order.name)
    plan = order.plan(root, found)
    records, arrays, seconds = [], {}, 0.0
    for shard in shards:
        content = json.loads(shard.read_text("utf-8"))
        records += content["records"]
        seconds += content["seconds"]
        with np.load(shard.with_suffix(".npz")) as stored:
            arrays |= {key: stored[key] for key in stored}
    identity = {
        "experiment": order.name,
        "artefact": found.details["artefact"],
        "effort": order.effort,
        "code": code,
        "seed": experiment.ROOT_SEED,
        "inputs": inputs,
    }
    results.gather(identity, plan, records, arrays, out)
    results.write_json(
        out.with_suffix(".run.json"),
        {
            "seconds": round(seconds, 1),
            "jobs": len(shards),
            "finished": datetime.datetime.now(datetime.UTC).isoformat("T", "seconds"),
            "host": platform.node(),
            "machine": platform.machine(),
            "python": platform.python_version(),
            "versions": {name: version(name) for name in VERSIONS},
        },
    )


def draw(
    root: Path,
    kind: str,
    name: str,
    folder: Path,
    out: Path,
    sets: Sequence[str] = (),
) -> None:
    """Draw a figure (svg, png, csv) or write a table (csv), and describe it (json).

    A figure marked with a scene leaves that too (html). ``sets`` are the image sets of
    the build, for what shows all of them.
    """
    found = producer(root, kind, name)
    read = results_of(root, found, name, sets)
    made = function_of(found)(results.opened(folder, read))
    if isinstance(made, Drawing):
        from repro.page.style import save_drawing

        save_drawing(made, out.with_suffix(""))
        _write_scene(found, made, out.with_suffix(".html"))
    else:
        results.write_atomic(out.with_suffix(".csv"), csv_text(made.columns))
    results.write_json(
        out,
        {
            "id": name,
            "kind": kind,
            "caption": made.caption,
            "evidence": found.details["evidence"],
            "results": read,
            "check": _check(made),
            "scene": bool(found.details.get("scene")),
            "source": [found.path, found.function],
        },
    )


def _write_scene(found: discover.Producer, made: Drawing, out: Path) -> None:
    """Write the figure's scene where its mark promises one; drop an old one if not."""
    from repro.page.reader import label, plain
    from repro.page.scene_page import scene_html

    promised = found.details.get("scene", False)
    if promised != (made.scene is not None):
        raise ValueError(
            f"{found.module}:{found.line}: {found.id} is marked with scene={promised}, "
            f"and its drawing has {'a' if made.scene else 'no'} scene"
        )
    if made.scene is None:
        out.unlink(missing_ok=True)
    else:
        title = f"{label(found.id)} {plain(made.caption)}".strip()
        results.write_atomic(out, scene_html(made.scene, title))


def csv_text(columns) -> str:
    """CSV of named columns, numbers in full precision."""
    import csv
    from io import StringIO

    buffer = StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return buffer.getvalue()


def _check(made: Drawing | Table) -> dict | None:
    check: Check | None = made.check
    return None if check is None else {"holds": bool(check.holds), "text": check.text}


def judge(
    root: Path,
    page: str,
    stem: str,
    effort: str,
    folder: Path,
    out: Path,
    sets: Sequence[str] = (),
) -> None:
    """Run every claim test of a page, and collect its numbers and artefacts.

    ``stem`` is the id of the chapter file; it differs from the page's where the file
    makes one page per image set. ``sets`` are the image sets of the build.
    """
    mine = [p for p in discover.producers(root) if p.page == stem]
    claims, numbers, artefacts = {}, {}, {}
    for found in mine:
        evidence = found.details.get("evidence")
        name = found.id if stem == page else f"{found.id}@{page.rpartition('/')[2]}"
        if found.kind in ("claim", "numbers"):
            read = results_of(root, found, name, sets)
            outcome = function_of(found)(results.opened(folder / "results", read))
            data = [f"results/{need}.json" for need in discover.result_ids(read)]
        if found.kind == "claim":
            claims[found.id] = {
                "evidence": evidence,
                "readings": [_finite(r.as_dict()) for r in outcome],
                "data": data,
            }
        elif found.kind == "numbers":
            numbers |= {
                key: _finite({**vars(value), "evidence": evidence, "data": data})
                for key, value in outcome.items()
            }
        elif found.kind in ("figure", "table"):
            described = json.loads((folder / f"{name}.json").read_text("utf-8"))
            endings = ["svg", "png", "csv"] if found.kind == "figure" else ["csv"]
            endings += ["html"] if found.details.get("scene") else []
            artefacts[name] = {
                "evidence": evidence,
                "files": [(folder / f"{name}.{e}").as_posix() for e in endings],
                "check": described["check"],
            }
    results.write_json(
        out,
        {
            "page": page,
            "effort": effort,
            "claims": claims,
            "numbers": numbers,
            "artefacts": artefacts,
        },
    )


def _finite(values: dict) -> dict:
    """Infinite or missing floats as text or null, so that the JSON is plain."""

    def plain(value: object) -> object:
        if isinstance(value, tuple | list):
            return [plain(v) for v in value]
        if hasattr(value, "item"):
            value = value.item()
        if isinstance(value, float) and value != value:
            return None
        if isinstance(value, float) and value in (float("inf"), float("-inf")):
            return str(value)
        return value

    return {key: plain(value) for key, value in values.items()}


def results_of(
    root: Path, found: discover.Producer, name: str, sets: Sequence[str]
) -> dict[str, str | dict[str, str]]:
    """Result ids that the producer called ``name`` reads: `discover.results_read`."""
    per_set = discover.per_set_experiments(discover.producers(root))
    return discover.results_read(found.needs, per_set, name.partition("@")[2], sets)


def notebooks(pages: list[Path], folder: Path) -> None:
    """Copy the executed pages to ``folder``, one sub-folder per chapter."""
    with tempfile.TemporaryDirectory(dir=_made(folder.parent)) as scratch:
        for page in pages:
            target = Path(scratch) / "notebooks" / page.parent.name / page.name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(page, target)
        shutil.rmtree(folder, ignore_errors=True)
        shutil.move(Path(scratch) / "notebooks", folder)


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder
