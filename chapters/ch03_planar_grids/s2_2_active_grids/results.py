"""Results of section 3.2.2 for figures, tables, claims and text."""

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.trials.blooming import (
    CORNER_METHODS,
    EXPOSURES,
    SHARES,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.codes import SLANT_PX
from chapters.ch03_planar_grids.s2_2_active_grids.trials.profile import (
    AMPLITUDE_GREY,
    DATA_SHEET_GAMMA,
)
from repro.judge.statistics import median_interval
from repro.page.reader import value

PERCENT_OF_PERIOD = 100 / (2 * np.pi)
# Options of questions that the text does not answer, the primary one first.
AMPLITUDES = {"80 grey levels": 80.0, "50 grey levels": 50.0}
THRESHOLDS = ("one grey value", "white and black", "mean of the sines")
METHODS = (*CORNER_METHODS, "active grid")
# Option of the question clipped_sines -> name of the active grid in a trial.
CLIPPED = {"kept": "active grid", "left out": "masked"}


def profile_column(result, camera, gamma, name):
    """A value (views,) of the imaged period."""
    return result.column(f"{camera}.{gamma}.{name}")


def misfit_ratio(result, camera, gamma=DATA_SHEET_GAMMA):
    """RMS misfit (views,) without further harmonics over that with one."""
    rms = [profile_column(result, camera, gamma, f"rms_{k}") for k in (0, 1)]
    return rms[0] / rms[1]


def third_grey(result, camera, amplitude_grey=AMPLITUDE_GREY):
    """RMS (views,) of order 3 for a sine of this amplitude, in grey levels.

    Its square is the drop of the squared misfit. All orders are proportional to
    the amplitude.
    """
    without, with_it = (
        profile_column(result, camera, DATA_SHEET_GAMMA, f"rms_{k}") for k in (1, 2)
    )
    return np.sqrt(without**2 - with_it**2) * amplitude_grey / AMPLITUDE_GREY


def bit_counts(result, edges, light, threshold):
    """(wrong by the threshold, wrong by the inverse, pixels): (trials,) each,
    summed over blur and noise; then the pixels that are wrong by only one of them.
    """
    trials = result.select(slant_px=SLANT_PX[edges], light=light)

    def total(name):
        return trials.column(name).reshape(len(trials.conditions), -1).sum(axis=0)

    return (
        total(f"{threshold}.wrong"),
        total("inverse.wrong"),
        total("pixels"),
        int(total(f"{threshold}.only_threshold").sum()),
        int(total(f"{threshold}.only_inverse").sum()),
    )


def bloom_errors(result, method, exposure, share, name="rms_px"):
    """RMS errors (trials,) in px, or located shares, of a method."""
    return result.column(f"{method}.{exposure}.{share}.{name}")


def bloom_growth(result, method, exposure, name="rms_px"):
    """Growth (trials,) of the error by blooming, px."""
    with_spill, without = (
        bloom_errors(result, method, exposure, share, name)
        for share in reversed(SHARES)
    )
    return with_spill - without


def name_values(open_results):
    """Name the numbers that the page quotes."""
    quoted = {
        **of_response(open_results),
        "bits.anywhere.falls_off.one_grey_value": threshold_factor(
            open_results("exp_c3_inverse_helps")
        ),
        **of_blooming(open_results("exp_c3_blooming")),
    }
    for name, number in quoted.items():
        value(name, number)


def of_response(open_results):
    """Phase errors by the published orders, in percent of a period."""
    three, five = open_results("exp_c3_radiometric_ok").by("rest").values()
    return {
        "response.three": PERCENT_OF_PERIOD * three.column("largest_rad")[0],
        "response.five": PERCENT_OF_PERIOD * five.column("largest_rad")[0],
    }


def threshold_factor(bits):
    """Wrong bits by one grey value over those by the inverse, in uneven light."""
    wrong, paired, *_ = bit_counts(bits, "anywhere", "falls off", THRESHOLDS[0])
    return wrong.sum() / max(paired.sum(), 1)


def of_blooming(bloom):
    """Errors at the corners with the most light, and the located share in percent."""
    much = EXPOSURES[-1]

    def median(method, name="rms_px"):
        return median_interval(bloom_errors(bloom, method, much, 1.0, name)).value

    return {
        "bloom.saddle": median("saddle point"),
        "bloom.active": median("active grid"),
        "bloom.located": 100 * median("active grid", "share"),
    }
