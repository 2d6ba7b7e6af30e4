"""`raxel calibrate MIRRORSET --out mirror.npz --json F --report FOLDER`"""

from contextlib import nullcontext
from pathlib import Path

import numpy as np

from raxel.calibration.mirror.images import mirror_views
from raxel.calibration.mirror.stages import calibrate_mirror
from raxel.calibration.views.boards import board_views
from raxel.cli.outputs import check_written
from raxel.cli.warnings import print_warnings, warning_fields
from raxel.errors import CalibrationError, InputError
from raxel.evaluation.comparison import predicted_errors, viewers_aside
from raxel.evaluation.diagnoses import Diagnosis, known, mirror_lines, stage_lines
from raxel.features.boards import detect_boards
from raxel.io.files import check_can_be_written, together, write_json
from raxel.report import check_report, new_report, write_mirror_report
from raxel.sets import ImageSet, load_mirror_set

# Options of `raxel calibrate` that do not apply to a mirror set.
BOARD_OPTIONS = "corners", "points", "detector"
N_SAMPLES = 21  # along each side of a mirror, at which the errors of rays are predicted


def calibrate_mirror_set(options, say):
    """Fit a camera to each stage of a mirror set: all files are written, or none."""
    mirror_set = load_mirror_set(options.set)
    if options.model != "auto":
        raise InputError(
            f"--model: found {options.model}, but {mirror_set.description} is a mirror "
            "set (spline model); leave --model out"
        )
    check_no_options(options, mirror_set, BOARD_OPTIONS)
    outputs = stage_files(options.out, len(mirror_set.steps) + 1)
    written = [options.out, *outputs, options.json]
    for path in filter(None, written):
        check_can_be_written(path)
    taken = {Path(path).resolve() for path in (options.out, *outputs)}
    if options.json and Path(options.json).resolve() in taken:
        raise InputError(
            f"{options.json}: --json names the file of another result; give another "
            "name"
        )
    check_mirror_written(written, mirror_set)
    if options.report:
        _check_report(options.report, mirror_set, written)
    views = mirror_views(mirror_set, say)
    try:
        found = calibrate_mirror(views, say=say)
    except InputError as fault:
        raise type(fault)(f"{mirror_set.description}: {fault}") from fault
    expected = _expected(mirror_set, views, found, say)
    result = _result(mirror_set, views, found, outputs, expected)
    for label, text in (*mirror_lines(result), *stage_lines(result)):
        print(f"{mirror_set.name}: {label}: {text}")
    print_warnings(result["warnings"])
    report = new_report(options.report) if options.report else nullcontext()
    with report as folder, together() as place:
        # Drawn first, and put in its place when all else is written.
        if folder:
            say(f"drawing the report of {len(found.cameras)} stages")
            write_mirror_report(folder, mirror_set, found, result)
        for path, camera in zip(outputs, found.cameras, strict=True):
            camera.save(place(path))
        found.cameras[-1].save(place(options.out))
        if options.json:
            write_json(place(options.json), result)


def stage_files(out, count):
    """mirror-0.npz, mirror-1.npz, ... next to mirror.npz: the cameras of the stages."""
    path = Path(out)
    return [str(path.with_name(f"{path.stem}-{k}{path.suffix}")) for k in range(count)]


def check_mirror_written(written, mirror_set, read=()):
    """As `check_written`, for all that a mirror set reads."""
    own = [mirror_set.description, *read]
    if not isinstance(mirror_set.viewer, ImageSet):
        own.append(mirror_set.viewer)
    check_written(written, list(mirror_set.image_sets.values()), own)


def _check_report(folder, mirror_set, written):
    """As `check_report`, for the mirror set's folder and all of its image sets."""
    viewer = mirror_set.viewer
    others = [*written, *([] if isinstance(viewer, ImageSet) else [viewer])]
    for one in (mirror_set, *mirror_set.image_sets.values()):
        check_report(folder, one, others)


def check_no_options(options, mirror_set, names):
    """Raise InputError for options that do not apply to a mirror set."""
    for option in names:
        if getattr(options, option, None):
            raise InputError(
                f"--{option}: not for a mirror set ({mirror_set.description}); leave "
                "it out"
            )


def _result(mirror_set, views, found, outputs, expected):
    """What is written to --json; expected: of `_expected`."""
    errors, with_viewer = expected
    stages = [
        _stage(mirror_set, found, k, path) | {"predicted_ray_error_deg": error}
        for k, (path, error) in enumerate(zip(outputs, errors, strict=True))
    ]
    return {
        "set": mirror_set.name,
        "model": "spline mirror",
        "unit": "mm",
        "viewer": views.viewer.kind,
        "viewer_error_counted": with_viewer,
        "clamp": {
            "points": views.clamp.points.tolist(),
            "rms_px": found.line.rms_px,
            "hidden_mm": views.clamp.hidden_mm,
        },
        "primary": _primary(views, found),
        "stages": stages,
        "bundle": {
            "corners_variance": found.bundle.variance,
            "freedom": int(found.bundle.freedom),
            "converged": bool(found.bundle.converged),
        },
        **warning_fields([Diagnosis.reported("mirror", text) for text in found.flags]),
    }


def _primary(views, found):
    """The first shape: how well rays meet, and the poses of the monitor."""
    primary = found.primary
    motions = [
        {
            "first": views.grids[0].name,
            "second": view.name,
            "distance_mm": motion.distance,
            "distance_sd_mm": known(motion.distance_sd),
            "angle_deg": float(np.degrees(motion.angle)),
            "angle_sd_deg": known(np.degrees(motion.angle_sd)),
        }
        for view, motion in zip(views.grids[1:], primary.motions, strict=True)
    ]
    return {
        "points_from_rays_mm": known(np.nanmean(primary.mirror.misses)),
        "residual_mm": _spread(primary.residuals),
        "platter_rms_px": found.poses.rms_px,
        "grids": motions,
    }


def _stage(mirror_set, found, stage, path):
    """One stage: the data of its shape, and its residuals."""
    camera = found.cameras[stage]
    fields = {
        "camera": path,
        "functions": list(camera.grid.shape),
        "residual_mm": _spread(found.residuals_mm(stage)),
    }
    if stage == 0:
        return fields
    step, update = mirror_set.steps[stage - 1], found.updates[stage - 1]
    names = [view.view.name for view in found.views]
    grid = found.views[names.index(step.after)].grid
    return fields | {
        "before": step.before,
        "after": step.after,
        "deflection_mm": step.deflection_mm,
        "T_camera_grid": found.bundle.T_camera_grid[grid].tolist(),
        "step_by_step_residual_mm": _spread(update.residuals),
        "corners": int(np.count_nonzero(update.used)),
        "wrong_corners": int(np.count_nonzero(update.wrong)),
        "support": {
            "along_u": update.support.along_u.tolist(),
            "along_v": update.support.along_v.tolist(),
            "reach": update.support.reach.tolist(),
        },
        "flags": list(update.flags),
    }


def _spread(residuals):
    """{mean, sd} of distances; None without any."""
    residuals = residuals[np.isfinite(residuals)]
    if len(residuals) == 0:
        return {"mean": None, "sd": None}
    return {"mean": float(np.mean(residuals)), "sd": float(np.std(residuals))}


def _expected(mirror_set, views, found, say):
    """([{median, largest}] over each stage's mirror: predicted errors of rays, degrees;
    whether the error of the camera that views the mirror is included)"""
    pixels = [_spread_over(camera) for camera in found.cameras]
    perturbed, counted = _perturbed(mirror_set, views, say), False
    try:
        errors = predicted_errors(views, found, pixels, perturbed)
        counted = bool(perturbed)
    except CalibrationError:
        errors = predicted_errors(views, found, pixels)
    finite = [each[np.isfinite(each)] for each in errors]
    predicted = [
        {"median": float(np.median(each)), "largest": float(np.max(each))}
        for each in finite
    ]
    return predicted, counted


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
