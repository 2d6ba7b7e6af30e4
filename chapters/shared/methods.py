"""The methods that chapters 2 and 4 compare, and how they are scored."""

from raxel.calibration import linear_as_printed, linear_cgsp, linear_well_conditioned

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


def as_printed(points, *, side=-1):
    """The standard linear stage as the thesis prints it, with t_z as corrected.

    The printed form of t_z divides by C_y, which is 0 for the thesis's own centre
    [0 0 600].
    """
    return linear_as_printed(*points, side=side, tz="corrected")


# The linear stages of chapter 4, by what trials call them: points (n, N, 2) of rays
# that meet all grids and the side of C_z in; centre and T_base_grid out, or a
# CalibrationError.
LINEAR_STAGES = {
    "as_printed": as_printed,
    "well_conditioned": linear_well_conditioned,
    "cgsp": linear_cgsp,
}
LINEAR_NAMES = {
    "as_printed": "standard, as printed",
    "well_conditioned": "standard, well conditioned",
    "cgsp": "CGSP",
}
# The linear stages of chapter 2, of points (3, N, 2). As printed, t_z divides by C_y
# (2.23).
STARTS = {
    "as printed": lambda points: linear_as_printed(*points),
    "well conditioned": linear_well_conditioned,
}
# Options of the ledger's question `standard_method`.
STANDARD_METHODS = {"as printed": "as_printed", "well conditioned": "well_conditioned"}
