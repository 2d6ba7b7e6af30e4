"""Do sines of several periods, without a Gray code, tell which period is seen?"""

import cv2
import numpy as np

from raxel.features.active_grid.checks.sample import Doubt
from raxel.features.active_grid.checks.steps import every_turned, put_right
from raxel.features.active_grid.layout import REACH
from raxel.features.active_grid.periods import share_told

PIXELS = 5000
WINDOW = 2 * REACH + 1
MOST = 0.5  # share of pixels that must know their period


def frequency_doubts(sample, axis, noise):
    """A Doubt or none about the sines of an axis of a Sample; noise: a Noise.

    If they do not fit each other, steps that run backwards or begin elsewhere are tried
    for each of them: both are mistakes that leave each of them sound by itself.
    """
    code = sample.codes[axis]
    every = code.sines, *code.others
    periods = np.array([1 / one.period for one in every])
    periods = (sample.extents[axis] * periods).astype(np.float32)
    turns, variances = _windows(sample, every, noise)
    if share_told(turns, variances, periods) >= MOST:
        return
    ways = []
    for k, sines in enumerate(every):
        for turned in every_turned(len(sines.steps))[1:]:
            trial = turns.copy()
            trial[k] = turned.undone(turns[k], sines) % 1
            if share_told(trial, variances, periods) >= MOST:
                shown = turned.shown(range(len(sines.steps)))
                moved = np.sum(shown != np.arange(len(shown)))
                ways.append((moved, [sample.names[n] for n in sines.steps], shown))
    along = "xy"[code.axis]
    if ways:
        least = min(moved for moved, *_ in ways)
        told = [put_right(names, [shown]) for n, names, shown in ways if n == least]
        yield Doubt(
            True,
            f"the sines along {along} contradict each other: {', or '.join(told)}, or "
            "mend offset",
        )
        return
    ends = ((one.steps[0], one.steps[-1]) for one in every)
    files = ", ".join(f"{sample.names[j]} to {sample.names[k]}" for j, k in ends)
    yield Doubt(
        True,
        f"the sines along {along} ({files}) do not tell which period a pixel sees: "
        "their phases are too uncertain, by noise or a response that is not linear, "
        "or not of these periods; take more steps, expose longer, mend periods, or "
        "add Gray code",
    )


def _windows(sample, every, noise):
    """Phases of windows in the bands and their variances, (F, P) float32, periods."""
    lit = np.flatnonzero(sample.lit)
    some = lit[:: -(-len(lit) // PIXELS)]
    turns, variances = [], []
    for sines in every:
        wave, mean = sample.wave_of(sines, sines.steps)
        sine, cosine = (
            np.array([cv2.blur(band, (WINDOW, WINDOW)) for band in part])
            for part in (wave.imag, wave.real)
        )
        wave = (cosine + 1j * sine).ravel()[some]
        of_wave = 2 / len(sines.steps) * noise.at(mean.ravel()[some]) / WINDOW**2
        turns.append(np.angle(wave) / (2 * np.pi) % 1)
        variances.append(of_wave / (np.abs(wave) ** 2 + 1e-6) / (2 * np.pi) ** 2)
    return np.float32(turns), np.float32(variances)
