"""Result files: one per experiment, reproducible for the same code, seed and input.

`<experiment>.json` holds settings, conditions, per-trial values and summaries,
`<experiment>.npz` arrays, `<experiment>.run.json` what differs between runs.
"""

from __future__ import annotations

import hashlib
import json
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, cached_property
from io import BytesIO
from pathlib import Path

import numpy as np

from raxel.io import files
from repro.judge.statistics import median_interval
from repro.run.outcomes import Plan

Part = str | float
"""A key of the return value of a trial."""
WRITTEN: list[Path] = []
"""Files that this process has written so far, for the record of the job."""


def write_atomic(path: Path, content: str | bytes) -> None:
    """Write as `raxel.io.files.write_whole`; make the folder if it is missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    files.write_whole(path, content)
    WRITTEN.append(path)


def write_json(path: Path, content: object) -> None:
    """Write as `raxel.io.files.write_json`; make the folder if it is missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    files.write_json(path, content)
    WRITTEN.append(path)


def write_arrays(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write an .npz whose bytes depend on the arrays only, not on the time."""
    buffer = BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(arrays):
            data = BytesIO()
            np.lib.format.write_array(data, np.ascontiguousarray(arrays[name]))
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), data.getvalue())
    write_atomic(path, buffer.getvalue())


def hash_of(path: Path) -> str:
    """SHA-256 of a file's content; an unchanged file is read once."""
    return _hash(path, path.stat().st_mtime_ns)


@cache
def _hash(path: Path, changed: int) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def gather(
    identity: Mapping[str, object],
    plan: Plan,
    records: Sequence[dict],
    arrays: Mapping[str, np.ndarray],
    path: Path,
) -> None:
    """Join the records of the shards into the result file; check that none is
    missing."""
    wanted = set(plan.pairs)
    found = [(r["condition"], r["trial"]) for r in records]
    if len(found) != len(set(found)) or set(found) != wanted:
        raise ValueError(
            f"{path}: {len(wanted - set(found))} of {len(wanted)} trials missing, "
            f"{len(found) - len(set(found))} twice; remove the shards and run again"
        )
    ordered = sorted(records, key=lambda r: (r["condition"], r["trial"]))
    if arrays:
        write_arrays(path.with_suffix(".npz"), arrays)
    else:
        path.with_suffix(".npz").unlink(missing_ok=True)
    write_json(
        path,
        {
            **identity,
            "settings": dict(plan.settings),
            "trials_per_condition": plan.trials,
            "first_trial": plan.first,
            "conditions": list(plan.conditions),
            "trials": ordered,
            "summaries": [
                _summaries([r["values"] for r in ordered if r["condition"] == c])
                for c in range(len(plan.conditions))
            ],
        },
    )


def _summaries(rows: Sequence[Mapping[str, object]]) -> dict[str, dict]:
    names = sorted({n for row in rows for n, v in row.items() if _is_number(v)})
    return {name: summary([row.get(name) for row in rows]) for name in names}


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def summary(values: Sequence[float | None]) -> dict:
    """Median with its 95 % interval, mean, SD of the trials that have a value.

    Trials without a value are counted: only a judgement defines the worst value.
    """
    good = np.sort([v for v in values if _is_number(v)])
    middle = median_interval(good)
    return {
        "n": len(good),
        "without_value": len(values) - len(good),
        "median": middle.value,
        "median_interval": [middle.low, middle.high],
        "mean": float(good.mean()),
        "sd": float(good.std(ddof=1)) if len(good) > 1 else None,
    }


class Selection:
    """Trials of several conditions of a result, in the order of the plan, then by
    trial.

    ``column``, ``texts`` and ``arrays`` return a value with one entry per trial over
    all conditions, so that a seed per condition reads like a seed per trial. A trial
    returns a dictionary of dictionaries; a path is a sequence of keys: ``column("CGSP",
    "stage2", "error_mm")``.
    """

    def __init__(self, result: Result, conditions: Mapping[int, dict]) -> None:
        self._result, self._conditions = result, conditions

    @property
    def conditions(self) -> list[dict]:
        """Return the selected conditions, in the order of the plan."""
        return list(self._conditions.values())

    def select(self, **condition: object) -> Selection:
        """Return the conditions that match; KeyError if none does."""
        fits = {
            i: have for i, have in self._conditions.items() if _fits(have, condition)
        }
        if not fits:
            raise KeyError(f"{self._result.path}: 0 conditions fit {condition}")
        return Selection(self._result, fits)

    def by(self, key: str, **condition: object) -> dict[object, Selection]:
        """Return level -> its trials, for every level of a condition's ``key``."""
        found = self.select(**condition)
        levels = dict.fromkeys(c[key] for c in found.conditions if key in c)
        return {level: found.select(**{key: level}) for level in levels}

    def levels(self, key: str, **condition: object) -> list:
        """Return every level of a condition's ``key`` once, in the order of the
        plan."""
        return list(self.by(key, **condition))

    def column(self, *path: Part | Sequence[Part]) -> np.ndarray:
        """Return a value of every trial (..., trials); nan if the trial has none.

        Several keys at one position of the path give an axis before the trials.
        """
        for place, keys in enumerate(path):
            if isinstance(keys, list | tuple):
                before, after = path[:place], path[place + 1 :]
                return np.array([self.column(*before, key, *after) for key in keys])
        name = _joined(path)
        return np.array([_number(v.get(name)) for v in self._rows()], dtype=float)

    def texts(self, *path: Part) -> list[str | None]:
        """Return a text of every trial (such as the reason of a failure)."""
        name = _joined(path)
        return [v.get(name) for v in self._rows()]

    def arrays(self, *path: Part) -> list[np.ndarray]:
        """Return one array per trial; trials without it are omitted."""
        name = _joined(path)
        stored, first = self._result.stored, self._result.first_trial
        trials = range(first, first + self._result.trials_per_condition)
        keys = (f"{i}/{t}/{name}" for i in self._conditions for t in trials)
        known = frozenset(stored)
        return [stored[key] for key in keys if key in known]

    def _rows(self) -> list[dict]:
        return [row for i in self._conditions for row in self._result._values[i]]


class Result(Selection):
    """A result file, read: all of its trials.

    Its methods also take a condition, and then read the trials of that condition only.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        content = json.loads(path.read_text("utf-8"))
        self.settings: dict = content["settings"]
        self.trials_per_condition: int = content["trials_per_condition"]
        self.first_trial: int = content["first_trial"]
        self._values: list[list[dict]] = [[] for _ in content["conditions"]]
        for record in content["trials"]:
            self._values[record["condition"]].append(record["values"])
        super().__init__(self, dict(enumerate(content["conditions"])))

    @cached_property
    def stored(self) -> Mapping[str, np.ndarray]:
        """Return the arrays of all trials; each is read when it is needed."""
        return np.load(self.path.with_suffix(".npz"))

    def column(self, *path: Part | Sequence[Part], **condition: object) -> np.ndarray:
        """Read as `Selection.column`, for the one condition that matches."""
        return self.one(**condition).column(*path)

    def texts(self, *path: Part, **condition: object) -> list[str | None]:
        """Read as `Selection.texts`, for the one condition that matches."""
        return self.one(**condition).texts(*path)

    def arrays(self, *path: Part, **condition: object) -> list[np.ndarray]:
        """Read as `Selection.arrays`, for the one condition that matches."""
        return self.one(**condition).arrays(*path)

    def names(self) -> list[str]:
        """Return the names of all values of any trial."""
        return sorted({name for row in self._rows() for name in row})

    def one(self, **condition: object) -> Selection:
        """Return the trials of the one condition that matches; KeyError for 0 or
        several."""
        found = self.select(**condition)
        if len(found.conditions) != 1:
            raise KeyError(
                f"{self.path}: {len(found.conditions)} conditions fit {condition}"
            )
        return found


def _joined(path: Sequence[Part]) -> str:
    """Return the name under which a value is stored (`repro.run.marks.run_trials`)."""
    return ".".join(map(str, path))


def _fits(have: Mapping[str, object], condition: Mapping[str, object]) -> bool:
    return all(k in have and have[k] == v for k, v in condition.items())


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else float("nan")


def opened(folder: Path, experiments: Iterable[str]) -> dict[str, Result]:
    """Return experiment -> Result."""
    return {name: Result(folder / f"{name}.json") for name in experiments}
