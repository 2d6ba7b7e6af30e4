"""Claims about the tin for single runs.

Each function takes the `TinRuns` at an error level. It returns whether the claim holds
(seeds,), the measured value (seeds,), its unit, and words. A rejected run has no value.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.trials.faces import OUTLYING

MAX_ERROR_DEG = 2.5
MIN_NORMALITY = 0.99


def middle(values):
    """Median of the runs that have a value, as words; "nothing" without any."""
    known = values[np.isfinite(values)]
    return f"{np.median(known):.3g}" if len(known) else "nothing"


def angles_found(runs):
    """The largest difference of the three angles from the reference."""
    off = runs.off()
    most = np.abs(off).max(axis=0)
    below = np.mean(np.all(off < 0, axis=0))
    return (
        most <= MAX_ERROR_DEG,
        most,
        "deg",
        "largest difference of the three; by the true mirror "
        f"{middle(runs.of('off_deg', 'true'))} degrees; all three below the reference "
        f"in {100 * below:.0f} % of the seeds",
    )


def distances_normal(runs):
    """The smallest of the three faces' correlations with a normal law."""
    least, whole, true = (
        runs.normality(*of).min(axis=0)
        for of in (("published",), ("published", "qq_all"), ("true",))
    )
    return (
        least >= MIN_NORMALITY,
        least,
        "",
        f"least of the three faces, without those beyond {OUTLYING:g} robust "
        f"deviations; with them {middle(whole)}; by the true mirror {middle(true)}",
    )
