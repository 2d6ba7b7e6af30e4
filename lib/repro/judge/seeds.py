"""The rule for claims that are judged seed by seed, on rendered rigs.

A predicate is true of a seed or not. The claim says that it is true of nine in ten, and
the share's exact interval decides, as an interval does everywhere. Runs through
pictures are too few for any interval to lie above nine in ten: there the share itself
decides, and the verdict carries the mark "few seeds".
"""

from __future__ import annotations

import numpy as np

from repro.judge.statistics import FAILS, HOLDS, UNDECIDED, proportion

SHARE_OF_SEEDS = 0.9
MIN_SEEDS = 36
"""The least number whose exact 95 % interval lies above nine in ten, all being true."""


def few_seeds(seeds: int) -> bool:
    """Whether a share of so many seeds decides without its interval."""
    return 0 < seeds < MIN_SEEDS


def decision_of_seeds(holds: np.ndarray) -> str:
    """Whether a predicate (seeds,) is true of nine in ten; open without any seed."""
    if not len(holds):
        return UNDECIDED
    if few_seeds(len(holds)):
        return HOLDS if np.mean(holds) >= SHARE_OF_SEEDS else FAILS
    return proportion(np.asarray(holds, float)).above(SHARE_OF_SEEDS)
