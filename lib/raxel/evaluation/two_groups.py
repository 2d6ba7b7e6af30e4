"""Do photographs fall into two groups by what each asks of one correction?

Two cameras, or two focal lengths of one, lie mixed in a set in no order that is known.
But each photograph, its pose free, asks for a correction of its own: those of two
cameras for two numbers, those of one, whatever moves their corners together, for
numbers that scatter about one. So the photographs are divided where that explains most
of how their numbers differ. Of one Gaussian that is much already, of a dozen as a rule
two thirds, and how wide it is nobody needs to know.

Any given division explains a share of what independent Gaussian numbers differ by that
has a beta distribution. There are 2^(n-1) - 1 ways to divide n photographs in two, and
the best of them explains more than some share no more often than all of them together
do (C. E. Bonferroni's inequality). Where it explains nearly all, hardly two of them do
so at once, and that bound is as good as exact.
"""

import numpy as np

ALIKE = 1e-9  # of the largest eigenvalue: what photographs say nothing of


def two_groups(normal, right, direction):
    """(first (n,) bool, p_value): the best division in two of n photographs, and how
    often photographs of one camera are divided as well, at most.

    normal (n, K, K) and right (n, K): each photograph's equations for corrections that
    all share; direction (K,): the correction that may differ. (None, 1.0) where fewer
    than four photographs tell of it.
    """
    from scipy.stats import beta

    y, covariance = beyond_together(normal, right, direction)
    size, axes = np.linalg.eigh(covariance)
    told = size > ALIKE * size[-1]
    free = np.count_nonzero(told)
    if free < 3:
        return None, 1.0
    along = axes[:, told].T @ y / size[told]
    asked = axes[:, told] @ along
    order, n = np.argsort(asked), len(y)
    # The threshold's k-th row has the k smallest in the first group.
    first = np.argsort(order) < np.arange(1, n)[:, None]
    spread = np.einsum("kn,nm,km->k", first, covariance, first)
    known = spread > ALIKE * size[-1]
    explained = np.where(known, (first @ y) ** 2, 0.0) / np.where(known, spread, 1.0)
    best = int(np.argmax(explained))
    share = explained[best] / max(y @ asked, np.finfo(float).tiny)
    once = beta.sf(min(share, 1.0), 0.5, (free - 1) / 2)
    return first[best], float(min(1.0, (2.0 ** (n - 1) - 1) * once))


def beyond_together(normal, right, direction):
    """What photographs say of the direction beyond what all say together, (n,), and its
    covariance (n, n) in units of their scatter."""
    inverse = np.linalg.pinv(normal.sum(axis=0), hermitian=True)
    together = inverse @ right.sum(axis=0)
    to_all = normal @ direction
    y = (right - normal @ together) @ direction
    return y, np.diag(to_all @ direction) - to_all @ inverse @ to_all.T
