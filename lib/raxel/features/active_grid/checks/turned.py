"""Bits without inverses that something turned over: their code counts backwards.

A hand that is darker than the monitor takes a bit away, and what is read there is read
well. But in a Gray code one bit that is turned over makes all that it divides count
backwards. Wherever the phase goes on into the next period, cells then go on into the
one before, two periods off. A surface that breaks seldom does so along such lines; and
where it does, what lies beside the break goes on into its other neighbour.
"""

import cv2
import numpy as np

from raxel.features.active_grid.checks.leftover import Steps
from raxel.features.active_grid.checks.outliers import STRIDE, WHOLE

ROWS = 128  # at once
FEW = 20  # pixels
READ = 0.5  # of the sine's modulation, from its mean: a bit that is well read
SMOOTH_TURN = 0.5  # of the cosine from pixel to pixel: on one surface
BLURRED = 2  # deviations of the blur, to either side of an edge, are not asked
OFF = 2  # periods: at the monitor's rim, and by noise at edges, it is one
LARGEST = 201  # px, of areas, a period across, whose borders have a say together
MIN_BORDER = 0.5  # of one across an area: a break that leans meets fewer of them
# Borders of an area that go on, in those that run against the phase: none of what is
# turned over goes on, and about as many of what lies beside a break.
SOUND = 0.25
AGAINST, ALONG, AMID = range(3)  # borders against and along the phase, leaps elsewhere


def turned_over(images, code, good, blur_px):
    """(H, W) bool: where the code of an axis runs against its phase.

    images: n pictures (H, W); code: AxisCode with steps and Gray code; good: (H, W)
    bool, pixels that count; blur_px: None where it is not known. Of large pictures
    every STRIDE-th pixel each way is asked. What is turned over within one period, or
    in two beside each other by their finest bit, is not seen; and up to a period about
    what is seen goes with it.
    """
    stride = 1 if good.size <= WHOLE else STRIDE
    every = slice(None, None, stride)
    images = [image[every, every] for image in images]
    small = good[every, every]
    reach = 1 + int(np.ceil(BLURRED * (blur_px or 1) / stride))
    some = np.flatnonzero(small)
    some = np.unravel_index(some[:: 1 + len(some) // 4000], small.shape)
    steps = Steps.of(images, code, some)
    votes, turns = np.zeros((2, 3, *small.shape), np.uint8), []
    ends = np.zeros(small.shape, bool)
    for top in range(0, len(small), ROWS):
        rows = slice(max(top - reach, 0), top + ROWS + reach)
        found, ended = _votes(images, steps, code, small, rows, reach, turns)
        votes[..., rows, :] |= found
        ends[rows] |= ended
    if not votes[:, AGAINST].any():
        return np.zeros(good.shape, bool)
    _leave_out_sound(votes, ends, reach)
    votes = votes.max(axis=0)
    votes = votes[AGAINST], votes[ALONG] | votes[AMID]
    period = 1 / max(*turns, 1 / LARGEST)
    side = int(min(period, LARGEST)) | 1
    size = {"ddepth": cv2.CV_32F, "ksize": (side, side), "normalize": False}
    against, along = (cv2.boxFilter(each, **size) for each in votes)
    mask = (against > along) & (against > MIN_BORDER * 2 * reach * side)
    own = np.ones((side, side), np.uint8)
    mask = cv2.dilate(mask.astype(np.uint8), own).repeat(stride, 0).repeat(stride, 1)
    return good & (mask[: len(good), : good.shape[1]] > 0)


def _votes(images, steps, code, good, rows, reach, turns):
    """(2, 3, rows, W): down and to the right, AGAINST, ALONG and AMID; and (rows, W)
    bool, where an area of one period and one cell ends; turns: to which periods from
    pixel to pixel, one way, are added."""
    seen = steps.at((rows,))
    # From the monitor's border, as cells count.
    phase = np.angle(seen.unit) / (2 * np.pi) - code.sines.offset
    cell, read = np.zeros(phase.shape, np.int32), good[rows].copy()
    for light, _ in code.bits:
        off = images[light][rows] - seen.mean
        cell = 2 * cell + ((off > 0) ^ (cell & 1).astype(bool))
        read &= np.abs(off) > READ * seen.size
    turn = phase % 1
    order = np.rint((cell + 0.5) * code.cell / code.period - turn)
    votes, ends = np.zeros((2, 3, *turn.shape), np.uint8), ~good[rows]
    for axis in (0, 1):
        both = [np.moveaxis(array, axis, 0) for array in (order, turn, read)]
        unit, ended = (np.moveaxis(array, axis, 0) for array in (seen.unit, ends))
        step = unit[1:] * unit[:-1].conj()
        smooth = step.real > SMOOTH_TURN
        leaps = np.diff(both[0], axis=0) != 0
        ended[1:] |= ~smooth | leaps | (np.abs(np.diff(both[1], axis=0)) > 0.5)
        if len(unit) > 2 * reach:
            own = np.moveaxis(votes[axis], axis + 1, 1)
            turns.append(_vote(*both, step, smooth, reach, own))
    return votes, ends


def _vote(order, turn, read, step, smooth, reach, votes):
    """Write the votes of pixels of which one lies `reach` before, one behind; periods
    from pixel to pixel, 0 of none. step: from pixel to pixel, complex."""
    path = np.ones((2 * reach, 1), np.uint8)
    smooth = cv2.erode(smooth.astype(np.uint8), path)
    gone = np.cumsum(np.angle(step), axis=0) / (2 * np.pi)
    gone = np.concatenate([0 * gone[:1], gone])
    first, last = slice(None, -2 * reach), slice(2 * reach, None)
    ahead = gone[last] - gone[first]
    known = read[first] & read[last] & (smooth[reach : len(turn) - reach] > 0)
    # Whole periods, as the code should count them.
    periods = np.rint(turn[first] + ahead - turn[last])
    border, off = periods != 0, np.abs(order[last] - order[first] - periods)
    votes[AGAINST, reach:-reach] = known & border & (off >= OFF)
    votes[ALONG, reach:-reach] = known & border & (off == 0)
    # Where surfaces break, cells leap amid a period as well.
    votes[AMID, reach:-reach] = known & ~border & (off >= OFF)
    some = np.abs(ahead[known])[::50]
    return np.median(some) / (2 * reach) if len(some) > FEW else 0.0


def _leave_out_sound(votes, ends, reach):
    """Take from votes those AGAINST at areas that go on elsewhere: what is turned over
    goes on nowhere, and a break along the border of a period has sound areas beside."""
    areas = cv2.connectedComponents((~ends).astype(np.uint8), connectivity=4)[1]
    counts = np.zeros((2, areas.max() + 1))
    pairs = [_apart(areas, axis, reach) for axis in (0, 1)]
    inner = [_apart(votes[axis], axis + 1, reach)[1] for axis in (0, 1)]
    for (first, _, last), own in zip(pairs, inner, strict=True):
        for kind in (AGAINST, ALONG):
            for beside in (first, last):
                found = beside[own[kind] > 0]
                counts[kind] += np.bincount(found, minlength=counts.shape[1])
    sound = counts[ALONG] > SOUND * counts[AGAINST]
    sound[0] = False  # ends
    for (first, _, last), own in zip(pairs, inner, strict=True):
        own[AGAINST][sound[first] | sound[last]] = 0


def _apart(array, axis, reach):
    """Views of what lies `reach` before pixels, of these, and of what lies behind."""
    array = np.moveaxis(array, axis, 0)
    parts = array[: -2 * reach], array[reach:-reach], array[2 * reach :]
    return [np.moveaxis(part, 0, axis) for part in parts]
