"""Results of section 3.2.2, as its figures, tables, claims and prose need them."""

from itertools import product

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.trials.blooming import (
    CORNER_METHODS,
    EXPOSURES,
    SHARES,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.codes import (
    EDGES_AND_LIGHT,
    SLANT_PX,
    light_along,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.profile import (
    AMPLITUDE_GREY,
    DATA_SHEET_GAMMA,
)
from repro.judge.statistics import median_interval
from repro.page.reader import value

PERCENT_OF_PERIOD = 100 / (2 * np.pi)
# Options of questions that the text leaves open; the one that decides comes first.
CAMERAS = ("linear", "sRGB")
AMPLITUDES = {"80 grey levels": 80.0, "50 grey levels": 50.0}
THRESHOLDS = ("one grey value", "white and black", "mean of the sines")
METHODS = (*CORNER_METHODS, "active grid")
# Option of the question clipped_sines -> the trial's name of the active grid.
CLIPPED = {"kept": "active grid", "left out": "masked"}
EDGES = ("one picture", "midpoint")


def profile_column(result, camera, gamma, name):
    """A value (seeds,) of the imaged period."""
    return result.column(f"{camera}.{gamma}.{name}")


def misfit_ratio(result, camera, gamma=DATA_SHEET_GAMMA):
    """RMS misfit (seeds,) without further harmonics over that with one."""
    rms = [profile_column(result, camera, gamma, f"rms_{k}") for k in (0, 1)]
    return rms[0] / rms[1]


def third_grey(result, camera, amplitude_grey=AMPLITUDE_GREY):
    """RMS (seeds,) of order 3 beside a sine of this amplitude, grey levels.

    It takes its square off the squared misfit. All orders are in proportion to the
    amplitude.
    """
    without, with_it = (
        profile_column(result, camera, DATA_SHEET_GAMMA, f"rms_{k}") for k in (1, 2)
    )
    return np.sqrt(without**2 - with_it**2) * amplitude_grey / AMPLITUDE_GREY


def bit_counts(result, edges, light, threshold):
    """(wrong by the threshold, wrong by the inverse, pixels): (trials,) each,
    summed over blur and noise; and the pixels that only one of the two has wrong.
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
    """RMS errors (trials,) in px, or shares, of a method."""
    return result.column(f"{method}.{exposure}.{share}.{name}")


def bloom_growth(result, method, exposure, name="rms_px"):
    """Growth (trials,) of the error by spilling, px."""
    with_spill, without = (
        bloom_errors(result, method, exposure, share, name)
        for share in reversed(SHARES)
    )
    return with_spill - without


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    quoted = {
        **of_profile(open_results("fig_3_9")),
        **of_light(open_results),
        **of_bits(open_results("exp_c3_inverse_helps")),
        **of_blooming(open_results("exp_c3_blooming")),
    }
    for name, number in quoted.items():
        value(name, number)


def of_profile(profile):
    """Misfits at the data-sheet gamma."""

    def misfit(camera, k):
        rms = profile_column(profile, camera, DATA_SHEET_GAMMA, f"rms_{k}")
        return float(np.median(rms))

    return (
        {f"{camera}.rms_{k}": misfit(camera, k) for camera in CAMERAS for k in range(3)}
        | {
            f"{camera}.third_grey": float(np.median(third_grey(profile, camera)))
            for camera in CAMERAS
        }
        | {
            "linear.third_lower": float(
                np.median(third_grey(profile, "linear", AMPLITUDES["50 grey levels"]))
            )
        }
    )


def of_light(open_results):
    """What the published orders do to a phase."""
    three, five = open_results("exp_c3_radiometric_ok").by("rest").values()
    return {
        "response.three": PERCENT_OF_PERIOD * three.column("largest_rad")[0],
        "response.five": PERCENT_OF_PERIOD * five.column("largest_rad")[0],
    }


def of_bits(bits):
    """Wrong bits by a threshold for one by an inverse, and the light in a corner."""
    found = {"bits.corner_light": 100 * light_along(2, "falls off")[-1]}
    for (edges, light), threshold in product(EDGES_AND_LIGHT, THRESHOLDS):
        wrong, paired, *_ = bit_counts(bits, edges, light, threshold)
        name = f"bits.{edges}.{light}.{threshold}".replace(" ", "_")
        found[name] = wrong.sum() / max(paired.sum(), 1)
    return found


def of_blooming(bloom):
    """Errors in too much light that spills, and shares of what is located."""

    def median(method, exposure, name="rms_px"):
        return median_interval(bloom_errors(bloom, method, exposure, 1.0, name)).value

    little, much = EXPOSURES
    return {
        **{f"bloom.{method.split()[0]}": median(method, much) for method in METHODS},
        **{f"edges.{n.split()[-1]}": median("edges", little, n) for n in EDGES},
        "bloom.all_pixels": median("all pixels", little),
        "bloom.left": 100 * median("all pixels", much, "share"),
        "bloom.corners_left": 100 * median("masked", little, "share"),
        "bloom.located": 100 * median("active grid", much, "share"),
    }
