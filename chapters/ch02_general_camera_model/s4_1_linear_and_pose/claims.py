"""The claims of sections 2.4, 2.4.1 and 2.4.2, tested as the registry words them."""

import numpy as np

from chapters.ch02_general_camera_model.s4_1_linear_and_pose.results import (
    counted,
    exact_errors,
    only_value,
)
from repro.judge.statistics import median_and_range
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value

RANK_A, RANK_D, MAX_SOLUTIONS = 12, 5, 8
NULL_ENTRY = 1e-6
EXACT_MM, EXACT_RAD = 1e-6, 1e-8
RECOVERED = 1e-6


@claim("c2_rank_A", needs=("exp_c2_rank_A",), evidence="analytic")
def judge_rank_a(results):
    """14 unknowns; numerical rank 12 in all seeds."""
    ran = results["exp_c2_rank_A"]
    ranks, columns = ran.column("rank"), ran.column("unknowns")
    return Reading.of(
        (ranks == RANK_A).all() and (columns == 14).all(),
        median_and_range(ranks),
        reason=f"{len(ranks)} scenes; smallest of the 12 singular "
        f"values {ran.column('smallest').min():.2g} of the largest",
    )


@claim("c2_rank_D", needs=("exp_c2_rank_D",), evidence="analytic")
def judge_rank_d(results):
    """Rank 5; null vectors vanish on l1, l2 and the lambda terms."""
    ran = results["exp_c2_rank_D"]
    ranks = ran.column("orthonormal.rank")
    entry = ran.column("orthonormal.null_entry").max()
    other = ran.column("any.null_entry").max()
    return Reading.of(
        (ranks == RANK_D).all() and entry < NULL_ENTRY,
        median_and_range(ranks),
        reason=f"largest null-vector entry on l1, l2, lambda terms "
        f"{entry:.1g}; {other:.1g} with bases that are not orthonormal",
    )


@claim("c2_linear_exact", needs=("exp_c2_linear_exact",), evidence="analytic")
def judge_linear_exact(results):
    """1e-6 mm and 1e-8 rad corrected; the printed C_z must fail."""
    ran = results["exp_c2_linear_exact"]
    found = {
        form: exact_errors(ran, form) for form in ("corrected", "well_conditioned")
    }
    lengths = max(found["corrected"]["centre_mm"], found["corrected"]["translation_mm"])
    printed = np.nan_to_num(ran.column("printed_depth_mm"), nan=np.inf)
    negative = int(ran.column("printed_negative").sum())
    exact = lengths < EXACT_MM and found["corrected"]["rotation_rad"] < EXACT_RAD
    other = max(
        found["well_conditioned"][name] for name in ("centre_mm", "translation_mm")
    )
    return Reading.of(
        exact and printed.min() > EXACT_MM,
        lengths,
        unit="mm",
        reason="largest error of centre and translations, corrected "
        f"(rotations {found['corrected']['rotation_rad']:.1g} rad); "
        f"well conditioned {other:.1g} mm. The printed C_z² is "
        f"negative in {negative} of {len(printed)} scenes and "
        f"otherwise wrong by at least {printed.min():.2g} mm",
    )


@claim("c2_pose_eight", needs=("exp_c2_pose_eight",), evidence="analytic")
def judge_pose_eight(results):
    """At most eight real solutions, closed under negation of the depths."""
    ran = results["exp_c2_pose_eight"]
    number = ran.column("solutions", anchors="common")
    paired = ran.column("paired_share", anchors="common")
    distinct = ran.column("paired_share", anchors="distinct")
    return Reading.of(
        number.max() <= MAX_SOLUTIONS and (paired == 1).all(),
        float(number.max()),
        unit="solutions",
        reason=f"triplets by number of solutions: "
        f"{counted(ran, 'common')}; all in pairs of opposite sign in "
        f"{int((paired == 1).sum())} of {len(paired)} triplets. With "
        f"distinct anchors {counted(ran, 'distinct')}, and a pair in "
        f"{int((distinct > 0).sum())} of {len(distinct)} (E-2.15)",
    )


@claim("c2_generic_no_motion", needs=("exp_c2_generic_no_motion",), evidence="analytic")
def judge_generic_no_motion(results):
    """T_1, T_2 to 1e-6 without noise; a wrong T_1 leaves a ray error."""
    ran = results["exp_c2_generic_no_motion"]
    lengths = np.nan_to_num(ran.column("pose_mm"), nan=np.inf).max()
    angle = np.nan_to_num(ran.column("pose_rad"), nan=np.inf).max()
    right = ran.column("two_pose_deg.right").max()
    wrong = ran.column("two_pose_deg.wrong")
    return Reading.of(
        max(lengths, angle) < RECOVERED and wrong.min() > max(1e-6, 10 * right),
        float(lengths),
        unit="mm",
        reason=f"largest error of a translation; of a rotation "
        f"{angle:.1g} rad. Two-pose method: median ray error "
        f"{np.median(wrong):.2g} deg (at least {wrong.min():.2g}) with "
        f"T_1 wrong by 1 mm, {right:.1g} deg with the right one",
    )


@numbers("sec_2_4_1", needs=("exp_c2_rank_A", "exp_c2_rank_D"), evidence="analytic")
def values_of_ranks(results):
    """Ranks of A and D, the same in every scene or not given at all."""
    return {
        "s2_4_1_rankA": Value(only_value(results["exp_c2_rank_A"], "rank")),
        "s2_4_1_rankD": Value(only_value(results["exp_c2_rank_D"], "orthonormal.rank")),
    }


@numbers("sec_2_4_2", needs=("exp_c2_pose_eight",), evidence="analytic")
def values_of_solutions(results):
    """The largest number of real solutions that any triplet had."""
    found = results["exp_c2_pose_eight"].column("solutions", anchors="common")
    return {"s2_4_2_solutions": Value(float(found.max()))}
