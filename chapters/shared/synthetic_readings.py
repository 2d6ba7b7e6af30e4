"""The readings of section 2.5.1: what its text leaves open, as the trials call it."""

from __future__ import annotations

import numpy as np

from chapters.shared.methods import LINEAR, SCALES, SCORINGS
from repro.run import Case

# Question of the ledger -> {option: name in the trials}, the primary one first.
NAMES = {
    "noise": {"px": "px", "mm": "mm"},
    "scoring": dict(
        zip(("fresh noise", "same noise", "no noise"), SCORINGS, strict=True)
    ),
    "extent": {"unbounded": "unbounded", "finite": "finite"},
    "standard_method": {linear: method for method, linear in LINEAR.items()},
    "residual_scale": dict(
        zip(("corrected view", "source image"), SCALES, strict=True)
    ),
}
# Asked of the sweeps alone: no figure of section 2.5.2, which shares NAMES, has means.
STATISTIC = {"statistic_of_trials": {"median": "median", "mean": "mean"}}


class SweepCase:
    """Trials of one reading."""

    def __init__(self, result, options: dict[str, str] | None = None) -> None:
        self.result = result
        self.taken = Case(NAMES | STATISTIC, options)
        self.statistic = self.taken["statistic_of_trials"]

    def generic(self, quantity: str, law: str | None = None, **condition) -> np.ndarray:
        """Trials of the generic method, (trials,).

        law: which one, in the sweep that holds several in every trial.
        """
        method = self.taken["standard_method"]
        return self._column(f"{law}.{method}" if law else method, quantity, condition)

    def parametric(self, quantity: str, **condition) -> np.ndarray:
        """Trials of the parametric method, (trials,)."""
        return self._column("parametric", quantity, condition)

    def exact(self, quantity: str, law: str | None = None, **condition) -> np.ndarray:
        """Trials of exact rays, scored on fresh noise in any reading."""
        place = f"exact.{self.taken['residual_scale']}.{quantity}"
        return self.column(f"{law}.{place}" if law else place, **condition)

    def over_exact(self, quantity: str, **condition) -> np.ndarray:
        """The generic method's trials as multiples of those of exact rays."""
        exact = self.exact(quantity, **condition)
        return self.generic(quantity, **condition) / exact

    def column(self, name: str, **condition) -> np.ndarray:
        """Trials of a value without a method, such as the point noise."""
        open_text = {"domain": self.taken["noise"], "extent": self.taken["extent"]}
        return self.result.column(name, **open_text | condition)

    def other(self, **options: str) -> SweepCase:
        """The same reading with other options."""
        return SweepCase(self.result, {**self.taken.options, **options})

    def _column(self, method: str, quantity: str, condition: dict) -> np.ndarray:
        place = f"{method}.{self.taken['scoring']}.{self.taken['residual_scale']}"
        return self.column(f"{place}.{quantity}", **condition)
