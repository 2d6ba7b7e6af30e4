"""Did camera and monitor rest, by the light that a pattern does not change?

A picture and its inverse add up to one without pattern, as the steps of a sine do.
Where these differ from each other as if the first were shifted, something moved, to
first order in the shift.
"""

from itertools import pairwise

import numpy as np

from raxel.features.active_grid.checks.sample import Doubt

MOVED_PX, FAR_MOVED_PX = 0.7, 1.2
EDGE = 0.2  # of the steepest slope
FEW_EDGES = 0.3  # of those along the other direction
SURE = 8  # standard deviations of the estimated motion
TONE = 2  # times what a tone curve does: less may be its as well


def motion_doubts(sample):
    """The largest motion, as one Doubt or none."""
    found = []
    flat = sorted(_without_pattern(sample), key=lambda one: min(one[0]))
    fitted = [_shifts(plain, flat[0][1], pattern) for _, plain, pattern in flat]
    shifts = [shift for shift, _, _ in fitted]
    # One tone curve is behind all pictures, and coarse bits have few edges to know it.
    least = TONE * max((np.hypot(*tone) for _, _, tone in fitted), default=0.0)
    for (pictures, _, _), (_, within, _) in zip(flat, fitted, strict=True):
        within = within * (np.hypot(*within) > least)
        found.append((within, "between {} and {}", pictures))
    for (before, after), (last, first) in zip(
        pairwise(shifts), pairwise(flat), strict=True
    ):
        pictures = last[0][-1], first[0][0]
        found.append((after - before, "between {} and {}", pictures))
    sizes = [float(np.hypot(*shift)) for shift, _, _ in found]
    if sizes and max(sizes) > MOVED_PX:
        size = max(sizes)
        _, when, pictures = found[sizes.index(size)]
        when = when.format(sample.names[pictures[0]], sample.names[pictures[-1]])
        yield Doubt(
            "moved",
            size > FAR_MOVED_PX,
            f"the picture moved by about {size:.1f} px {when}; camera and monitor must "
            "be at rest: take the pictures again",
        )


def _without_pattern(sample):
    """(pictures, their mean without pattern, half of what the pattern adds or None)"""
    for axis, code in enumerate(sample.codes):
        for light, dark in code.bits:
            if dark is not None:
                a, b = sample.pictures[light], sample.pictures[dark]
                yield (light, dark), (a + b) / 2, (a - b) / 4
        if code.steps:
            yield code.steps, sample.wave(axis)[1], None


def _shifts(plain, reference, pattern):
    """Shift (2,) px against the reference, of a picture against its inverse, and what
    the tone curve does to these two, alike.

    At an edge of the pattern a tone curve makes both together brighter or darker,
    whichever side is bright. What a shift leaves turns with the side; unless it is far
    more, it is the tone curve's as well.
    """
    columns = [reference, np.ones_like(reference), *slopes_within(reference)]
    if pattern is None:
        return _fitted(plain, columns)[2:], np.zeros(2), np.zeros(2)
    slopes = [_edges(slope) for slope in slopes_within(pattern)]
    # Where edges end at the monitor's border, a few go across their own direction.
    count = [np.count_nonzero(slope) for slope in slopes]
    slopes = [
        s * (n > FEW_EDGES * max(count)) for s, n in zip(slopes, count, strict=True)
    ]
    found = _fitted(plain, [*columns, *slopes, *map(np.abs, slopes)])
    return found[2:4], found[4:6], found[6:]


def slopes_within(picture):
    """Changes per pixel along u and v within each band."""
    if picture.shape[1] < 2:
        return np.gradient(picture, axis=2), np.zeros_like(picture)
    return np.gradient(picture, axis=2), np.gradient(picture, axis=1)


def _edges(slope):
    """The slope where there is an edge, 0 where there is noise."""
    size = np.abs(slope)
    return np.where(size > EDGE * size.max(), slope, 0)


def _fitted(values, columns):
    """Coefficients of the columns, 0 for those that are not SURE."""
    basis = np.stack([column.ravel() for column in columns], axis=1).astype(float)
    used = basis.any(axis=0)
    scale = np.where(used, np.sqrt(np.mean(basis**2, axis=0)), 1)
    basis = basis / scale
    normal = basis.T @ basis + 1e-9 * len(basis) * np.eye(len(scale))
    inverse = np.linalg.inv(normal)
    found = inverse @ (basis.T @ values.ravel())
    left = values.ravel() - basis @ found
    spread = np.sqrt(np.mean(left**2) * np.diag(inverse))
    return np.where(used & (np.abs(found) > SURE * spread), found / scale, 0)
