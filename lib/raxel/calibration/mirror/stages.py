"""A mirror that bends, calibrated from its views: first shape, deflections, bundle.

What 5.2 does one after another, as one call: the monitor's places through the platter
(5.26, 5.27), the clamp's line, the primary calibration, an update for each step, and
the bundle over all of them. It takes views, so pictures may come from anywhere;
`raxel.calibration.mirror.from_pictures` reads them out of a mirror set.

Frame: the viewer's; mm, radians.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.bundle import StageBundle, StageView, bundle_stages
from raxel.calibration.mirror.clamp_line import ClampLine, clamp_line, fixed_line
from raxel.calibration.mirror.platter import PlatterPoses, grid_poses_in_platter
from raxel.calibration.mirror.primary import PrimaryCalibration, primary_from_points
from raxel.calibration.mirror.sightings import magnification, normalised
from raxel.calibration.mirror.update import MirrorSettings, update_mirror
from raxel.calibration.pose.three_point import placed_points
from raxel.calibration.views.correspondence import BoardView
from raxel.calibration.views.samples import sample_boards
from raxel.errors import CalibrationError, InputError

SETTINGS = MirrorSettings(fixed_shape=False)
# mm between two places of the monitor: nearer, they are one, or tell of no directions.
NEAREST_MM = 10.0
LINE_POINTS = 9
# How far the clamp's line may lie outside what sees the monitor, and how much of that
# may lie beyond the line: shares of its extent along u, and of its pixels.
OUTSIDE, BEYOND = 0.25, 0.1
# Where nobody states the deflections: the end moves by this share of the length.
DEFLECTED = 0.1
# Points of the monitor beyond this many medians are wrong; more than this share is not
# left out in silence.
FAR, ROUNDS, MOST_WRONG = 10.0, 4, 0.25
SAMPLES = 1000  # pixels for each grid, about, as in the thesis


class ClampPicks(NamedTuple):
    """points (N, 2) px along the clamp's edge; sd_px: of each, across it; hidden_mm: by
    how much the edge may lie before the true clamp."""

    points: np.ndarray
    sd_px: float = 0.0
    hidden_mm: float = 0.0


class StepViews(NamedTuple):
    """BoardViews of a board that stands still, before and after one deflection, their
    corners in the same order; deflection_mm: as stated, None where it is not. A view
    that is the after of one step and the before of the next has one name in both."""

    before: BoardView
    after: BoardView
    deflection_mm: float | None = None


class MirrorViews(NamedTuple):
    """What `calibrate_mirror` takes.

    viewer: the calibrated central camera; grids: a DenseView in the mirror for each
    place of the monitor; platter: PlatterPictures, position k being
    that of grids[k]; thickness: of the platter, mm; clamp: ClampPicks; steps:
    StepViews; flags: what a reader should know of the pictures, one text each.
    """

    viewer: object
    grids: tuple
    platter: tuple
    thickness: float
    clamp: ClampPicks
    steps: tuple
    flags: tuple = ()


class MirrorCalibration(NamedTuple):
    """cameras: a SplineMirrorCamera for each stage, 0 the first shape; poses:
    PlatterPoses; line: ClampLine; primary: PrimaryCalibration; updates: a MirrorUpdate
    for each step; bundle: StageBundle, whose cameras these are; views: the StageViews
    that went into it; flags: of views and stages, one text each."""

    cameras: tuple
    poses: PlatterPoses
    line: ClampLine
    primary: PrimaryCalibration
    updates: tuple
    bundle: StageBundle
    views: tuple
    flags: tuple

    def residuals_mm(self, stage):
        """Distances (N,), mm, of the boards' corners of a stage from its rays."""
        found = [
            ray_distances(self.cameras[stage], view, self.bundle.T_camera_grid[grid])
            for at, grid, view in self.views
            if at == stage
        ]
        return np.concatenate([np.zeros(0), *found])


def calibrate_mirror(views, quantity="inverse depth", settings=SETTINGS, say=None):
    """MirrorCalibration of MirrorViews.

    quantity: of the splines, see SplineMirrorCamera; settings: MirrorSettings of each
    step; say: a callable that is told what is done, a line each. Raises InputError and
    CalibrationError, one line, that name the step or picture: whatever a stage leaves
    open is refused, so that no camera's shape is a guess.
    """
    say = say or (lambda line: None)
    say("places of the monitor, through the platter")
    poses = grid_poses_in_platter(views.viewer, views.platter, views.thickness)
    _check_apart(poses, views.grids)
    line = _line(views)
    say("first shape of the mirror")
    spline = {"shape": settings.shape, "degree": settings.degree, "quantity": quantity}
    primary, wrong = _primary(views, poses, line, spline)
    clamp = _held(primary.camera, line, views)
    updates = _updated(primary.camera, views.steps, clamp, settings, say)
    say("all stages at once")
    cameras = [primary.camera, *(update.camera for update in updates)]
    shown, T_camera_grid = _stage_views(views.steps, updates)
    bundle = bundle_stages(
        cameras, shown, T_camera_grid, clamp=clamp,
        first_covariance=primary.covariance, prior_sd=settings.prior_sd,
    )  # fmt: skip
    flags = [*views.flags, *wrong, *(f"first shape: {text}" for text in primary.flags)]
    for k, update in enumerate(updates, 1):
        flags += [f"stage {k}: {text}" for text in update.flags]
    flags += [text for text in bundle.flags if text not in flags]
    return MirrorCalibration(
        bundle.cameras, poses, line, primary, updates, bundle, shown, tuple(flags)
    )


def ray_distances(camera, view, T_camera_grid):
    """Distances (n,), mm, of a BoardView's corners that were found from their rays."""
    off = _from_rays(camera, view.pixels, view.points[None], T_camera_grid[None])[0]
    return off[np.isfinite(off)]


def _check_apart(poses, grids):
    """Refuse a place of the monitor that was photographed twice."""
    middle = np.mean(grids[0].points[np.isfinite(grids[0].pixels[:, 0])], axis=0)
    for first in range(len(grids)):
        for second in range(first + 1, len(grids)):
            moved = poses.motion(first, second, middle).distance
            if moved < NEAREST_MM:
                raise CalibrationError(
                    f"primary calibration: {grids[first].name} and "
                    f"{grids[second].name} are one place of the monitor, {moved:.1f} "
                    "mm apart; move it by some 100 mm between them"
                )


def _line(views):
    """The ClampLine, no more certain than its picks, beside what sees the monitor."""
    found = clamp_line(views.viewer, views.clamp.points)
    picks = views.clamp.points[found.used]
    sd = views.clamp.sd_px / np.median(magnification(views.viewer, picks))
    p = normalised(views.viewer, picks)
    reach = np.linalg.norm(p - p.mean(axis=0), axis=1)
    line = found._replace(
        offset_sd=max(found.offset_sd, sd / np.sqrt(len(picks))),
        angle_sd=max(found.angle_sd, sd / np.sqrt(np.sum(reach**2))),
    )
    _check_beside(line, views)
    return line


def _check_beside(line, views):
    """Refuse a clamp that lies away from the mirror, or across it."""
    pixels = np.concatenate([view.pixels for view in views.grids])
    p = normalised(views.viewer, pixels[np.isfinite(pixels[:, 0])])
    axis = np.array([np.cos(line.angle), np.sin(line.angle)])
    off = (p - line.ends[0]) @ axis
    sign = 1.0 if np.median(off) > 0 else -1.0
    off, extent = sign * off, np.ptp(off)
    if off.min() > OUTSIDE * extent:
        raise InputError(
            f"clamp: its line lies {100 * off.min() / extent:.0f} % of the mirror's "
            "length away from where the mirror shows the monitor; pick it at the edge "
            "of the mirror, and let the monitor fill the mirror"
        )
    beyond = np.mean(off < 0)
    if beyond > BEYOND:
        raise InputError(
            f"clamp: {100 * beyond:.0f} % of the pixels that see the monitor lie "
            "beyond its line; pick it where the mirror is held, at the mirror's edge"
        )


def _primary(views, poses, line, spline):
    """(PrimaryCalibration, flags) of pixels spread over the grids, without those that
    were decoded wrongly, as at the mirror's border."""
    viewer, grids = views.viewer, views.grids
    samples = SAMPLES * len(grids)
    seen = sample_boards(grids, viewer.width, viewer.height, samples)
    points = np.where(seen.seen[..., None], seen.points, np.nan)
    pixels, known = seen.pixels.astype(float), np.count_nonzero(seen.seen)
    span = line.points(LINE_POINTS)
    for _ in range(ROUNDS):
        found = primary_from_points(
            viewer, pixels, points, poses, angle=line.angle, span=span, **spline
        )
        # By the linear stage, which a few wrong points hardly turn.
        off = _from_rays(found.linear, pixels, points, poses.T_camera_grid)
        far = off > FAR * np.nanmedian(off)
        if not far.any():
            break
        points[far] = np.nan
    left = np.count_nonzero(np.isfinite(points[..., 0]))
    if left < (1 - MOST_WRONG) * known:
        raise CalibrationError(
            f"primary calibration: {known - left} of {known} points of the monitor do "
            "not fit the others; photograph its patterns anew, with nothing moved"
        )
    flags = [f"first shape: {known - left} of {known} points of the monitor left out"]
    return found, flags if left < known else []


def _from_rays(camera, pixels, points, T_camera_grid):
    """Distances (n, N), mm, of what pixels (N, 2) see of n grids from their rays."""
    rays = camera.rays(pixels)
    placed = [placed_points(xy, T) for xy, T in zip(points, T_camera_grid, strict=True)]
    return np.linalg.norm(np.cross(rays.directions, placed - rays.origins), axis=2)


def _held(camera, line, views):
    """FixedLine, by what of the clamp is hidden and how far the mirror is to bend."""
    hidden = views.clamp.hidden_mm
    length = hidden + _length(camera, line)
    stated = [step.deflection_mm for step in views.steps]
    if None in stated:
        most = DEFLECTED * length
    else:
        most = np.abs(np.cumsum(stated)).max()
    return (
        fixed_line(
            camera, line, hidden=hidden, length=length, deflection=float(most) or None
        )
        if most
        else fixed_line(camera, line)
    )


def _length(camera, line):
    """mm on the mirror from the middle of the line to the knots' other end."""
    grid, middle = camera.grid, line.points(3)[1:2]
    u, v = grid.turned(middle)[0]
    ends = grid.breaks[0][[0, -1]]
    far = grid.unturned(np.array([[ends[np.argmax(np.abs(ends - u))], v]]))
    return float(
        np.linalg.norm(np.diff(camera.mirror.points(np.r_[middle, far]), axis=0))
    )


def _updated(camera, steps, clamp, settings, say):
    """A MirrorUpdate for each step, from the camera of the one before."""
    found = []
    for k, step in enumerate(steps, 1):
        say(f"step {k}: {step.before.name}, {step.after.name}")
        # What the mirror shows at this stage: knots reach what the next step needs.
        outline = step.after.pixels
        if k < len(steps):
            outline = np.concatenate([outline, steps[k].before.pixels])
        outline = outline[np.isfinite(outline[:, 0])]
        noise = _noise(step)
        try:
            update = update_mirror(
                camera, step.before.pixels, step.after.pixels, step.before.points,
                clamp, settings._replace(noise_px=noise or settings.noise_px),
                outline=outline,
            )  # fmt: skip
        except CalibrationError as fault:
            raise CalibrationError(
                f"step {k} ({step.before.name}, {step.after.name}): {fault}"
            ) from fault
        found.append(update)
        camera = update.camera
    return tuple(found)


def _noise(step):
    """Median standard deviation of a step's corners, px; None where not stated."""
    stated = [view.sd for view in (step.before, step.after) if view.sd is not None]
    if not stated or not np.isfinite(stated).any():
        return None
    return float(np.nanmedian(np.concatenate(stated)))


def _stage_views(steps, updates):
    """(StageViews, T_camera_grid (m, 4, 4)): every picture once, without the corners
    taken for wrong; a board that stayed over several steps has one pose."""
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
