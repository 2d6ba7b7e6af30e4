"""Motion of a cylinder from pairs of images, and its shape (Table 5.7).

The camera is static and the cylinder moves, which is the inverse motion of the camera.
T_k (4, 4) takes points of the first image to where they are in image k. A translation
is that of the point closest to all rays, about which rays determine a rotation best.
Step lengths are open and estimated from the rays, or each is given. All six images are
also adjusted in one bundle with open lengths. Frame: the viewer's; mm, degrees.
"""

from itertools import pairwise as pairwise_of
from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import (
    MARKS,
    NOISE_PX,
    STEP_MM,
    STEPS,
    shown,
)
from raxel.cameras.core.base import Rays
from raxel.cameras.core.centrality import closest_point
from raxel.errors import CalibrationError, InputError
from raxel.geometry.poses import angle_between_rotations
from raxel.multiview.fits.cylinders import fit_cylinder
from raxel.multiview.generalised_motion import refine_generalised_pose
from raxel.multiview.generalised_robust import generalised_pose_ransac
from raxel.multiview.noisy_rays import rays_of_pixels
from raxel.multiview.ray_bundle import bundle_rays
from raxel.multiview.ray_points import RayView
from raxel.multiview.triangulation import triangulate

# Rays of a calibrated camera miss by more than noise: the start is from the first of
# these multiples of the standard deviation within which most pairs agree. All matches
# are correct.
THRESHOLDS, MIN_AGREEMENT, DRAWS = (10.5, 31.5), 0.8, 64
MAX_STEPS = 20  # of a fit: diverging lengths would go on
MIN_IN_FRONT = 0.5  # share of points in front of the mirror, as all of them are
MIN_N_PAIRS = 17  # for the linear solution
MARKER_MM = 3.0
BASELINES = range(1, STEPS + 1)


class SeenMarks(NamedTuple):
    """Rays of the marks.

    used (25,): marks with rays in all positions; rays: NoisyRays of each position;
    centre (3,): the point closest to all of them.
    """

    used: np.ndarray
    rays: list
    centre: np.ndarray

    def shift(self, T):
        """Translation (3,) of the centre by a motion (4, 4)."""
        return T[:3, :3] @ self.centre + T[:3, 3] - self.centre


def seen_by(camera, pixels, noise_px=NOISE_PX):
    """SeenMarks of pixels (6, 25, 2). Raises CalibrationError for too few marks."""
    used = np.all([shown(camera, x) for x in pixels], axis=0)
    if used.sum() < MIN_N_PAIRS:
        raise CalibrationError(
            f"cylinder: the camera has rays of {used.sum()} marks in all places"
        )
    rays = [rays_of_pixels(camera, x[used], noise_px) for x in pixels]
    o, d = (
        np.concatenate([getattr(one, name) for one in rays])
        for name in ("origins", "directions")
    )
    return SeenMarks(used, rays, closest_point(Rays(o, d, np.ones(len(o), bool))))


def motion_and_shape(camera, scene, pixels, rng, alone=False, noise_px=NOISE_PX):
    """Motion and shape of the cylinder by a camera, as a trial keeps them.

    alone: whether lengths are open only; otherwise they are given as well, and all six
    images are adjusted together.
    """
    try:
        seen = seen_by(camera, pixels, noise_px)
        pairs = pairwise(seen.rays, rng)
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    out = {"open": of_pairs(seen, scene, pairs)}
    if alone:
        return out
    given = pairwise(seen.rays, rng, STEP_MM, pairs)
    return out | {
        "given": of_pairs(seen, scene, given),
        "together": together(seen, chained(given)),
    }


def pairwise(rays, rng, length=None, near=None):
    """T_2_1 (4, 4) of each place and the next, from rays.

    length: mm, where known. Each pair is searched from samples; near: an additional
    start of each pair. Without one, the step before is a start where the search ends
    with most points behind the mirror, or fails, as the motion is even. Solutions with
    points in front of the mirror come first, then the best fit.
    """
    found = []
    for k, pair in enumerate(pairwise_of(rays)):
        ends = [_of_all(pair, T, length) for T in _from_samples(*pair, rng, length)]
        if near is not None:
            ends += [_of_all(pair, near[k], length)]
        if found and not any(end.ahead >= MIN_IN_FRONT for end in ends):
            ends += [_of_all(pair, found[-1], length)]
        if not ends:
            raise CalibrationError("motion: no two rays of most pairs meet")
        best = min(ends, key=lambda end: (end.ahead < MIN_IN_FRONT, end.rms))
        found.append(best.T_2_1)
    return found


def _of_all(pair, start, length):
    return refine_generalised_pose(*pair, start, length=length, most=MAX_STEPS)


def _from_samples(rays_1, rays_2, rng, length):
    """[T_2_1 (4, 4)] from samples, [] where no motion fits most of the pairs."""
    for threshold in THRESHOLDS:
        try:
            found = generalised_pose_ransac(
                rays_1, rays_2, rng, threshold, length=length, most_trials=DRAWS
            )
        except CalibrationError:
            continue
        if np.mean(found.inliers) >= MIN_AGREEMENT:
            return [found.T_2_1]
    return []


def chained(pairs):
    """T (6, 4, 4) from the first position, of those from each to the next."""
    T = [np.eye(4)]
    for step in pairs:
        T.append(step @ T[-1])
    return np.array(T)


def of_pairs(seen, scene, pairs):
    """Steps estimated one by one and added up, and the cylinder under them.

    Lengths are scaled so that the mean step is the true one, as in Table 5.7. Both
    radii of the cylinder are kept; distances are from the scaled one.
    """
    lengths = [np.linalg.norm(seen.shift(T)) for T in pairs]
    scale = STEP_MM / np.mean(lengths)
    T = chained(pairs)
    out = {"mean_mm": float(np.mean(lengths))}
    path = np.zeros((STEPS + 1, 3))
    for k in BASELINES:
        path[k] = scale * seen.shift(T[k])
        out[f"step{k}"] = {
            "length_mm": float(np.linalg.norm(path[k])),
            "turn_deg": turn_between(T[k], scene.T[k]),
            "off_mm": float(np.linalg.norm(path[k] - scene.T[k][:3, 3])),
        }
    return out | {"path": path} | shape_of(seen, T, scale)


def shape_of(seen, T, scale):
    """The cylinder through the marks under motions (6, 4, 4).

    Only `no_shape` where none can be fitted.
    """
    views = [RayView(one) for one in seen.rays]
    return cylinder_through(triangulate(views, T).points, scale)


def cylinder_through(points, scale=1.0):
    """Radius, distances and axis of the cylinder through points (n, 3), NaN allowed."""
    known = np.isfinite(points).all(axis=1)
    try:
        fit = fit_cylinder(points[known])
    except InputError as refusal:
        return {"no_shape": refusal.code}
    off = scale * np.abs(fit.residuals)
    return {
        "radius_mm": fit.radius,
        "scaled_mm": scale * fit.radius,
        "fit_mm": float(off.mean()),
        "fit_sd_mm": float(off.std(ddof=1)),
        "missed": int(MARKS - np.count_nonzero(off <= MARKER_MM)),
        "points": scale * points,
        "cylinder": scaled_cylinder(fit, scale),
    }


def scaled_cylinder(fit, scale):
    """(7,): a point of the axis, its direction, the radius."""
    at = fit.T_frame_cylinder[:3, 3]
    return np.array([*(scale * at), *fit.axis, scale * fit.radius])


def together(seen, start):
    """Six views in one bundle: length of the whole translation, and its SD, percent."""
    try:
        bundle = bundle_rays([RayView(one) for one in seen.rays], start)
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    T = bundle.T_view_world[STEPS]
    return {
        "length_mm": float(np.linalg.norm(seen.shift(T))),
        "told_percent": 100 * bundle.scale_sd(STEPS),
    }


def turn_between(T, true):
    """Degrees between the rotations of two motions."""
    return float(np.degrees(angle_between_rotations(T[:3, :3], true[:3, :3])))
