"""Small ledgers and what pages judged of them, for the tests of verdicts."""

from pathlib import Path

from repro.judge import ledger, verdict
from repro.run.outcomes import Reading

ROOT = Path(__file__).resolve().parents[1]
PAGE = "ch02_one/s1"


def number(value=640, comparator="eq", role="result", source="synthetic", unit="px"):
    return {
        "artefact": "fig_2_1",
        "quantity": "width",
        "value": value,
        "unit": unit,
        "comparator": comparator,
        "role": role,
        "source": source,
    }


def claim(*artefacts):
    return {"section": "2.1", "artefacts": list(artefacts), "statement": "It grows."}


def artefact(data="synthetic", chapter=2):
    return {"title": "A plot", "chapter": chapter, "data": data}


def question(*options):
    return {"options": list(options), "primary": options[0]}


def small(**kinds):
    """A ledger of the given entries; the questions noise and extent are open."""
    kinds.setdefault("artefacts", {"fig_2_1": artefact()})
    open_questions = {
        "noise": question("px", "mm"),
        "extent": question("unbounded", "finite"),
    }
    empty = {key: {} for key in ("numbers", "claims", "settings", "sections")}
    return ledger.Ledger(**{"readings": open_questions, **empty, **kinds})


def judged(page=PAGE, effort="full", claims=None, numbers=None, artefacts=None):
    return {
        "page": page,
        "effort": effort,
        "claims": claims or {},
        "numbers": numbers or {},
        "artefacts": artefacts or {},
    }


def value(found, interval=None, unit="", reason="", put_in="", evidence="synthetic"):
    return {
        "value": found,
        "interval": interval,
        "unit": unit,
        "reason": reason,
        "put_in": put_in,
        "evidence": evidence,
        "data": ["results/sweep.json"],
    }


def readings(*outcomes, evidence="synthetic"):
    """Judged claim from (verdict, options) pairs."""
    made = [
        Reading(v, i, reading=r, reason="slope") for i, (v, r) in enumerate(outcomes)
    ]
    return {
        "evidence": evidence,
        "readings": [r.as_dict() for r in made],
        "data": ["results/sweep.json"],
    }


def drawn(check=None, evidence="synthetic"):
    files = [f"figures/full/fig_2_1.{ending}" for ending in ("svg", "csv")]
    return {"evidence": evidence, "files": files, "check": check}


def by_id(book, *pages, effort="full", unfinished=None):
    missing = {"2": "the rest"} if unfinished is None else unfinished
    return {r["id"]: r for r in verdict.rows(book, pages, missing, effort)}


def of_number(entry, found, effort="full"):
    book = small(numbers={"n": entry})
    return by_id(book, judged(effort=effort, numbers={"n": found}), effort=effort)["n"]


def of_claim(*outcomes, effort="full"):
    book = small(claims={"c": claim("fig_2_1")})
    page = judged(effort=effort, claims={"c": readings(*outcomes)})
    return by_id(book, page, effort=effort)["c"]


def of_artefact(check=None, data="synthetic", effort="full", **verdicts):
    names = {f"c_{word}": claim("fig_2_1") for word in verdicts}
    book = small(artefacts={"fig_2_1": artefact(data)}, claims=names)
    page = judged(
        effort=effort,
        claims={
            f"c_{w}": readings((v, {})) for w, v in verdicts.items() if v != "not yet"
        },
        artefacts={"fig_2_1": drawn(check)},
    )
    return by_id(book, page, effort=effort)["fig_2_1"]
