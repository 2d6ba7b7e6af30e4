"""CELECT's loops over a window's pixels and over its Hough space, compiled.

All functions and constants that these functions use are in this file: compiled code is
cached between runs and recompiled when this file changes, not when another one does.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

N_ANGLE_BINS = 180
_ANGLES = np.radians(np.arange(N_ANGLE_BINS))
_NORMAL_U = (-np.sin(_ANGLES)).astype(np.float32)
_NORMAL_V = np.cos(_ANGLES).astype(np.float32)


@njit(cache=True, error_model="numpy")
def within(points, centre, radius):
    """The points (m, 2) of (n, 2) float64 within `radius` of a centre (2,)."""
    found = np.empty_like(points)
    count = 0
    for i in range(len(points)):
        u, v = points[i, 0] - centre[0], points[i, 1] - centre[1]
        found[count, 0], found[count, 1] = points[i, 0], points[i, 1]
        count += u * u + v * v <= radius * radius
    return found[:count]


@njit(cache=True, error_model="numpy")
def hough_space(points, centre, m):
    """The smoothed Hough space (2 m + 1, N_ANGLE_BINS) float32 of points (n, 2).

    Rows are R + m in px, rounded; R is of `lines_of`. Points, in float64, farther than
    m from the centre (2,) have no votes. Smoothed with 1 2 1 over 4 in both directions.
    """
    votes = np.zeros((2 * m + 3, N_ANGLE_BINS), np.int32)
    rows = np.empty(N_ANGLE_BINS, np.int32)
    half = np.float32(m + 0.5)
    for i in range(len(points)):
        u = np.float32(points[i, 0] - centre[0])
        v = np.float32(points[i, 1] - centre[1])
        if u * u + v * v > m * m:
            continue
        for a in range(N_ANGLE_BINS):
            # The second product and the sum are rounded once. Truncation after adding a
            # half rounds, as no value is negative.
            across = np.float64(u * _NORMAL_U[a]) + np.float64(v) * _NORMAL_V[a]
            rows[a] = np.int32(np.float32(across) + half)
        for a in range(N_ANGLE_BINS):
            votes[rows[a] + 1, a] += 1
    votes[0], votes[-1] = votes[1], votes[-2]
    return _smooth(votes)


@njit(cache=True, error_model="numpy")
def _smooth(votes):
    """Votes with a row more on either side, smoothed; end columns are repeated."""
    height, width = votes.shape
    space = np.empty((height - 2, width), np.float32)
    column = np.empty(width, np.int32)
    share = np.float32(1 / 16)
    for i in range(height - 2):
        for j in range(width):
            column[j] = votes[i, j] + 2 * votes[i + 1, j] + votes[i + 2, j]
        for j in range(1, width - 1):
            space[i, j] = share * (column[j - 1] + 2 * column[j] + column[j + 1])
        space[i, 0] = share * (3 * column[0] + column[1])
        space[i, -1] = share * (3 * column[-1] + column[-2])
    return space


@njit(cache=True, error_model="numpy")
def lines_of(
    space: np.ndarray,
    highest: np.ndarray,
    limits: tuple[int, int],
    neighbourhood: tuple[int, int],
    share: float,
    wrap: float,
    split: float,
) -> np.ndarray:
    """Return the lines of `trace.peaks_of` from a Hough space.

    Parameters
    ----------
    space : np.ndarray
        Hough space, as of `trace.vote`.
    highest, limits, neighbourhood, share
        As in `strongest_peaks`; `limits` is (least, most).
    wrap : float
        Degrees from the border of the angle within which peaks are searched for again.
    split : float
        Bins from which on two peaks are two lines.

    Returns
    -------
    np.ndarray
        (n, 3) rows of R px, theta deg and votes.
    """
    m = space.shape[0] // 2
    peaks = strongest_peaks(
        space, highest, limits, neighbourhood, share, (0, N_ANGLE_BINS)
    )
    peaks[:, 0] -= m
    border = np.minimum(peaks[:, 1], N_ANGLE_BINS - peaks[:, 1]) <= wrap
    n_border = np.count_nonzero(border)
    if wrap > 0 and n_border:
        along = neighbourhood[1]
        reach = min(int(wrap), N_ANGLE_BINS // 2 - along - 1)
        strip = _across_border(space, reach + along)
        columns = along, along + 2 * reach + 1
        highest = _highest_within(strip, neighbourhood, columns)
        limits = 1, n_border  # type: ignore[assignment]
        found = strongest_peaks(strip, highest, limits, neighbourhood, share, columns)
        found[:, 0] -= m
        found[:, 1] += N_ANGLE_BINS - reach - along
        peaks = np.concatenate((peaks[~border], found))
    return merged_lines(peaks, split)


@njit(cache=True, error_model="numpy")
def merged_lines(peaks: np.ndarray, bins: float) -> np.ndarray:
    """Return the peaks with those within `bins` of each other merged into one.

    The merged peak is their mean, weighted by the votes. Close means by steps: a chain
    of close peaks is one line. The same line written as (R, theta) and (-R, theta +
    180) is close to itself.

    Parameters
    ----------
    peaks : np.ndarray
        (n, 3) rows of (R, theta, votes).
    bins : float
        Distance of close peaks in bins.

    Returns
    -------
    np.ndarray
        (m, 3) rows of (R, theta, votes), theta from 0 to below 180 degrees.
    """
    count, lines = 0, np.empty_like(peaks)
    group, free = np.empty_like(peaks), np.ones(len(peaks), np.bool_)
    for first in range(len(peaks)):
        if not free[first]:
            continue
        group[0], members, done = peaks[first], 1, 0
        free[first] = False
        while done < members:
            for other in range(first + 1, len(peaks)):
                R, theta = _nearest_form(peaks[other], group[done, 1])
                distance = math.hypot(R - group[done, 0], theta - group[done, 1])
                if free[other] and distance <= bins:
                    free[other] = False
                    group[members, 0], group[members, 1] = R, theta
                    group[members, 2] = peaks[other, 2]
                    members += 1
            done += 1
        R = theta = votes = 0.0
        for member in group[:members]:
            R += member[2] * member[0]
            theta += member[2] * member[1]
            votes += member[2]
        R, theta = R / votes, theta / votes
        turns = math.floor(theta / N_ANGLE_BINS)
        lines[count, 0] = -R if turns % 2 else R
        lines[count, 1], lines[count, 2] = theta - N_ANGLE_BINS * turns, votes
        count += 1
    return lines[:count]


@njit(cache=True, error_model="numpy")
def _nearest_form(line, theta_deg):
    """(R, theta) of a line, or (-R, theta +- 180), with theta nearest to theta_deg."""
    turns = np.rint((theta_deg - line[1]) / N_ANGLE_BINS)
    return (-line[0] if turns % 2 else line[0]), line[1] + N_ANGLE_BINS * turns


@njit(cache=True, error_model="numpy")
def strongest_peaks(space, highest, limits, neighbourhood, share, columns):
    """Non-maximum suppression: rows (n, 3) of row, column, votes, the strongest first.

    A peak of a Hough space (h, w) is the largest value of its `neighbourhood` (rows,
    columns), half widths, so that the flank of another peak does not count; `highest`
    (h, w) is that value for every cell. Peaks count down to `share` of the strongest,
    but `limits` (minimum, maximum) of them. If there are fewer than the minimum, the
    largest values outside the neighbourhoods of the others are added. `columns` (first,
    last + 1) restricts all of them.
    """
    minimum, maximum = limits
    row, column = np.empty(maximum, np.int64), np.empty(maximum, np.int64)
    found = 0
    tops = _tops(space, highest, columns)
    while found < maximum:
        best = _largest_of(space, tops, row[:found], column[:found], neighbourhood)
        if best < 0:
            break
        i, j = tops[best]
        if found >= minimum and space[i, j] < share * space[row[0], column[0]]:
            break
        row[found], column[found] = i, j
        found += 1
    while found < minimum:
        i, j = _largest_elsewhere(
            space, row[:found], column[:found], neighbourhood, columns
        )
        if i < 0:
            break
        row[found], column[found] = i, j
        found += 1
    peaks = np.empty((found, 3))
    for n in range(found):
        peaks[n, 0], peaks[n, 1] = row[n], column[n]
        peaks[n, 2] = space[row[n], column[n]]
    return peaks


@njit(cache=True, error_model="numpy")
def _tops(space, highest, columns):
    """Cells (n, 2) above zero that are local maxima, row by row."""
    height, width = space.shape
    tops = np.empty((height * width, 2), np.int64)
    is_top = np.zeros(-(-width // 8) * 8, np.uint8)
    eight = is_top.view(np.uint64)
    count = 0
    for i in range(height):
        for j in range(width):
            is_top[j] = (space[i, j] > 0) & (space[i, j] >= highest[i, j])
        # Maxima are sparse: eight cells are tested at a time.
        for k in range(len(eight)):
            if eight[k]:
                for j in range(max(8 * k, columns[0]), min(8 * k + 8, columns[1])):
                    if is_top[j]:
                        tops[count, 0], tops[count, 1] = i, j
                        count += 1
    return tops[:count]


@njit(cache=True, error_model="numpy")
def _across_border(space, reach):
    """The columns of a space within `reach` of 180 degrees, by (-R, theta + 180)."""
    height = space.shape[0]
    strip = np.empty((height, 2 * reach + 1), np.float32)
    for i in range(height):
        for j in range(reach):
            strip[i, j] = space[i, N_ANGLE_BINS - reach + j]
        for j in range(reach + 1):
            strip[i, reach + j] = space[height - 1 - i, j]
    return strip


@njit(cache=True, error_model="numpy")
def _highest_within(space, neighbourhood, columns):
    """The local maxima of some columns; inf in all other cells."""
    highest = np.full_like(space, np.inf)
    last = space.shape[0] - 1
    for i in range(last + 1):
        for j in range(columns[0], columns[1]):
            value = space[i, j]
            neighbours = max(space[i, j - 1], space[i, j + 1])
            neighbours = max(
                neighbours, space[max(i - 1, 0), j], space[min(i + 1, last), j]
            )
            if (
                value >= neighbours
                and value > 0
                and _is_top(space, i, j, neighbourhood)
            ):
                highest[i, j] = value
    return highest


@njit(cache=True, error_model="numpy")
def _is_top(space, i, j, neighbourhood):
    """Whether a cell is the maximum of its neighbourhood."""
    across, along = neighbourhood
    for row in range(max(i - across, 0), min(i + across + 1, space.shape[0])):
        for column in range(j - along, j + along + 1):
            if space[row, column] > space[i, j]:
                return False
    return True


@njit(cache=True, error_model="numpy")
def _largest_of(space, tops, row, column, neighbourhood):
    """Index of the largest of the maxima outside all neighbourhoods, or -1."""
    best, index = np.float32(0), -1
    for k in range(len(tops)):
        value = space[tops[k, 0], tops[k, 1]]
        if value > best and _free(tops[k, 0], tops[k, 1], row, column, neighbourhood):
            best, index = value, k
    return index


@njit(cache=True, error_model="numpy")
def _largest_elsewhere(space, row, column, neighbourhood, columns):
    """The cell of the largest value above zero outside all neighbourhoods, or -1."""
    best, at = np.float32(0), (-1, -1)
    for i in range(space.shape[0]):
        for j in range(columns[0], columns[1]):
            if space[i, j] > best and _free(i, j, row, column, neighbourhood):
                best, at = space[i, j], (i, j)
    return at


@njit(cache=True, error_model="numpy")
def _free(i, j, row, column, neighbourhood):
    """Whether a cell is outside the neighbourhoods of others (n,), (n,)."""
    across, along = neighbourhood
    for n in range(len(row)):
        if abs(row[n] - i) <= across and abs(column[n] - j) <= along:
            return False
    return True


@njit(cache=True, error_model="numpy")
def farthest_ahead(
    edges: np.ndarray,
    centre: np.ndarray,
    normal: np.ndarray,
    distance: float,
    band: float,
    away_from: np.ndarray,
    direction: np.ndarray,
) -> int:
    """Return the index of the edge pixel of `trace.next_anchor`, -1 without one.

    Parameters
    ----------
    edges : np.ndarray
        (n, 2) edge pixels (u, v).
    centre, normal, away_from, direction : np.ndarray
        (2,) pixels and vectors.
    distance : float
        Distance in px of the line along its `normal`.
    band : float
        Largest distance in px from the line.

    Returns
    -------
    int
        Index of an edge pixel.
    """
    offset = centre[0] * normal[0] + centre[1] * normal[1] + distance
    farthest, index = -1.0, -1
    for i in range(len(edges)):
        u, v = edges[i, 0], edges[i, 1]
        along = (u - centre[0]) * direction[0] + (v - centre[1]) * direction[1]
        if along > 0 and abs(u * normal[0] + v * normal[1] - offset) < band:
            du, dv = u - away_from[0], v - away_from[1]
            square = du * du + dv * dv
            if square > farthest:
                farthest, index = square, i
    return index


@njit(cache=True, error_model="numpy")
def structure_tensor(across, down):
    """Products (h, w, 3) of gradients (h, w) float32: both squares, then u by v."""
    height, width = across.shape
    tensor = np.empty((height, width, 3), np.float32)
    for i in range(height):
        for j in range(width):
            u, v = across[i, j], down[i, j]
            tensor[i, j, 0], tensor[i, j, 1], tensor[i, j, 2] = u * u, v * v, u * v
    return tensor


@njit(cache=True, error_model="numpy")
def response_of(tensor, k):
    """Harris's det M - k trace(M)^2 (h, w) of a tensor (h, w, 3); all float32."""
    height, width, _ = tensor.shape
    response = np.empty((height, width), np.float32)
    for i in range(height):
        for j in range(width):
            uu, vv, uv = tensor[i, j, 0], tensor[i, j, 1], tensor[i, j, 2]
            trace = uu + vv
            response[i, j] = uu * vv - uv * uv - k * (trace * trace)
    return response


@njit(cache=True, error_model="numpy")
def set_within(mask, first, centre, radius):
    """Pixels (n, 2) int32 within a circle where a mask (h, w) uint8 is set, row by row.

    first (2,): pixel (u, v) of the mask's first element; centre (2,), radius px.
    """
    height, width = mask.shape
    count = 0
    for i in range(height):
        for j in range(width):
            count += mask[i, j] != 0
    found = np.empty((count, 2), np.int32)
    count = 0
    for i in range(height):
        for j in range(width):
            if mask[i, j]:
                u, v = first[0] + j, first[1] + i
                du, dv = u - centre[0], v - centre[1]
                if du * du + dv * dv <= radius * radius:
                    found[count, 0], found[count, 1] = u, v
                    count += 1
    return found[:count]
