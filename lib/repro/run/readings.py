"""What a claim's test reads and says in one reading of an open text."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from repro.judge.statistics import median_and_range, proportion
from repro.run.outcomes import Reading


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

    @property
    def is_primary(self) -> bool:
        """Whether every question has its primary option."""
        return all(self.option(q) == next(iter(self.names[q])) for q in self.names)


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
    return Reading.of_seeds(
        holds,
        middle if middle.failed < len(found) else "nothing",
        unit,
        f"{reason}; true in {np.count_nonzero(holds)} of {len(holds)} seeds "
        f"({share.low:.2f} to {share.high:.2f})",
    )
