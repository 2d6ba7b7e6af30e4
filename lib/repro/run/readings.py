"""What a claim's test reads and says in one reading of an open text."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from repro.judge.statistics import FAILS, HOLDS, UNDECIDED, median_and_range, proportion
from repro.run.outcomes import DECISIONS, Reading

SHARE_OF_SEEDS = 0.9
"""A counterpart's claim holds where it is true of this share of the seeds."""


class Case:
    """One reading of an open text, as what the trials call the options taken.

    names: question -> {option of the ledger: name}, the primary option first. A
    question that is not asked has its primary option, so that `Case(names)` is what
    figures and prose show.
    """

    def __init__(
        self,
        names: Mapping[str, Mapping[str, object]],
        options: Mapping[str, str] | None = None,
    ) -> None:
        self.names, self.options = names, options or {}

    def __getitem__(self, question: str):
        """What the trials call the option that is taken of a question."""
        names = self.names[question]
        return names[self.option(question)]

    def option(self, question: str) -> str:
        """The option that is taken of a question."""
        return self.options.get(question, next(iter(self.names[question])))


def counterpart(
    holds: np.ndarray, found: np.ndarray, unit: str = "", reason: str = ""
) -> Reading:
    """The Reading of a claim on a rendered rig: true in nine of ten seeds, or not.

    holds: (seeds,) bool, whether the claim is true of a seed, false where a method
    failed; found: (seeds,) what was measured, not finite where a method failed: the
    median and the range shown are those of the seeds that have a value.
    """
    share = proportion(np.asarray(holds, float))
    middle = median_and_range(found)
    known = middle.failed < len(found)
    return Reading(
        DECISIONS[decision_of_seeds(holds)],
        middle.value if known else "nothing",
        interval=(middle.low, middle.high) if known else None,
        unit=unit,
        reason=f"{reason}; true in {np.count_nonzero(holds)} of {len(holds)} seeds "
        f"({share.low:.2f} to {share.high:.2f})",
    )


def decision_of_seeds(holds: np.ndarray) -> str:
    """Whether a predicate is true of nine of ten seeds (seeds,); open without any."""
    if not len(holds):
        return UNDECIDED
    return HOLDS if np.mean(holds) >= SHARE_OF_SEEDS else FAILS
