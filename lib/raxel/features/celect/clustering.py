"""Candidates along a contour into corners by clustering (6.3.1), instead of t8.

The number of corners is known from the user, so it is the data that say how far apart
candidates of one corner may lie.
"""

import numpy as np

from raxel.features.celect.processing import average_close

MOST_UNEVEN = 2.0
"""How many times as far as the last the next corner along a contour may be."""


def clustered(corners, along, distance, count):
    """Labels (n,) of candidates (n, 2): clusters of their places along the contour.

    Takes the place of `processing.average_close`, which has the arguments. The tree of
    average linkage over `along` is cut where it has `count` clusters. If these are
    uneven (a step along the contour is more than twice the one before, or less than
    half of it), a corner is missing or too many: then the published rule decides.
    """
    from scipy.cluster.hierarchy import fcluster, linkage

    if len(corners) <= count:
        return average_close(corners, along, distance, count)
    tree = linkage(along[:, None], "average")
    labels = fcluster(tree, count, "maxclust") - 1
    if unevenness(along, labels) > MOST_UNEVEN:
        return average_close(corners, along, distance, count)
    return labels


def unevenness(along, labels):
    """Largest ratio, at least 1, of neighbouring steps between clusters' means."""
    means = np.bincount(labels, along) / np.bincount(labels)
    steps = np.diff(np.sort(means))
    if len(steps) < 2:
        return 1.0
    ratio = steps[1:] / steps[:-1]
    return float(np.maximum(ratio, 1 / ratio).max())
