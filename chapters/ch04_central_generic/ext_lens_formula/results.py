"""Names, medians over trials, and the numbers that the page quotes."""

import numpy as np

from repro.judge.statistics import median_interval
from repro.page.reader import value

NAMES = {
    "zhang": "pinhole, two radial terms",
    "kannala-brandt": "Kannala-Brandt",
    "unified": "unified sphere",
    "pupil": "Kannala-Brandt, pupil by test",
}
TITLES = {
    "fisheye": "fisheye of 183°",
    "mirror": "mirror, decentred",
    "pupil": "fisheye, moving pupil",
}
# What the prose quotes: lens and model.
QUOTED = (
    ("fisheye", "kannala-brandt"),
    ("mirror", "unified"),
    ("mirror", "kannala-brandt"),
    ("pupil", "kannala-brandt"),
    ("pupil", "pupil"),
)


def error(result, lens, model):
    """Return the median held-out error (px) over trials, an Estimate."""
    return median_interval(result.column(f"{model}.rms_px", lens=lens))


def ring_errors(result, lens, model):
    """Return the median errors (px) in rings about the image centre; NaN if empty."""
    rings = np.array(result.arrays(f"{model}.ring_px", lens=lens))
    if not len(rings):
        return None
    known = np.isfinite(rings).any(axis=0)
    return np.where(known, np.nanmedian(np.where(known, rings, 0.0), axis=0), np.nan)


def moved(result, lens):
    """Return the number of trials in which the test finds a pupil shift."""
    return int(np.nansum(result.column("pupil.test.moves", lens=lens)))


def shift(result, lens):
    """Return the median pupil shift (mm), an Estimate."""
    return median_interval(result.column("pupil.test.shift_mm", lens=lens))


def name_values(open_results):
    """Name the numbers of the prose."""
    result = open_results("ext_lens_known")
    value("trials", result.trials_per_condition)
    for lens, model in QUOTED:
        value(f"{lens}.{model}", error(result, lens, model).value)
