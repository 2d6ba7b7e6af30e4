"""Errors, counts and ranks of section 2.4, and the numbers that its page quotes."""

from collections import Counter

import numpy as np

from repro.page.reader import value


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    of_run(open_results("alg_1_run"))
    of_motion(open_results("exp_c2_generic_no_motion"))
    of_exactness(open_results("exp_c2_linear_exact"))
    of_triplets(open_results("exp_c2_pose_eight"))


def of_run(run):
    """What the fisheye's run of Algorithm 1 leaves."""
    fisheye = {"camera": "fisheye"}
    value("locate_mm", run.column("locate.median_mm", **fisheye)[0])
    value("fisheye_deg", run.column("table.median_deg", **fisheye)[0])


def of_motion(free):
    """Poses without a stage, and rays with a wrong one."""
    value("pose_mm", free.column("pose_mm").max())
    value("wrong_deg", float(np.median(free.column("two_pose_deg.wrong"))))


def of_exactness(exact):
    """Errors of the linear stage, corrected and as printed."""
    value("scenes", exact.trials_per_condition)
    value("negative", int(exact.column("printed_negative").sum()))
    value("wrong_mm", float(np.nanmedian(exact.column("printed_depth_mm"))))


def of_triplets(triplets):
    """How many solutions three points have."""
    value("triplets", triplets.trials_per_condition)
    paired = triplets.column("paired_share", anchors="distinct")
    value("distinct_paired", int((paired > 0).sum()))
    value("grunert", int(triplets.column("grunert_agrees", anchors="common").sum()))


def exact_errors(result, form):
    """Largest errors over trials: centre and translation (mm), rotation.

    A trial that gave nothing counts as an infinite error.
    """
    return {
        name: float(np.nan_to_num(result.column(f"{form}.{name}"), nan=np.inf).max())
        for name in ("centre_mm", "translation_mm", "rotation_rad")
    }


def counted(result, anchors):
    """How often each number of real solutions came out, in words."""
    found = Counter(result.column("solutions", anchors=anchors).astype(int))
    return ", ".join(f"{n}: {found[n]}" for n in sorted(found))


def only_value(result, name):
    """The one value that all trials have; what they have, where they differ."""
    found = sorted(set(result.column(name)))
    if len(found) == 1:
        return float(found[0])
    return " or ".join(f"{value:g}" for value in found)
