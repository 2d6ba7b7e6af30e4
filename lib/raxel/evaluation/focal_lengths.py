"""Do images differ more in focal length than in everything else?

A lens that refocuses, a zoom that drifts, two cameras mixed: each image, its pose
free, requires a focal length of its own. Scatter of single corners does not limit the
differences, as corners of one image err together. But what moves them together moves
them in other directions as well. So the squares of what images require of this one
correction, beyond the joint solution, are compared with those of all others, this one
being free in each image: their ratio has Fisher's distribution, of as many squares as
there are (`raxel.evaluation.image_equations`), where all directions are moved alike.

No two groups need be separable for that, which takes a difference of several standard
deviations of each image; many that differ by one are enough.

Of 24 drawn sets of 14 images whose corners scatter by 0.1 px, by two pinholes mixed at
random, 21 are reported with p < 1e-4 where focal lengths differ by 1 %, 13 at 0.75 %
and 3 at 0.5 %. A test with known and independent scatter of corners would report 24,
22 and 11: corners that may err together cost the rest. Of focal lengths that scatter
by 0.3 % (SD) 6 of 24 such sets are reported, and 8 by that test.
"""

from typing import NamedTuple

import numpy as np

from raxel.evaluation.image_equations import within_groups

ALIKE = 1e-9  # of the largest eigenvalue: undetermined by the images


class FocalLengths(NamedTuple):
    """sd: relative, by which images differ in focal length beyond what explains how
    they differ otherwise, 0 where nothing is beyond; times: ratio of the differences to
    explained ones; p_value: of that; shorter, longer: names of the images of two groups
    that explain the differences best."""

    sd: float
    times: float
    p_value: float
    shorter: tuple
    longer: tuple


def focal_lengths(normal, right, direction, variance, names):
    """FocalLengths of n images; None where fewer than four determine the correction.

    normal (n, K, K) and right (n, K): each image's equations for shared corrections;
    direction (K,): the one that may differ; variance: of scatter, the least that
    explains how images differ; names (n,): of the images.
    """
    from scipy.stats import f as fisher

    inverse = np.linalg.pinv(normal.sum(axis=0), hermitian=True)
    to_all = normal @ direction
    own = to_all @ direction
    excess = (right - normal @ (inverse @ right.sum(axis=0))) @ direction
    size, axes = np.linalg.eigh(np.diag(own) - to_all @ inverse @ to_all.T)
    known = size > ALIKE * size[-1]
    free = np.count_nonzero(known)
    if free < 3:
        return None
    # The others, with this correction free in each image.
    share = to_all / np.maximum(own, np.finfo(float).tiny)[:, None]
    others = normal - share[:, :, None] * to_all[:, None]
    rest = right - share * (right @ direction)[:, None]
    explained, freedom = within_groups(others, rest, [np.ones(len(own), bool)])
    explained = max(explained, variance)
    along = axes[:, known].T @ excess
    ratio = np.mean(along**2 / size[known]) / explained
    # By corrections b of their own the excess is its covariance times b.
    sd = np.sqrt(max(ratio - 1, 0.0) * explained * free / np.sum(size[known]))
    p_value = fisher.sf(ratio, free, freedom)
    groups = (tuple(names[group]) for group in _two_groups(excess, own))
    return FocalLengths(float(sd), float(np.sqrt(ratio)), float(p_value), *groups)


def _two_groups(excess, own):
    """Indices of images of shorter and of longer focal length: of all divisions at a
    limit, the one with the largest sum of squares between the groups."""
    order = np.argsort(excess / np.maximum(own, np.finfo(float).tiny))
    weight = np.cumsum(own[order])[:-1]
    between = np.cumsum(excess[order])[:-1] ** 2 / (weight * (own.sum() - weight))
    return np.split(order, [np.argmax(between) + 1])
