"""Numbers and names for readers: rounded, aligned, without markup."""

from __future__ import annotations

import math
import re

# Units of pure numbers: in the records, but not shown to readers.
HIDDEN_UNITS = ("1", "count")
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

    A low end far smaller than the width keeps two digits; an infinite end is written as
    "no bound".
    """
    unit = "" if unit in HIDDEN_UNITS else unit
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
    """A number to three digits, or "no bound": failed trials count as the worst."""
    return "no bound" if math.isinf(number) else significant(number, 3)


def significant(number: float, digits: int) -> str:
    """Return a number with these digits, and with more if it would become 1.

    An R2 of 0.999998 is not 1: the difference from 1 is the information. Thousands keep
    all digits before the point.
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
    """Return the name of an artefact of the thesis: Fig. 2.3; empty if it has none."""
    kind, _, number = artefact.partition("_")
    if kind not in NAMES or not re.fullmatch(r"[0-9a-z]+(_[0-9]+)*", number):
        return ""
    words = number.upper() if kind == "app" else number.replace("_", ".")
    return f"{NAMES[kind]} {words}"


def literal(text: str) -> str:
    """Return a user's text as one line of MyST that displays exactly this text.

    Names of images and sets, and reasons that quote them, may contain anything that a
    file name can: HTML, roles, links, formulae, bars of a table.
    """
    line = "".join(c if c.isprintable() else " " for c in text)
    line = re.sub(r"[\\`*_\[\]<>$#|{}~^&!]", r"\\\g<0>", " ".join(line.split()))
    # The begin of a line may be that of a list, a fence, an option of a directive.
    return re.sub(r"^(\d*)([%+\-=:.)(@'\"])", r"\1\\\2", line)


def unescaped(text: str) -> str:
    """Return Markdown without its backslashes, except those of a formula."""
    found = re.compile(rf"{ESCAPED}|\$[^$]*\$")
    return found.sub(lambda m: m[1] or m[0], text)


def plain(text: str) -> str:
    """Return a caption without markup, on one line."""
    # Escaped characters are not markup: they are replaced meanwhile.
    text = re.sub(ESCAPED, lambda m: chr(ASIDE + ord(m[1])), text)
    text = re.sub(r"\\(?:mathrm|text|mathbf)\{([^}]*)\}", r"\1", text)
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text)
    text = " ".join(re.sub(r"[$*`\\{}]", "", text).split())
    return re.sub("[\ue000-\ue07f]", lambda m: chr(ord(m[0]) - ASIDE), text)


def _back(found: re.Match) -> str:
    return chr(ord(found[0]) - ASIDE)


def number_in(text: str) -> float | None:
    """Return the number in a cell of a table; None for words."""
    try:
        return float(text)
    except ValueError:
        return None


def alike(cells: list[str], digits: int) -> list[str]:
    """Return the cells of a column; numbers of similar size have equal decimal places.

    The largest has ``digits`` digits. If sizes differ by 100 or more, each has.
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
