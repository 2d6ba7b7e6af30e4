"""What right and wrong students answer to the exercises of a page."""

import numpy as np

from repro.page.exercise import check
from repro.page.notebook import read_page
from repro.page.questions import exercises_of, task_of
from repro.page.reader import names_on_page


def misjudged(root, page):
    """One line for each answer to an exercise of a page that is judged wrongly."""
    notebook = read_page(root / "chapters" / page / "page.py")
    names = names_on_page(page)
    lines = []
    for exercise in exercises_of(notebook):
        expected, options = task_of(exercise, notebook, names)
        found = expected()

        def judged(answer, found=found, options=options):
            return check(answer, lambda: found, **options)

        for answer, right in answers(found):
            if judged(answer).right is not right:
                lines.append(f"{page}: {answer!r} should be {right}: {exercise.line}")
        for explanation, wrong in options.get("slips", {}).items():
            outcome = judged(wrong())
            if (outcome.right, outcome.text) != (False, explanation):
                lines.append(f"{page}: slip {explanation!r} gives no explanation")
        if judged(None).right is not None:
            lines.append(f"{page}: no answer counts as one: {exercise.line}")
    return lines


def answers(found):
    """(answer, whether it is right) for a right one and its relatives."""
    exact = np.asarray(found)
    given = [(found, True), (exact.tolist(), True), (exact, True), (str(found), False)]
    if exact.dtype.kind in "iu":
        near = [(found + 1, False), (found - 1, False), (float(found), True)]
        return given + near
    rounded = [float(f"{number:.3g}") for number in exact.ravel()]
    rounded = np.reshape(rounded, exact.shape)
    scale = np.abs(exact).max() or 1.0
    uneven = np.arange(1, exact.size + 1).reshape(exact.shape)
    return [
        *given,
        (rounded.tolist(), True),
        (exact[..., None], True),
        (exact + 0.005 * scale, True),
        (exact * 1.005, True),
        (exact + 0.04 * scale * uneven, False),
        (exact * np.nan, False),
        ([1.0] * (exact.size + 1), False),
    ]
