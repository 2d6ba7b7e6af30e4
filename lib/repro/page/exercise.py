"""Exercises that check their own answer.

The library computes the right answer when an answer is checked; no page contains it.
The cell of an exercise looks like this; the answer replaces ``None``:

    check(None, expected=rays_that_meet, hint="a plane has two sides")
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from numbers import Real

import numpy as np

from repro.page.reader import Shown
from repro.page.templates import render


class Checked(Shown):
    """The outcome of a check: ``right`` is True, False, or None for no answer yet."""

    def __init__(self, right: bool | None, text: str) -> None:
        kind = {True: "tip", False: "warning", None: "note"}[right]
        title = {True: "Right", False: "Not yet", None: "Your turn"}[right]
        super().__init__(
            f":::{{admonition}} {title}\n:class: {kind}\n{text}\n:::",
            render("outcome", title=title, text=text),
        )
        self.right = right
        self.text = text


def check(
    answer: object,
    expected: Callable[[], object],
    *,
    tolerance: float = 0.01,
    hint: str = "",
    slips: Mapping[str, Callable[[], object]] | None = None,
    up_to_factor: bool = False,
) -> Checked:
    """Compare an answer with the one that the library computes.

    Parameters ---------- answer : number, list or array of numbers, or word; None if
    not answered yet. expected : function without arguments that computes the right
    answer. tolerance : largest error that counts as right, as a share of the largest
    entry of
        the right answer. The page states another value than the default.
        Words, and counts (whole numbers by type), are compared exactly.
    hint : text for a wrong answer. slips : explanation -> function that computes the
    answer with this mistake. The
        explanation is given when the answer equals it.
    up_to_factor : a common factor of all numbers, also a negative one, does not count.
    """
    if answer is None:
        return Checked(None, "Put your answer in place of None and run the cell again.")

    def near(other: object) -> object:
        return _scaled(answer, other) if up_to_factor else answer

    right = expected()
    if _same(near(right), right, tolerance):
        return Checked(True, "The library computes the same.")
    for explanation, slip in (slips or {}).items():
        wrong = slip()
        if _same(near(wrong), wrong, tolerance):
            return Checked(False, explanation)
    return Checked(False, _advice(_difference(near(right), right), hint))


def _advice(text: str, hint: str) -> str:
    return f"{text} Hint: {hint}" if hint else text


def _same(answer: object, right: object, tolerance: float) -> bool:
    if isinstance(right, str):
        return isinstance(answer, str) and _word(answer) == _word(right)
    given, wanted = _numbers(answer), _numbers(right)
    if given.shape != wanted.shape or given.dtype.kind not in "iuf":
        return False
    if wanted.dtype.kind in "iu":
        return bool(np.array_equal(given, wanted))
    scale = np.abs(wanted).max(initial=0.0)
    limit = tolerance * (scale or 1.0)
    return bool(np.allclose(given, wanted, rtol=0, atol=limit, equal_nan=True))


def _scaled(answer: object, other: object) -> object:
    """The answer, scaled to fit ``other`` best."""
    given, wanted = _numbers(answer), _numbers(other)
    if given.shape != wanted.shape or given.dtype.kind not in "iuf" or not given.any():
        return answer
    return given * (np.vdot(given, wanted) / np.vdot(given, given))


def _numbers(answer: object) -> np.ndarray:
    """An answer as an array without axes of length 1: a column equals a row.

    Fractions and other exact numbers become floats.
    """
    try:
        found = np.squeeze(np.asarray(answer))
    except ValueError:  # lists of unequal lengths
        return np.asarray(None)
    if found.dtype == object and all(isinstance(x, Real) for x in found.flat):
        return found.astype(float)
    return found


def _word(text: str) -> str:
    return " ".join(text.lower().split())


def _difference(answer: object, right: object) -> str:
    """Describe the error of the answer, without the right answer."""
    if isinstance(right, str):
        return "That is not it."
    given, wanted = _numbers(answer), _numbers(right)
    if given.dtype.kind not in "iuf":
        kind = type(answer).__name__
        what = "A number is" if wanted.ndim == 0 else "An array of numbers is"
        return f"{what} asked for, not {kind}."
    if given.shape != wanted.shape:
        return f"The shape is {given.shape}; it should be {wanted.shape}."
    if not np.isfinite(given).all():
        return "Not every number is finite."
    if given.ndim == 0:
        return "Too large." if given > wanted else "Too small."
    return f"The largest error is {np.abs(given - wanted).max():.2g}."
