"""What the claims about corrected pictures say of one trial, and what is measured.

Each takes the `Corrected` trials of a reading and gives whether it is true (trials,),
what was measured (trials,), its unit, and words.
"""

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.results.corrected import (
    BOARDS,
    LINES,
)
from chapters.shared.central_sets import FISH, OMNI
from repro.judge.statistics import with_worst

REMOVED = 0.2
MIN_RATIO, EQUAL = 1.3, (0.85, 1.25)
MAX_BIAS, SEAM, SKEW = 0.25, 1.5, 0.3


def less_view(lines):
    """Less vertical view with the standard method, and its depth is why."""
    own, cgsp = lines.both(OMNI, "vertical_deg")
    same, _ = lines.both(OMNI, "equal_depth_deg")
    less = cgsp - own
    left = np.abs(cgsp - same) / np.abs(less)
    return (
        (less > 0) & (left <= REMOVED),
        less,
        "deg",
        "CGSP's vertical view less the standard one's; with equal depth "
        f"{100 * np.nanmedian(left):.0f} % of the difference is left",
    )


def larger_residuals(boards):
    """Mean and SD of the standard residuals at least 1.3 times CGSP's."""
    mean, spread = (boards.ratio(OMNI, name) for name in ("mean_mm", "sd_mm"))
    return (
        (mean >= MIN_RATIO) & (spread >= MIN_RATIO),
        mean,
        "",
        f"ratio of the means; of the SDs {np.median(spread):.3f}",
    )


def equal_residuals(boards):
    """The means of the fisheye are nearly equal."""
    mean = boards.ratio(FISH, "mean_mm")
    return (mean >= EQUAL[0]) & (mean <= EQUAL[1]), mean, "", "ratio of the means"


def no_radial_bias(boards):
    """No quintile of radius has a mean radial residual of a quarter RMS."""
    worse = with_worst(boards.both(OMNI, "radial_bias")).max(axis=0)
    return (
        worse <= MAX_BIAS,
        worse,
        "",
        "largest mean radial residual of a quintile over the RMS, the worse of both "
        "methods",
    )


def seams(boards):
    """Standard residuals are larger beside seams, CGSP's less so."""
    own, cgsp = boards.both(OMNI, "seam_ratio")
    return (
        (own > SEAM) & (cgsp < own),
        own,
        "",
        "mean residual beside seams over that elsewhere; CGSP "
        f"{np.nanmedian(cgsp):.2f}",
    )


def skew(boards):
    """Residuals of the fisheye rise with the angle to the plane's normal."""
    least = boards.both(FISH, "skew_spearman").min(axis=0)
    return (
        least >= SKEW,
        least,
        "",
        "rank correlation of angle and residual, the smaller of both methods",
    )


# Claims that are judged trial by trial, and what they read.
BY_TRIAL = {
    "c4_unwrap_fov": (LINES, less_view),
    "c4_t44_omni": (BOARDS, larger_residuals),
    "c4_t44_fish": (BOARDS, equal_residuals),
    "c4_no_radial_bias": (BOARDS, no_radial_bias),
    "c4_seams": (BOARDS, seams),
    "c4_skew_amplifies": (BOARDS, skew),
}
