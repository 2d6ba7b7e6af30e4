"""Does one photograph tell of another camera than all others?

A picture that was cropped, turned, mirrored or taken by another camera has a pose that
takes in most of it, and its residuals are hardly larger. So it is asked as halves are:
how far does what it says of the camera lie from what all say together, against how far
the others lie from each other, whatever moves these? The ratio has Fisher's
distribution, of as many squares as photographs have (`raxel.evaluation.apart`); the
photograph that differs most is one of n, so its p-value is n times as large.
"""

from typing import NamedTuple

import numpy as np

from raxel.evaluation.apart import apart, inverse_root

NOTHING = 1e-6  # of what all tell: a photograph's share that tells of no camera


class OddOne(NamedTuple):
    """index: of the photograph; times: how many times as far as explained it lies from
    the others; p_value: of that, times how many there are; change (K,): of the
    correction that all ask for, if it is left out; spread (K, K): its covariance, in
    units of scatter."""

    index: int
    times: float
    p_value: float
    change: np.ndarray
    spread: np.ndarray


def odd_one(normal, right, variance):
    """The OddOne that differs most of n photographs, three or more; None where none of
    them tells anything.

    normal (n, K, K) and right (n, K): each photograph's equations for corrections that
    all share; variance: of scatter, the least that explains how photographs differ.
    """
    from scipy.stats import f as fisher

    n, found = len(right), []
    root, _ = inverse_root(normal.sum(axis=0))
    for k in range(n):
        others = np.arange(n) != k
        rest = apart(normal[others], right[others])
        both = apart(
            np.array([normal[k], normal[others].sum(axis=0)]),
            np.array([right[k], right[others].sum(axis=0)]),
        )
        share = root.T @ normal[k] @ root
        if np.trace(share) < NOTHING:
            continue
        ratio = both.variance / max(rest.variance, variance)
        own = np.trace(share) ** 2 / np.sum(share**2)
        free = min(rest.several, own)
        p_value = fisher.sf(ratio, free, (n - 2) * rest.several)
        found.append((p_value, ratio, k))
    if not found:
        return None
    p_value, ratio, k = min(found)
    inverse, without = (
        np.linalg.pinv(part, hermitian=True)
        for part in (normal.sum(axis=0), normal.sum(axis=0) - normal[k])
    )
    change = without @ (right.sum(axis=0) - right[k]) - inverse @ right.sum(axis=0)
    times, p_value = float(np.sqrt(ratio)), float(min(1.0, n * p_value))
    return OddOne(k, times, p_value, change, without - inverse)
