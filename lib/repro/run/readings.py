"""Input and result of a claim's test in one reading of an ambiguous text."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from repro.judge.statistics import median_and_range, proportion
from repro.run.outcomes import Reading


class Case:
    """One reading of an ambiguous text, with the names that trials give its options.

    names: question -> {option of the ledger: name}, the primary option first. A
    question without a given option has its primary option, so that `Case(names)` is the
    case of figures and prose.
    """

    def __init__(
        self,
        names: Mapping[str, Mapping[str, object]],
        options: Mapping[str, str] | None = None,
    ) -> None:
        self.names, self.options = names, options or {}

    def __getitem__(self, question: str):
        """Return the name that trials give the chosen option of a question."""
        names = self.names[question]
        return names[self.option(question)]

    def option(self, question: str) -> str:
        """Return the chosen option of a question."""
        return self.options.get(question, next(iter(self.names[question])))

    @property
    def is_primary(self) -> bool:
        """Return whether every question has its primary option."""
        return all(self.option(q) == next(iter(self.names[q])) for q in self.names)


def counterpart(
    holds: np.ndarray, found: np.ndarray, unit: str = "", reason: str = ""
) -> Reading:
    """Return the Reading of a claim on a rendered rig: true in nine of ten runs, or
    not.

    holds: (seeds,) bool, whether the claim holds in a run, false if a method failed;
    found: (seeds,) measured values, not finite if a method failed. Median and range are
    those of the runs with a value.
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
