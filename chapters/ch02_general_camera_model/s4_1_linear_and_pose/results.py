"""Errors, counts and ranks of section 2.4, and the numbers that its page quotes."""

from collections import Counter

import numpy as np

from repro.page.reader import value


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    fisheye = open_results("alg_1_run").select(camera="fisheye")
    free = open_results("exp_c2_generic_no_motion")
    exact = open_results("exp_c2_linear_exact")
    triplets = open_results("exp_c2_pose_eight")
    paired = triplets.column("paired_share", anchors="distinct")
    agrees = triplets.column("grunert_agrees", anchors="common")
    found = {
        "locate_mm": fisheye.column("locate.median_mm")[0],
        "fisheye_deg": fisheye.column("table.median_deg")[0],
        "pose_mm": free.column("pose_mm").max(),
        "wrong_deg": np.median(free.column("two_pose_deg.wrong")),
        "scenes": exact.trials_per_condition,
        "negative": int(exact.column("printed_negative").sum()),
        "wrong_mm": np.nanmedian(exact.column("printed_depth_mm")),
        "triplets": triplets.trials_per_condition,
        "distinct_paired": np.count_nonzero(paired > 0),
        "grunert": int(agrees.sum()),
    }
    for name, number in found.items():
        value(name, number)


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
