"""The claims of section 2.3, tested as the registry words them."""

import numpy as np

from chapters.ch02_general_camera_model.s3_general_camera.results import (
    line_fits,
    slope,
)
from chapters.shared.general_cameras import KINDS
from repro.judge.statistics import FAILS, HOLDS, UNDECIDED, median_interval
from repro.run.experiment import claim
from repro.run.outcomes import Reading

ROUNDING = 1e-12
RAY_ERROR = 1e-9
MIN_R2 = 0.98


@claim(
    "c2_pluecker_invariant", needs=("exp_c2_pluecker_invariant",), evidence="analytic"
)
def judge_pluecker_invariant(results):
    """Relative difference below 1e-12 over pairs of points of a line."""
    ran = results["exp_c2_pluecker_invariant"]
    difference = ran.column("difference").max()
    asymmetry = ran.column("asymmetry").max()
    return Reading.of(
        difference < ROUNDING and asymmetry < ROUNDING,
        float(difference),
        reason="largest difference of an entry, matrices at unit norm; "
        "a matrix plus its transpose, which is 0 if it is "
        f"antisymmetric, is at most {asymmetry:.1g}",
    )


@claim("c2_pluecker_origin", needs=("exp_c2_pluecker_origin",), evidence="analytic")
def judge_pluecker_origin(results):
    """Norm ratio below 1e-12 through the origin, above 0 otherwise."""
    ran = results["exp_c2_pluecker_origin"]
    through = ran.column("through_origin").max()
    beside = ran.column("beside_origin").min()
    nearest = ran.column("least_distance_m").min()
    return Reading.of(
        through < ROUNDING < beside,
        float(through),
        reason="norm of the last three entries over that of the "
        f"vector, lengths in m; at least {beside:.2g} for lines that pass "
        f"the origin at {1e3 * nearest:.2g} mm or more",
    )


@claim("c2_nonparam_any", needs=("exp_c2_nonparam_any",), evidence="analytic")
def judge_nonparametric(results):
    """Faceted mirror, two known grid poses: ray error below 1e-9."""
    faceted = results["exp_c2_nonparam_any"].one(camera="faceted")
    angle, gap, jump = (
        faceted.column(name).max() for name in ("angle_rad", "gap_mm", "jump_deg")
    )
    share = faceted.column("share").min()
    return Reading.of(
        angle < RAY_ERROR and gap < RAY_ERROR and share == 1,
        float(angle),
        unit="rad",
        reason=f"largest angle; the lines pass the mirror points at "
        f"{gap:.1g} mm; {100 * share:.0f} % of the rays, neighbours up "
        f"to {jump:.0f} deg apart",
    )


@claim("c2_two_pose_needs_T", needs=("fig_2_2_error",), evidence="synthetic")
def judge_two_pose_needs_motion(results):
    """The ray error grows linearly with the error of T_1, R2 >= 0.98.

    The line is fitted in each trial, in which the error of T_1 keeps its
    direction.
    """
    ran = results["fig_2_2_error"]
    fits = {kind: line_fits(ran, kind) for kind in KINDS}
    rising = all(slope(ran, kind) > 0 for kind in KINDS)
    worst = {kind: float(r2.min()) for kind, r2 in fits.items()}
    middle = median_interval(np.minimum(*fits.values()))
    decision = UNDECIDED
    if rising and min(worst.values()) >= MIN_R2:
        decision = HOLDS
    elif not rising or middle.high < MIN_R2:
        decision = FAILS
    return Reading.of(
        decision,
        middle,
        reason="R² of the straight line of a trial; lowest of all "
        "trials: " + ", ".join(f"{r2:.6f} ({kind})" for kind, r2 in worst.items()),
    )
