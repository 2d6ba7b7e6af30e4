"""The readings of section 2.5.1: every combination of what its text leaves open."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

import numpy as np

from chapters.shared.methods import LINEAR, SCALES, SCORINGS
from repro.run.outcomes import DECISIONS, Reading

QUESTIONS = {
    "noise": ("px", "mm"),
    "scoring": ("fresh noise", "same noise", "no noise"),
    "extent": ("unbounded", "finite"),
    "standard_method": ("as printed", "well conditioned"),
    "residual_scale": ("corrected view", "source image"),
}
METHOD = {linear: method for method, linear in LINEAR.items()}
SCORING = dict(zip(QUESTIONS["scoring"], SCORINGS, strict=True))
SCALE = dict(zip(QUESTIONS["residual_scale"], SCALES, strict=True))
Judge = Callable[["SweepCase"], tuple[str, float | str, tuple | None, str]]


class SweepCase:
    """Trials of one reading."""

    def __init__(self, result, options: dict[str, str]) -> None:
        self.result = result
        self.options = options

    def generic(self, quantity: str, law: str | None = None, **condition) -> np.ndarray:
        """Trials of the generic method, (trials,).

        law: which one, in the sweep that holds several in every trial.
        """
        method = METHOD[self._option("standard_method")]
        if law is not None:
            method = f"{law}.{method}"
        return self._column(method, quantity, condition)

    def parametric(self, quantity: str, **condition) -> np.ndarray:
        """Trials of the parametric method, (trials,)."""
        return self._column("parametric", quantity, condition)

    def exact(self, quantity: str, law: str | None = None, **condition) -> np.ndarray:
        """Trials of exact rays, scored on fresh noise in any reading."""
        scale = SCALE[self._option("residual_scale")]
        place = f"exact.{scale}.{quantity}"
        if law is not None:
            place = f"{law}.{place}"
        return self.column(place, **condition)

    def over_exact(self, quantity: str, **condition) -> np.ndarray:
        """The generic method's trials as multiples of those of exact rays."""
        exact = self.exact(quantity, **condition)
        return self.generic(quantity, **condition) / exact

    def column(self, name: str, **condition) -> np.ndarray:
        """Trials of a value without a method, such as the point noise."""
        return self.result.column(name, **self._with(condition))

    def other(self, **options: str) -> SweepCase:
        """The same reading with other options."""
        return SweepCase(self.result, self.options | options)

    def _column(self, method: str, quantity: str, condition: dict) -> np.ndarray:
        scale = SCALE[self._option("residual_scale")]
        place = f"{method}.{SCORING[self._option('scoring')]}.{scale}"
        return self.result.column(f"{place}.{quantity}", **self._with(condition))

    def _with(self, condition: dict) -> dict:
        domain = {"domain": self._option("noise")}
        return domain | {"extent": self._option("extent")} | condition

    def _option(self, question: str) -> str:
        return self.options.get(question, QUESTIONS[question][0])


def every_reading(result, questions: dict[str, tuple[str, ...]]) -> Iterator[SweepCase]:
    """One case per combination of options of the given questions."""
    for options in product(*questions.values()):
        yield SweepCase(result, dict(zip(questions, options, strict=True)))


def judged(
    result, questions: dict[str, tuple[str, ...]], judge: Judge
) -> list[Reading]:
    """Readings of a claim about the simulated sweeps."""
    return readings_of(every_reading(result, questions), judge)


def readings_of(cases, judge) -> list[Reading]:
    """Readings of a claim: decision, value, interval and remark of each."""
    readings = []
    for case in cases:
        decision, value, interval, remark = judge(case)
        readings.append(
            Reading(
                DECISIONS[decision],
                value,
                reading=case.options,
                interval=interval,
                reason=remark,
            )
        )
    return readings
