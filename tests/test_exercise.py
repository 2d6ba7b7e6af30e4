"""Answers to exercises: right, wrong, and what a wrong one is told."""

import numpy as np

from repro.page import exercise


def test_exercises_know_right_from_wrong():
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


def test_exercises_in_functions():
    cases = [(1.0,), (4.0,)]
    good = exercise.check_function(lambda x: x**0.5, np.sqrt, lambda: cases)
    assert good.right is True
    bad = exercise.check_function(lambda x: x / 2, np.sqrt, lambda: cases, hint="root")
    assert bad.text == "Case 1: Too small. Hint: root"
    broken = exercise.check_function(lambda: 0, np.sqrt, lambda: cases)
    assert broken.text.startswith("Case 1: TypeError")
    assert exercise.check_function(None, np.sqrt, lambda: cases).right is None
