"""Where a place of the active grid lies in the picture: the decoded data searched."""

from itertools import combinations

import numpy as np

from raxel.features.active_grid.lookup import nearest_pixels

NEAREST = 12  # pixels of which four are chosen
MIN_SINE = 0.05  # of the angles of a triangle that counts as one
HALF = 3  # of the window of the local fit, px


def at_four_pixels(grid, places):
    """Pixels (n, 2) that see places (n, 2) mm, by the four nearest ones (3.3.4).

    The homography that takes the locations of four pixels, no three of them in a row,
    to these pixels is asked for the place. They are the first such four when pixels
    are ordered by how far from the place their locations are. NaN where none are near.
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
    """Pixels (n, 2) that see places (n, 2) mm, by all decoded ones of a window.

    Locations are fitted as a polynomial of second degree in the pixels, weighted with
    their sigma, and that is inverted by Newton's method. NaN where none are near.
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
    """The six terms of second degree of positions (n, 2)."""
    x, y = p.T
    return np.column_stack([np.ones(len(p)), x, y, x * x, x * y, y * y])


def windows_about(grid, places):
    """(place, (pixels (m, 2), locations (m, 2), sigma (m,)) or None) of each place.

    The window is about the decoded pixel whose location is nearest to the place. None
    where that one is farther away than two pixels look apart.
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
    """The first four of pixels (n, 2), in their order, no three of them in a row."""
    for last in range(3, len(pixels)):
        for others in combinations(range(last), 3):
            four = (*others, last)
            if all(is_triangle(pixels[list(t)]) for t in combinations(four, 3)):
                return four
    return None


def is_triangle(points):
    """Whether three points (3, 2) are clearly not in a row."""
    a, b = points[1] - points[0], points[2] - points[0]
    area = abs(a[0] * b[1] - a[1] * b[0])
    return area > MIN_SINE * np.linalg.norm(a) * np.linalg.norm(b)


def through_four(source, target):
    """The homography (3, 3) that takes four points (4, 2) to four others."""
    rows = [
        row
        for (x, y), (u, v) in zip(source, target, strict=True)
        for row in (
            [x, y, 1, 0, 0, 0, -u * x, -u * y, -u],
            [0, 0, 0, x, y, 1, -v * x, -v * y, -v],
        )
    ]
    return np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)
