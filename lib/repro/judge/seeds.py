"""The rule for claims that are judged per simulated run (seed), on rendered rigs.

A predicate holds for a run or not. The claim states that it holds in nine of ten runs,
and the exact interval of the share decides. Runs that render images are too few for an
interval above nine in ten: there the share itself decides, and the verdict is marked
"few seeds".
"""

from __future__ import annotations

import numpy as np

from repro.judge.statistics import FAILS, HOLDS, UNDECIDED, proportion

SHARE_OF_SEEDS = 0.9
MIN_SEEDS = 36
"""Smallest number of runs whose exact 95 % interval is above nine in ten if all
succeed."""


def few_seeds(seeds: int) -> bool:
    """Return whether a share of so many runs decides without its interval."""
    return 0 < seeds < MIN_SEEDS


def decision_of_seeds(holds: np.ndarray) -> str:
    """Decide whether a predicate (seeds,) holds in nine of ten; undecided without
    any."""
    if not len(holds):
        return UNDECIDED
    if few_seeds(len(holds)):
        return HOLDS if np.mean(holds) >= SHARE_OF_SEEDS else FAILS
    return proportion(np.asarray(holds, float)).above(SHARE_OF_SEEDS)
