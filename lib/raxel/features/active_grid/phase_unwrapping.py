"""Phase unwrapping: the period of each pixel, its neighbours and breaks.

Which period each pixel sees, where sines tell it in the place of a Gray code.

Phases are those of windows of 7 x 7 pixels, or of one pixel where its window shows no
single place (`periods`).
"""

from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from scipy.stats import chi2

from raxel.features.active_grid.coding import (
    BESIDE,
    BREAK,
    CELLS,
    DARK,
    DECODED,
    FILLED,
    REACH,
    RIM,
    UNKNOWN,
)
from raxel.features.active_grid.reading import MIN_MODULATION

# Which period is seen, by the phases of sines of several periods. The sines that
# places are read from leave the number of their period open. For each number that the
# monitor has, the phases of the others are known; that one is taken which they fit
# best, by least squares over the place with the variances of all phases. How much
# worse the next best fits says how likely it is the right one: a sum of squares
# larger by d makes a number exp(d / 2) times less likely.


# With such a lead the next best number of a period has one chance in a million.
MIN_LEAD = 2 * np.log(1e6)
# Sums of squares of phases, in variances, that no place explains.
FAR = 25.0
# Standard deviations of a place, by which it may seem to lie beyond the monitor.
BEYOND_BORDER = np.float32(6)


class Phases(NamedTuple):
    """Of F sines, those of places first, at (h, w) pixels: turns and their variances
    (F, h, w) float32; lit (h, w): whether all are seen."""

    turns: np.ndarray
    variances: np.ndarray
    lit: np.ndarray


class PlaceFit(NamedTuple):
    """Of each pixel (h, w): place in periods of the first sines, the sum of squares
    that it leaves in variances, and by how much that of the next best is larger."""

    place: np.ndarray
    left: np.ndarray
    lead: np.ndarray

    def told(self, scatter):
        """(h, w) bool: where no other period is likely; scatter: as `scatter_of`."""
        return (self.lead > MIN_LEAD * scatter) & (self.left < FAR * scatter)


def share_told(turns, variances, periods):
    """Of P pixels, the share whose period is told; turns, variances: (F, P)."""
    lit = np.ones((1, turns.shape[1]), bool)
    phases = Phases(turns[:, None], variances[:, None], lit)
    fit = fitted_periods(phases, periods)
    return float(np.mean(fit.told(scatter_of([phases], periods))))


def usual_misfit(turns, variances, periods):
    """Of P pixels of F sines (F, P): by how many periods each is off the places of the
    first, in the mean (F,), and its periods over those of the first (F,)."""
    lit = np.ones((1, turns.shape[1]), bool)
    fit = fitted_periods(Phases(turns[:, None], variances[:, None], lit), periods)
    shares = periods / periods[0]
    off = fit.place[0] * shares[:, None] - turns
    return np.mean(off - np.round(off), axis=1), shares


def scatter_of(parts, periods):
    """By how much sums of squares of phases are larger than noise makes them, or 1."""
    left = np.concatenate(
        [fitted_periods(part, periods).left[part.lit] for part in parts]
    )
    usual = chi2.median(len(periods) - 1)
    return max(1.0, np.median(left) / usual) if len(left) else 1.0


def fitted_periods(phases, periods):
    """The PlaceFit of each pixel; periods: (F,) across the monitor."""
    shape = phases.lit.shape
    fit = PlaceFit(*(np.zeros(shape, np.float32) for _ in range(3)))
    turns, variances = (np.ascontiguousarray(array) for array in phases[:2])
    _fit_periods(turns, variances, phases.lit, periods, *fit)
    return fit


@njit(cache=True, nogil=True, error_model="numpy")
def _fit_periods(turns, variances, lit, periods, place, left, lead):
    """Fill the arrays of PlaceFit where `lit`, a pixel after the other."""
    weights = np.empty(len(periods), np.float32)
    count = np.int64(np.ceil(periods[0]))
    for y in range(lit.shape[0]):
        for x in range(lit.shape[1]):
            if not lit[y, x]:
                continue
            total = np.float32(0)
            for j in range(len(periods)):
                weights[j] = 1 / variances[j, y, x]
                total += weights[j] * periods[j] * periods[j]
            beyond = BEYOND_BORDER * np.sqrt(variances[0, y, x])
            best = second = np.float32(np.inf)
            for k in range(-1, count + 1):
                at = k + turns[0, y, x]
                if at < -beyond or at > periods[0] + beyond:
                    continue
                squares = along = np.float32(0)
                for j in range(1, len(periods)):
                    off = at * (periods[j] / periods[0]) - turns[j, y, x]
                    off -= np.round(off)
                    squares += weights[j] * off * off
                    along += weights[j] * periods[j] * off
                squares -= along * along / total
                if squares < best:
                    second, best = best, squares
                    place[y, x] = at
                elif squares < second:
                    second = squares
            left[y, x], lead[y, x] = best, second - best


# Where a blurred break of the camera or of what it sees goes through decoded pixels.
# Two facets of a mirror, or two surfaces, show places far apart side by side, and a
# lens spreads the jump over several pixels: no two of them need be far apart, and
# what they show is a mixture of the two. On one surface, however bent, the step over
# some pixels lies between the steps before and behind it. A jump does not.


# px; half of a step, which holds most of a jump that is no farther away.
HALF = 4
# Every other row is enough: what is marked is wider.
EVERY = 2
# Five standard deviations of the difference of two steps that share an end.
BEYOND = np.float32(5 * np.sqrt(6))
# Of a step; so little does a smooth surface depart where its bending turns round.
BENT = np.float32(0.1)
# Of a period; what four steps and more leave of a gamma is smaller, what three leave is
# taken off before (`response`), and where there is no noise, rounding to whole grey
# levels is none that a mean takes away.
MIN_SD = np.float32(0.02)
_HALF = np.float32(0.5)


@njit(cache=True, nogil=True, error_model="numpy")
def _beyond(first, middle, last):
    """By how much a step is beyond both others; below 0 where it lies between them."""
    low = first if first < last else last
    high = last if first < last else first
    above, under = middle - high, low - middle
    return above if above > under else under


@njit(cache=True, nogil=True, error_model="numpy")
def _may_jump(places, least):
    """Whether any of the middle steps is beyond both others by more than `least`.

    That takes a third of the time of `_mark_steps`, and few rows hold a jump.
    """
    a, b, c, d = places
    found = False
    for x in range(len(a)):
        found |= _beyond(b[x] - a[x], c[x] - b[x], d[x] - c[x]) > least
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_steps(places, spreads, least, found):
    """Set where the middle step of (4, n) places, evenly apart, is beyond both others.

    spreads: (4, n), their standard deviations, which may be marked by a minus sign.
    Nothing is set where one of them is NaN.
    """
    a, b, c, d = places
    sa, sb, sc, sd = spreads
    for x in range(len(found)):
        first, last = b[x] - a[x], d[x] - c[x]
        outer = max(abs(sa[x]), abs(sd[x]))
        spread = max(outer, max(abs(sb[x]), abs(sc[x])))
        limit = least + BEYOND * spread + BENT * abs(_HALF * (first + last))
        # Where one of the others holds the jump, bending alone is no reason.
        limit += _HALF * abs(last - first)
        found[x] |= _beyond(first, c[x] - b[x], last) > limit


@njit(cache=True, nogil=True, error_model="numpy")
def find_breaks(location, sigma, used, length, start, stop, found):
    """Set found[y // EVERY, x], for rows from start to before stop, within a jump.

    location, sigma: (A, H, W) float32, NaN where not decoded; used: (A,), 0 where there
    are no phases, so that places are in steps as they should be; length: (A,), of a
    period; start: a multiple of EVERY. A jump nearer than 3 HALF px to what is not
    decoded is not seen across it.
    """
    height, width = location.shape[1:]
    reach = 3 * HALF
    for y in range(start, stop, EVERY):
        row = found[y // EVERY]
        row[:] = 0
        for axis in range(len(location)):
            if not used[axis]:
                continue
            at, sd, least = location[axis], sigma[axis], MIN_SD * length[axis]
            n = width - 2 * reach
            if n > 0:
                i, j, k = 2 * HALF, 4 * HALF, 6 * HALF
                p, s = at[y], sd[y]
                places = p[:n], p[i : i + n], p[j : j + n], p[k:]
                if _may_jump(places, least):
                    spreads = s[:n], s[i : i + n], s[j : j + n], s[k:]
                    _mark_steps(places, spreads, least, row[reach : reach + n])
            if reach <= y < height - reach:
                i, j, k, m = y - reach, y - HALF, y + HALF, y + reach
                places = at[i], at[j], at[k], at[m]
                if _may_jump(places, least):
                    _mark_steps(places, (sd[i], sd[j], sd[k], sd[m]), least, row)


@njit(cache=True, nogil=True, error_model="numpy")
def mark_breaks(near, location, sigma, status):
    """Take away the locations (A, H, W) of decoded pixels where `near` is not 0."""
    for y in range(len(status)):
        for x in range(len(status[y])):
            if near[y, x] and status[y, x] == DECODED:
                status[y, x] = BREAK
                location[:, y, x] = np.nan
                sigma[:, y, x] = np.nan


# Locations averaged with their eight neighbours, and holes filled from them (3.2.2).
# Neither extrapolates or goes across a break: a pixel is averaged if all nine are
# there and agree, a hole is filled from neighbours on opposite sides that agree.


# Standard deviation of a mean of 3 x 3 independent values, and of 3 x 3 means over
# 7 x 7 pixels, which overlap: (1 + 4 + 9 + 9 + 9 + 9 + 9 + 4 + 1) / 21^2 along each
# axis, where one mean over 7 x 7 has 1 / 7.
OF_PIXELS, OF_WINDOWS = np.float32(1 / 3), np.float32(55 / 441 * 7)


@njit(cache=True, nogil=True, error_model="numpy")
def smooth_neighbours(location, sigma, status, reach):
    """Average locations over 3 x 3 pixels, in place.

    location, sigma: (A, H, W) float32; status: (H, W) uint8; reach: (A,), how far
    neighbours on one surface may be apart. sigma is negative where the sines of a pixel
    were not averaged over 7 x 7 before, and positive afterwards; where that is so of
    only some of the nine, a pixel is left as it is.
    """
    count, height, width = location.shape
    ninth = np.float32(1 / 9)
    # Rows as they were, since those written are read again.
    before = np.empty((2, 2, count, width), np.float32)
    for y in range(1, height - 1):
        for axis in range(count):
            if y == 1:
                before[0, 0, axis], before[1, 0, axis] = (
                    location[axis, 0],
                    sigma[axis, 0],
                )
            before[0, y % 2, axis] = location[axis, y]
            before[1, y % 2, axis] = sigma[axis, y]
        here, above = y % 2, (y - 1) % 2
        for x in range(1, width - 1):
            agree = True
            for v in range(y - 1, y + 2):
                for u in range(x - 1, x + 2):
                    agree = agree and status[v, u] == DECODED
            for axis in range(count):
                if not agree:
                    break
                own = before[0, here, axis, x]
                alone = before[1, here, axis, x] < 0
                for u in range(x - 1, x + 2):
                    for place, spread in (
                        (before[0, above, axis, u], before[1, above, axis, u]),
                        (before[0, here, axis, u], before[1, here, axis, u]),
                        (location[axis, y + 1, u], sigma[axis, y + 1, u]),
                    ):
                        agree = agree and abs(place - own) < reach[axis]
                        agree = agree and (spread < 0) == alone
            if not agree:
                continue
            for axis in range(count):
                place = spread = np.float32(0)
                for u in range(x - 1, x + 2):
                    place += before[0, above, axis, u] + before[0, here, axis, u]
                    place += location[axis, y + 1, u]
                    spread += before[1, above, axis, u] + before[1, here, axis, u]
                    spread += sigma[axis, y + 1, u]
                location[axis, y, x] = ninth * place
                share = OF_PIXELS if spread < 0 else OF_WINDOWS
                sigma[axis, y, x] = share * (ninth * spread)
    for axis in range(count):
        for y in range(height):
            for x in range(width):
                sigma[axis, y, x] = abs(sigma[axis, y, x])


@njit(cache=True, nogil=True, error_model="numpy")
def fill_holes(location, sigma, cells, status, reach, length):
    """Give pixels without a location the mean of neighbours on opposite sides.

    As `smooth_neighbours`; cells: (A, H, W) int16; length: (A,) of a period. Filled
    pixels fill no others. Their sigma is the mean of the neighbours', as these may be
    averages of the same pixels.
    """
    count, height, width = location.shape
    mean = np.empty((2, count), np.float32)
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            if status[y, x] == DECODED:
                continue
            mean[:] = 0
            pairs = 0
            for v, u in ((0, 1), (1, 0), (1, 1), (1, -1)):
                if status[y + v, x + u] != DECODED or status[y - v, x - u] != DECODED:
                    continue
                apart = False
                for axis in range(count):
                    step = location[axis, y + v, x + u] - location[axis, y - v, x - u]
                    apart = apart or abs(step) > reach[axis]
                if apart:
                    continue
                pairs += 1
                for axis in range(count):
                    for one, other in ((v, u), (-v, -u)):
                        mean[0, axis] += location[axis, y + one, x + other]
                        mean[1, axis] += sigma[axis, y + one, x + other]
            if pairs:
                status[y, x] = FILLED
                for axis in range(count):
                    location[axis, y, x] = mean[0, axis] / (2 * pairs)
                    sigma[axis, y, x] = mean[1, axis] / (2 * pairs)
                    cells[axis, y, x] = np.floor(location[axis, y, x] / length[axis])


@njit(cache=True, nogil=True, error_model="numpy")
def mark_rim(near, location, sigma, status):
    """Take away the locations (A, H, W) of decoded pixels where `near` is not 0."""
    width = status.shape[1]
    rim = np.zeros(-(-width // 8) * 8, np.uint8)
    eight = rim.view(np.uint64)
    for y in range(len(status)):
        marked, own = near[y], status[y]
        for x in range(width):
            rim[x] = (marked[x] != 0) & (own[x] == DECODED)
        # Few are: eight pixels at a time are passed over.
        for k in range(len(eight)):
            if eight[k]:
                for x in range(8 * k, min(8 * k + 8, width)):
                    if rim[x]:
                        status[y, x] = RIM
                        location[:, y, x] = np.nan
                        sigma[:, y, x] = np.nan


# Pixels left out: at the rim of the lit area, the image's border, and at jumps.


SPECK = 2  # px; so small, a spot without light is no rim


def trim_rim(first, stop, margin, out):
    """Leave out what is within `margin` px of pixels without light; specks are none."""
    location, sigma, _, status = out
    reach = SPECK + margin
    start, end = max(0, first - reach), min(len(status), stop + reach)
    around = status[start:end]
    unlit = ((around == DARK) | (around == BESIDE)).view(np.uint8)
    if not unlit.any():
        return
    # Beyond the image it goes on as at its border, where strips are no specks.
    unlit = cv2.copyMakeBorder(unlit, *(SPECK,) * 4, cv2.BORDER_REPLICATE)
    unlit = cv2.erode(unlit, np.ones((SPECK + 1,) * 2, np.uint8))
    # What is left of a spot grows by what it lost, and by the margin.
    size = 2 * margin + SPECK + 1
    near = cv2.dilate(unlit, np.ones((size, size), np.uint8))
    near = near[SPECK + first - start :, SPECK:-SPECK]
    mark_rim(near, location[:, first:stop], sigma[:, first:stop], status[first:stop])


def trim_sides(margin, extent, out):
    """Leave out pixels at the image's border whose surroundings end beyond it.

    What lies `margin` px further out is not in the image. It is where the surface
    seen there goes on; a blurred pixel sees the monitor's border if that is beyond.
    """
    location, sigma, _, status = out
    if min(status.shape) <= 2 * margin:
        return
    for turned in (False, True):
        for step in (1, -1):
            place, spread, own = (
                (np.swapaxes(a, -1, -2) if turned else a)[..., ::step, :]
                for a in (location, sigma, status)
            )
            outwards = place[:, margin] - place[:, 2 * margin]
            beyond = place[:, :margin] + outwards[:, None]
            inside = np.all((beyond >= 0) & (beyond <= extent), axis=0)
            rim = np.nonzero(~inside & (own[:margin] == DECODED))
            own[rim] = RIM
            place[:, *rim] = np.nan
            spread[:, *rim] = np.nan


def leave_out_breaks(first, stop, margin, broken, out):
    """Leave out what is within `margin` px of a jump; broken: every EVERY-th row."""
    location, sigma, _, status = out
    # A jump was found HALF to either side of it, or in rows passed over a little less.
    grow = max(margin - HALF + EVERY, 0)
    start = max(0, first - grow) // EVERY
    end = -(-min(len(status), stop + grow) // EVERY)
    if not broken[start:end].any():
        return
    near = np.zeros(((end - start) * EVERY, status.shape[1]), np.uint8)
    near[::EVERY] = broken[start:end]
    near = cv2.dilate(near, np.ones((2 * grow + 1,) * 2, np.uint8))
    near, part = near[first - start * EVERY :], slice(first, stop)
    mark_breaks(near, location[:, part], sigma[:, part], status[part])


ROWS = 256  # worked through at a time
WINDOW = 2 * REACH + 1
# Periods by which a pixel's phase departs from its window's on a surface, beside noise.
OF_BENDING, BEYOND_NOISE = np.float32(0.05), np.float32(6)
BLOCKS = 8  # of rows, all over the image, by which the scatter of phases is known


def told_cells(images, codes, monitor_px, noise, smooth):
    """(A, H, W) uint16: `period_cells` of the axes where sines tell of periods."""
    cells = np.zeros((len(codes), *images[0].shape), np.uint16)
    for axis, code in enumerate(codes):
        if code.others:
            extent = monitor_px[code.axis]
            cells[axis] = period_cells(images, code, extent, noise, smooth)
    return cells


def period_cells(images, code, extent, noise, smooth):
    """(H, W) uint16: the cell of each pixel, CELLS to a period, or UNKNOWN.

    images: images (H, W) of a view; code: the AxisCode of its sines; extent: of the
    monitor along that axis, px; noise: a Noise; smooth: whether windows are averaged.
    Where phases scatter more than noise lets them, as a response makes them that is not
    linear, they are taken to be as uncertain as they scatter.
    """
    height, width = images[0].shape
    starts = range(0, height, ROWS)
    every = starts[:: -(-len(starts) // BLOCKS)]
    sines = code.sines, *code.others
    periods = np.array([extent / one.period for one in sines], np.float32)
    some = zip(*(_phases(images, sines, first, noise) for first in every), strict=True)
    scatter = [scatter_of(phases, periods) for phases in some]
    cells = np.empty((height, width), np.uint16)
    for first in starts:
        own, means = _phases(images, sines, first, noise)
        found = _cells(own, own, periods, scatter[0])
        if smooth:
            of_means = _cells(own, means, periods, scatter[1])
            found = np.where(of_means == UNKNOWN, found, of_means)
        cells[first : first + ROWS] = found
    return cells


def _cells(own, phases, periods, scatter):
    """(h, w) uint16; own: the pixels' own phases, beside those of windows."""
    fit = fitted_periods(phases, periods)
    good = own.lit & fit.told(scatter)
    apart = np.abs(own.turns - phases.turns)
    apart = np.minimum(apart, 1 - apart)
    limit = OF_BENDING + BEYOND_NOISE * np.sqrt(own.variances)
    good &= np.all(apart <= limit, axis=0)
    cells = np.clip(np.floor(CELLS * fit.place), 0, UNKNOWN - 1)
    return np.where(good, cells, UNKNOWN).astype(np.uint16)


def _phases(images, sines, first, noise):
    """Phases of ROWS rows from `first`: of each pixel, and of the windows around."""
    height, width = images[0].shape
    start, stop = max(first - REACH, 0), min(first + ROWS + REACH, height)
    inner = slice(first - start, min(first + ROWS, height) - start)
    shape = 2, len(sines), stop - start, width
    turns, variances = np.empty(shape, np.float32), np.empty(shape, np.float32)
    lit = np.ones(shape[2:], bool)
    for k, one in enumerate(sines):
        parts = np.zeros((3, *shape[2:]), np.float32)
        for image, weights in zip(one.steps, one.weights.T, strict=True):
            light = images[image][start:stop].astype(np.float32)
            for part, weight in zip(parts, weights, strict=True):
                part += np.float32(weight) * light
        of_wave = 2 / len(one.steps) * noise.at(parts[2])
        lit &= parts[0] ** 2 + parts[1] ** 2 > MIN_MODULATION**2 * of_wave
        means = [cv2.blur(part, (WINDOW, WINDOW)) for part in parts[:2]]
        for n, (sine, cosine) in enumerate((parts[:2], means)):
            turns[n, k] = np.arctan2(sine, cosine) / (2 * np.pi) % 1
            variances[n, k] = of_wave / WINDOW ** (2 * n) / (sine**2 + cosine**2 + 1e-6)
    variances /= (2 * np.pi) ** 2
    turns, variances, lit = turns[:, :, inner], variances[:, :, inner], lit[inner]
    return Phases(turns[0], variances[0], lit), Phases(turns[1], variances[1], lit)
