"""Both generic methods on the same decoded grids, by the protocol of 4.3.1.

The standard method adjusts the poses of three grids (centre kept) and places further
grids by three points and a refinement; CGSP leaves its linear stage as it is, and
places further grids linearly. Outliers are looked for once, and both get the same
points.
"""

import numpy as np

from chapters.shared.methods import LINEAR_STAGES
from raxel.calibration import (
    calibrate_central,
    grid_pose_ransac,
    linear_cgsp,
    pose_from_rays,
    relaxed_start,
)

LINEAR = 3  # grids of the linear stage
# weight: of the linear stage's points in the rays, against those of further grids;
# most: points that a further grid is placed by.
PROTOCOL = {"weight": 10.0, "most": 2000}
ADJUSTED = 2000  # rays that the poses are adjusted on
# The linear stages by what these trials call them.
SWEPT_METHODS = ("printed", "cgsp")  # along the sweep of the bench's noise
METHODS = {"printed": "as_printed", "conditioned": "well_conditioned", "cgsp": "cgsp"}


def without_outliers(points, rng):
    """points (n, N, 2) with NaN where three grids of the linear stage disagree.

    A grid's points that no homography relates to the base's are wrong ones.
    """
    first = points[:LINEAR]
    found = linear_cgsp(first, robust="ransac", rng=rng)
    shared = np.isfinite(first[0, :, 0]) & np.isfinite(first[..., 0])
    kept = points.copy()
    kept[:LINEAR][shared & ~found.inliers] = np.nan
    return kept


def by_protocol(points, method, rng):
    """The CentralCalibration of one of METHODS from points (n, N, 2).

    Raises CalibrationError where the linear stage gives nothing. As printed, it needs
    rays that see all three grids.
    """
    first = points[:LINEAR]
    seen = np.isfinite(first[..., 0]).all(axis=0)
    given = first[:, seen] if method == "printed" else first
    start = LINEAR_STAGES[METHODS[method]](given)
    if method == "cgsp":
        return calibrate_central(points, start, grid_pose_ransac, rng, **PROTOCOL)
    start = relaxed_start(first, start, ADJUSTED)
    return calibrate_central(points, start, pose_from_rays, rng, **PROTOCOL)
