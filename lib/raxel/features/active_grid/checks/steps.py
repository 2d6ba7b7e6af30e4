"""Which step does each picture of a sine show?

Each picture of a sine, less the mean of all and in shares of their spread, is a
combination of a sine and a cosine over the pixels. So the pictures lie on a circle, at
the angles of their steps, up to a turn and a reflection: picture j of those in the
order of the circle shows step m + j or m - j. The edges of a Gray code, or sines of
other periods, settle which. Every picture that does not show its own step is named.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from raxel.features.active_grid.checks.sample import Doubt

FAINT = 0.01  # of the contrast: less is no sine
SAME_STEP = 0.1  # of the distance between steps
OF_SINES = 0.6  # share of a picture that is explained by what all have in common
MIN_LEFT = 0.01  # share that a sine leaves of the steps as they are listed
HEALED = 0.4  # of it is left by an order that explains the pictures
NEAREST = 0.2  # of a step: what is farther from one than this is no step
OFFSETS, SAME_OFFSET = 24, 0.005  # in a period, and what is taken for one of them
MAX_WAYS = 2  # to put pictures in order that are named, if as few are moved by each


class Turned(NamedTuple):
    """Sines seen from step m on, and backwards where sign is -1."""

    sign: int
    m: int

    def undone(self, turns, sines):
        """Phases in periods, of Sines in their order; turns: as read in this one."""
        ahead = self.m / len(sines.steps)
        if self.sign > 0:
            return turns - ahead
        return 0.5 - turns - ahead - 2 * sines.offset

    def shown(self, order):
        """The step that each listed picture shows; order: of them round the circle."""
        steps = self.m + self.sign * np.arange(len(order))
        return steps[np.argsort(order)] % len(order)


def every_turned(count):
    """[Turned, ...] of so many steps."""
    return [Turned(sign, m) for sign in (1, -1) for m in range(count)]


def nearest_turned(turns, backwards, sines):
    """The Turned by which phases seem `turns` periods ahead, or None; backwards:
    whether they fall where places rise, and `turns` is by how much 0.5 - phase is."""
    count = len(sines.steps)
    ahead = count * (turns - 2 * sines.offset * backwards)
    if abs(ahead - round(ahead)) > NEAREST:
        return None
    return Turned(-1 if backwards else 1, round(ahead) % count)


def told_offset(offset):
    """An offset as it is written in set.yaml, by one that is measured."""
    near = round(offset * OFFSETS) / OFFSETS
    offset = near if abs(offset - near) < SAME_OFFSET else offset
    return f"{offset % 1:.3g}"


def put_right(names, orders):
    """What is wrong and what to do, every picture concerned by name.

    names: of listed pictures; orders: for each explanation the steps that they show.
    Of explanations that leave more pictures in place than others these are told.
    """
    moved = [int(np.sum(shown != np.arange(len(names)))) for shown in orders]
    fewest = [one for one, n in zip(orders, moved, strict=True) if n == min(moved)]
    return ", or ".join(_told(names, shown) for shown in fewest[:MAX_WAYS])


def _told(names, shown):
    moved = [k for k, step in enumerate(shown) if step != k]
    if all(shown[shown[k]] == k for k in moved):
        pairs = [(k, shown[k]) for k in moved if k < shown[k]]
        told = ", ".join(f"{names[j]} and {names[k]}" for j, k in pairs)
        return f"{told} are in each other's place: exchange them"
    told = ", ".join(f"{names[k]} shows step {shown[k]}" for k in moved)
    return f"{told}: mend step"


def faulty_pictures(sample, axis, sines):
    """A Doubt or none: about pictures of some Sines that show none of their steps."""
    names = [sample.names[k] for k in sines.steps]
    along, values = "xy"[sample.codes[axis].axis], _around_mean(sample, sines.steps)
    spread = np.sqrt(np.mean(values**2, axis=0))
    contrast = np.median((sample.high - sample.low)[sample.lit])
    if np.median(spread) < FAINT * contrast:
        yield Doubt(
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
            True,
            f"{names[k]} shows the same step as {names[j]}; put the right picture "
            "there or take it again",
        )
        return
    common = _in_common(alike)
    if common.min() < OF_SINES:
        odd = np.flatnonzero(common < common.min() + 0.1)
        other = _taken_for(sample, axis, sines, odd)
        if other is not None:
            yield Doubt(
                True,
                f"{names[odd[0]]} and {sample.names[other]} are in each other's place: "
                f"{names[odd[0]]} shows no step of the sines along {along} that the "
                "others show; exchange them",
            )
            return
        yield Doubt(
            True,
            f"{' or '.join(names[k] for k in odd)} shows no step of the sines along "
            f"{along} that the others show; put the right picture there",
        )


def _taken_for(sample, axis, sines, odd):
    """The sine along the other axis that fits in the place of the odd one, or None."""
    if len(odd) > 1:
        return None
    for other, code in enumerate(sample.codes):
        for k in code.steps if other != axis else ():
            steps = list(sines.steps)
            steps[odd[0]] = k
            values = _in_shares(_around_mean(sample, steps))
            if _in_common(values @ values.T).min() > OF_SINES:
                return k
    return None


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
