"""Phase unwrapping without Gray code, breaks of the surface, and excluded pixels.

Multi-frequency phase unwrapping: sinusoids of several periods determine the fringe
order of each pixel. Phases are those of windows of 7 x 7 pixels, or of one pixel where
its window has no unique position.
"""

from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from scipy.special import gammaincinv

from raxel.features.active_grid.coding import (
    BORDER,
    BREAK,
    CELLS_PER_PERIOD,
    DARK,
    DECODED,
    FILLED,
    OUTSIDE,
    UNKNOWN,
    WINDOW_RADIUS,
)
from raxel.features.active_grid.reading import MIN_MODULATION

# Fringe order by the phases of sinusoids of several periods. The sinusoids that give
# positions do not determine their order. Each order on the monitor predicts the phases
# of the others. The order with the best fit is used: least squares over the position,
# weighted with the variances of all phases. An order whose sum of squares is larger by
# d is exp(d / 2) times less likely.


# With such a lead the second best order has a probability of 1e-6.
MIN_LEAD = 2 * np.log(1e6)
# Sums of squares of phases, in variances, that no position explains.
MAX_MISFIT = 25.0
# Standard deviations of a position by which it may exceed the monitor.
BORDER_SIGMAS = np.float32(6)


class Phases(NamedTuple):
    """Hold phases of F sinusoids, those of positions first, at (h, w) pixels.

    turns, variances: (F, h, w) float32; lit: (h, w), whether all are bright enough.
    """

    turns: np.ndarray
    variances: np.ndarray
    lit: np.ndarray


class PositionFit(NamedTuple):
    """Hold the fit of each pixel (h, w).

    position: in periods of the first sinusoids; misfit: sum of squares in variances;
    lead: by how much that of the second best order is larger.
    """

    position: np.ndarray
    misfit: np.ndarray
    lead: np.ndarray

    def is_unique(self, scatter):
        """Return (h, w) bool: other orders are unlikely; scatter: `phase_scatter`."""
        return (self.lead > MIN_LEAD * scatter) & (self.misfit < MAX_MISFIT * scatter)


def unwrapped_share(turns, variances, periods):
    """Return the share of P pixels with a unique order; turns, variances: (F, P)."""
    lit = np.ones((1, turns.shape[1]), bool)
    phases = Phases(turns[:, None], variances[:, None], lit)
    fit = fitted_periods(phases, periods)
    return float(np.mean(fit.is_unique(phase_scatter([phases], periods))))


def mean_misfit(turns, variances, periods):
    """Return the mean misfit (F,) in periods, and the periods over the first (F,).

    turns, variances: (F, P), of P pixels.
    """
    lit = np.ones((1, turns.shape[1]), bool)
    fit = fitted_periods(Phases(turns[:, None], variances[:, None], lit), periods)
    shares = periods / periods[0]
    residual = fit.position[0] * shares[:, None] - turns
    return np.mean(residual - np.round(residual), axis=1), shares


def phase_scatter(parts, periods):
    """Return the sums of squares of phases over their expectation, at least 1."""
    misfit = np.concatenate(
        [fitted_periods(part, periods).misfit[part.lit] for part in parts]
    )
    usual = 2 * gammaincinv((len(periods) - 1) / 2, 0.5)  # median of chi squared
    return max(1.0, np.median(misfit) / usual) if len(misfit) else 1.0


def fitted_periods(phases, periods):
    """Return the PositionFit of each pixel; periods: (F,) across the monitor."""
    shape = phases.lit.shape
    fit = PositionFit(*(np.zeros(shape, np.float32) for _ in range(3)))
    turns, variances = (np.ascontiguousarray(array) for array in phases[:2])
    _fit_periods(turns, variances, phases.lit, periods, *fit)
    return fit


@njit(cache=True, nogil=True, error_model="numpy")
def _fit_periods(turns, variances, lit, periods, position, misfit, lead):
    """Fill the arrays of PositionFit where `lit`, pixel by pixel."""
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
            slack = BORDER_SIGMAS * np.sqrt(variances[0, y, x])
            best = second = np.float32(np.inf)
            for k in range(-1, count + 1):
                at = k + turns[0, y, x]
                if at < -slack or at > periods[0] + slack:
                    continue
                squares = along = np.float32(0)
                for j in range(1, len(periods)):
                    residual = at * (periods[j] / periods[0]) - turns[j, y, x]
                    residual -= np.round(residual)
                    squares += weights[j] * residual * residual
                    along += weights[j] * periods[j] * residual
                squares -= along * along / total
                if squares < best:
                    second, best = best, squares
                    position[y, x] = at
                elif squares < second:
                    second = squares
            misfit[y, x], lead[y, x] = best, second - best


# Blurred breaks within decoded pixels. Two facets of a mirror, or two surfaces, show
# distant positions side by side, and the lens spreads the jump over several pixels.
# Then no two neighbours need to be distant, and their positions are mixtures. On one
# surface, however curved, the step over some pixels is between the steps on both sides.
# A jump is not.


# px; half of a step, which contains most of a jump at this distance or nearer.
HALF_STEP_PX = 4
# Every second row is sufficient, since the marked area is wider.
ROW_STEP = 2
# Five standard deviations of the difference of two steps that share an end.
JUMP_SIGMAS = np.float32(5 * np.sqrt(6))
# Share of a step by which a smooth surface deviates where its curvature changes sign.
MAX_BEND_SHARE = np.float32(0.1)
# Periods. The residual ripple of a gamma is smaller with four steps or more and is
# corrected first with three (`response`). Without noise, rounding to whole grey levels
# does not average out.
MIN_JUMP_PERIODS = np.float32(0.02)
_HALF = np.float32(0.5)


@njit(cache=True, nogil=True, error_model="numpy")
def _excess(first, middle, last):
    """Return the excess of a step over both others; negative if it is between them."""
    low = first if first < last else last
    high = last if first < last else first
    above, under = middle - high, low - middle
    return above if above > under else under


@njit(cache=True, nogil=True, error_model="numpy")
def _may_jump(positions, threshold):
    """Whether any middle step exceeds both others by more than `threshold`.

    This takes a third of the time of `_mark_steps`, and few rows have a jump.
    """
    a, b, c, d = positions
    found = False
    for x in range(len(a)):
        found |= _excess(b[x] - a[x], c[x] - b[x], d[x] - c[x]) > threshold
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_steps(positions, spreads, threshold, found):
    """Mark where the middle step of (4, n) equidistant positions exceeds both others.

    spreads: (4, n), their standard deviations, possibly marked by a minus sign. NaN
    marks nothing.
    """
    a, b, c, d = positions
    sa, sb, sc, sd = spreads
    for x in range(len(found)):
        first, last = b[x] - a[x], d[x] - c[x]
        outer = max(abs(sa[x]), abs(sd[x]))
        spread = max(outer, max(abs(sb[x]), abs(sc[x])))
        limit = (
            threshold
            + JUMP_SIGMAS * spread
            + MAX_BEND_SHARE * abs(_HALF * (first + last))
        )
        # Where one of the others contains the jump, a bend alone is not a reason.
        limit += _HALF * abs(last - first)
        found[x] |= _excess(first, c[x] - b[x], last) > limit


@njit(cache=True, nogil=True, error_model="numpy")
def find_breaks(location, sigma, used, length, start, stop, found):
    """Set found[y // ROW_STEP, x] within a jump, for rows from start to before stop.

    location, sigma: (A, H, W) float32, NaN where not decoded; used: (A,), 0 without
    phases, where positions are steps anyway; length: (A,), of a period; start: a
    multiple of ROW_STEP. A jump nearer than 3 HALF_STEP_PX to pixels that are not
    decoded is not detected across it.
    """
    height, width = location.shape[1:]
    reach = 3 * HALF_STEP_PX
    for y in range(start, stop, ROW_STEP):
        row = found[y // ROW_STEP]
        row[:] = 0
        for axis in range(len(location)):
            if not used[axis]:
                continue
            at, sd, threshold = (
                location[axis],
                sigma[axis],
                MIN_JUMP_PERIODS * length[axis],
            )
            n = width - 2 * reach
            if n > 0:
                i, j, k = 2 * HALF_STEP_PX, 4 * HALF_STEP_PX, 6 * HALF_STEP_PX
                p, s = at[y], sd[y]
                positions = p[:n], p[i : i + n], p[j : j + n], p[k:]
                if _may_jump(positions, threshold):
                    spreads = s[:n], s[i : i + n], s[j : j + n], s[k:]
                    _mark_steps(positions, spreads, threshold, row[reach : reach + n])
            if reach <= y < height - reach:
                i, j, k, m = y - reach, y - HALF_STEP_PX, y + HALF_STEP_PX, y + reach
                positions = at[i], at[j], at[k], at[m]
                if _may_jump(positions, threshold):
                    _mark_steps(positions, (sd[i], sd[j], sd[k], sd[m]), threshold, row)


@njit(cache=True, nogil=True, error_model="numpy")
def mark_breaks(near, location, sigma, status):
    """Remove the locations (A, H, W) of decoded pixels where `near` is not 0."""
    for y in range(len(status)):
        for x in range(len(status[y])):
            if near[y, x] and status[y, x] == DECODED:
                status[y, x] = BREAK
                location[:, y, x] = np.nan
                sigma[:, y, x] = np.nan


# Averages of locations with their eight neighbours, and filled holes (3.2.2). Neither
# extrapolates nor crosses a break: a pixel is averaged if all nine exist and agree, a
# hole is filled from neighbours on opposite sides that agree.


# Standard deviation of a mean of 3 x 3 independent values, and of 3 x 3 overlapping
# means over 7 x 7 pixels: (1 + 4 + 9 + 9 + 9 + 9 + 9 + 4 + 1) / 21^2 along each axis,
# where one mean over 7 x 7 has 1 / 7.
PIXEL_MEAN_SIGMA, WINDOW_MEAN_SIGMA = np.float32(1 / 3), np.float32(55 / 441 * 7)


@njit(cache=True, nogil=True, error_model="numpy")
def smooth_neighbours(location, sigma, status, reach):
    """Average locations over 3 x 3 pixels, in place.

    location, sigma: (A, H, W) float32; status: (H, W) uint8; reach: (A,), maximal
    distance between neighbours on one surface. sigma is negative where the phase of a
    pixel was not averaged over 7 x 7 before, and positive afterwards. A pixel is not
    averaged if only some of the nine are negative.
    """
    count, height, width = location.shape
    ninth = np.float32(1 / 9)
    # Copies of rows, since rows that are written are read again.
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
                    for position, spread in (
                        (before[0, above, axis, u], before[1, above, axis, u]),
                        (before[0, here, axis, u], before[1, here, axis, u]),
                        (location[axis, y + 1, u], sigma[axis, y + 1, u]),
                    ):
                        agree = agree and abs(position - own) < reach[axis]
                        agree = agree and (spread < 0) == alone
            if not agree:
                continue
            for axis in range(count):
                position = spread = np.float32(0)
                for u in range(x - 1, x + 2):
                    position += before[0, above, axis, u] + before[0, here, axis, u]
                    position += location[axis, y + 1, u]
                    spread += before[1, above, axis, u] + before[1, here, axis, u]
                    spread += sigma[axis, y + 1, u]
                location[axis, y, x] = ninth * position
                share = PIXEL_MEAN_SIGMA if spread < 0 else WINDOW_MEAN_SIGMA
                sigma[axis, y, x] = share * (ninth * spread)
    for axis in range(count):
        for y in range(height):
            for x in range(width):
                sigma[axis, y, x] = abs(sigma[axis, y, x])


@njit(cache=True, nogil=True, error_model="numpy")
def fill_holes(location, sigma, cells, status, reach, length):
    """Give pixels without a location the mean of neighbours on opposite sides.

    See `smooth_neighbours`; cells: (A, H, W) int16; length: (A,) of a period. Filled
    pixels do not fill others. Their sigma is the mean of the neighbours' sigma, as
    these may be averages of the same pixels.
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
                disagree = False
                for axis in range(count):
                    step = location[axis, y + v, x + u] - location[axis, y - v, x - u]
                    disagree = disagree or abs(step) > reach[axis]
                if disagree:
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
def mark_border(near, location, sigma, status):
    """Remove the locations (A, H, W) of decoded pixels where `near` is not 0."""
    width = status.shape[1]
    border = np.zeros(-(-width // 8) * 8, np.uint8)
    eight = border.view(np.uint64)
    for y in range(len(status)):
        marked, own = near[y], status[y]
        for x in range(width):
            border[x] = (marked[x] != 0) & (own[x] == DECODED)
        # Few are: eight pixels are tested at a time.
        for k in range(len(eight)):
            if eight[k]:
                for x in range(8 * k, min(8 * k + 8, width)):
                    if border[x]:
                        status[y, x] = BORDER
                        location[:, y, x] = np.nan
                        sigma[:, y, x] = np.nan


# Excluded pixels: at the border of the lit area, the image's border, and at jumps.


MAX_SPOT_PX = 2  # smaller dark spots have no border


def trim_border(first, stop, margin, out):
    """Exclude pixels within `margin` px of dark pixels, except near small spots."""
    location, sigma, _, status = out
    reach = MAX_SPOT_PX + margin
    start, end = max(0, first - reach), min(len(status), stop + reach)
    around = status[start:end]
    unlit = ((around == DARK) | (around == OUTSIDE)).view(np.uint8)
    if not unlit.any():
        return
    # The image is extended by its border, where strips are not small spots.
    unlit = cv2.copyMakeBorder(unlit, *(MAX_SPOT_PX,) * 4, cv2.BORDER_REPLICATE)
    unlit = cv2.erode(unlit, np.ones((MAX_SPOT_PX + 1,) * 2, np.uint8))
    # The eroded spot grows by what it lost, and by the margin.
    size = 2 * margin + MAX_SPOT_PX + 1
    near = cv2.dilate(unlit, np.ones((size, size), np.uint8))
    near = near[MAX_SPOT_PX + first - start :, MAX_SPOT_PX:-MAX_SPOT_PX]
    mark_border(near, location[:, first:stop], sigma[:, first:stop], status[first:stop])


def trim_sides(margin, extent, out):
    """Exclude pixels at the image's border whose surroundings exceed the monitor.

    The surface is extrapolated by `margin` px. If that is outside the monitor, the
    blurred pixel receives light from the monitor's border.
    """
    location, sigma, _, status = out
    if min(status.shape) <= 2 * margin:
        return
    for transposed in (False, True):
        for step in (1, -1):
            position, spread, own = (
                (np.swapaxes(a, -1, -2) if transposed else a)[..., ::step, :]
                for a in (location, sigma, status)
            )
            outwards = position[:, margin] - position[:, 2 * margin]
            slack = position[:, :margin] + outwards[:, None]
            inside = np.all((slack >= 0) & (slack <= extent), axis=0)
            border = np.nonzero(~inside & (own[:margin] == DECODED))
            own[border] = BORDER
            position[:, *border] = np.nan
            spread[:, *border] = np.nan


def exclude_breaks(first, stop, margin, broken, out):
    """Exclude pixels within `margin` px of a jump; broken: every ROW_STEP-th row."""
    location, sigma, _, status = out
    # A jump is found HALF_STEP_PX to either side, slightly less in skipped rows.
    grow = max(margin - HALF_STEP_PX + ROW_STEP, 0)
    start = max(0, first - grow) // ROW_STEP
    end = -(-min(len(status), stop + grow) // ROW_STEP)
    if not broken[start:end].any():
        return
    near = np.zeros(((end - start) * ROW_STEP, status.shape[1]), np.uint8)
    near[::ROW_STEP] = broken[start:end]
    near = cv2.dilate(near, np.ones((2 * grow + 1,) * 2, np.uint8))
    near, part = near[first - start * ROW_STEP :], slice(first, stop)
    mark_breaks(near, location[:, part], sigma[:, part], status[part])


ROWS_PER_BLOCK = 256
WINDOW = 2 * WINDOW_RADIUS + 1
# Periods by which a pixel's phase may deviate from that of its window, besides noise.
MAX_BEND_PERIODS, NOISE_SIGMAS = np.float32(0.05), np.float32(6)
N_SCATTER_BLOCKS = 8  # of rows, all over the image, for the scatter of phases


def unwrapped_cells(images, codes, monitor_px, noise, smooth):
    """Return (A, H, W) uint16: `period_cells` of the axes without Gray code."""
    cells = np.zeros((len(codes), *images[0].shape), np.uint16)
    for axis, code in enumerate(codes):
        if code.others:
            extent = monitor_px[code.axis]
            cells[axis] = period_cells(images, code, extent, noise, smooth)
    return cells


def period_cells(images, code, extent, noise, smooth):
    """Return (H, W) uint16: the cell, CELLS_PER_PERIOD per period, or UNKNOWN.

    images: images (H, W) of a view; code: the AxisCode of its sinusoids; extent: of the
    monitor along that axis, px; noise: a Noise; smooth: whether windows are averaged.
    Variances are scaled where phases scatter more than noise, as behind a nonlinear
    response.
    """
    height, width = images[0].shape
    starts = range(0, height, ROWS_PER_BLOCK)
    every = starts[:: -(-len(starts) // N_SCATTER_BLOCKS)]
    sines = code.sines, *code.others
    periods = np.array([extent / one.period for one in sines], np.float32)
    some = zip(*(_phases(images, sines, first, noise) for first in every), strict=True)
    scatter = [phase_scatter(phases, periods) for phases in some]
    cells = np.empty((height, width), np.uint16)
    for first in starts:
        own, means = _phases(images, sines, first, noise)
        found = _cells(own, own, periods, scatter[0])
        if smooth:
            of_means = _cells(own, means, periods, scatter[1])
            found = np.where(of_means == UNKNOWN, found, of_means)
        cells[first : first + ROWS_PER_BLOCK] = found
    return cells


def _cells(own, phases, periods, scatter):
    """Return (h, w) uint16; own: phases of single pixels; phases: of windows."""
    fit = fitted_periods(phases, periods)
    good = own.lit & fit.is_unique(scatter)
    disagree = np.abs(own.turns - phases.turns)
    disagree = np.minimum(disagree, 1 - disagree)
    limit = MAX_BEND_PERIODS + NOISE_SIGMAS * np.sqrt(own.variances)
    good &= np.all(disagree <= limit, axis=0)
    cells = np.clip(np.floor(CELLS_PER_PERIOD * fit.position), 0, UNKNOWN - 1)
    return np.where(good, cells, UNKNOWN).astype(np.uint16)


def _phases(images, sines, first, noise):
    """Return phases of a block of rows: of each pixel, and of the windows around."""

    height, width = images[0].shape
    start, stop = (
        max(first - WINDOW_RADIUS, 0),
        min(first + ROWS_PER_BLOCK + WINDOW_RADIUS, height),
    )
    inner = slice(first - start, min(first + ROWS_PER_BLOCK, height) - start)
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
