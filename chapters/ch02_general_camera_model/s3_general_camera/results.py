"""Effect of an error of T_1 on the rays, from the results of section 2.3."""

import numpy as np

from chapters.ch02_general_camera_model.s3_general_camera.trials.known_motion import (
    LEVELS,
)
from repro.judge.statistics import weighted_line
from repro.page.reader import value


def line_fits(result, kind):
    """Return R2 of a straight line through the errors of each trial, (trials,)."""
    errors = np.stack(
        [result.column(f"ray_deg.{level:g}", kind=kind) for level in LEVELS], axis=1
    )
    weights = np.ones(len(LEVELS))
    return np.array([weighted_line(LEVELS, error, weights).r2 for error in errors])


def slope(result, kind):
    """Return the median ray error per unit of error of T_1 (deg per mm or deg)."""
    smallest = LEVELS[0]
    found = result.column(f"ray_deg.{smallest:g}", kind=kind)
    return float(np.median(found)) / smallest


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    wrong = open_results("fig_2_2_error")
    any_camera = open_results("exp_c2_nonparam_any")
    found = {
        "per_mm": np.median(wrong.column("ray_deg.1", kind="translation")),
        "per_deg": np.median(wrong.column("ray_deg.1", kind="rotation")),
        "jump_deg": any_camera.column("jump_deg", camera="faceted").max(),
    }
    for name, number in found.items():
        value(name, number)
