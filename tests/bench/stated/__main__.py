"""`python -m tests.bench.stated [PART ...]`: measure parts anew, keep the others.

Writes data/records/stated.json. Without names, all parts: it takes long.
"""

import importlib
import pkgutil
import sys
from datetime import UTC, datetime
from pathlib import Path
from time import process_time

import numpy as np

from raxel.io.files import read_json, write_json
from tests.bench import stated
from tests.bench.provenance import commit, versions

RECORD = Path("data/records/stated.json")
DIGITS = 4


def parts():
    """Names of the parts: modules of this package with a measurement."""
    found = [one.name for one in pkgutil.iter_modules(stated.__path__)]
    return [name for name in found if not name.startswith("_")]


def measured_part(name):
    """What the record holds of one part."""
    module = importlib.import_module(f"tests.bench.stated.{name}")
    began, rows = process_time(), []
    for row in module.measured():
        rows.append({key: _rounded(value) for key, value in row.items()})
        print(name, rows[-1], flush=True)
    return {
        "part": name,
        "what": module.WHAT,
        "titles": _titles(module, rows),
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "raxel": commit(),
        "seconds": round(process_time() - began),
        "rows": rows,
    }


def _titles(module, rows):
    """{name: head} of the columns, in the rows' order; KeyError for one without."""
    heads = stated.COMMON | module.TITLES
    return {name: heads[name] for name in rows[0]}


def recorded(names):
    """The record, with these parts measured now."""
    kept = read_json(RECORD)["sets"] if RECORD.exists() else []
    found = {one["part"]: one for one in kept}
    found |= {name: measured_part(name) for name in names}
    return {
        "what": "How stated errors compare with errors that happen: corners, decoded "
        "places, calibrations. Each part has a line of its own.",
        "command": "python -m tests.bench.stated",
        "note": "A record: no build makes it again, since it takes long.",
        "versions": versions(),
        "sets": [found[name] for name in sorted(found)],
    }


def _rounded(value):
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None
    return value


if __name__ == "__main__":
    asked = sys.argv[1:] or parts()
    if unknown := sorted(set(asked) - set(parts())):
        sys.exit(f"no part {', '.join(unknown)}: there are {', '.join(parts())}")
    write_json(RECORD, recorded(asked))
