"""What the claims about the tin say of one seed, and what is measured there.

Each takes the `TinRuns` of a bench and gives whether it is true (seeds,), what was
measured (seeds,), its unit, and words. A seed that was rejected has no value.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.trials.faces import OUTLYING

MOST_OFF_DEG = 2.5
LEAST_NORMAL = 0.99


def middle(values):
    """Median of the seeds that have a value, as words: "nothing" without any."""
    known = values[np.isfinite(values)]
    return f"{np.median(known):.3g}" if len(known) else "nothing"


def angles_found(runs):
    """The largest difference of the three angles from the reference."""
    off = runs.off()
    most = np.abs(off).max(axis=0)
    below = np.mean(np.all(off < 0, axis=0))
    return (
        most <= MOST_OFF_DEG,
        most,
        "deg",
        "largest difference of the three; by the true mirror "
        f"{middle(runs.of('off_deg', 'true'))} degrees; all three below the reference "
        f"in {100 * below:.0f} % of the seeds",
    )


def distances_normal(runs):
    """The least of the three faces' correlations with a normal law."""
    least, whole, true = (
        runs.normality(*of).min(axis=0)
        for of in (("published",), ("published", "qq_all"), ("true",))
    )
    return (
        least >= LEAST_NORMAL,
        least,
        "",
        f"least of the three faces, without those beyond {OUTLYING:g} robust "
        f"deviations; with them {middle(whole)}; by the true mirror {middle(true)}",
    )
