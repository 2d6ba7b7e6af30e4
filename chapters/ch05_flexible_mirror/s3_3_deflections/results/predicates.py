"""Predicates of the claims about three deflections, run by run.

Each takes the `Runs` at an error level and returns whether the claim is true (seeds,),
the measured value (seeds,), its unit, and words. A run that was rejected before the
last stage that the claim uses has no value.
"""

import numpy as np
from scipy.stats import chi2_contingency

from chapters.ch05_flexible_mirror.s3_3_deflections.results.runs import (
    LAST,
    SHIFT_MM,
    STAGES,
    STEP_MM,
    of_strips,
    strip_means,
)

MAX_SHIFT_ERROR_MM, MAX_TURN_DEG = 1.5, 0.4
MAX_ERROR = 10.0  # %, of a deflection
MAX_ANGLE_RATIO, MAX_REST = 1.5, 0.25
SIGNIFICANT = 0.01
TOP = 0.9  # quantile of the errors above which they are largest


def middle(values):
    """Median of the runs that have a value, as words: "nothing" without any."""
    known = values[np.isfinite(values)]
    return f"{np.median(known):.3g}" if len(known) else "nothing"


def by_stage(values):
    """Medians (stages,) of the runs that have a value, as words."""
    return ", ".join(middle(of_stage) for of_stage in values)


def travel(runs, name):
    """Estimated travel of the monitor (stages, seeds)."""
    return np.array([runs.raw(f"stage{stage}.{name}") for stage in STAGES])


def pose_reflection(runs):
    """Test that the monitor travels 100 mm without rotation, at all four stages.

    Its poses do not depend on the flexible mirror: rejected runs have them too.
    """
    off = np.abs(travel(runs, "shift_mm") - SHIFT_MM)
    turn = travel(runs, "turn_deg")
    return (
        np.all((off <= MAX_SHIFT_ERROR_MM) & (turn <= MAX_TURN_DEG), axis=0),
        off.max(axis=0),
        "mm",
        "largest error of the shift at stages 0 to 3; largest turn "
        f"{middle(turn.max(axis=0))} degrees",
    )


def deflection_errors(runs):
    """Errors (3, seeds) of the final deflections, %."""
    return 100 * (runs.at("deflection_mm") / STEP_MM - 1)


def deflections_found(runs):
    """Test that every final deflection is within 10 % of the actual one."""
    off = deflection_errors(runs)
    return (
        np.all(np.abs(off) <= MAX_ERROR, axis=0),
        np.abs(off).max(axis=0),
        "%",
        f"largest error of the three stages; by stage {by_stage(off)} %",
    )


def below_final(runs):
    """Difference of linear estimates from the final ones, % of these (3, seeds)."""
    return 100 * (1 - runs.at("linear_mm") / runs.at("deflection_mm"))


def angles_not_worse(runs):
    """Test that angles to measured rays hardly grow from stage 0 to stage 3."""
    measured = runs.of(LAST, "measured_deg") / runs.of(0, runs["primary_grids"])
    true = runs.of(LAST, "angle_deg") / runs.of(0, "angle_deg")
    return (
        measured <= MAX_ANGLE_RATIO,
        measured,
        "",
        f"stage 3 over stage 0, to measured rays; to the true rays {middle(true)}",
    )


def angles_by_place(runs):
    """Mean angles of the clamped strip, of all and of the free strips.

    (3, stages, seeds), degrees, to the true rays.
    """
    stages = [
        runs.each(stage, ("off_deg", "sheet"), strip_means, 3) for stage in STAGES
    ]
    return np.stack(stages, axis=1)


def angles_spatial(runs):
    """Test that angles are smallest at the clamp and largest at the free edges."""
    clamped, whole, free = angles_by_place(runs)
    ordered = (clamped < whole) & (whole < free)
    shares = ", ".join(f"{100 * share:.0f}" for share in ordered.mean(axis=1))
    return (
        ordered.all(axis=0),
        (free / clamped).mean(axis=0),
        "",
        "free over clamped, mean of four stages; so ordered in "
        f"{shares} % of the seeds at stages 0 to 3",
    )


def dynamic_removes(runs):
    """Test that calibration leaves at most a quarter of the error of stage 3."""
    left = runs.at("back_mm") / runs.at("stale_mm")
    true = runs.of(LAST, "back_true_mm") / runs.of(LAST, "stale_mm")
    return (
        left[-1] <= MAX_REST,
        left[-1],
        "",
        f"error after over before, at stage 3; stages 1 to 3 {by_stage(left)}; with "
        f"the board's true pose after it {middle(true)}",
    )


def edge_excess(own, sheet):
    """Excess of the largest tenth of errors at free edges, and its p-value.

    own: (N, 2) mm; sheet: (N, 2) positions. The share of free edges in that tenth over
    the share among the others, and p of a chi-squared test; p is 1 where nothing
    differs.
    """
    size = np.linalg.norm(own, axis=1)
    known = np.isfinite(size)
    size, free = size[known], of_strips(sheet[known])[1]
    top = size > np.quantile(size, TOP)
    counts = np.array(
        [
            [np.count_nonzero(a & b) for b in (free, ~free)]
            for a in (top, ~top)
        ]
    )  # fmt: skip
    if not counts.sum(axis=0).all():
        return 1.0, 1.0
    share, others = counts[:, 0] / counts.sum(axis=1)
    ratio = share / others if others else np.inf
    return ratio, float(chi2_contingency(counts, correction=False).pvalue)


def edge_residuals(runs):
    """Test that the largest tenth of errors of stage 3 is at free edges more often."""
    excess, p = runs.each(LAST, ("own", "seen_at"), edge_excess, 2)
    return (
        (excess > 1) & (p < SIGNIFICANT),
        excess,
        "",
        "share of free edges among the largest tenth over that among the others; "
        f"median p {middle(p)}",
    )


def linear_ratios(runs):
    """Linear over actual deflection (3, seeds)."""
    return runs.linear() / STEP_MM


# Claims that are judged run by run.
BY_SEED = {
    "c5_deflection_8pct": deflections_found,
    "c5_angles_not_worse": angles_not_worse,
    "c5_angles_spatial": angles_spatial,
    "c5_dynamic_removes": dynamic_removes,
    "c5_edge_residuals": edge_residuals,
}
