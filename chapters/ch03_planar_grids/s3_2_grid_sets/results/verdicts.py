"""What a predicate that is tested seed by seed decides."""

from __future__ import annotations

import numpy as np

from repro.judge.statistics import FAILS, HOLDS, UNDECIDED
from repro.run.outcomes import DECISIONS

MOST_SEEDS = 0.9


def decided(holds):
    """Verdict from whether a predicate is true of each seed that it speaks of."""
    if not holds:
        return DECISIONS[UNDECIDED]
    return DECISIONS[HOLDS if np.mean(holds) >= MOST_SEEDS else FAILS]


def seeds_told(holds):
    """The same in words."""
    if not holds:
        return "no seed has any"
    return f"true of {int(np.sum(holds))} of {len(holds)} seeds"
