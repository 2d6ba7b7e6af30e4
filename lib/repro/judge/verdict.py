"""The verdict on everything the thesis printed: one row per entry of the ledger.

A row compares an entry with the result of a page, `judged/<page>.json`, which the judge
job writes. Numbers follow `repro.judge.number_rules`. A claim has the verdict of its
primary reading; the other readings are its variants. Artefacts and sections follow from
their claims.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

from repro.judge import firmness
from repro.judge.ledger import Ledger, LedgerError, read_yaml
from repro.judge.number_rules import VerdictError, judge_number, not_produced, ratio
from repro.judge.readings import crossed, primary
from repro.judge.schema import faults, hint

KINDS = ("claims", "numbers", "artefacts")
DECIDED = ("reproduced", "differs")
JUDGED = (*DECIDED, "undecided")
# These verdicts do not depend on trials.
WITHOUT_TRIALS = ("not yet", "not comparable")
# Of mixed evidence, a row shows the kind furthest from pure calculation.
EVIDENCE = ("photograph", "rendered", "synthetic", "analytic")


def read_judged(folder: Path, pages: Iterable[str] | None = None) -> list[dict]:
    """Return the contents of the judged files below ``folder``; raises VerdictError.

    With ``pages`` (ids), only their files are read: another job may be writing others.
    """
    if pages is None:
        paths = sorted(folder.rglob("*.json"))
    else:
        paths = [folder / f"{page}.json" for page in sorted(pages)]
    found = []
    for path in paths:
        name = path.relative_to(folder).as_posix()
        try:
            content = json.loads(path.read_text("utf-8"))
        except ValueError as error:
            raise VerdictError(f"{name}: not JSON ({error}); delete it") from None
        _raise_first(faults(content, "judged", name))
        found.append(content)
    return found


def read_unfinished(root: Path) -> dict[str, str]:
    """Return the chapters that are not built yet, each with what is missing."""
    content = read_yaml(root / "chapters" / "unfinished.yaml")
    _raise_first(faults(content, "unfinished", "unfinished.yaml"))
    return content


def rows(
    ledger: Ledger,
    judged: Sequence[Mapping],
    unfinished: Mapping[str, str],
    effort: str,
) -> list[dict]:
    """Return the rows of the scoreboard: artefacts, numbers, claims, sections.

    Parameters
    ----------
    judged : contents of the judged files, one per page.
    unfinished : chapter -> what is missing; only there may a value be missing.
    effort : 'quick' shows values without verdicts.

    Raises
    ------
    VerdictError
        One line: a value that fits no rule or is missing, and what to do.
    """
    board = _Board(ledger, _collected(ledger, judged, effort), unfinished, effort)
    for identifier in ledger.claims:
        board.add("claim", identifier, _claim)
    for identifier in ledger.numbers:
        board.add("number", identifier, _number)
    for identifier in ledger.artefacts:
        board.add("artefact", identifier, _artefact)
    for identifier in ledger.sections:
        board.add("section", identifier, _section)
    _raise_first(board.problems)
    order = (ledger.artefacts, ledger.numbers, ledger.claims, ledger.sections)
    made = [board.made[identifier] for identifier in chain.from_iterable(order)]
    return [_quick(row) for row in made] if effort == "quick" else made


def _raise_first(lines: Sequence[str]) -> None:
    if lines:
        more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
        raise VerdictError(lines[0] + more)


def _collected(ledger: Ledger, judged: Iterable[Mapping], effort: str) -> dict:
    """Kind -> id -> judged entry with its page; every id is known and judged once."""
    found: dict[str, dict] = {kind: {} for kind in KINDS}
    problems = []
    for content in judged:
        page = content["page"]
        if content["effort"] != effort:
            problems.append(
                f"{page}: effort: found {content['effort']!r} in a {effort} build; "
                "delete the judged file"
            )
        for kind in KINDS:
            known = getattr(ledger, kind)
            for identifier, entry in content[kind].items():
                if identifier.startswith("ext_"):
                    continue
                if identifier not in known:
                    problems.append(
                        f"{page}: {identifier}: {_unknown(kind, known, identifier)}"
                    )
                elif identifier in found[kind]:
                    other = found[kind][identifier]["page"]
                    problems.append(
                        f"{page}: {identifier}: also judged by {other}; keep one, and "
                        "delete the judged file of a removed page"
                    )
                else:
                    found[kind][identifier] = {**entry, "page": page}
    _raise_first(problems)
    return found


def _unknown(kind: str, known: Iterable[str], identifier: str) -> str:
    close = hint(identifier, list(known))
    advice = close or "; names outside the thesis begin with ext_"
    return f"not in the {kind} of the ledger{advice}"


@dataclass
class _Board:
    """The rows made so far, and the problems found."""

    ledger: Ledger
    found: Mapping[str, Mapping[str, Mapping]]
    unfinished: Mapping[str, str]
    effort: str
    made: dict[str, dict] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    def add(self, kind: str, identifier: str, judge) -> None:
        """Make the row of one entry, or record why it cannot be made."""
        row = self._empty(kind, identifier)
        try:
            row |= judge(self, identifier) or self._missing(row)
        except VerdictError as error:
            self.problems.append(f"{self._place(kind, identifier)}: {error}")
        self.made[identifier] = row

    def _empty(self, kind: str, identifier: str) -> dict:
        entry = self.ledger.entry(identifier)
        printed = {"claim": "statement", "number": "value"}.get(kind, "title")
        words = {"claim": "statement", "number": "quantity"}.get(kind, "title")
        return {
            "id": identifier,
            "kind": kind,
            "chapter": self.ledger.chapter(identifier),
            "words": entry[words],
            "conditions": entry.get("conditions", "") if kind == "number" else "",
            "verdict": "not yet",
            **firmness.NOT_JUDGED,
            "few_seeds": False,
            "evidence": None,
            "effort": self.effort,
            "published": entry[printed],
            "regenerated": None,
            "interval": None,
            "ratio": None,
            "unit": entry.get("unit", ""),
            "reason": "",
            "test": entry.get("test", ""),
            "changed": entry.get("changed", ""),
            "variants": [],
            "page": None,
            "source": None,
            "data": [],
        }

    def _missing(self, row: dict) -> dict:
        chapter = str(row["chapter"])
        if chapter not in self.unfinished:
            raise VerdictError(
                f"no producer, and chapter {chapter} counts as built; produce it, or "
                "list the chapter in chapters/unfinished.yaml"
            )
        return {"reason": f"still missing: {self.unfinished[chapter]}"}

    def _place(self, kind: str, identifier: str) -> str:
        entry = self.found.get(kind + "s", {}).get(identifier)
        return f"{entry['page']}: {identifier}" if entry else identifier


def _site_files(entry: Mapping) -> dict:
    """Page, code and data as addresses on the site, which keeps the names of
    files."""
    files = [
        ("results/" if "results" in Path(f).parts else "figures/") + Path(f).name
        for f in entry.get("data", entry.get("files", []))
    ]
    source = "source/{}.html#{}".format(*entry["source"]) if "source" in entry else None
    return {"page": f"{entry['page']}.html", "source": source, "data": files}


def _joined(*reasons: str) -> str:
    return "; ".join(reason for reason in reasons if reason)


def _number(board: _Board, identifier: str) -> dict | None:
    entry = board.ledger.numbers[identifier]
    value = board.found["numbers"].get(identifier)
    if value is None:
        if entry["role"] != "literature":
            return None
        verdict, reason = not_produced(entry)
        return {"verdict": verdict, "reason": reason}
    verdict, reason = judge_number(entry, value)
    shown = {key: value[key] for key in ("evidence", "interval")}
    if board.effort == "quick" and verdict != "not comparable":
        reason = ""
    return {
        "verdict": verdict,
        "regenerated": value["value"],
        "ratio": ratio(entry, value) if verdict == "counterpart" else None,
        "reason": _joined(reason, value["reason"]),
        **shown,
        **_site_files(value),
    }


def _claim(board: _Board, identifier: str) -> dict | None:
    found = board.found["claims"].get(identifier)
    if found is None:
        return None
    readings = found["readings"]
    deciding = _primary(board.ledger, identifier, readings)
    others = [reading for reading in readings if reading is not deciding]
    variant = ("reading", "verdict", "regenerated", "interval", "reason")
    judged = deciding["verdict"] in JUDGED
    return {
        "verdict": deciding["verdict"],
        **(
            firmness.of_readings(deciding["verdict"], others)
            if judged
            else firmness.NOT_JUDGED
        ),
        "few_seeds": deciding["few_seeds"],
        "evidence": found["evidence"],
        "regenerated": deciding["regenerated"],
        "interval": deciding["interval"],
        "unit": deciding["unit"],
        "reason": deciding["reason"],
        "variants": [{key: other[key] for key in variant} for other in others],
        **_site_files(found),
    }


def _primary(ledger: Ledger, claim: str, readings: Sequence[Mapping]) -> Mapping:
    """The reading with all primary options; every reading that is not settled must
    exist."""
    questions = list(readings[0]["reading"])
    try:
        known = crossed(ledger.readings, questions)
        wanted = crossed(ledger.readings, questions, claim)
    except LedgerError as error:
        raise VerdictError(str(error)) from None
    found = [dict(reading["reading"]) for reading in readings]
    for reading in found:
        if reading not in known:
            raise VerdictError(
                f"reading: found {reading}; give the same questions in each reading, "
                "with options of settings.yaml"
            )
        if found.count(reading) > 1:
            raise VerdictError(f"reading: found {reading} twice; give each once")
    for reading in wanted:
        if reading not in found:
            raise VerdictError(f"reading: {reading} missing; test it too")
    return readings[found.index(primary(ledger.readings, questions))]


def _artefact(board: _Board, identifier: str) -> dict | None:
    found = board.found["artefacts"].get(identifier)
    if found is None:
        return None
    claims = board.ledger.claims_of(identifier)
    verdict, regenerated, reason, firm = _from_claims(board, claims)
    check = found["check"]
    if check is not None and not check["holds"]:
        verdict, reason = "differs", _joined("check failed: " + check["text"], reason)
        firm = firmness.WHOLE
    elif check is not None:
        reason = _joined(reason, "check: " + check["text"])
        if not claims:
            verdict, regenerated = "reproduced", "drawn as computed"
            firm = firmness.WHOLE
    elif not claims and board.ledger.artefacts[identifier]["data"] == "illustration":
        raise VerdictError("check: missing; a drawing without claims requires one")
    return {
        "verdict": verdict,
        **firm,
        "evidence": found["evidence"],
        "regenerated": None if board.effort == "quick" else regenerated,
        "reason": "" if board.effort == "quick" else reason,
        **_site_files(found),
    }


def _from_claims(
    board: _Board, claims: Sequence[str]
) -> tuple[str, str | None, str, dict]:
    """Verdict of an entry from its claims, count, exceptions, firmness."""
    rows = [board.made[claim] for claim in claims]
    counts = Counter(row["verdict"] for row in rows)
    decided = sum(counts[verdict] for verdict in DECIDED)
    reason = _exceptions(rows)
    if not decided:
        return "counterpart", None, reason, firmness.NOT_JUDGED
    verdict = "differs" if counts["differs"] else "reproduced"
    count = f"{counts['reproduced']} of {decided} decided claims reproduced"
    return verdict, count, reason, firmness.of_claims(verdict, rows)


def _exceptions(rows: Sequence[Mapping]) -> str:
    """Claims by verdict, except those that are reproduced and firm."""
    order = ("differs", "undecided", "not comparable", "not yet", "reproduced")
    groups: dict[str, list[str]] = {}
    for row in sorted(rows, key=lambda row: order.index(row["verdict"])):
        loose = row["firmness"] == firmness.SOME
        group = row["verdict"] + (", not firm" if loose else "")
        groups.setdefault(group, []).append(row["id"])
    groups.pop("reproduced", None)
    return "; ".join(f"{group}: {', '.join(ids)}" for group, ids in groups.items())


def _section(board: _Board, identifier: str) -> dict | None:
    claims = board.ledger.claims_of(identifier)
    members = [board.made[i] for i in claims + board.ledger.numbers_of(identifier)]
    produced = [row for row in members if row["page"]]
    if not produced:
        if any(row["verdict"] == "not yet" for row in members):
            return None
        return {"verdict": "not comparable", "reason": members[0]["reason"]}
    verdict, regenerated, reason, firm = _from_claims(board, claims)
    seen = {row["evidence"] for row in produced}
    data = dict.fromkeys(chain.from_iterable(row["data"] for row in produced))
    return {
        "verdict": verdict,
        **firm,
        "evidence": next(kind for kind in EVIDENCE if kind in seen),
        "regenerated": None if board.effort == "quick" else regenerated,
        "reason": "" if board.effort == "quick" else reason,
        "page": produced[0]["page"],
        "data": list(data),
    }


def _quick(row: dict) -> dict:
    """The row with its values, without the verdicts, which require more trials."""
    kept = row["verdict"] in WITHOUT_TRIALS
    variants = [{**variant, "verdict": "quick"} for variant in row["variants"]]
    without = {"few_seeds": False, **firmness.NOT_JUDGED}
    shown = {**row, "variants": variants, **without}
    return shown if kept else {**shown, "verdict": "quick"}
