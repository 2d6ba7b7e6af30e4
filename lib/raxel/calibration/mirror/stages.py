"""Calibration of a flexible mirror from its views: first shape, deflections, bundle.

The steps of 5.2 in one call: poses of the monitor from the flat reference mirror (5.26,
5.27), the clamp line, the primary calibration, an update for each step, and the bundle
adjustment. Input are views; `raxel.calibration.mirror.images` measures them in the
images of a mirror set.

Frame: that of the viewing camera; mm, rad.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from raxel.calibration.mirror.bundle import StageBundle, StageView, bundle_stages
from raxel.calibration.mirror.clamp import ClampLine, clamp_line, fixed_line
from raxel.calibration.mirror.observations import (
    MIN_REACH,
    magnification,
    normalised,
    wrong_matches,
)
from raxel.calibration.mirror.platter import PlatterPoses, grid_poses_in_platter
from raxel.calibration.mirror.primary import PrimaryCalibration, primary_from_points
from raxel.calibration.mirror.update import MirrorSettings, update_mirror
from raxel.calibration.pose.three_point import placed_points
from raxel.calibration.views.correspondence import BoardView
from raxel.calibration.views.dense import sample_boards
from raxel.errors import CalibrationError, InputError

# Errors in a mirror's images that a calibration does not show by itself. Each is
# rejected or reported.


# Minimum distance between two positions of the monitor, for two distinct directions.
MIN_MONITOR_SHIFT_MM = 10.0
# Minimum fraction of pixels that see a different point of the monitor in its other
# position, and the minimum difference of these points.
MIN_CHANGED_FRACTION, CHANGED_MM = 0.5, 1.0
# Maximum distance of the clamp line from the area that sees the monitor, as a fraction
# of its extent along u. Maximum fraction of its pixels beyond the line, and beyond a
# line that replaces a hidden clamp.
MAX_CLAMP_GAP, MAX_BEYOND_CLAMP, MAX_BEYOND_HIDDEN_CLAMP = 0.1, 0.02, 0.15
# Mean residual angles of a stage. Smooth sheets leave 0.015 degrees. The shape absorbs
# most of a board motion: 6 mm at 260 mm from the mirror leaves 0.015 to 0.06, and a
# motion of 1 mm is indistinguishable from a bend.
WARN_RESIDUAL_DEG, MAX_RESIDUAL_DEG = 0.02, 0.25
# As a fraction of the extent of the first shape along u: below, a warning.
MIN_SPAN_FRACTION = 0.8


def check_distinct_positions(poses, grids):
    """Reject a position of the monitor that occurs twice in the flat mirror.

    poses: PlatterPoses; grids: views of the monitor in the mirror, in their order.
    """
    middle = np.mean(grids[0].points[np.isfinite(grids[0].pixels[:, 0])], axis=0)
    for first, second in _pairs(grids):
        moved = poses.motion(first, second, middle).distance
        if moved < MIN_MONITOR_SHIFT_MM:
            raise CalibrationError(
                f"primary calibration: {_named(grids, first, second)} show one "
                f"position of the monitor ({moved:.1f} mm apart); move it by about 100 "
                "mm",
                code="same-place",
            )


def check_distinct_images(points, grids):
    """Reject a monitor that the bending mirror shows twice in one position.

    points: (n, N, 2) mm, points of each grid that pixels see, NaN where none.
    """
    for first, second in _pairs(grids):
        separation = np.linalg.norm(points[first] - points[second], axis=1)
        separation = separation[np.isfinite(separation)]
        if len(separation) and np.mean(separation > CHANGED_MM) < MIN_CHANGED_FRACTION:
            raise CalibrationError(
                f"primary calibration: {_named(grids, first, second)} show the same "
                "points of the monitor; take images of its patterns at both positions",
                code="same-points",
            )


def check_clamp_line(line, viewer, grids, hidden=False):
    """Reject a ClampLine outside the mirror, or across it; hidden: whether it replaces
    an invisible clamp."""
    pixels = np.concatenate([view.pixels for view in grids])
    p = normalised(viewer, pixels[np.isfinite(pixels[:, 0])])
    axis = np.array([np.cos(line.angle), np.sin(line.angle)])
    errors = (p - line.ends.mean(axis=0)) @ axis
    errors = errors * (1.0 if np.median(errors) > 0 else -1.0)
    # A few pixels at the border are decoded wrongly.
    nearest, extent = np.quantile(errors, 0.005), np.ptp(errors)
    if nearest > MAX_CLAMP_GAP * extent:
        raise InputError(
            f"clamp: its line is {100 * nearest / extent:.0f} % of the mirror's length "
            "from the image of the monitor; place it at the mirror's edge, and fill "
            "the mirror with the monitor"
        )
    beyond = np.mean(errors < 0)
    if beyond > (MAX_BEYOND_HIDDEN_CLAMP if hidden else MAX_BEYOND_CLAMP):
        raise InputError(
            f"clamp: {100 * beyond:.0f} % of the pixels that see the monitor are "
            "beyond its line; place it at the clamped edge of the mirror"
        )


def misfit_flags(stage, step, degrees):
    """Flags (list) for residuals (N,), degrees, beyond noise.

    step: StepViews. Raises CalibrationError where they are so large that the shape is
    wrong.
    """
    mean = np.mean(degrees) if len(degrees) else np.inf
    if mean < WARN_RESIDUAL_DEG:
        return []
    found = (
        f"corners deviate by {mean:.2g} deg (mean) from their rays; use smaller steps "
        "and a static board, camera and clamp"
    )
    if mean > MAX_RESIDUAL_DEG:
        names = f"{step.before.name}, {step.after.name}"
        raise CalibrationError(
            f"step {stage} ({names}): {found}", code="moved-between-images"
        )
    return [f"stage {stage}: {found}"]


def partial_coverage_flags(cameras):
    """Flags (list) for stages whose corners cover a part of the mirror only.

    cameras: SplineMirrorCameras of the stages, the first of which shows all.
    """
    flags = []
    for k, camera in enumerate(cameras[1:], 1):
        spans = [np.ptp(one.grid.breaks[0]) for one in (camera, cameras[0])]
        if spans[0] < MIN_SPAN_FRACTION * spans[1]:
            flags.append(
                f"stage {k}: common corners cover {100 * spans[0] / spans[1]:.0f} % of "
                "the mirror from the clamp; there are no rays near the free edge"
            )
    return flags


def _pairs(grids):
    count = len(grids)
    return [(i, j) for i in range(count) for j in range(i + 1, count)]


def _named(grids, first, second):
    return f"{grids[first].name} and {grids[second].name}"


DEFAULT_SETTINGS = MirrorSettings(fixed_shape=False)
N_LINE_POINTS = 9
# Default deflection of the end, as a fraction of the length.
DEFAULT_DEFLECTION = 0.1
N_PIXELS_PER_GRID = 1000  # approximate number per grid, as in the thesis


class ClampPicks(NamedTuple):
    """Hold points along the clamped edge of the mirror in the image.

    Attributes
    ----------
    points : ndarray, shape (N, 2)
        Points along the clamp's edge, px.
    sd_px : float
        Standard deviation of each point across the edge, px.
    hidden_mm : float
        Distance by which the edge may lie in front of the true clamp, mm.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import ClampPicks
    >>> picks = ClampPicks(np.array([[10.0, 5.0], [12.0, 250.0], [14.0, 495.0]]), 0.5)
    >>> picks.points.shape, picks.sd_px, picks.hidden_mm
    ((3, 2), 0.5, 0.0)
    """

    points: np.ndarray
    sd_px: float = 0.0
    hidden_mm: float = 0.0


class StepViews(NamedTuple):
    """Hold the views of a stationary chessboard before and after one deflection.

    A view that is `after` of one step and `before` of the next has one name in both.

    Attributes
    ----------
    before, after : BoardView
        Views of the chessboard, their corners in the same order.
    deflection_mm : float or None
        Stated deflection, mm; None where it is not stated.
    """

    before: BoardView
    after: BoardView
    deflection_mm: float | None = None


class MirrorViews(NamedTuple):
    """Hold the input of `calibrate_mirror`.

    Attributes
    ----------
    viewer : Camera
        Calibrated central camera that views the mirror.
    grids : tuple of DenseView
        View of the monitor in the mirror for each position of the monitor.
    platter : tuple of FlatMirrorImage
        Images of the flat reference mirror. Position k is that of ``grids[k]``.
    thickness : float
        Thickness of the flat reference mirror, mm.
    clamp : ClampPicks
        Points along the clamped edge.
    steps : tuple of StepViews
        Views of each deflection.
    flags : tuple of str
        Warnings about the images, one text each.
    """

    viewer: object
    grids: tuple
    platter: tuple
    thickness: float
    clamp: ClampPicks
    steps: tuple
    flags: tuple = ()


class MirrorCalibration(NamedTuple):
    """Hold the result of `calibrate_mirror`.

    Attributes
    ----------
    cameras : tuple of SplineMirrorCamera
        Camera of each stage; 0 is the first shape.
    poses : PlatterPoses
        Poses of the monitor from the flat reference mirror.
    line : ClampLine
        Line of the clamp in the image.
    primary : PrimaryCalibration
        Calibration of the first shape.
    updates : tuple of MirrorUpdate
        Calibration of each step.
    bundle : StageBundle
        Adjustment of all stages, whose cameras `cameras` are.
    views : tuple of StageView
        Views that the bundle used.
    flags : tuple of str
        Warnings about views and stages, one text each.
    """

    cameras: tuple
    poses: PlatterPoses
    line: ClampLine
    primary: PrimaryCalibration
    updates: tuple
    bundle: StageBundle
    views: tuple
    flags: tuple

    def residuals_mm(self, stage: int) -> NDArray[np.float64]:
        """Return distances (N,), mm, of a stage's chessboard corners from its rays."""
        return self._residuals(stage)[0]

    def residuals_deg(self, stage: int) -> NDArray[np.float64]:
        """Return `residuals_mm` (N,) of a stage as angles at the mirror, degrees."""
        return np.degrees(np.arctan2(*self._residuals(stage)))

    def _residuals(self, stage):
        """(2, N): distances of corners from their rays, and along them, mm."""
        camera = self.cameras[stage]
        found = [
            _by_rays(camera, view.pixels, view.points, self.bundle.T_camera_grid[grid])
            for at, grid, view in self.views
            if at == stage
        ]
        found = np.concatenate([np.zeros((2, 0)), *found], axis=1)
        return found[:, np.isfinite(found[0])]


def calibrate_mirror(
    views: MirrorViews,
    quantity: str = "inverse depth",
    settings: MirrorSettings = DEFAULT_SETTINGS,
    say: Callable[[str], object] | None = None,
) -> MirrorCalibration:
    """Calibrate a bending mirror: first shape, deflections and bundle over all stages.

    Whatever a stage leaves undetermined is rejected, so that no camera has a guessed
    shape.

    Parameters
    ----------
    views : MirrorViews
        Views of the monitor, of the flat reference mirror and of the steps.
    quantity : str
        Quantity of the splines, "inverse depth" or "distance"; see
        `SplineMirrorCamera`.
    settings : MirrorSettings
        Settings of each step.
    say : callable or None
        Called with one line of text for each stage of the work.

    Returns
    -------
    MirrorCalibration
        Cameras of all stages, in the frame of the viewing camera (mm, rad).

    Raises
    ------
    InputError
        For input that does not fit. The message is one line and names step or image.
    CalibrationError
        ``same-place``, ``same-points``, ``moved-between-images``, or the code of the
        stage that failed. The message is one line and names step or image.

    References
    ----------
    Thesis 5.2.
    """
    say = say or (lambda line: None)
    say("poses of the monitor, from the flat reference mirror")
    poses = grid_poses_in_platter(views.viewer, views.platter, views.thickness)  # type: ignore[arg-type]
    check_distinct_positions(poses, views.grids)
    line = _line(views)
    say("first shape of the mirror")
    spline = {"shape": settings.shape, "degree": settings.degree, "quantity": quantity}
    primary = _primary(views, poses, line, spline)
    clamp = _held(primary.camera, line, views)
    updates = _updated(primary.camera, views.steps, clamp, settings, say)
    say("bundle adjustment of all stages")
    cameras = [primary.camera, *(update.camera for update in updates)]
    shown, T_camera_grid = _stage_views(views.steps, updates)
    bundle = bundle_stages(
        cameras, shown, T_camera_grid, clamp=clamp,
        first_covariance=primary.covariance, prior_sd=settings.prior_sd,
    )  # fmt: skip
    flags = [*views.flags, *(f"first shape: {text}" for text in primary.flags)]
    for k, update in enumerate(updates, 1):
        flags += [f"stage {k}: {text}" for text in update.flags]
    flags += [text for text in bundle.flags if text not in flags]
    flags += partial_coverage_flags(bundle.cameras)
    found = MirrorCalibration(
        bundle.cameras, poses, line, primary, updates, bundle, shown, tuple(flags)
    )
    doubts = [
        text
        for k in range(1, len(cameras))
        for text in misfit_flags(k, views.steps[k - 1], found.residuals_deg(k))
    ]
    return found._replace(flags=(*found.flags, *doubts))


def _line(views):
    """ClampLine, at most as certain as its points, next to the monitor's image."""
    found = clamp_line(views.viewer, views.clamp.points)
    picks = views.clamp.points[found.used]
    sd = views.clamp.sd_px / np.median(magnification(views.viewer, picks))
    p = normalised(views.viewer, picks)
    reach = np.linalg.norm(p - p.mean(axis=0), axis=1)
    line = found._replace(
        offset_sd=max(found.offset_sd, sd / np.sqrt(len(picks))),
        angle_sd=max(found.angle_sd, sd / np.sqrt(np.sum(reach**2))),
    )
    hidden = views.clamp.hidden_mm > 0
    check_clamp_line(line, views.viewer, views.grids, hidden)
    return line


def _primary(views, poses, line, spline):
    """PrimaryCalibration of pixels spread over the grids."""
    viewer, grids = views.viewer, views.grids
    samples = N_PIXELS_PER_GRID * len(grids)
    seen = sample_boards(grids, viewer.width, viewer.height, samples)
    points = np.where(seen.seen[..., None], seen.points, np.nan)
    check_distinct_images(points, grids)
    return primary_from_points(
        viewer, seen.pixels.astype(float), points, poses, angle=line.angle,
        span=line.points(N_LINE_POINTS), **spline,
    )  # fmt: skip


def _by_rays(camera, pixels, points, T_camera_grid):
    """(2, N) mm: distances of points (N, 2) of a grid from the rays of pixels (N, 2),
    and distances along these rays."""
    rays = camera.rays(pixels)
    q = placed_points(points, T_camera_grid) - rays.origins
    across = np.linalg.norm(np.cross(rays.directions, q), axis=1)
    return np.stack([across, np.sum(rays.directions * q, axis=1)])


def _held(camera, line, views):
    """FixedLine, from the hidden width of the clamp and the largest deflection."""
    hidden = views.clamp.hidden_mm
    length = hidden + _length(camera, line)
    stated = [step.deflection_mm for step in views.steps]
    most = DEFAULT_DEFLECTION * length
    if None not in stated and any(stated):
        most = float(np.abs(np.cumsum(stated)).max())
    return fixed_line(camera, line, hidden=hidden, length=length, deflection=most)


def _length(camera, line):
    """Length on the mirror, mm, from the middle of the line to the opposite knots."""
    grid, middle = camera.grid, line.points(3)[1:2]
    u, v = grid.turned(middle)[0]
    ends = grid.breaks[0][[0, -1]]
    far = grid.unturned(np.array([[ends[np.argmax(np.abs(ends - u))], v]]))
    return float(
        np.linalg.norm(np.diff(camera.mirror.points(np.r_[middle, far]), axis=0))
    )


def _updated(camera, steps, clamp, settings, say):
    """A MirrorUpdate for each step, from the camera of the previous one."""
    found = []
    for k, step in enumerate(steps, 1):
        say(f"step {k}: {step.before.name}, {step.after.name}")
        following = steps[k].before if k < len(steps) else None
        outline = _outline(camera, step, following, settings)
        noise = _noise(step)
        try:
            update = update_mirror(
                camera, step.before.pixels, step.after.pixels, step.before.points,
                clamp, settings._replace(noise_px=noise or settings.noise_px),
                outline=outline,
            )  # fmt: skip
        except CalibrationError as fault:
            raise CalibrationError(
                f"step {k} ({step.before.name}, {step.after.name}): {fault}",
                code=fault.code,
            ) from fault
        found.append(update)
        camera = update.camera
    return tuple(found)


def _outline(camera, step, following, settings):
    """Pixels (N, 2) that a stage's knots span in addition to the common corners.

    All board areas in its images, so that the next step finds its corners there, but
    only as far as the common corners support the outermost knot intervals: with fewer
    knots the whole shape would be worse.
    """
    viewer, grid = camera.viewer, camera.grid
    points, after = step.before.points, step.after.pixels
    wrong = wrong_matches(points, step.before.pixels) | wrong_matches(points, after)
    common = camera.rays(step.before.pixels).valid & ~wrong
    common = grid.turned(normalised(viewer, after[common & np.isfinite(after[:, 0])]))
    if len(common) == 0:
        return None
    shown = [after] if following is None else [after, following.pixels]
    shown = grid.turned(normalised(viewer, np.concatenate(shown)))
    intervals = np.subtract(settings.shape, settings.degree)
    beyond = (1 - MIN_REACH) / intervals * np.ptp(common, axis=0)
    low, high = common.min(axis=0) - beyond, common.max(axis=0) + beyond
    p = grid.unturned(np.clip(shown[np.isfinite(shown[:, 0])], low, high))
    return viewer.project(np.column_stack([p, np.ones(len(p))])).pixels


def _noise(step):
    """Median standard deviation of a step's corners, px; None where unknown."""
    stated = [view.sd for view in (step.before, step.after) if view.sd is not None]
    if not stated or not np.isfinite(stated).any():
        return None
    return float(np.nanmedian(np.concatenate(stated)))


def _stage_views(steps, updates):
    """(StageViews, T_camera_grid (m, 4, 4)): every image once, without rejected
    corners; a board that stayed over several steps has one pose."""
    shown, poses, grid_of = {}, [], {}
    for k, (step, update) in enumerate(zip(steps, updates, strict=True)):
        grid = grid_of.get(step.before.name)
        if grid is None:
            grid = len(poses)
            poses.append(update.pose.T_camera_grid)
        for stage, view in ((k, step.before), (k + 1, step.after)):
            grid_of[view.name] = grid
            earlier = shown.get(view.name)
            pixels = view.pixels if earlier is None else earlier.view.pixels
            right = np.where(update.wrong[:, None], np.nan, pixels)
            shown[view.name] = StageView(stage, grid, view._replace(pixels=right))
    return tuple(shown.values()), np.stack(poses)
