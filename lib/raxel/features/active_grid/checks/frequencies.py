"""Do sines of several periods, without a Gray code, tell which period is seen?"""

import cv2
import numpy as np

from raxel.features.active_grid.checks.sample import Doubt
from raxel.features.active_grid.checks.steps import rounded_offset
from raxel.features.active_grid.layout import REACH
from raxel.features.active_grid.periods import share_told, usual_misfit

PIXELS = 5000
WINDOW = 2 * REACH + 1
MOST = 0.5  # share of pixels that must know their period
WASHED_OUT = 0.5  # of the modulation of pixels, that their windows must keep
# Periods by which sines begin off each other in the mean over all pixels: ripples of a
# response and noise have none. So much of an offset that all share is too much.
OFF, TOO_FAR_OFF = 0.002, 0.04


def frequency_doubts(sample, axis, noise):
    """A Doubt or none about the sines of an axis of a Sample; noise: a Noise.

    Pictures of two of them exchanged, steps in the wrong order and offsets that are
    not stated leave each sine sound by itself, and phases that contradict each other.
    """
    code = sample.codes[axis]
    every = code.sines, *code.others
    periods = np.array([1 / one.period for one in every])
    periods = (sample.extents[axis] * periods).astype(np.float32)
    turns, variances = _windows(sample, every, noise)
    along = "xy"[code.axis]
    if share_told(turns, variances, periods) >= MOST:
        yield from _offset_doubts(every, turns, variances, periods, along)
        return
    files = ", ".join(
        f"{sample.names[one.steps[0]]} to {sample.names[one.steps[-1]]}"
        for one in every
    )
    yield Doubt(
        "periods-unknown",
        True,
        f"the phases of the sines along {along} ({files}) do not determine the period: "
        "check their order, step, periods and offset, or reduce the noise",
    )


def _offset_doubts(every, turns, variances, periods, along):
    """Sines that fit each other, but not quite: a small offset looks like a response
    that is not linear, whose errors have a mean of none."""
    off, shares = usual_misfit(turns, variances, periods)
    # The offset that all share, by how much each is off the places of the first.
    begun = off @ (shares - 1) / max((shares - 1) @ (shares - 1), 1e-6)
    most = np.abs(off).max()
    if most < OFF or abs(begun) < TOO_FAR_OFF:
        return
    offset = rounded_offset(every[0].offset + begun)
    yield Doubt(
        "offset",
        True,
        f"the sines along {along} begin {most:.2g} periods off each other: give "
        f"offset: {offset} if all of them begin there; else something moved between "
        "them, and they must be taken again",
    )


def _windows(sample, every, noise):
    """Phases of windows in the bands and their variances, (F, P) float32, periods.

    Of sines that windows wash out, those of pixels.
    """
    lit = np.flatnonzero(sample.lit)
    some = lit[:: -(-len(lit) // PIXELS)]
    turns, variances = [], []
    for sines in every:
        wave, mean = sample.wave_of(sines, sines.steps)
        sine, cosine = (
            np.array([cv2.blur(band, (WINDOW, WINDOW)) for band in part])
            for part in (wave.imag, wave.real)
        )
        own, wave = wave.ravel()[some], (cosine + 1j * sine).ravel()[some]
        of_wave = 2 / len(sines.steps) * noise.at(mean.ravel()[some])
        if np.median(np.abs(wave)) < WASHED_OUT * np.median(np.abs(own)):
            wave = own  # of windows that hold a period, the mean is turned round
        else:
            of_wave = of_wave / WINDOW**2
        turns.append(np.angle(wave) / (2 * np.pi) % 1)
        variances.append(of_wave / (np.abs(wave) ** 2 + 1e-6) / (2 * np.pi) ** 2)
    return np.float32(turns), np.float32(variances)
