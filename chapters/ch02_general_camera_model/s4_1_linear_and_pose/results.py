"""Errors, counts and ranks of section 2.4, and the numbers its page quotes."""

from collections import Counter

import numpy as np

from repro.page.reader import value


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    fisheye = open_results("alg_1_run").select(camera="fisheye")
    free = open_results("exp_c2_generic_no_motion")
    exact = open_results("exp_c2_linear_exact")
    found = {
        "locate_mm": fisheye.column("locate.median_mm")[0],
        "fisheye_deg": fisheye.column("table.median_deg")[0],
        "pose_mm": free.column("pose_mm").max(),
        "wrong_deg": np.median(free.column("two_pose_deg.wrong")),
        "scenes": exact.trials_per_condition,
        "negative": int(exact.column("printed_negative").sum()),
    }
    for name, number in found.items():
        value(name, number)


def exact_errors(result, form):
    """Return the largest errors over trials: centre, translation (mm), rotation.

    A failed trial counts as an infinite error.
    """
    return {
        name: float(np.nan_to_num(result.column(f"{form}.{name}"), nan=np.inf).max())
        for name in ("centre_mm", "translation_mm", "rotation_rad")
    }


def counted(result, anchors):
    """Return how often each number of real solutions occurs, in words."""
    found = Counter(result.column("solutions", anchors=anchors).astype(int))
    return ", ".join(f"{n}: {found[n]}" for n in sorted(found))


def only_value(result, name):
    """Return the value that all trials share, or all values, where they differ."""
    found = sorted(set(result.column(name)))
    if len(found) == 1:
        return float(found[0])
    return " or ".join(f"{value:g}" for value in found)
