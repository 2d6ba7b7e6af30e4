"""Looking up a decoded active grid: the point at a place of the picture, and back."""

import numba
import numpy as np

from raxel.errors import InputError
from raxel.geometry.homography import apply_homography, homography_dlt

ANYWHERE = 1e9  # side of a cell that holds all there is
REACH = 2  # px about the nearest pixel, where the four are looked for


def points_at(location, pixels):
    """Points (N, 2) that are seen at pixels (N, 2), bilinear between the four around.

    location: (H, W, 2), as `Decoded.location`. NaN where one of the four has none, or
    lies outside the picture.
    """
    pixels = np.asarray(pixels, float)
    first = np.floor(pixels)
    height, width = location.shape[:2]
    with np.errstate(invalid="ignore"):
        inside = np.all((first >= 0) & (first + 1 < [width, height]), axis=1)
    points = np.full(pixels.shape, np.nan)
    u, v = first[inside].astype(int).T
    right, down = (pixels[inside] - first[inside]).T[..., None]
    points[inside] = (1 - down) * (
        (1 - right) * location[v, u] + right * location[v, u + 1]
    ) + down * ((1 - right) * location[v + 1, u] + right * location[v + 1, u + 1])
    return points


def pixels_of(location, points):
    """Pixels (N, 2) where points (N, 2) of the grid are seen.

    location: (H, W, 2), as `Decoded.location`, is searched for the pixel that sees
    nearest to a point. The four nearest ones there, no three of them on a line, have a
    homography that takes their points to their pixels, and the point with them. NaN
    where no four pixels about it have a location, or all see it from one side only, and
    for points that are not finite.
    """
    points = np.asarray(points, float)
    pixels = np.full((len(points), 2), np.nan)
    asked = np.flatnonzero(np.isfinite(points).all(axis=1))
    if len(asked):
        single = np.ascontiguousarray(location, np.float32)
        nearest = nearest_pixels(single, points[asked])
        for k, pixel in zip(asked, nearest, strict=True):
            if pixel[0] >= 0:
                pixels[k] = _between(location, pixel, points[k])
    return pixels


def nearest_pixels(location, points):
    """The pixel (N, 2), u and v, that sees nearest to each point (N, 2); -1 for none.

    location: (H, W, 2) float32 in one piece, NaN where there is none; points: finite,
    N >= 1. They are sorted into as many square cells as there are points, and a pixel
    is compared with those in its own cell and the eight around it.
    """
    low, extent = points.min(axis=0), np.ptp(points, axis=0).max()
    side = extent / np.sqrt(len(points)) or ANYWHERE
    cells = ((points - low) / side).astype(int) + 1
    shape = cells.max(axis=0) + 2
    number = cells @ [1, shape[0]]
    order = np.argsort(number, kind="stable")
    starts = np.searchsorted(number[order], np.arange(shape.prod() + 1))
    return _search(location, points, low, side, shape, order, starts)


@numba.njit(cache=True)
def _search(location, points, low, side, shape, order, starts):
    best = np.full(len(points), np.inf)
    pixels = np.full((len(points), 2), -1)
    for v in range(location.shape[0]):
        for u in range(location.shape[1]):
            x, y = location[v, u, 0], location[v, u, 1]
            if np.isnan(x) or np.isnan(y):
                continue
            column = int(np.floor((x - low[0]) / side)) + 1
            row = int(np.floor((y - low[1]) / side)) + 1
            if not (0 <= column < shape[0] and 0 <= row < shape[1]):
                continue
            first, last = max(column - 1, 0), min(column + 1, shape[0] - 1)
            for near in range(max(row - 1, 0), min(row + 1, shape[1] - 1) + 1):
                start = starts[near * shape[0] + first]
                for k in range(start, starts[near * shape[0] + last + 1]):
                    n = order[k]
                    distance = (x - points[n, 0]) ** 2 + (y - points[n, 1]) ** 2
                    if distance < best[n]:
                        best[n] = distance
                        pixels[n, 0], pixels[n, 1] = u, v
    return pixels


def _between(location, pixel, point):
    """Where `point` is seen between the four pixels that see nearest to it."""
    low = np.maximum(pixel - REACH, 0)
    high = pixel + REACH + 1
    part = location[low[1] : high[1], low[0] : high[0]]
    v, u = np.nonzero(np.isfinite(part).all(axis=2))
    seen = part[v, u].astype(float)
    around = np.column_stack([u, v]) + low
    order = np.argsort(np.sum((seen - point) ** 2, axis=1), kind="stable")
    four = []
    for k in order:
        if all(_triangle(around[i], around[j], around[k]) for i, j in _pairs(four)):
            four.append(k)
        if len(four) == 4:
            break
    else:
        return np.full(2, np.nan)
    try:
        H = homography_dlt(seen[four], around[four].astype(float))
    except InputError:  # their places are in a row, or one
        return np.full(2, np.nan)
    found = apply_homography(H, point[None])[0]
    return found if np.abs(found - pixel).max() <= 1 else np.full(2, np.nan)


def _pairs(members):
    return [(i, j) for n, i in enumerate(members) for j in members[n + 1 :]]


def _triangle(a, b, c):
    """Whether three pixels are not on one line."""
    return (b[0] - a[0]) * (c[1] - a[1]) != (b[1] - a[1]) * (c[0] - a[0])
