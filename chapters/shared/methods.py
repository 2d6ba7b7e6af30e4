"""The methods that chapters 2 and 4 compare, and how they are scored."""

from __future__ import annotations

from functools import partial

from raxel.calibration import (
    linear_as_printed,
    linear_cgsp,
    linear_well_conditioned,
    pose_from_rays,
    pose_three_point_ransac,
)

METHODS = ("parametric", "generic_as_printed", "generic_well_conditioned")
# The linear stage that a generic method begins with.
LINEAR = {
    "generic_as_printed": "as printed",
    "generic_well_conditioned": "well conditioned",
}
NAMES = {
    "parametric": "standard perspective",
    "generic_as_printed": "central generic, as printed",
    "generic_well_conditioned": "central generic, well conditioned",
    "opencv_fisheye": "OpenCV fisheye",
    "exact": "exact rays",
}
# Scored on fresh noise of the same size, on the noise calibrated with, or
# without noise; in px of the corrected view, or of the source image.
SCORINGS = ("fresh", "noisy", "clean")
SCALES = ("corrected", "source")


def _as_printed(points, *, side):
    return linear_as_printed(*points, side=side, tz="corrected")


# Chapter 4's linear stages: points (3, N, 2) of rays that meet all grids and
# the side of C_z in; centre and T_base_grid out, or a CalibrationError.
# As printed, t_z is taken as corrected: the thesis's own centre [0 0 600]
# has C_y = 0, by which the printed form divides.
LINEAR_STAGES = {
    "standard as printed": _as_printed,
    "standard well conditioned": linear_well_conditioned,
    "CGSP": linear_cgsp,
    "CGSP circle": partial(linear_cgsp, pinhole="circle"),
}
# Both readings of the standard method's pose stage (2.4.2 and 4.2.2).
STANDARD_POSES = {
    "three points": pose_three_point_ransac,
    "three points, refined": pose_from_rays,
}
