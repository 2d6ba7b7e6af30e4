"""The ledger: what the thesis printed, read from `data/published` and checked.

Only `repro` reads it. An experiment with access to a published value could be tuned
towards it, so no chapter and no module of `raxel` imports this module.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import chain
from pathlib import Path

from raxel.errors import InputError
from raxel.io import documents
from repro.judge.kept import Kept
from repro.judge.schema import FOLDER as SCHEMAS
from repro.judge.schema import faults, hint

FOLDER = Path("data/published")
LISTS = {
    "artefacts": ("artefacts", "sections"),
    "numbers": ("numbers",),
    "claims": ("claims",),
    "settings": ("settings", "readings"),
}
Entries = Mapping[str, dict]


class LedgerError(InputError):
    """A fault in the ledger: one line with file, entry, field, found, what to do."""


@dataclass(frozen=True)
class Ledger:
    """Entries by id, in the order of their files.

    ``sections`` are the section ids that a claim or number names instead of an
    artefact; ``readings`` the questions on which the text is ambiguous.
    """

    artefacts: Entries
    numbers: Entries
    claims: Entries
    settings: Entries
    readings: Entries
    sections: Entries

    def entry(self, identifier: str) -> dict:
        """Return the entry of an id of any kind; LedgerError for an unknown id."""
        for entries in self._kinds():
            if identifier in entries:
                return entries[identifier]
        known = list(chain.from_iterable(self._kinds()))
        raise LedgerError(f"{identifier}: no such id{hint(identifier, known)}")

    def printed(self, identifiers: Iterable[str]) -> dict[str, float | str | None]:
        """Id -> printed value of numbers; LedgerError for an unknown id."""
        for identifier in identifiers:
            if identifier not in self.numbers:
                raise LedgerError(
                    f"{identifier}: published: not in numbers.yaml"
                    f"{hint(identifier, list(self.numbers))}"
                )
        return {i: self.numbers[i]["value"] for i in identifiers}

    def chapter(self, identifier: str) -> int | str:
        """Chapter of an artefact, number, claim or section: 1 to 6, or 'A'."""
        if identifier in self.artefacts:
            return self.artefacts[identifier]["chapter"]
        if identifier in self.numbers:
            return self.chapter(self.numbers[identifier]["artefact"])
        if identifier in self.claims:
            return _chapter(self.claims[identifier]["section"])
        if identifier in self.sections:
            return _chapter(identifier.removeprefix("sec_").replace("_", "."))
        self.entry(identifier)
        raise LedgerError(f"{identifier}: settings and readings have no chapter")

    def claims_of(self, identifier: str) -> list[str]:
        """Claims that name the artefact or section."""
        return [
            c for c, entry in self.claims.items() if identifier in entry["artefacts"]
        ]

    def numbers_of(self, identifier: str) -> list[str]:
        """Numbers of the artefact or section."""
        return [
            n for n, entry in self.numbers.items() if entry["artefact"] == identifier
        ]

    def _kinds(self) -> tuple[Entries, ...]:
        return (
            self.artefacts, self.numbers, self.claims, self.settings, self.readings,
            self.sections,
        )  # fmt: skip


def _chapter(section: str) -> int | str:
    number = section.partition(".")[0]
    return int(number) if number.isdigit() else number


def load(root: Path) -> Ledger:
    """Read and check the ledger of the checkout at ``root``; raises LedgerError."""
    paths = [root / FOLDER / f"{stem}.yaml" for stem in LISTS]
    return _load(tuple((p, p.stat().st_mtime_ns if p.is_file() else 0) for p in paths))


@cache
def _load(dated: tuple[tuple[Path, int], ...]) -> Ledger:
    """The ledger of files with these modification times: an unchanged one is read
    once."""
    lists: dict[str, list[dict]] = {}
    origin: dict[str, str] = {}
    root = dated[0][0].parents[2]
    kept = Kept(
        root, "ledger", (__file__, documents.__file__, *sorted(SCHEMAS.glob("*.json")))
    )
    for (path, _), names in zip(dated, LISTS.values(), strict=True):
        content = kept.of(path, _read)
        for name in names:
            lists[name] = content[name]
            origin[name] = path.name
    kept.keep()
    _raise_first(_repeated(lists, origin))
    entries = {name: {e["id"]: e for e in items} for name, items in lists.items()}
    asked = entries["readings"]
    _raise_first([*_unknown(entries, origin), *_primaries(asked), *_uncrossed(asked)])
    _raise_first(_settled(asked, entries["claims"]))
    named = {e["artefact"] for e in lists["numbers"]}
    named |= set(chain.from_iterable(e["artefacts"] for e in lists["claims"]))
    entries["sections"] = {k: e for k, e in entries["sections"].items() if k in named}
    return Ledger(**entries)


def _read(path: Path) -> tuple[object, list[Path]]:
    """Content of a file of the ledger, checked, and the file."""
    content = read_yaml(path)
    _raise_first(faults(content, path.stem, path.name))
    return content, [path]


def read_yaml(path: Path) -> object:
    """Content of a YAML file; LedgerError if it is missing or malformed."""
    if not path.is_file():
        raise LedgerError(f"{path}: not found; restore it from git")
    try:
        return documents.read_yaml(path)
    except InputError as fault:
        line = str(fault).removeprefix(f"{path.parent}/")
        raise LedgerError(line) from None


def _raise_first(lines: Iterable[str]) -> None:
    lines = list(lines)
    if lines:
        more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
        raise LedgerError(lines[0] + more)


def _repeated(lists: Mapping[str, list[dict]], origin: Mapping[str, str]) -> list[str]:
    seen: dict[str, str] = {}
    lines = []
    for name, items in lists.items():
        for entry in items:
            identifier = entry["id"]
            if identifier in seen:
                lines.append(
                    f"{origin[name]}: {identifier}: id: already used in "
                    f"{seen[identifier]}; rename one of the two"
                )
            seen.setdefault(identifier, origin[name])
    return lines


def _unknown(entries: Mapping[str, Entries], origin: Mapping[str, str]) -> list[str]:
    """References to artefacts or sections that do not exist."""
    known = [*entries["artefacts"], *entries["sections"]]
    lines = []
    for name, field in (
        ("numbers", "artefact"),
        ("claims", "artefacts"),
        ("settings", "used_by"),
        ("readings", "used_by"),
    ):
        for identifier, entry in entries[name].items():
            named = entry[field] if isinstance(entry[field], list) else [entry[field]]
            for other in named:
                if other not in known:
                    lines.append(
                        f"{origin[name]}: {identifier}: {field}: found {other!r}, no "
                        "artefact or section of artefacts.yaml"
                        f"{hint(other, known) or '; list it there'}"
                    )
    return lines


def _primaries(readings: Entries) -> list[str]:
    return [
        f"settings.yaml: {identifier}: primary: found {entry['primary']!r}; "
        f"give one of its options, {', '.join(entry['options'])}"
        for identifier, entry in readings.items()
        if entry["primary"] not in entry["options"]
    ]


def _uncrossed(readings: Entries) -> list[str]:
    return [
        f"settings.yaml: {identifier}: not_crossed_with: found {other!r}, no question "
        f"of the readings{hint(other, list(readings)) or '; list it there'}"
        for identifier, entry in readings.items()
        for other in entry.get("not_crossed_with", ())
        if other not in readings
    ]


def _settled(readings: Entries, claims: Entries) -> list[str]:
    return [
        f"settings.yaml: {identifier}: settled: found {claim!r}, no claim of "
        f"claims.yaml{hint(claim, list(claims)) or '; list it there'}"
        for identifier, entry in readings.items()
        for claim in entry.get("settled", {"claims": ()})["claims"]
        if claim not in claims
    ]
