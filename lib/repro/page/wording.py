"""Numbers and names as people read them: rounded, aligned, without markup."""

from __future__ import annotations

import math
import re

# Units of pure numbers: they are in the records, and no reader needs them.
UNSPOKEN = ("1", "count")
TINY = 1e-3  # numbers below it read better as 2e-14
NEAR_ONE = 1e-12  # below this, rounding errors of the computation
# Larger numbers are written with an exponent.
PLAIN_BELOW = 1e6
ESCAPED = r"\\([!-/:-@\[-`{-~])"  # in Markdown, any mark of punctuation can be
ASIDE = 0xE000  # a range that no text uses
NAMES = {"fig": "Fig.", "table": "Table", "alg": "Algorithm", "app": "Appendix"}


def rounded(
    number: float | str,
    interval: tuple[float, float] | list[float] | None,
    unit: str = "",
) -> str:
    """A number with unit and interval, to two digits of the interval's width.

    A low end that is far smaller than the width keeps two digits of its own; an end
    that is infinite is told as "no bound".
    """
    unit = "" if unit in UNSPOKEN else unit
    if isinstance(number, str):
        return f"{number} {unit}".strip()
    if not interval or None in interval:
        return f"{significant(number, 3)} {unit}".strip()
    low, high = interval
    if isinstance(low, str) or isinstance(high, str):
        return f"{significant(number, 3)} {unit}".strip() + f" ({low} to {high})"
    if math.isinf(low) or math.isinf(high):
        ends = " to ".join(_bounded(end) for end in (low, high))
        if math.isinf(number):
            return f"{_bounded(number)} ({ends})"
        return f"{_bounded(number)} {unit}".strip() + f" ({ends})"
    half = (high - low) / 2
    if half <= 0:
        return f"{significant(number, 4)} {unit}".strip()
    places = max(0, 1 - math.floor(math.log10(half)))
    if places > 6:
        text, low, high = (significant(end, 3) for end in (number, low, high))
        return f"{text} {unit}".strip() + f" ({low} to {high})"
    text = f"{number:.{places}f} {unit}".strip()
    far_smaller = TINY * half <= low < half / 10
    start = significant(low, 2) if far_smaller else f"{low:.{places}f}"
    return f"{text} ({start} to {high:.{places}f})"


def _bounded(number: float) -> str:
    """A number to three digits, or that there is no bound: trials that failed count as
    the worst."""
    return "no bound" if math.isinf(number) else significant(number, 3)


def significant(number: float, digits: int) -> str:
    """A number to so many digits, and to more where these would make it 1.

    An R2 of 0.999998 is not 1: what it lacks to 1 is what it says. Thousands keep all
    digits before the point.
    """
    text = f"{number:.{digits}g}"
    if "e+" in text and abs(number) < PLAIN_BELOW:
        return f"{number:.0f}"
    lacking = abs(1 - abs(number))
    if text not in ("1", "-1") or lacking < NEAR_ONE:
        return text
    places = -math.floor(math.log10(lacking) + 1e-9)  # 1 - 0.9999 is below 1e-4
    return f"{number:.{places}f}"


def label(artefact: str) -> str:
    """Name of an artefact of the thesis for people: Fig. 2.3; empty if it has none."""
    kind, _, number = artefact.partition("_")
    if kind not in NAMES or not re.fullmatch(r"[0-9a-z]+(_[0-9]+)*", number):
        return ""
    said = number.upper() if kind == "app" else number.replace("_", ".")
    return f"{NAMES[kind]} {said}"


def literal(text: str) -> str:
    """Text that anybody wrote as MyST that shows it and means nothing else, one line.

    Names of photographs and sets, and reasons that quote them, may hold whatever a
    file's name can: HTML, roles, links, formulae, bars of a table.
    """
    line = "".join(c if c.isprintable() else " " for c in text)
    line = re.sub(r"[\\`*_\[\]<>$#|{}~^&!]", r"\\\g<0>", " ".join(line.split()))
    # What begins a line may begin a list, a fence, an option of a directive.
    return re.sub(r"^(\d*)([%+\-=:.)(@'\"])", r"\1\\\2", line)


def unescaped(text: str) -> str:
    """Markdown without its backslashes, but for those of a formula."""
    found = re.compile(rf"{ESCAPED}|\$[^$]*\$")
    return found.sub(lambda m: m[1] or m[0], text)


def plain(text: str) -> str:
    """A caption without markup, on one line."""
    # What is escaped is no markup: it is out of the way meanwhile.
    text = re.sub(ESCAPED, lambda m: chr(ASIDE + ord(m[1])), text)
    text = re.sub(r"\\(?:mathrm|text|mathbf)\{([^}]*)\}", r"\1", text)
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text)
    text = " ".join(re.sub(r"[$*`\\{}]", "", text).split())
    return re.sub("[\ue000-\ue07f]", lambda m: chr(ord(m[0]) - ASIDE), text)


def _back(found: re.Match) -> str:
    return chr(ord(found[0]) - ASIDE)


def number_in(text: str) -> float | None:
    """The number that a cell of a table holds; None for words."""
    try:
        return float(text)
    except ValueError:
        return None


def alike(cells: list[str], digits: int) -> list[str]:
    """Cells of a column; numbers of similar size with the same digits behind the point.

    The largest gets ``digits`` digits. Where sizes differ by 100 or more, each does.
    """
    numbers = [number_in(cell) for cell in cells if not re.fullmatch(r"[+-]?\d+", cell)]
    sizes = [abs(x) for x in numbers if x and math.isfinite(x)]
    if len(sizes) < 2 or max(sizes) >= 100 * min(sizes) or max(sizes) < TINY:
        return [_shortened(cell, digits) for cell in cells]
    places = max(0, digits - 1 - math.floor(math.log10(max(sizes))))
    return [
        f"{number:.{places}f}"
        if abs(number or 0) in sizes
        else _shortened(cell, digits)
        for cell, number in zip(cells, map(number_in, cells), strict=True)
    ]


def _shortened(cell: str, digits: int) -> str:
    number = number_in(cell)
    if number is None or not math.isfinite(number) or re.fullmatch(r"[+-]?\d+", cell):
        return cell
    return f"{number:.{digits}g}"
