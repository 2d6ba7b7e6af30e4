"""What the correction experiments left, by camera and method."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.trials.protocol import (
    STANDARD_METHODS,
)
from chapters.shared.central_sets import FISH, OMNI, RIGS
from repro.judge.statistics import with_worst
from repro.page.reader import value


def of_camera(result, camera, name):
    """Values (trials,) of one camera over all its conditions."""
    found = [
        result.column(name, **condition)
        for condition in result.conditions
        if condition["camera"] == camera
    ]
    return np.concatenate(found)


def ratio(result, camera, standard, name):
    """Standard over CGSP, (seeds,); a failed standard run counts as the worst."""
    over, under = (
        of_camera(result, camera, f"{method}.{name}") for method in (standard, "cgsp")
    )
    return with_worst(over) / under


def readings():
    """The options of the question which standard method, and its column."""
    return [
        ({"standard_method": option}, method)
        for option, method in STANDARD_METHODS.items()
    ]


def fields(result, camera, method):
    """Rows of the board that Fig. 4.9 draws, of the first seed, or None."""
    for condition in result.conditions:
        if condition["camera"] == camera:
            found = result.arrays(f"{method}.field", **condition)
            return found[0] if found else None
    return None


def name_values(open_results):
    """Name the numbers of the prose."""
    boards = open_results("fig_4_9_boards")
    lines = open_results("fig_4_7_lines")
    for camera in RIGS:
        short = "omni" if camera == OMNI else "fish"
        for method in ("printed", "conditioned", "cgsp"):
            mean = of_camera(boards, camera, f"{method}.mean_mm")
            value(f"{short}.{method}.mean", float(np.nanmedian(mean)))
            worst = of_camera(lines, camera, f"{method}.worst_share")
            value(f"{short}.{method}.worst", 100 * float(np.nanmedian(worst)))
        found = of_camera(boards, camera, "boards_found")
        value(f"{short}.boards", int(found.sum()))
    for method in ("printed", "cgsp"):
        beside = of_camera(boards, OMNI, f"{method}.seam_ratio")
        value(f"seam.{method}", float(np.nanmedian(beside)))
        skew = of_camera(boards, FISH, f"{method}.skew_spearman")
        value(f"skew.{method}", float(np.nanmedian(skew)))
        high = of_camera(lines, OMNI, f"{method}.vertical_deg")
        value(f"vertical.{method}", float(np.nanmedian(high)))
    value("trials", lines.trials_per_condition)
