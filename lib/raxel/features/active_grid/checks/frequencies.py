"""Do sines of several periods, without a Gray code, tell which period is seen?"""

from itertools import combinations

import cv2
import numpy as np

from raxel.features.active_grid.checks.sample import Doubt
from raxel.features.active_grid.checks.steps import (
    MAX_WAYS,
    every_turned,
    put_right,
    told_offset,
)
from raxel.features.active_grid.layout import REACH
from raxel.features.active_grid.periods import share_told, usual_misfit

PIXELS = 5000
WINDOW = 2 * REACH + 1
MOST = 0.5  # share of pixels that must know their period
WASHED_OUT = 0.5  # of the modulation of pixels, that their windows must keep
OFFSETS = 24  # tried, in a period
ONE_OFFSET = 0.95  # length of the mean of unit vectors
# Periods by which sines begin off each other in the mean over all pixels: ripples of a
# response and noise have none. So much of an offset that all share is too much.
OFF, TOO_FAR_OFF = 0.002, 0.04


def frequency_doubts(sample, axis, noise):
    """A Doubt or none about the sines of an axis of a Sample; noise: a Noise.

    If they do not fit each other, pictures of two of them are exchanged for a trial,
    and all of them, or one alone, begin elsewhere: mistakes that leave each of them
    sound by itself.
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
    seen = turns, variances, periods
    offsets = list(_common_offset(every, *seen))
    ways = [*_exchanged(sample, every, *seen), *offsets]
    ways += _steps_of_one(sample, every, *seen)
    if ways:
        told = ", or ".join(ways[:MAX_WAYS] + ["mend offset"] * (not offsets))
        yield Doubt(True, f"the sines along {along} contradict each other: {told}")
        return
    files = ", ".join(_files(sample, one) for one in every)
    yield Doubt(
        True,
        f"the sines along {along} ({files}) do not tell which period a pixel sees: "
        "their phases are too uncertain, by noise or a response that is not linear, "
        "or not of these periods; take more steps, expose longer, mend periods or "
        "offset, or add Gray code",
    )


def _files(sample, sines):
    return f"{sample.names[sines.steps[0]]} to {sample.names[sines.steps[-1]]}"


def _exchanged(sample, every, turns, variances, periods):
    """What to do, for pairs of sines whose pictures fit in each other's place."""
    for j, k in combinations(range(len(every)), 2):
        order = np.arange(len(every))
        order[[j, k]] = k, j
        if share_told(turns[order], variances[order], periods) >= MOST:
            one, other = _files(sample, every[j]), _files(sample, every[k])
            yield (
                f"{one} and {other} are in each other's place: exchange their pictures "
                "or their periods"
            )


def _common_offset(every, turns, variances, periods):
    """What to do, if all begin elsewhere by as much: the offset, where only one fits.

    Of 1 and 16 periods any fifteen do.
    """
    found = []
    for off in np.arange(1, OFFSETS) / OFFSETS:
        trial = np.float32((turns - off) % 1)
        if share_told(trial, variances, periods) >= MOST:
            begun = _begun(*usual_misfit(trial, variances, periods))
            found.append(np.exp(2j * np.pi * (off + begun)))
    if found and np.abs(np.mean(found)) > ONE_OFFSET:
        off = np.angle(np.mean(found)) / (2 * np.pi)
        offset = told_offset(every[0].offset + off)
        yield f"give offset: {offset} if all of them begin there"


def _steps_of_one(sample, every, turns, variances, periods):
    """What to do, for each that begins elsewhere or runs backwards."""
    ways = []
    for k, sines in enumerate(every):
        for turned in every_turned(len(sines.steps))[1:]:
            trial = turns.copy()
            trial[k] = turned.undone(turns[k], sines) % 1
            if share_told(trial, variances, periods) >= MOST:
                shown = turned.shown(range(len(sines.steps)))
                moved = np.sum(shown != np.arange(len(shown)))
                ways.append((moved, [sample.names[n] for n in sines.steps], shown))
    least = min((moved for moved, *_ in ways), default=0)
    return [put_right(names, [shown]) for n, names, shown in ways if n == least]


def _begun(off, shares):
    """The offset that all share, by how much each is off the places of the first."""
    return float(off @ (shares - 1) / max((shares - 1) @ (shares - 1), 1e-6))


def _offset_doubts(every, turns, variances, periods, along):
    """Sines that fit each other, but not quite: a small offset looks like a response
    that is not linear, whose errors have a mean of none."""
    misfit = usual_misfit(turns, variances, periods)
    begun = _begun(*misfit)
    most = np.abs(misfit[0]).max()
    if most < OFF or abs(begun) < TOO_FAR_OFF:
        return
    offset = told_offset(every[0].offset + begun)
    yield Doubt(
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
