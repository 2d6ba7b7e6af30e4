"""Which step does each picture of a sine show?

Each picture of a sine, less the mean of all and in shares of their spread, is a
combination of a sine and a cosine over the pixels. So the pictures lie on a circle, at
the angles of their steps, up to a turn and a reflection: picture j of those in the
order of the circle shows step m + j or m - j. The edges of a Gray code, or sines of
other periods, determine which.
"""

from itertools import combinations

import numpy as np

from raxel.features.active_grid.checks.sample import Doubt

FAINT = 0.01  # of the contrast: less is no sine
SAME_STEP = 0.1  # of the distance between steps
OF_SINES = 0.6  # share of a picture that is explained by what all have in common
MIN_LEFT = 0.01  # share that a sine leaves of the steps as they are listed
HEALED = 0.4  # of it is left by an order that explains the pictures
OFFSETS, SAME_OFFSET = 24, 0.005  # in a period, and what is taken for one of them


def rounded_offset(offset):
    """An offset as it is written in set.yaml, by one that is measured."""
    near = round(offset * OFFSETS) / OFFSETS
    offset = near if abs(offset - near) < SAME_OFFSET else offset
    return f"{offset % 1:.3g}"


def faulty_pictures(sample, axis, sines):
    """A Doubt or none: about pictures of some Sines that show none of their steps."""
    names = [sample.names[k] for k in sines.steps]
    along, values = "xy"[sample.codes[axis].axis], _around_mean(sample, sines.steps)
    spread = np.sqrt(np.mean(values**2, axis=0))
    contrast = np.median((sample.high - sample.low)[sample.lit])
    if np.median(spread) < FAINT * contrast:
        yield Doubt(
            "no-sines",
            True,
            f"{names[0]} to {names[-1]} show no sines along {along}, but as good as "
            "equal light; put the right pictures there or take them again",
        )
        return
    values = _in_shares(values)
    alike = values @ values.T / values.shape[1]
    count, step, size = len(values), 2 * np.pi / len(values), np.sqrt(np.diag(alike))
    near = 1 - alike / (size[:, None] * size) + np.eye(count)
    j, k = divmod(int(np.argmin(near)), count)
    both_signs = 0.15 < np.mean(values[j] > 0) < 0.85
    if both_signs and near[j, k] < SAME_STEP * (1 - np.cos(step)):
        yield Doubt(
            "same-step",
            True,
            f"{names[k]} shows the same step as {names[j]}; put the right picture "
            "there or take it again",
        )
        return
    common = _in_common(alike)
    if common.min() < OF_SINES:
        odd = np.flatnonzero(common < common.min() + 0.1)
        yield Doubt(
            "not-a-step",
            True,
            f"{' or '.join(names[k] for k in odd)} shows no step of the sines along "
            f"{along} that the others show; put the right picture there",
        )


def circle_order(sample, sines):
    """Pictures of some Sines, by their place in the list, in an order that makes sines
    of them: the listed one, unless that leaves much that another one explains."""
    listed = list(range(len(sines.steps)))
    values = _in_shares(_around_mean(sample, sines.steps))
    alike = values @ values.T / values.shape[1]
    if len(listed) == 3 or not _covered(alike):
        return listed  # any three pictures are the steps of some sine
    order, before, after = _best_order(alike)
    return order if before > MIN_LEFT and after < HEALED * before else listed


def _around_mean(sample, pictures):
    """(N, P) light at lit pixels, less the mean of all."""
    values = sample.pictures[list(pictures)][:, sample.lit]
    return values - values.mean(axis=0)


def _in_shares(values):
    """In shares of their spread, where that is not faint."""
    spread = np.sqrt(np.mean(values**2, axis=0))
    good = spread > 0.25 * np.median(spread)
    return values[:, good] / spread[good]


def _in_common(alike):
    """(N,) the share of each picture that a sine of all explains; 1 where any three
    pictures are the steps of some sine, or too little of a period is seen."""
    if len(alike) == 3 or not _covered(alike):
        return np.ones(len(alike))
    weights, vectors = np.linalg.eigh(alike)
    return np.sum(weights[-2:] * vectors[:, -2:] ** 2, axis=1) / np.diag(alike)


def _covered(alike):
    """Whether there is enough of a period in the picture to know a sine by."""
    weights = np.linalg.eigvalsh(alike)
    return weights[-2] > 0.05 * weights[-1]


def _best_order(alike):
    """(order, what the steps leave as listed, what they leave in that order).

    What is left when a sine of the listed steps is fitted, as a share of all; pictures
    are exchanged as long as that makes it less.
    """
    count = len(alike)
    steps = 2 * np.pi / count * np.arange(count)
    due = 2 / count * np.cos(steps[:, None] - steps)
    total = np.trace(alike)

    def left(order):
        return 1 - np.sum(due * alike[np.ix_(order, order)]) / total

    order = list(range(count))
    listed = least = left(order)
    while True:
        trials = []
        for j, k in combinations(range(count), 2):
            trial = order.copy()
            trial[j], trial[k] = trial[k], trial[j]
            trials.append((left(trial), trial))
        best, trial = min(trials)
        if best > least - 1e-9:
            return order, listed, least
        least, order = best, trial
