"""Random sample consensus with a truncated cost: one loop for every model.

Sources: Fischler and Bolles 1981, doi:10.1145/358669.358692; Torr and Zisserman 2000,
doi:10.1006/cviu.1999.0832 (truncated cost).
"""

import math

import numpy as np

from raxel.errors import InputError


def best_hypothesis(
    propose, squared_errors, limit, *, sample_size, confidence, most_trials, batch
):
    """The hypothesis with the least truncated squared error, or None if none came.

    propose(count): stack (m, ...) of hypotheses from ``count`` samples, m may differ
    from count. squared_errors(hypotheses): (m, N), NaN counts as beyond the limit.
    limit: squared error from which on a pair counts as wrong.

    Samples are drawn in batches until, at the share of right pairs of the best
    hypothesis so far, one sample of ``sample_size`` right pairs has been met with
    probability ``confidence``; at most ``most_trials``, rounded up to a batch.
    """
    best, best_cost, drawn, needed = None, math.inf, 0, most_trials
    while drawn < needed:
        hypotheses = propose(batch)
        drawn += batch
        if len(hypotheses) == 0:
            continue
        squared = squared_errors(hypotheses)
        right = squared < limit
        cost = np.where(right, squared, limit).sum(axis=1)
        i = int(np.argmin(cost))
        if cost[i] < best_cost:
            best, best_cost = hypotheses[i], cost[i]
            trials = trials_needed(np.mean(right[i]), sample_size, confidence)
            needed = min(most_trials, trials)
    return best


def trials_needed(share, sample_size, confidence):
    """Samples needed to meet one of right pairs only, at a share of right pairs."""
    miss = 1 - share**sample_size
    if miss <= 0:
        return 0
    return math.log(1 - confidence) / math.log(miss) if miss < 1 else math.inf


def checked_generator(model, rng):
    """Refuse what is no numpy Generator; model: its name, for errors."""
    if not isinstance(rng, np.random.Generator):
        raise InputError(
            f"{model}: found {type(rng).__name__} for rng; give "
            "numpy.random.default_rng(seed)"
        )
