"""How wrong are the rays of a mirror that bends? What the fit says, and what it cannot.

Three things make rays wrong. Noise of the corners and the monitor's points: the
bundle's covariance. A mirror that is no such spline: what residuals have beyond the
corners' noise, however much that hides of it. And the viewer's own calibration, which
the fit takes for exact: every pose of a board and every shape comes through it. That
one is asked by calibrating again, with viewers that are a standard deviation aside,
along each direction in which their parameters scatter.

An error of a direction has two components; of one with this root mean square length
half are smaller than sqrt(ln 2) of it. What a common rotation of all rays does is a
choice of axes and no error. Frame: the viewer's.
"""

import numpy as np

from raxel.calibration.mirror.stages import calibrate_mirror
from raxel.calibration.parametric.lens_bundle import adjusted, stacked
from raxel.calibration.parametric.lens_fit import FormulaFit, covariance_of
from raxel.calibration.parametric.lens_laws import LensFormula
from raxel.calibration.parametric.zhang import found_corners
from raxel.calibration.views.near_copies import near_copies
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.geometry.poses import nearest_rotation

PINHOLE = LensFormula("perspective", 2, 0, 0)
MEDIAN = np.sqrt(np.log(2))  # of the length of two equal components, in its RMS


def viewers_aside(camera, boards):
    """Viewers, each one standard deviation aside: a PerspectiveCamera's parameters by
    the BoardViews that it was fitted to, along the axes of their covariance."""
    K = camera.K
    values = np.array([K[0, 0], K[1, 1], *K[:2, 2], *camera.radial])
    poses = [score.T_camera_grid for score in evaluate_camera(camera, boards).images]
    seen = stacked([found_corners(view) for view in boards], near_copies(boards))
    fit = FormulaFit(PINHOLE, adjusted(PINHOLE, values, poses, seen, "tukey"))
    variances, axes = np.linalg.eigh(covariance_of(fit, seen).covariance)
    return [
        PINHOLE.camera(
            values + np.sqrt(max(variance, 0.0)) * axis, camera.width, camera.height
        )
        for variance, axis in zip(variances, axes.T, strict=True)
    ]


def predicted_errors(views, found, pixels, aside=()):
    """Median error that is expected of each stage's rays, degrees: an array (N,) each.

    views: MirrorViews; found: their MirrorCalibration; pixels: (N, 2) for each stage;
    aside: viewers a standard deviation aside, none where that is not known. NaN where
    a stage has no ray. Raises CalibrationError where another viewer gives no mirror.
    """
    squares = [
        2 * _noise(found, stage, own) ** 2 + 2 * _misfit(found, stage) ** 2
        for stage, own in enumerate(pixels)
    ]
    for viewer in aside:
        other = calibrate_mirror(views._replace(viewer=viewer))
        R = _turn(viewer, views.viewer, np.concatenate(pixels))
        for stage, own in enumerate(pixels):
            rays = [one.cameras[stage].rays(own).directions for one in (other, found)]
            squares[stage] += np.sum((rays[0] @ R.T - rays[1]) ** 2, axis=1)
    return [MEDIAN * np.degrees(np.sqrt(each)) for each in squares]


def _noise(found, stage, pixels):
    """(N,) radians, of one component, by the covariance alone."""
    sd, misfit = found.bundle.ray_sd(stage, pixels), found.bundle.misfit[stage]
    return np.sqrt(np.maximum(sd**2 - misfit**2, 0.0))


def _misfit(found, stage):
    """Radians, of one component: what residuals have beyond the corners' noise, small
    or not; what the bundle tells of it where it is sure."""
    own = [k for k, view in enumerate(found.views) if view.stage == stage]
    stated = [found.views[k].view.sd for k in own]
    off = np.radians(found.residuals_deg(stage))
    if not own or any(sd is None for sd in stated) or len(off) == 0:
        return found.bundle.misfit[stage]
    residuals = np.concatenate([found.bundle.residuals[k] for k in own])
    times = np.mean(residuals**2) / np.nanmean(np.concatenate(stated) ** 2)
    beyond = np.mean(off**2) / 2 * max(1 - 1 / times, 0.0)
    return max(np.sqrt(beyond), found.bundle.misfit[stage])


def _turn(viewer, other, pixels):
    """Rotation (3, 3) that takes the directions of a viewer to those of another."""
    mine, its = (one.rays(pixels).directions for one in (viewer, other))
    known = np.isfinite(mine).all(axis=1) & np.isfinite(its).all(axis=1)
    return nearest_rotation(its[known].T @ mine[known])
