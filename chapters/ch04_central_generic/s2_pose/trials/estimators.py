"""The pose estimators that 4.2 compares, on one set of rays and points."""

import numpy as np

from raxel.calibration.pose.grid_pose import (
    grid_pose_ransac,
    linear_grid_pose,
    refine_pose_angular,
)
from raxel.calibration.pose.three_point import (
    pose_three_point_ransac,
    ray_errors,
    refine_pose_ray_point,
)
from raxel.errors import CalibrationError
from raxel.geometry import angle_between_rotations

ROUNDS = 20  # of re-estimation, as in `raxel.geometry.homography`
ESTIMATORS = ("three_points", "standard", "cgsp", "cgsp_ransac", "angular")
NAMES = {
    "three_points": "three points + RANSAC",
    "standard": "standard + RANSAC",
    "cgsp": "CGSP",
    "cgsp_ransac": "CGSP + RANSAC",
    "angular": "CGSP + RANSAC, angles refined",
}
# The standard method's pose by the question `standard_pose`.
STANDARD = {"refined": "standard", "as it comes out": "three_points"}


def all_estimates(directions, points, rng, threshold, metric="ray-point"):
    """Return {estimator: pose (4, 4), or the code of its error}.

    directions: (N, 3) rays of one origin; points: (N, 2); threshold: of both
    kinds of RANSAC, mm for metric "ray-point", radians for "angle". Refined
    estimators start from the unrefined ones.
    """
    given = directions, points
    ransac = *given, rng, threshold
    chains = (
        (
            ("three_points", "standard"),
            lambda: pose_three_point_ransac(*ransac, metric=metric),
            lambda found: by_distances(*given, found, threshold, metric),
        ),
        (("cgsp",), lambda: linear_grid_pose(*given)),
        (
            ("cgsp_ransac", "angular"),
            lambda: grid_pose_ransac(*ransac, metric=metric),
            lambda found: by_angles(*given, found),
        ),
    )
    out = {}
    for names, *steps in chains:
        found = None
        for name, step in zip(names, steps, strict=True):
            try:
                found = step() if found is None else step(found)
            except CalibrationError as error:
                out |= dict.fromkeys(names[names.index(name) :], error.code)
                break
            out[name] = found.T_camera_grid
    return out


def by_distances(directions, points, found, threshold, metric):
    """Return a pose with the ray-point distances (4.18) of its inliers minimised.

    Repeats until the inliers no longer change, as the linear re-estimation does.
    """
    T, right = found.T_camera_grid, found.inliers
    for _ in range(ROUNDS):
        T, _ = refine_pose_ray_point(directions[right], points[right], T)
        p = points @ T[:3, :2].T + T[:3, 3]
        now = ray_errors(directions, p[None], metric)[0] < threshold
        if np.array_equal(now, right) or np.count_nonzero(now) < 4:
            break
        right = now
    return found._replace(T_camera_grid=T, inliers=right)


def by_angles(directions, points, found):
    """Return a pose with the angles to its inliers minimised."""
    right = found.inliers
    return refine_pose_angular(directions[right], points[right], found.T_camera_grid)


def scored(found, true):
    """Return errors of a pose, or the reason why there is none."""
    if isinstance(found, str):
        return {"failed": found}
    return errors_of(found, true)


def errors_of(found, true):
    """Return the angle of R_true^-1 R (deg) and the translation error (mm)."""
    turn = angle_between_rotations(true[:3, :3], found[:3, :3])
    return {
        "rotation_deg": np.degrees(turn),
        "translation_mm": np.linalg.norm(found[:3, 3] - true[:3, 3]),
    }
