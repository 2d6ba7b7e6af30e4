"""What the correction experiments left, what claims ask of it, and the prose.

A predicate takes the `Corrected` trials of a reading and returns whether it is true
(trials,), what was measured (trials,), its unit, and words.
"""

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.trials.protocol import METHODS
from chapters.shared.bench_noise import BENCH, OPTIONS
from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.methods import LINEAR_NAMES
from repro.judge.statistics import with_worst
from repro.page.reader import value
from repro.run.readings import Case

BOARDS, LINES = "fig_4_9_boards", "fig_4_7_lines"
NAMES = {method: LINEAR_NAMES[stage] for method, stage in METHODS.items()}
READINGS = {
    "decoding_noise": OPTIONS,
    "standard_method": {"as printed": "printed", "well conditioned": "conditioned"},
}


class Corrected(Case):
    """Trials of one experiment in one reading, at the noise that trials call so."""

    def __init__(self, result, options=None, noise=BENCH):
        super().__init__(READINGS, options)
        self.result, self.noise = result, noise

    def of(self, camera, name):
        """A value of every trial of a camera, (trials,)."""
        return self.result.select(camera=camera).column(f"{self.noise}.{name}")

    def both(self, camera, name):
        """A value of the standard method and of CGSP, (2, trials)."""
        methods = self["standard_method"], "cgsp"
        return np.array([self.of(camera, f"{m}.{name}") for m in methods])

    def ratio(self, camera, name):
        """Standard over CGSP, (trials,); a failed standard run counts as the worst."""
        standard, cgsp = self.both(camera, name)
        return with_worst(standard) / cgsp


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


def name_values(open_results):
    """Name the numbers of the prose: medians of the trials that have a value."""
    boards, lines = open_results(BOARDS), open_results(LINES)
    wanted = [
        *(
            (f"{short}.{method}.{name}", result, camera, f"{method}.{key}")
            for short, camera in (("omni", OMNI), ("fish", FISH))
            for method in NAMES
            for name, result, key in (
                ("mean", boards, "mean_mm"),
                ("worst", lines, "worst_share"),
            )
        ),
        *(
            (f"{name}.{method}", result, camera, f"{method}.{key}")
            for name, result, camera, key in (
                ("seam", boards, OMNI, "seam_ratio"),
                ("skew", boards, FISH, "skew_spearman"),
                ("vertical", lines, OMNI, "vertical_deg"),
            )
            for method in ("printed", "cgsp")
        ),
    ]
    found = {
        "omni.boards": int(boards.select(camera=OMNI).column("boards_found").sum()),
        "fish.boards": int(boards.select(camera=FISH).column("boards_found").sum()),
        "trials": lines.trials_per_condition,
    }
    for name, result, camera, key in wanted:
        percent = 100 if name.endswith(".worst") else 1
        for prefix, noise in (("", BENCH), ("lab.", "laboratory")):
            trials = Corrected(result, noise=noise).of(camera, key)
            found[prefix + name] = percent * np.nanmedian(trials)
    for name, number in found.items():
        value(name, number)
