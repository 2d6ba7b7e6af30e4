"""Search of decoded data for the image of a screen position."""

from itertools import combinations

import numpy as np

from raxel.features.active_grid.lookup import nearest_pixels

NEAREST = 12  # candidate pixels, of which four are chosen
MIN_SINE = 0.05  # of the angles of a valid triangle
HALF = 3  # half-width of the window of the local fit, px


def at_four_pixels(grid, places):
    """Return pixels (n, 2) that see positions (n, 2) mm, by four near pixels (3.3.4).

    The homography from the locations of four pixels, no three of them collinear, to
    these pixels maps the position. They are the first such four when pixels are
    ordered by the distance of their locations from the position. NaN where no pixel
    is near.
    """
    out = np.full((len(places), 2), np.nan)
    for n, (place, window) in enumerate(windows_about(grid, places)):
        if window is None:
            continue
        pixels, locations, _ = window
        away = np.linalg.norm(locations - place, axis=1)
        order = np.argsort(away, kind="stable")[:NEAREST]
        four = first_four(pixels[order])
        if four is not None:
            chosen = order[list(four)]
            H = through_four(locations[chosen] - place, pixels[chosen])
            out[n] = H[:2, 2] / H[2, 2]
    return out


def by_local_fit(grid, places):
    """Return pixels (n, 2) that see positions (n, 2) mm, by all pixels of a window.

    Locations are fitted by a quadratic polynomial of the pixels, weighted with
    their sigma. Newton's method inverts it. NaN where no pixel is near.
    """
    out = np.full((len(places), 2), np.nan)
    for n, (place, window) in enumerate(windows_about(grid, places)):
        if window is None:
            continue
        pixels, locations, sigma = window
        middle = pixels.mean(axis=0)
        rows = terms(pixels - middle) / sigma[:, None]
        fit, *_ = np.linalg.lstsq(rows, locations / sigma[:, None], rcond=None)
        at = np.zeros(2)
        for _ in range(5):
            x, y = at
            value = terms(at[None])[0] @ fit
            slope = np.array([[0, 1, 0, 2 * x, y, 0], [0, 0, 1, 0, x, 2 * y]]) @ fit
            at = at + np.linalg.solve(slope.T, place - value)
        if np.abs(at).max() <= HALF + 1:
            out[n] = middle + at
    return out


def terms(p):
    """Return the six terms of degree up to two of positions (n, 2)."""
    x, y = p.T
    return np.column_stack([np.ones(len(p)), x, y, x * x, x * y, y * y])


def windows_about(grid, places):
    """Yield (place, (pixels (m, 2), locations (m, 2), sigma (m,)) or None) by place.

    The window is around the decoded pixel whose location is nearest to the place.
    None where the distance exceeds the step of two pixels.
    """
    location = np.where(grid.mask[..., None], grid.location, np.nan)
    step = np.nanmedian(np.linalg.norm(np.diff(location, axis=1), axis=2))
    height, width = grid.mask.shape
    nearest = nearest_pixels(np.ascontiguousarray(location), places)
    for place, (u, v) in zip(places, nearest, strict=True):
        if u < 0 or np.linalg.norm(location[v, u] - place) > 2 * step:
            yield place, None
            continue
        rows = slice(max(v - HALF, 0), min(v + HALF + 1, height))
        columns = slice(max(u - HALF, 0), min(u + HALF + 1, width))
        y, x = np.mgrid[rows, columns]
        known = grid.mask[rows, columns]
        sigma = np.linalg.norm(grid.sigma[rows, columns][known], axis=1)
        yield (
            place,
            (
                np.column_stack([x[known], y[known]]).astype(float),
                location[rows, columns][known].astype(float),
                sigma.astype(float),
            ),
        )


def first_four(pixels):
    """Return the first four of pixels (n, 2), in their order, no three collinear."""
    for last in range(3, len(pixels)):
        for others in combinations(range(last), 3):
            four = (*others, last)
            if all(is_triangle(pixels[list(t)]) for t in combinations(four, 3)):
                return four
    return None


def is_triangle(points):
    """Return whether three points (3, 2) are clearly not collinear."""
    a, b = points[1] - points[0], points[2] - points[0]
    area = abs(a[0] * b[1] - a[1] * b[0])
    return area > MIN_SINE * np.linalg.norm(a) * np.linalg.norm(b)


def through_four(source, target):
    """Return the homography (3, 3) that maps four points (4, 2) to four others."""
    rows = [
        row
        for (x, y), (u, v) in zip(source, target, strict=True)
        for row in (
            [x, y, 1, 0, 0, 0, -u * x, -u * y, -u],
            [0, 0, 0, x, y, 1, -v * x, -v * y, -v],
        )
    ]
    return np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)
