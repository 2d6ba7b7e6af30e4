"""Movements of camera or monitor by parts of a pixel, and what they do to places.

Where something moves between two steps of a sine, once and for good, the later ones are
shifted, each by its own slope: of five steps and more a sine leaves that. Where it
moves between the steps along x and those along y, their means differ as if one of them
were shifted; the monitor's border tells it. Nothing tells which of both poses a view
is of: places along both axes may be off by as much as they change over the movement.
"""

from typing import NamedTuple

import numpy as np

from raxel.features.active_grid.checks.leftover import SeenSteps, beside_response
from raxel.features.active_grid.checks.motion import slopes_within
from raxel.features.active_grid.checks.redundancy import (
    AS_WELL,
    SURE,
    axis_pixels,
    clipped_fit,
)
from raxel.features.active_grid.checks.sample import Doubt

FEWEST = 5  # steps: light that changes leaves all that a movement leaves of four
EVERY = 3  # pixels that others look at: a third knows a movement to 0.02 px
REACH = 3  # px, to both sides, for slopes: less noise, and within a window
# Above what slopes over pixels make of none; of the blur, what a tone curve behind it
# does to a border that is seen on one side alone: up to 0.035 of it.
LEAST_PX, OF_BLUR = 0.03, 0.05
# Of the light, over a pixel: a border is steeper, blurred by 6 px; falloff never is.
STEEP, MIN_AT_EDGES = 0.05, 100
BORDER = 4  # px
SAME_MEAN = 1.3  # times the shift of a mean: the border weighs steps by their light
ROWS, COLUMNS = 400, 400  # at most, for how places change


class Jolt(NamedTuple):
    """From picture `after` on, what is seen lies `shift` (2,) px further along u and v
    than up to picture `before`; sd: (2,), its standard deviation. within: the axis of
    whose steps both are, None where it is between axes."""

    before: int
    after: int
    shift: np.ndarray
    sd: np.ndarray
    within: int | None = None

    def is_sure(self, blur_px):
        """Whether that is more than noise, and such a blur, make of none."""
        certain = np.hypot(*(self.shift / np.maximum(self.sd, 1e-9)))
        least = max(LEAST_PX, OF_BLUR * blur_px)
        return certain > SURE and np.hypot(*self.shift) > least


def jolts(sample, blur_px):
    """[Jolt, ...] that are sure, of a Sample; blur_px: its standard deviation, or
    None."""
    found = [_of_steps(sample, axis) for axis in range(len(sample.codes))]
    found.append(_between_axes(sample))
    return [j for j in found if j is not None and j.is_sure(blur_px or 0.0)]


def without_means_of(found, alone_px):
    """Jolts less those between axes that means have where one step moved alone;
    alone_px: by how much, over the number of steps."""
    least = SAME_MEAN * alone_px
    return [j for j in found if j.within is not None or np.hypot(*j.shift) > least]


def changes_over(shift, location):
    """(2,) RMS by which places (H, W, 2) change over a shift (2,) px."""
    height, width = location.shape[:2]
    some = np.s_[:: 1 + height // ROWS, :: 1 + width // COLUMNS]
    right = (location[:, 1:] - location[:, :-1])[:-1][some]
    down = (location[1:] - location[:-1])[:, :-1][some]
    change = shift[0] * right + shift[1] * down
    known = np.isfinite(change)
    squares = np.sum(np.where(known, change, 0) ** 2, axis=(0, 1))
    return np.sqrt(squares / np.maximum(known.sum(axis=(0, 1)), 1))


def jolt_doubts(sample, found, errors, limits):
    """A Doubt or none; found: Jolts, of which the largest is told; errors: (2,) of
    places by them; limits: (2,), alike, that are worth a word."""
    if not np.any(errors > limits):
        return
    worst = max(found, key=lambda jolt: np.hypot(*jolt.shift))
    yield Doubt(
        False,
        f"the picture moved by about {np.hypot(*worst.shift):.2g} px between "
        f"{sample.names[worst.before]} and {sample.names[worst.after]}: places are "
        f"wrong by up to {errors[0]:.2g} along x and {errors[1]:.2g} along y, which "
        "standard deviations hold; camera and monitor must be at rest: take the "
        "pictures again",
    )


def _of_steps(sample, axis):
    """The Jolt amid the steps of an axis that explains most, or None where one step
    that moved alone explains as much: the first, the last, or any of five."""
    steps = sample.codes[axis].steps
    count = len(steps)
    pixels = axis_pixels(sample, axis, EVERY, REACH) if count >= FEWEST else None
    if pixels is None:
        return None
    size = np.abs(pixels.wave)
    unit = pixels.wave / np.maximum(size, 1e-6)
    usual = float(np.median(size))
    seen = SeenSteps(pixels.light, pixels.mean, size, unit, *pixels.at, usual)
    turn = np.exp(2j * np.pi * np.arange(count) / count)[:, None, None]
    # What lies further along u is what lay before it.
    moved = -(pixels.of_mean + (pixels.of_wave * turn).imag).swapaxes(0, 1)
    late = np.arange(count) >= np.arange(1, count)[:, None]
    which = np.concatenate([late, np.eye(count, dtype=bool)])
    changes = (which[:, None, :, None] * moved).reshape(-1, *moved.shape[1:])
    value, columns = beside_response(seen, changes)
    found = [_fitted(value, columns[k : k + 2]) for k in range(0, len(columns), 2)]
    gains = np.array([gain for gain, _, _ in found])
    best, alone = int(np.argmax(gains[: len(late)])), gains[len(late) :].max()
    if AS_WELL * gains[best] < alone:
        return None
    return Jolt(steps[best], steps[best + 1], *found[best][1:], axis)


def _fitted(values, columns):
    """By how much two columns make a sum of squares smaller, coefficients and SD."""
    inverse = np.linalg.pinv(columns @ columns.T)
    right = columns @ values
    found = inverse @ right
    return found @ right, found, np.sqrt(np.diag(inverse))


def _between_axes(sample):
    """The Jolt between the pictures along both axes, or None where nothing tells.

    Like is compared with like: sines with sines, or sums of pictures of the code and
    their inverses with such.
    """
    if len(sample.codes) < 2 or len({bool(own.steps) for own in sample.codes}) > 1:
        return None
    pair = [_plain(sample, axis) for axis in (0, 1)]
    if any(own is None for own in pair):
        return None
    (names, one), (others, other) = sorted(pair, key=lambda own: min(own[0]))
    level = (one + other) / 2
    curve = level**2 / max(level.max(), 1e-6)
    slopes = np.array(slopes_within(level))
    good = _inner(sample)
    edge = np.hypot(*slopes) > STEEP * np.quantile(level, 0.95)
    if np.count_nonzero(edge & good) < MIN_AT_EDGES:
        return None
    slopes = slopes * edge
    # Blur and a tone curve make a border brighter or darker, on whichever side it is.
    columns = np.array([*slopes, *np.abs(slopes), np.ones_like(level), level, curve])
    usual, found, inverse = clipped_fit((one - other)[good], columns[:, good])
    sd = np.sqrt(usual * np.diag(inverse)[:2].clip(0))
    return Jolt(max(names), min(others), found[:2], sd)


def _inner(sample):
    """Pixels that are not clipped, nor at the picture's border: programs that move
    pictures fill in what they do not see."""
    good = sample.high < sample.high.max()
    good[..., :BORDER] = good[..., -BORDER:] = False
    good[0, :BORDER] = good[-1, -BORDER:] = False
    return good


def _plain(sample, axis):
    """Pictures of an axis, and what they show (bands, BAND, W) without pattern."""
    code = sample.codes[axis]
    if code.steps:
        return code.steps, sample.wave(axis)[1]
    pairs = [pair for pair in code.bits if pair[1] is not None]
    if not pairs:
        return None
    names = [k for pair in pairs for k in pair]
    return names, sample.pictures[names].mean(axis=0)
