"""`raxel calibrate MIRRORSET --out mirror.npz --json F --report FOLDER`"""

from contextlib import nullcontext
from pathlib import Path

import numpy as np

from raxel.calibration.mirror.images import mirror_views
from raxel.calibration.mirror.stages import calibrate_mirror
from raxel.calibration.views.boards import board_views
from raxel.cli.outputs import check_written
from raxel.cli.scores import known
from raxel.cli.warnings import print_warnings
from raxel.errors import CalibrationError, InputError
from raxel.evaluation.comparison import predicted_errors, viewers_aside
from raxel.features.boards import detect_boards
from raxel.io.files import check_can_be_written, together, write_json
from raxel.report import check_report, new_report, write_mirror_report
from raxel.sets import ImageSet, load_mirror_set

# Options of `raxel calibrate` that a mirror set has no use for.
NOT_OF_A_MIRROR = "corners", "points", "detector"
NO_VIEWER = ", without the viewer's own error, which nobody states"
SPREAD = 21  # places along either side of a mirror at which its rays are looked at


def calibrate_mirror_set(options, say):
    """Fit a camera to each stage of a mirror set: all files are written, or none."""
    mirror_set = load_mirror_set(options.set)
    _check_options(options, mirror_set)
    outputs = stage_files(options.out, len(mirror_set.steps) + 1)
    written = [options.out, *outputs, options.json]
    for path in filter(None, written):
        check_can_be_written(path)
    _check_apart(options, outputs)
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
    for line in _lines(mirror_set, result):
        print(line)
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
    """mirror-0.npz, mirror-1.npz, ... beside mirror.npz: the cameras of the stages."""
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


def _check_apart(options, outputs):
    taken = {Path(path).resolve() for path in (options.out, *outputs)}
    if options.json and Path(options.json).resolve() in taken:
        raise InputError(
            f"{options.json}: --json names the file of another result; give another "
            "name"
        )


def _check_options(options, mirror_set):
    if options.model != "auto":
        raise InputError(
            f"--model: found {options.model} with {mirror_set.description}, whose "
            "mirror is a spline; leave --model out"
        )
    for option in NOT_OF_A_MIRROR:
        if getattr(options, option):
            raise InputError(
                f"--{option}: found with {mirror_set.description}, a mirror set; "
                "leave it out"
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
        "warnings": list(found.flags),
    }


def _primary(views, found):
    """Of the first shape: how well rays meet, and the monitor's places."""
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
    """Of one stage: what its shape rests on, and how sure it is."""
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
    """{mean, sd} of distances, None where there are none."""
    residuals = residuals[np.isfinite(residuals)]
    if len(residuals) == 0:
        return {"mean": None, "sd": None}
    return {"mean": float(np.mean(residuals)), "sd": float(np.std(residuals))}


def _expected(mirror_set, views, found, say):
    """([{median, largest}] over each stage's mirror: errors of rays to be expected,
    degrees; whether the viewer's own error is in them)"""
    pixels = [_spread_over(camera) for camera in found.cameras]
    aside, counted = _viewers_aside(mirror_set, views, say), False
    try:
        errors, counted = predicted_errors(views, found, pixels, aside), bool(aside)
    except CalibrationError:
        errors = predicted_errors(views, found, pixels)
    known = [each[np.isfinite(each)] for each in errors]
    told = [
        {"median": float(np.median(each)), "largest": float(np.max(each))}
        for each in known
    ]
    return told, counted


def _viewers_aside(mirror_set, views, say):
    """Viewers a standard deviation aside; none where photographs do not tell it."""
    if not isinstance(mirror_set.viewer, ImageSet):
        return []
    say("how far the viewer may be off")
    boards = board_views(mirror_set.viewer, detect_boards(mirror_set.viewer))
    return viewers_aside(views.viewer, boards)


def _spread_over(camera):
    """Pixels (SPREAD^2, 2) all over the mirror."""
    u, v = (np.linspace(b[0], b[-1], SPREAD) for b in camera.grid.breaks)
    p = camera.grid.unturned(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    return camera.viewer.project(np.column_stack([p, np.ones(len(p))])).pixels


def _lines(mirror_set, result):
    """What was found, for people."""
    name, primary = mirror_set.name, result["primary"]
    places = ", ".join(
        f"{m['first']} and {m['second']} {m['distance_mm']:.2f} mm apart (SD "
        f"{m['distance_sd_mm']:.2f})"
        for m in primary["grids"]
    )
    yield (
        f"{name}: first shape: rays meet within {primary['points_from_rays_mm']:.3f} "
        f"mm (mean); {places}"
    )
    without = "" if result["viewer_error_counted"] else NO_VIEWER
    for k, stage in enumerate(result["stages"]):
        sure = stage["predicted_ray_error_deg"]
        stated = stage.get("deflection_mm")
        bent = "" if stated is None else f", bent by {stated:g} mm as stated"
        residual = stage["residual_mm"]
        yield (
            f"{name}: stage {k}{bent}: residual {residual['mean']:.3f} mm (SD "
            f"{residual['sd']:.3f}), rays predicted to {sure['median']:.3f} deg "
            f"(median), {sure['largest']:.3f} at most{without}"
        )
