"""Firmness of a verdict: whether every reading of an ambiguous text gives it.

A claim is firm if all its readings share the verdict of the primary one. A verdict that
follows from claims is firm if no reading of one of them can change it: a `reproduced`
needs all of them firm, a `differs` one claim that differs in every reading. If no claim
is firm, the verdict depends on our choice of readings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

ALL, SOME, NONE = "all readings", "some readings", "no claim"
WHOLE = {"firmness": ALL, "agree": None}
NOT_JUDGED = {"firmness": None, "agree": None}


def of_readings(verdict: str, others: Sequence[Mapping]) -> dict:
    """Fields of a claim: its firmness, and [readings of that verdict, readings]."""
    agree = 1 + sum(other["verdict"] == verdict for other in others)
    return _fields(agree == 1 + len(others), agree, 1 + len(others))


def of_claims(verdict: str, claims: Sequence[Mapping]) -> dict:
    """Fields of a verdict that follows from rows of claims: [firm claims, claims]."""
    judged = [row for row in claims if row["firmness"]]
    firm = [row for row in judged if row["firmness"] == ALL]
    if verdict not in ("reproduced", "differs"):
        return NOT_JUDGED
    if not firm:
        return {"firmness": NONE, "agree": [0, len(judged)]}
    if verdict == "reproduced":
        return _fields(len(firm) == len(judged), len(firm), len(judged))
    settled = any(row["verdict"] == verdict for row in firm)
    return _fields(settled, len(firm), len(judged))


def _fields(firm: bool, agree: int, among: int) -> dict:
    return {"firmness": ALL if firm else SOME, "agree": [agree, among]}
