"""Rules by which a regenerated number is compared with the printed one.

The rule depends on role, source and comparator. A setting is run as stated. An analytic
value must be equal at the printed precision. A simulated result must have the published
value in its 95 % interval. A bound must have the interval on its side. A value measured
on hardware we do not have gets a rendered counterpart. A value that was put into a rig
is set, whatever the result. A value cited from the literature is not compared.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from decimal import Decimal

from raxel.errors import InputError

EXACT = 1e-9
BELOW, ABOVE = ("lt", "le"), ("gt", "ge")
Decision = tuple[str, str]


class VerdictError(InputError):
    """A judged value that fits no rule: one line with page, id, problem, what to do."""


def judge_number(entry: Mapping, value: Mapping) -> Decision:
    """Return the verdict of a regenerated number, and the reason if there is one.

    Parameters
    ----------
    entry : the number in the ledger.
    value : its regenerated value, as in a judged file.
    """
    if entry["role"] == "literature":
        return not_produced(entry)
    _same_unit(entry, value)
    if value["value"] is None:
        raise VerdictError("value: not a number; give a finite number")
    if entry["value"] is None:
        return "not comparable", entry.get("doubtful", "the text gives no value")
    if entry["role"] == "setting":
        return _setting(entry, value)
    if value["put_in"]:
        return "set", value["put_in"]
    analytic = "analytic" in (entry["role"], entry["source"])
    if not analytic and entry["source"] == "real":
        return _counterpart(entry, value)
    if entry["comparator"] in (*BELOW, *ABOVE):
        return _bound(entry, value)
    return _printed(entry, value) if analytic else _inside(entry, value)


def not_produced(entry: Mapping) -> Decision:
    """Return the verdict of a value that none of our runs can produce."""
    return "not comparable", "literature: " + entry.get("conditions", "cited, not run")


def _same_unit(entry: Mapping, value: Mapping) -> None:
    if value["unit"] not in ("", entry["unit"]):
        raise VerdictError(
            f"unit: found {value['unit']!r}; give it in {entry['unit']}, as published"
        )


def _setting(entry: Mapping, value: Mapping) -> Decision:
    if equal_as_printed(entry["value"], value["value"], exact=True):
        return "setting", ""
    return "setting", f"run with {value['value']}, the text states {entry['value']}"


def _printed(entry: Mapping, value: Mapping) -> Decision:
    exact = entry["unit"] == "count"
    if equal_as_printed(entry["value"], value["value"], exact=exact):
        return "reproduced", ""
    return "differs", "not equal at the printed precision"


def equal_as_printed(
    published: float | str, regenerated: float | str, exact: bool
) -> bool:
    """Return whether values are equal to half a unit of the last printed digit.

    ``exact`` values, such as counts, and a printed zero allow for rounding errors of
    the computation only. Text is compared without its spaces.
    """
    if isinstance(published, str):
        return "".join(published.split()) == "".join(str(regenerated).split())
    number = as_number(regenerated)
    if number is None:
        return False
    if exact or published == 0:
        return abs(number - published) <= EXACT * max(1.0, abs(published))
    return abs(number - published) <= half_last_digit(published) + EXACT


def half_last_digit(published: float) -> float:
    """Half a unit of the last printed digit: 0.005 for 0.46."""
    return 0.5 * 10.0 ** int(Decimal(repr(published)).as_tuple().exponent)


def _inside(entry: Mapping, value: Mapping) -> Decision:
    low, high = _interval(value, needed=True)
    if low <= float(entry["value"]) <= high:
        return "reproduced", ""
    return "differs", f"{entry['value']} lies outside the interval"


def _bound(entry: Mapping, value: Mapping) -> Decision:
    """Compare the whole interval with the stated side; a value without one is its own
    interval."""
    low, high = _interval(value, needed=False)
    bound = float(entry["value"])
    if entry["comparator"] in ABOVE:
        low, high, bound = -high, -low, -bound
    allowed = high <= bound if entry["comparator"] in ("le", "ge") else high < bound
    excluded = low > bound if entry["comparator"] in ("le", "ge") else low >= bound
    if allowed:
        return "reproduced", ""
    if excluded:
        return "differs", f"beyond the bound of {entry['value']}"
    return "undecided", f"the interval crosses the bound of {entry['value']}"


def _counterpart(entry: Mapping, value: Mapping) -> Decision:
    regenerated = as_number(value["value"])
    if regenerated is not None and math.isinf(regenerated):
        return "counterpart", "half of the trials or more failed"
    if entry["value"] == 0 and regenerated is not None:
        return "counterpart", f"no ratio to a published 0; difference {regenerated:.3g}"
    return "counterpart", ""


def ratio(entry: Mapping, value: Mapping) -> float | None:
    """Return regenerated / published; None if one is not finite, or published is 0."""
    regenerated = as_number(value["value"])
    if regenerated is None or math.isinf(regenerated):
        return None
    if isinstance(entry["value"], str) or not entry["value"]:
        return None
    return regenerated / entry["value"]


def _interval(value: Mapping, needed: bool) -> tuple[float, float]:
    ends = value["interval"]
    if ends is None and not needed:
        ends = [value["value"], value["value"]]
    if ends is None:
        raise VerdictError("interval: missing; give that of the simulation (95 %)")
    low, high = (as_number(end) for end in ends)
    if low is None or high is None or low > high:
        raise VerdictError(f"interval: found {ends}; give [low, high]")
    return low, high


def as_number(value: float | str | None) -> float | None:
    """Return the number of a value of a judged file, in which infinity is a string."""
    if isinstance(value, str) and value not in ("inf", "-inf"):
        return None
    return None if value is None or math.isnan(float(value)) else float(value)
