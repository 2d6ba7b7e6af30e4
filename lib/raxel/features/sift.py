"""Point correspondences of two images: SIFT features, matched by the ratio test.

A match is accepted where its descriptor is clearly nearer than the second nearest, in
both directions. Remaining outliers are rejected by geometry; see `raxel.multiview`.
Source: Lowe 2004, doi:10.1023/B:VISI.0000029664.99615.94; features by OpenCV.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike

from raxel.errors import InputError

MAX_DISTANCE_RATIO = (
    0.75  # of the distances of the nearest and the second nearest descriptor
)
# Matches in one square of twice this side, in both images, are one.
MATCH_CELL_PX = 0.5


class FeatureMatches(NamedTuple):
    """Hold features matched between two images.

    Attributes
    ----------
    pixels : np.ndarray
        (2, n, 2) matched positions (u, v) in both images, pixel centres at integers.
    ratio : np.ndarray
        (n,) ratio of the distances of the nearest and the second nearest descriptor,
        the most certain match first.
    features : tuple[int, ...]
        (2,) numbers of features found in each image.
    """

    pixels: np.ndarray
    ratio: np.ndarray
    features: tuple


def match_features(
    first: ArrayLike,
    second: ArrayLike,
    *,
    ratio: float = MAX_DISTANCE_RATIO,
    min_matches: int = 8,
) -> FeatureMatches:
    """Match SIFT features of two grey images by the ratio test, in both directions.

    Parameters
    ----------
    first, second : ArrayLike
        (h, w) grey levels, uint8.
    ratio : float
        Ratio of the distances, in (0, 1), below which a match counts.
    min_matches : int
        Minimum number of matches, 1 or more.

    Returns
    -------
    FeatureMatches
        The matches, the most certain first.

    Raises
    ------
    InputError
        `bad-input` for images of another shape or type, for `ratio` or `min_matches`
        out of range, and for fewer than `min_matches` matches.

    References
    ----------
    Lowe 2004, doi:10.1023/B:VISI.0000029664.99615.94.
    """
    if not 0 < ratio < 1 or not min_matches >= 1:
        raise InputError(
            f"features: found ratio {ratio} and min_matches {min_matches}; give a "
            "ratio between 0 and 1, and at least 1 match"
        )
    found = [_features(first, "first"), _features(second, "second")]
    positions, descriptors = zip(*found, strict=True)
    counts = tuple(map(len, positions))
    pairs, shares = np.empty((0, 2), int), np.empty(0)
    if min(counts) > 1:
        forward, backward = (
            _nearest(cv2.BFMatcher(), *order)
            for order in (descriptors, descriptors[::-1])
        )
        at = np.arange(counts[0])
        both = (forward.share < ratio) & (backward.nearest[forward.nearest] == at)
        pairs = np.column_stack([at, forward.nearest])[both]
        shares = forward.share[both]
    order = np.argsort(shares, kind="stable")
    pixels = np.stack([p[i] for p, i in zip(positions, pairs[order].T, strict=True)])
    single = _distinct_matches(pixels)
    if np.count_nonzero(single) < min_matches:
        raise InputError(
            f"features: {np.count_nonzero(single)} matches of {counts[0]} and "
            f"{counts[1]} features, {min_matches} required; use images with more "
            "texture or closer viewpoints"
        )
    return FeatureMatches(pixels[:, single], shares[order][single], counts)


class _Neighbours(NamedTuple):
    nearest: np.ndarray
    share: np.ndarray


def _features(image, name):
    image = np.asarray(image)
    if image.ndim != 2 or image.dtype != np.uint8 or image.size == 0:
        raise InputError(
            f"features: {name} image: found {image.shape} {image.dtype}; give "
            "grey levels (h, w), uint8"
        )
    # Without a precise upscale all positions are a quarter of a pixel to the lower
    # right.
    sift = cv2.SIFT_create(enable_precise_upscale=True)
    points, descriptors = sift.detectAndCompute(image, None)
    return np.array([p.pt for p in points]).reshape(-1, 2), descriptors


def _nearest(matcher, query, train):
    """The nearest of `train` to each of `query`, and its ratio to the second."""
    pairs = matcher.knnMatch(query, train, k=2)
    index = np.array([best.trainIdx for best, _ in pairs])
    far = np.array([[best.distance, second.distance] for best, second in pairs])
    return _Neighbours(index, far[:, 0] / np.maximum(far[:, 1], 1e-12))


def _distinct_matches(pixels):
    """Which matches (2, n, 2) do not share cells with a more certain one, (n,)."""
    cells = np.rint(pixels.transpose(1, 0, 2).reshape(-1, 4) / (2 * MATCH_CELL_PX))
    first = np.unique(cells, axis=0, return_index=True)[1]
    single = np.zeros(len(cells), bool)
    single[first] = True
    return single
