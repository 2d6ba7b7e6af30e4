"""`make recorded`: store the test of each judged claim as hashes.

A test may be changed after its result was known, but not without a note: `changed:` in
`claims.yaml` states the change. `data/published/recorded.yaml` holds hashes of each
claim's test, of the readings that it is judged in, of its judge and of `changed:`. A
claim whose test changed while its `changed:` did not gets no new entry, and `faults`
names it.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Mapping
from pathlib import Path

from repro.judge.ledger import FOLDER, LedgerError, read_yaml
from repro.judge.readings import crossed, open_questions, primary
from repro.judge.schema import faults as faults_of_schema
from repro.run.discover import Producer, producers
from repro.run.reach import Reach
from repro.run.results import write_atomic

NAME = "recorded.yaml"
# A part of an entry, and its name in messages.
PARTS = {"test": "its text", "readings": "its readings", "judge": "its judge"}
HEAD = """\
# The test of each judged claim, as hashes. `make recorded` writes this file.
#
# - test: the words of `test` in claims.yaml.
# - readings: every combination of options that the claim is judged in, and which of
#   them is primary.
# - judge: the code of the test, with the code of chapters/ that it reaches; what things
#   are called, comments and docstrings do not count. What it calls in lib/ counts by
#   its name alone: a change of repro.judge.statistics would otherwise ask for a new
#   `changed:` of every claim.
# - changed: the words of `changed` in claims.yaml, and of `rewritten`, which stands
#   there once for all claims: what was rewritten with every outcome the same.
#
# A test that is altered while `changed:` is the same fails the tests, and
# `make recorded` writes no new entry for it. First entries are free.
"""

Hashes = Mapping[str, str]


def tests_now(root: Path) -> dict[str, Hashes]:
    """Return claim -> hashes of its test in the checkout at ``root``, in their order.

    Claims without a judge, and claims outside the thesis, are omitted.
    """
    known = open_questions(root)
    reach = Reach(root, within=("chapters",))
    judged = {p.id: p for p in producers(root) if p.kind == "claim"}
    ledger = read_yaml(root / FOLDER / "claims.yaml")
    rewritten = ledger.get("rewritten", "")
    return {
        entry["id"]: _hashes(entry, rewritten, judged[entry["id"]], known, reach)
        for entry in ledger["claims"]
        if entry["id"] in judged
    }


def _hashes(
    entry: Mapping, rewritten: str, judge: Producer, known: Mapping, reach: Reach
) -> Hashes:
    questions = judge.details.get("readings", ())
    asked = sorted(crossed(known, questions), key=_as_json)
    return {
        "test": _hash(_words(entry["test"])),
        "readings": _hash([primary(known, questions), asked]),
        "judge": reach.key((judge.module, judge.function)),
        "changed": _hash(_words(f"{entry.get('changed', '')} {rewritten}")),
    }


def _words(text: str) -> list[str]:
    """The words of a text, without its line breaks."""
    return text.split()


def _hash(content: object) -> str:
    return hashlib.sha256(_as_json(content).encode()).hexdigest()[:16]


def _as_json(content: object) -> str:
    return json.dumps(content, sort_keys=True)


def recorded(root: Path) -> dict[str, Hashes]:
    """Return claim -> stored hashes of its test; raises LedgerError."""
    content = read_yaml(root / FOLDER / NAME)
    lines = faults_of_schema(content, "recorded", NAME)
    if lines:
        raise LedgerError(lines[0])
    return {
        entry["id"]: {name: entry[name] for name in (*PARTS, "changed")}
        for entry in content["recorded"]
    }


def faults(root: Path) -> list[str]:
    """Return one line for each claim whose test differs from the stored one.

    A file without entries was not written yet, and has no faults.
    """
    before, now = recorded(root), tests_now(root)
    if not before:
        return []
    rejected = _unannounced(before, now)
    old = [c for c in before | now if before.get(c) != now.get(c) and c not in rejected]
    lines = [
        f"{NAME}: {claim}: not the test of today; run make recorded" for claim in old
    ]
    return [*rejected.values(), *lines]


def _unannounced(
    before: Mapping[str, Hashes], now: Mapping[str, Hashes]
) -> dict[str, str]:
    """Claim -> message, if the test changed and `changed` did not."""
    found = {}
    for claim in now:
        if claim in before and before[claim]["changed"] == now[claim]["changed"]:
            other = [p for p in PARTS if before[claim][p] != now[claim][p]]
            if other:
                parts = " and ".join(PARTS[part] for part in other)
                found[claim] = (
                    f"claims.yaml: {claim}: its test changed ({parts}), but `changed` "
                    "did not; state there the change and the results known before, "
                    "then run make recorded"
                )
    return found


def record(root: Path) -> list[str]:
    """Store the present tests; return a line for each rejected one.

    A rejected claim keeps its entry.
    """
    path = root / FOLDER / NAME
    before, now = recorded(root) if path.is_file() else {}, tests_now(root)
    rejected = _unannounced(before, now)
    entries = [
        {"id": claim} | dict(before[claim] if claim in rejected else now[claim])
        for claim in now
    ]
    lines = [f"- {json.dumps(entry)}" for entry in entries]
    write_atomic(path, "\n".join([HEAD + "recorded:", *lines, ""]))
    return list(rejected.values())


def main() -> int:
    """Write the record of the current checkout; return 1 if a claim was rejected."""
    try:
        rejected = record(Path.cwd())
    except LedgerError as error:
        rejected = [str(error)]
    for line in rejected:
        print(line, file=sys.stderr)
    return 1 if rejected else 0


if __name__ == "__main__":
    sys.exit(main())
