"""The claims of section 2.5.2 about rendered counterparts of real pictures.

A claim about seeds holds if it is true in 90 % of them, as the ledger says. A
seed in which a method failed counts against that method.
"""

from __future__ import annotations

import numpy as np

from chapters.shared.zoom_readings import (
    generic_wins,
    judged,
    share_of,
)
from chapters.shared.zoom_scores import QUINTILES
from chapters.shared.zoom_shots import (
    STAGE_ZOOM,
    ZOOMS,
)
from repro.judge.statistics import (
    FAILS,
    HOLDS,
    all_of,
    bootstrap,
    median_interval,
    with_worst,
)
from repro.run.experiment import claim
from repro.run.outcomes import DECISIONS, Reading

SHARE = 0.9
FLAT = 1.25
WORSE = 1.3
NO_BIAS = 0.25
BIAS_P = MORAN_P = 0.01
CENTRE_GAIN = 0.8
RESIDUAL = (
    "standard_method",
    "residual_image",
    "residual_scale",
    "residual_statistic",
)
FIELD = ("standard_method", "residual_image", "residual_scale")


def in_seeds(holds):
    """Decision, share and words of a predicate over the seeds, (n,) bool."""
    share = float(np.mean(holds))
    decision = HOLDS if share >= SHARE else FAILS
    words = share_of(int(np.count_nonzero(holds)), len(holds))
    return decision, share, None, words


def spread_of_medians(*trials):
    """Largest over smallest of the medians along the last axis."""
    medians = [np.median(t, axis=-1) for t in trials]
    return np.max(medians, axis=0) / np.min(medians, axis=0)


@claim(
    "c2_t22_generic_flat", needs=("table_2_2_redrawn",), evidence="rendered"
)
def judge_generic_flat(results):
    """Largest over smallest generic residual of the three sets: <= 1.25."""

    def judge(case):
        trials = [with_worst(t) for t in case.residuals("generic")]
        spread = bootstrap(spread_of_medians, *trials)
        return (
            spread.below(FLAT + 1e-12),
            spread.value,
            (spread.low, spread.high),
            "largest over smallest of three medians",
        )

    return judged(results["table_2_2_redrawn"], RESIDUAL, judge)


@claim(
    "c2_t22_persp_set3", needs=("table_2_2_redrawn",), evidence="rendered"
)
def judge_parametric_worse(results):
    """Set 3: parametric residual above 1.3 times the generic one."""

    def judge(case):
        parametric = with_worst(case.residual("parametric", 3))
        generic = case.residual("generic", 3)
        holds = np.isfinite(generic) & (parametric > WORSE * generic)
        decision, share, _, words = in_seeds(holds)
        ratio = np.median(parametric) / np.median(with_worst(generic))
        return (
            decision,
            share,
            None,
            f"{words}; ratio of medians {ratio:.2f}",
        )

    return judged(results["table_2_2_redrawn"], RESIDUAL, judge)


def quintiles(case, name):
    """Means, p-values (quintiles, seeds) and RMS (seeds,) of set 3."""

    def column(value):
        place = f"{case.images}.radial.{case.scale}.{value}"
        return case.of(name, place, STAGE_ZOOM)

    numbers = range(1, QUINTILES + 1)
    means = np.stack([column(f"q{n}.mean_px") for n in numbers])
    p = np.stack([column(f"q{n}.p") for n in numbers])
    return means, p, column("rms_px")


@claim(
    "c2_persp_radial_bias",
    needs=("table_2_2_redrawn",),
    evidence="rendered",
)
def judge_radial_bias(results):
    """Opposite radial residuals in the second (or first) and last fifth."""

    def judge(case):
        means, p, _ = quintiles(case, "parametric")
        sure = p < BIAS_P
        inner = [
            sure[n] & (means[n] * means[-1] < 0) & sure[-1] for n in (0, 1)
        ]
        decision, share, _, words = in_seeds(inner[0] | inner[1])
        medians = ", ".join(f"{m:+.2f}" for m in np.nanmedian(means, 1))
        return (
            decision,
            share,
            None,
            f"{words}; median of the fifths {medians} px, outwards positive",
        )

    questions = ("residual_image", "residual_scale")
    return judged(results["table_2_2_redrawn"], questions, judge)


@claim(
    "c2_generic_no_radial_bias",
    needs=("table_2_2_redrawn",),
    evidence="rendered",
)
def judge_no_radial_bias(results):
    """Generic: radial residual at most a quarter of the RMS in every fifth."""

    def judge(case):
        means, _, rms = quintiles(case, "generic")
        largest = np.max(np.abs(means), axis=0) / rms
        decision, share, _, words = in_seeds(largest <= NO_BIAS)
        return (
            decision,
            share,
            None,
            f"{words}; largest fifth, median {np.nanmedian(largest):.2f} of "
            "the RMS",
        )

    return judged(results["table_2_2_redrawn"], FIELD, judge)


@claim(
    "c2_generic_systematic",
    needs=("table_2_2_redrawn", "fig_2_5_true_centre"),
    evidence="rendered",
)
def judge_systematic(results):
    """Neighbours correlate, and the true centre lowers the RMS by a fifth."""

    def judge(case):
        p = case.of("generic", f"moran.{case.scale}.p", STAGE_ZOOM)
        related, _, _, words = in_seeds(p < MORAN_P)
        centre = results["fig_2_5_true_centre"]
        place = f"{case.option('standard_method')}.{case.scale}"
        ratio = median_interval(centre.column(f"{place}.ratio"))
        return (
            all_of([related, ratio.below(CENTRE_GAIN + 1e-12)]),
            ratio.value,
            (ratio.low, ratio.high),
            "RMS with the true centre over RMS with the estimated one, "
            f"{ratio.failed} failed trials as the worst; Moran's I "
            f"significant in {words}",
        )

    questions = ("standard_method", "residual_scale")
    return judged(results["table_2_2_redrawn"], questions, judge)


@claim("c2_motion", needs=("table_2_2_redrawn",), evidence="rendered")
def judge_motion(results):
    """The steps scatter less about their mean with the generic method."""

    def judge(case):
        quantity = f"stage.{case.option('step_frame')}.deviation_mm"
        parametric = case.of("parametric", quantity, STAGE_ZOOM)
        generic = case.of("generic", quantity, STAGE_ZOOM)
        return generic_wins(generic, parametric, "RMS deviation")

    questions = ("standard_method", "step_frame")
    return judged(results["table_2_2_redrawn"], questions, judge)


@claim(
    "c2_homography_harmless",
    needs=("exp_c2_homography_harmless",),
    evidence="analytic",
)
def judge_homography(results):
    """A homography leaves nothing without distortion, and something with."""
    ran = results["exp_c2_homography_harmless"]
    clean = ran.column("without_px").max()
    distorted = ran.column("with_px").min()
    # Rounding of the same fit on distortion-free points is what `> 0` is above.
    holds = clean < 1e-8 and distorted > 1e3 * max(clean, 1e-12)
    return [
        Reading(
            DECISIONS[HOLDS if holds else FAILS],
            f"{clean:.1g} px without, at least {distorted:.2g} px with "
            "radial distortion",
            reason="largest and smallest RMS over random planes",
        )
    ]


def zoom_slope(levels, *trials):
    """Slope of log median residual on distortion level."""
    logs = np.log(np.stack([np.median(t, axis=-1) for t in trials], -1))
    centred = levels - levels.mean()
    return np.sum(logs * centred, axis=-1) / np.sum(centred**2)


def rendered_slopes(case):
    """Slopes of both methods over the three sets, with intervals."""
    levels = np.array(
        [
            np.median(case.result.column("distortion_level", zoom=zoom))
            for zoom in ZOOMS
        ]
    )
    return [
        bootstrap(
            lambda *t: zoom_slope(levels, *t),
            *(with_worst(t) for t in case.residuals(name)),
        )
        for name in ("parametric", "generic")
    ]
