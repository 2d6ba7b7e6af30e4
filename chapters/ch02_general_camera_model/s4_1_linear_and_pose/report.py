"""Results of this page read: values of the prose, figures, tables, judgements."""

from collections import Counter

import numpy as np

from repro.page import value
from repro.run import (
    Check,
    Reading,
    Table,
    Value,
    claim,
    median_and_range,
    numbers,
    table,
    with_worst,
)

# Errors, counts and ranks of section 2.4, and the numbers its page quotes.


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    fisheye = open_results("alg_1_run").select(camera="fisheye")
    free = open_results("exp_c2_generic_no_motion")
    exact = open_results("exp_c2_linear_exact")
    found = {
        "locate_mm": fisheye.column("locate", "median_mm")[0],
        "fisheye_deg": fisheye.column("table", "median_deg")[0],
        "pose_mm": free.column("pose_mm").max(),
        "wrong_deg": np.median(free.column("two_pose_deg", "wrong")),
        "scenes": exact.trials_per_condition,
        "negative": int(exact.column("printed_negative").sum()),
    }
    for name, number in found.items():
        value(name, number)


def exact_errors(result, form):
    """Return the largest errors over trials: centre, translation (mm), rotation.

    A failed trial counts as an infinite error.
    """
    names = ("centre_mm", "translation_mm", "rotation_rad")
    return with_worst(result.column(form, names)).max(axis=1)


def counted(result, anchors):
    """Return how often each number of real solutions occurs, in words."""
    found = Counter(result.column("solutions", anchors=anchors).astype(int))
    return ", ".join(f"{n}: {found[n]}" for n in sorted(found))


def only_value(result, *path):
    """Return the value that all trials share, or all values, where they differ."""
    found = sorted(set(result.column(*path)))
    if len(found) == 1:
        return float(found[0])
    return " or ".join(f"{value:g}" for value in found)


# Algorithm 1 with the outcome of its steps, and the linear stage without noise.


EXACT_DEG = 1e-6
STEPS = (
    (
        "image the grid in three or more overlapping poses, and in more "
        "poses to cover the field of view",
        "BoardView",
    ),
    ("find the location on each grid that each pixel sees", "locate_pixels"),
    ("estimate the poses, and the centre, linearly", "linear_well_conditioned"),
    ("bundle adjust poses and rays", "bundle_adjust_fixed_centre"),
    (
        "pose of each further grid, then its rays; bundle adjust",
        "pose_from_rays, bundle_adjust_fixed_centre",
    ),
    ("store the rays as Plücker matrices", "GeneralCamera.pluecker"),
)


def outcomes(ran, camera):
    """Return the outcome of the six steps for one camera, in words."""

    def found(*path):
        return float(ran.column(*path, camera=camera)[0])

    return [
        f"{found('overlap', 'boards'):.0f} boards; "
        f"{100 * found('overlap', 'one'):.0f} % of the pixels on one or more, "
        f"{100 * found('overlap', 'three'):.0f} % on three or more",
        f"{found('locate', 'pixels'):.0f} locations, median error "
        f"{found('locate', 'median_mm'):.1g} mm",
        "three boards; largest error of a position "
        f"{found('linear', 'pose_mm'):.1g} mm",
        f"ray-point distance (RMS) from {found('bundle', 'start_mm'):.3g} to "
        f"{found('bundle', 'end_mm'):.3g} mm; largest error of a position "
        f"{found('bundle', 'pose_mm'):.1g} mm",
        f"{found('others', 'boards'):.0f} more boards, "
        f"{found('others', 'left_out'):.0f} excluded; largest error of a "
        f"position {found('others', 'pose_mm'):.1g} mm",
        f"{found('table', 'matrices'):.0f} matrices, "
        f"{100 * found('table', 'share'):.0f} % of the pixels; median ray "
        f"error {found('table', 'median_deg'):.1g}°",
    ]


@table("alg_1", needs=("alg_1_run",), evidence="synthetic")
def alg_1(results):
    """Tabulate Algorithm 1 and check that the run reproduces the rays."""
    ran = results["alg_1_run"]
    exact = ran.column("table", "largest_deg", camera="pinhole")[0]
    fisheye = ran.one(camera="fisheye")
    median, pixel = fisheye.column("table", ("median_deg", "pixel_deg"))[:, 0]
    return Table(
        {
            "Step": list(range(1, 7)),
            "What": [what for what, _ in STEPS],
            "raxel": [f"`{name}`" for _, name in STEPS],
            "Pinhole": outcomes(ran, "pinhole"),
            "Fisheye": outcomes(ran, "fisheye"),
        },
        "Standard generic calibration: the six steps, the library function of "
        "each, and its outcome in one run without noise.",
        Check(
            bool(exact < EXACT_DEG and median < pixel / 2),
            f"the rays of the pinhole are reproduced to {exact:.1g}° "
            f"(all), those of the fisheye to {median:.2g}° (median), less "
            f"than half a pixel of {pixel:.2g}°",
        ),
    )


# The claims of sections 2.4, 2.4.1 and 2.4.2, tested as the registry words them.


RANK_A, RANK_D, MAX_SOLUTIONS = 12, 5, 8
NULL_ENTRY = 1e-6
EXACT_MM, EXACT_RAD = 1e-6, 1e-8
RECOVERED = 1e-6


@claim("c2_rank_A", needs=("exp_c2_rank_A",), evidence="analytic")
def judge_rank_a(results):
    """14 unknowns; numerical rank 12 in all scenes."""
    ran = results["exp_c2_rank_A"]
    ranks, unknowns = ran.column(("rank", "unknowns"))
    return Reading.of(
        (ranks == RANK_A).all() and (unknowns == 14).all(),
        median_and_range(ranks),
        reason=f"{len(ranks)} scenes; smallest of the 12 singular "
        f"values {ran.column('smallest').min():.2g} of the largest",
    )


@claim("c2_rank_D", needs=("exp_c2_rank_D",), evidence="analytic")
def judge_rank_d(results):
    """Rank 5; null vectors vanish on l1, l2 and the lambda terms."""
    ran = results["exp_c2_rank_D"]
    ranks = ran.column("orthonormal", "rank")
    entry, other = ran.column(("orthonormal", "any"), "null_entry").max(axis=1)
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
    centre, translation, rotation = exact_errors(ran, "corrected")
    lengths = float(max(centre, translation))
    printed = with_worst(ran.column("printed_depth_mm"))
    negative = int(ran.column("printed_negative").sum())
    exact = lengths < EXACT_MM and rotation < EXACT_RAD
    other = max(exact_errors(ran, "well_conditioned")[:2])
    return Reading.of(
        exact and printed.min() > EXACT_MM,
        lengths,
        unit="mm",
        reason="largest error of centre and translations, corrected "
        f"(rotations {rotation:.1g} rad); "
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
    lengths, angle = with_worst(ran.column(("pose_mm", "pose_rad"))).max(axis=1)
    right = ran.column("two_pose_deg", "right").max()
    wrong = ran.column("two_pose_deg", "wrong")
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
        "s2_4_1_rankD": Value(
            only_value(results["exp_c2_rank_D"], "orthonormal", "rank")
        ),
    }


@numbers("sec_2_4_2", needs=("exp_c2_pose_eight",), evidence="analytic")
def values_of_solutions(results):
    """The largest number of real solutions that any triplet had."""
    found = results["exp_c2_pose_eight"].column("solutions", anchors="common")
    return {"s2_4_2_solutions": Value(float(found.max()))}
