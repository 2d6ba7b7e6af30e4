"""Cross-validation of camera models: the same views, the same points for all models.

Points are the corners of boards, or decoded points of active grids. A table has rays
only where these were; a parametric model has them everywhere, also where it is wrong.
Therefore every point counts, and one without a ray counts as a large error. In
addition, all models are scored on the points for which each of them has a ray.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from raxel.calibration.mirror.stages import calibrate_mirror
from raxel.calibration.parametric.lens_bundle import LensFormula, adjusted, stacked
from raxel.calibration.parametric.lens_fit import FormulaFit, covariance_of
from raxel.calibration.parametric.opencv_fits import found_corners
from raxel.calibration.pose.non_central import pose_from_non_central_rays
from raxel.calibration.views.boards import board_views
from raxel.calibration.views.correspondence import BoardView, check_view, near_copies
from raxel.calibration.views.dense import DenseView
from raxel.cameras.core.base import Camera
from raxel.errors import CalibrationError
from raxel.evaluation.cross_validation import (
    Evaluation,
    cross_validate,
    evaluate_camera,
)
from raxel.evaluation.diagnoses import Diagnosis, diagnosis, known
from raxel.evaluation.ray_errors import errors_of_directions, inner_nodes
from raxel.features.boards import detect_boards
from raxel.geometry.planes import intersect_rays_plane
from raxel.geometry.poses import nearest_rotation
from raxel.sets.model import ImageSet

# Error of a point without a ray, and the largest error of any point.
MISSED_PX = 5.0
# Models with errors up to this ratio to the smallest are equal (the simplest counts).
EQUAL_RATIO = 1.02


class ModelComparison(NamedTuple):
    """Hold the cross-validated scores of several models, the simplest first.

    Attributes
    ----------
    own : dict of str to Evaluation
        Scores of each model on all corners.
    common : dict of str to Evaluation
        Scores on the corners for which every model in `own` has an answer, from boards
        held out of all of them; empty without any.
    failed : dict of str to str
        Reason for each model that gave no camera at all.
    errors_px : dict of str to float
        Errors, px, that rank the models: RMS distance of all held-out corners. A corner
        without a ray counts as MISSED_PX, and none counts as more.
    """

    own: dict
    common: dict
    failed: dict
    errors_px: dict

    def best(self) -> str:
        """Return the model that predicts best; see `choice`."""
        return self.choice()[0]

    def choice(self) -> tuple[str, str]:
        """Return the best model and the reason in words.

        The best model is the first of those whose error is at most EQUAL_RATIO times
        the smallest.

        Returns
        -------
        model : str
            The best model.
        reason : str
            Why it is the best.

        Raises
        ------
        CalibrationError
            If no model is left (codes ``no-camera``, ``no-overlap``).
        """
        if not self.own:
            raise CalibrationError("; ".join(self.failed.values()), code="no-camera")
        errors = {m: self.errors_px[m] for m, e in self.own.items() if e.n_scored}
        if not errors:
            raise CalibrationError(
                "cross-validation: no model has rays for six points of a held-out view;"
                " take more views that share areas of the image",
                code="no-overlap",
            )
        if len(errors) == 1:
            alone = len(self.own) == 1
            what = "gave a camera" if alone else "answers for a held-out view"
            return next(iter(errors)), f"no other model {what}"
        least = min(errors, key=errors.get)  # type: ignore[arg-type]
        best = next(m for m in errors if errors[m] <= EQUAL_RATIO * errors[least])
        counted = f"where one without a ray counts as {MISSED_PX:g} px"
        if best == least:
            return best, (
                f"the smallest error on held-out points, {errors[best]:.3g} px RMS, "
                + counted
            )
        return best, (
            f"on held-out points, {counted}, as good as {least}"
            f" ({errors[best]:.3g} and {errors[least]:.3g} px RMS), and simpler"
        )

    def diagnoses(self) -> list[Diagnosis]:
        """Return a warning for each model that some parts gave no camera."""
        return [
            diagnosis(
                "cross-validation-incomplete",
                model=model,
                count=len(evaluation.left_out),
                reason=next(iter(evaluation.left_out.values())),
            )
            for model, evaluation in self.own.items()
            if evaluation.left_out
        ]

    def fields(self) -> dict[str, Any]:
        """Return the scores of all models for JSON."""
        tried = {
            model: {
                "own": own.totals(),
                "counted_rms_px": known(self.errors_px[model]),
                "parts_left_out": list(own.left_out.values()),
            }
            for model, own in self.own.items()
        }
        for model, common in self.common.items():
            tried[model]["common"] = common.totals()
        return tried | {name: {"refused": why} for name, why in self.failed.items()}


def compare_models(
    builders: dict[str, Callable[[list], Any]],
    views: Sequence[BoardView | DenseView],
    folds: int,
) -> ModelComparison:
    """Cross-validate models on the same parts of `views`.

    Parameters
    ----------
    builders : dict of str to callable
        Models, the simplest first; each callable as `cross_validate` takes it.
    views : sequence of BoardView or DenseView
        Views with different names.
    folds : int
        Number of parts. It is smaller where fewer views are no near copies of others.
        Near copies stay in one part.

    Returns
    -------
    ModelComparison
        The scores.
    """
    cameras = {model: remembering(build) for model, build in builders.items()}
    own, failed, parts = {}, {}, _parts(views, folds)
    for model, build in cameras.items():
        try:
            own[model] = cross_validate(build, views, parts)
        except CalibrationError as fault:
            failed[model] = str(fault)
    common = _on_shared(cameras, own, views, parts) if len(own) > 1 else {}
    errors = {model: counted_error_px(found, views) for model, found in own.items()}
    return ModelComparison(own, common, failed, errors)


def counted_error_px(
    evaluation: Evaluation, views: Sequence[BoardView | DenseView]
) -> float:
    """Return the RMS distance of all corners of the views, none of which is excluded.

    A corner without a ray, or in a view without a camera, counts as MISSED_PX. None
    counts as more.

    Parameters
    ----------
    evaluation : Evaluation
        Scores of the views.
    views : sequence of BoardView or DenseView
        The views.

    Returns
    -------
    float
        RMS distance, px; NaN without corners.
    """
    count = sum(np.count_nonzero(np.isfinite(view.pixels[:, 0])) for view in views)
    off = np.concatenate([image.residuals_px for image in evaluation.images])
    off = np.linalg.norm(off[np.isfinite(off[:, 0])], axis=1)
    squares = np.sum(np.minimum(off, MISSED_PX) ** 2)
    squares += (count - len(off)) * MISSED_PX**2
    return float(np.sqrt(squares / count)) if count else np.nan


def _parts(views, folds):
    """Indices of the views of each part; near copies are in one, unless all views are
    copies of one."""
    groups = np.unique(near_copies(views), return_inverse=True)[1]
    if not groups.any():
        groups = np.arange(len(views))
    folds = min(folds, groups.max() + 1)
    return [np.flatnonzero(groups % folds == part) for part in range(folds)]


def _on_shared(cameras, own, views, parts):
    """Evaluations on the corners for which all models have a ray; {} without any.

    Without the other corners a board has another pose, at which a model may miss a
    corner that it had. This is repeated until all models score all corners.
    """
    whole = _parts_of_all(own, parts)
    common, complete = own, len(whole) == len(parts)
    while whole:
        shares = [evaluation.share_with_ray for evaluation in common.values()]
        if np.isnan(shares).all():
            break
        if complete and min(shares) == 1:
            return common
        views, complete = _shared_corners(common, views), True
        common = {model: cross_validate(cameras[model], views, whole) for model in own}
    return {}


def remembering(build):
    """Function that builds a camera once for the same views, by their names."""
    cameras = {}

    def built(views):
        key = tuple(view.name for view in views)
        if key not in cameras:
            cameras[key] = build(views)
        return cameras[key]

    return built


def _shared_corners(evaluations, views):
    """The views with only those corners that all models score."""
    scored = [{s.name: s for s in e.images} for e in evaluations.values()]
    shared = []
    for view in views:
        pixels = view.pixels.copy()
        for scores in scored:
            if view.name in scores:
                pixels[np.isnan(scores[view.name].residuals_px[:, 0])] = np.nan
        shared.append(view._replace(pixels=pixels))
    return shared


def _parts_of_all(evaluations, parts):
    """The parts for which every model gave a camera."""
    folds_of = [{score.fold for score in e.images} for e in evaluations.values()]
    whole = set.intersection(*folds_of)
    return [parts[fold] for fold in sorted(whole)]


# Predicted errors of the rays of a flexible mirror. There are three sources. Noise of
# the corners and of the monitor's points: the covariance of the bundle adjustment. A
# mirror that is no such spline: the excess of the residuals over the corners' noise.
# And the calibration of the camera that views the mirror, which the fit assumes exact:
# all poses and shapes depend on it. Its effect is determined by calibrating again, with
# cameras changed by a standard deviation along each principal axis of the covariance
# of their parameters. The error of a direction has two components; half of the errors
# are smaller than sqrt(ln 2) times their RMS length. A common rotation of all rays is a
# choice of axes and no error. Frame: that of the camera.


PINHOLE = LensFormula("perspective", 2, 0, 0)
MEDIAN_OVER_RMS = np.sqrt(np.log(2))  # of the length of two equal components


def viewers_aside(camera, boards):
    """PerspectiveCameras, each changed by one standard deviation along a principal
    axis of the covariance that the BoardViews of the camera determine."""
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
    """Predicted median error of each stage's rays, degrees: an array (N,) each.

    views: MirrorViews; found: their MirrorCalibration; pixels: (N, 2) for each stage;
    aside: cameras changed by a standard deviation, empty where it is unknown. NaN where
    a stage has no ray. Raises CalibrationError where such a camera gives no mirror.
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
    return [MEDIAN_OVER_RMS * np.degrees(np.sqrt(each)) for each in squares]


def _noise(found, stage, pixels):
    """(N,) radians, of one component, by the covariance alone."""
    sd, misfit = found.bundle.ray_sd(stage, pixels), found.bundle.misfit[stage]
    return np.sqrt(np.maximum(sd**2 - misfit**2, 0.0))


def _misfit(found, stage):
    """Radians, of one component: excess of the residuals over the corners' noise; at
    least the misfit that the bundle adjustment found."""
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
    """Rotation (3, 3) that maps the directions of a camera to those of another."""
    mine, its = (one.rays(pixels).directions for one in (viewer, other))
    known = np.isfinite(mine).all(axis=1) & np.isfinite(its).all(axis=1)
    return nearest_rotation(its[known].T @ mine[known])


# Back-projection of corners onto their board, in mm (5.3.3), for non-central cameras
# such as one that views a mirror. The pose of the board is fitted with the camera. It
# may absorb a wrong shape of the mirror; errors against a known shape do not.


class BackProjection(NamedTuple):
    """Hold the back-projected corners of one board.

    Attributes
    ----------
    name : str
        Name of the view.
    T_camera_grid : ndarray, shape (4, 4), or None
        Pose of the board; None where none was found.
    errors_mm : ndarray, shape (N, 2)
        Points where the rays of its corners meet its plane, less the corners, mm. NaN
        where a corner was not found or has no ray.
    reason : str
        Why no pose was found, or ''.
    """

    name: str
    T_camera_grid: np.ndarray | None
    errors_mm: np.ndarray
    reason: str = ""

    @property
    def distances_mm(self) -> np.ndarray:
        """Return the lengths (n,) of the known errors, mm."""
        found = np.linalg.norm(self.errors_mm, axis=1)
        return found[np.isfinite(found)]


def back_projection(camera: Camera, view: BoardView) -> BackProjection:
    """Return the BackProjection of a BoardView, posed by the rays of the camera."""
    view = check_view(view)
    rays = camera.rays(view.pixels)
    unknown = np.full(view.pixels.shape, np.nan)
    try:
        T = pose_from_non_central_rays(rays, view.points).T_camera_grid
    except CalibrationError as fault:
        return BackProjection(view.name, None, unknown, str(fault))
    met = intersect_rays_plane(rays.origins, rays.directions, T)
    return BackProjection(view.name, T, met.points - view.points)


N_SAMPLES = 21  # along each side of a mirror, at which the errors of rays are predicted


def spread_fields(residuals):
    """{mean, sd} of distances; None without any."""
    residuals = residuals[np.isfinite(residuals)]
    if len(residuals) == 0:
        return {"mean": None, "sd": None}
    return {"mean": float(np.mean(residuals)), "sd": float(np.std(residuals))}


def expected_errors(mirror_set, views, found, say):
    """([{median, largest}] over each stage's mirror: predicted errors of rays, degrees;
    whether the error of the camera that views the mirror is included). The cameras get
    them as `error_nodes`."""
    spread = [_spread_over(camera) for camera in found.cameras]
    nodes = [inner_nodes(camera) for camera in found.cameras]
    pixels = [np.concatenate(both) for both in zip(spread, nodes, strict=True)]
    perturbed = _perturbed(mirror_set, views, say)
    try:
        errors = predicted_errors(views, found, pixels, perturbed)
    except CalibrationError:
        perturbed, errors = [], predicted_errors(views, found, pixels)
    predicted = [
        {"median": float(np.median(each)), "largest": float(np.max(each))}
        for each in (
            error[: len(own)][np.isfinite(error[: len(own)])]
            for error, own in zip(errors, spread, strict=True)
        )
    ]
    for camera, error, own in zip(found.cameras, errors, spread, strict=True):
        sd = np.radians(error[len(own) :] / MEDIAN_OVER_RMS) / np.sqrt(2)
        camera.error_nodes = errors_of_directions(camera, sd)
    return predicted, bool(perturbed)


def _perturbed(mirror_set, views, say):
    """Cameras that view the mirror, each changed by a standard deviation; [] where no
    images determine it."""
    if not isinstance(mirror_set.viewer, ImageSet):
        return []
    say("uncertainty of the camera that views the mirror")
    boards = board_views(mirror_set.viewer, detect_boards(mirror_set.viewer))
    return viewers_aside(views.viewer, boards)


def _spread_over(camera):
    """Pixels (N_SAMPLES^2, 2) all over the mirror."""
    u, v = (np.linspace(b[0], b[-1], N_SAMPLES) for b in camera.grid.breaks)
    p = camera.grid.unturned(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    return camera.viewer.project(np.column_stack([p, np.ones(len(p))])).pixels
