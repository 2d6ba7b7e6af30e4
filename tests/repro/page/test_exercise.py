"""Answers to exercises: right, wrong, and explanations of mistakes."""

from fractions import Fraction

import numpy as np
import pytest

from repro.page import exercise
from tests.exercise_answers import misjudged
from tests.small_checkouts import ROOT

PAGES = [
    path.parent.relative_to(ROOT / "chapters").as_posix()
    for path in sorted(ROOT.glob("chapters/*/*/exercises.py"))
]


def test_check_accepts_right_and_rejects_wrong():
    def expected():
        return np.array([1.0, 2.0, 3.0])

    assert exercise.check(None, expected).right is None
    assert exercise.check([1.0, 2.0, 3.0005], expected).right is True
    wrong = exercise.check([1.0, 2.0, 3.5], expected, hint="look at z")
    assert wrong.right is False
    assert wrong.text == "The largest error is 0.5. Hint: look at z"
    slip = exercise.check(
        [-1.0, -2.0, -3.0], expected, slips={"Mind the sign.": lambda: -expected()}
    )
    assert slip.text == "Mind the sign."
    assert "shape is (2,)" in exercise.check([1.0, 2.0], expected).text
    assert "not str" in exercise.check("one", expected).text
    assert exercise.check(3, lambda: 2).text == "Too large."
    assert exercise.check(2, lambda: 2).right is True
    assert exercise.check("  Negated  Moment", lambda: "negated moment").right is True
    assert "3.0" not in wrong.text


def test_check_accepts_fraction_column_rounding():
    def expected():
        return np.array([0.5, -2.0])

    for right in ([Fraction(1, 2), -2], [[0.5], [-2]], (0.495, -1.99)):
        assert exercise.check(right, expected).right is True
    for wrong in (["0.5", "-2"], [0.5, None], [[1], [2, 3]], [np.nan, -2], [0.5, -2.1]):
        assert exercise.check(wrong, expected).right is False
    assert exercise.check(np.int64(60), lambda: 60.0).right is True
    assert exercise.check(60.5, lambda: 60.0).right is True
    assert exercise.check("60", lambda: 60.0).right is False
    assert exercise.check(60.5, lambda: 60).right is False


def test_check_accepts_any_factor():
    def line():
        return np.array([3.0, 4.0, 0.0])

    def outcome(answer, **options):
        return exercise.check(answer, line, up_to_factor=True, **options)

    assert outcome([-6, -8, 0]).right is outcome([0.3, 0.4, 0]).right is True
    assert outcome([3, -4, 0]).right is outcome([0, 0, 0]).right is False
    slip = {"The second is negative.": lambda: line() * [1, -1, 1]}
    assert outcome([-9, 12, 0], slips=slip).text == "The second is negative."


@pytest.mark.parametrize("page", PAGES)
def test_exercises_accept_right_answers(page):
    assert misjudged(ROOT, page) == []
