"""Mirror sets: `raxel calibrate` and `raxel evaluate`."""

import re
from pathlib import Path

import numpy as np

from raxel.calibration import board_views, calibrate_mirror
from raxel.calibration.mirror.images import mirror_views
from raxel.cameras.registry import load_camera
from raxel.cli.evaluate import check_size
from raxel.cli.findings import of_left_out, of_pitch, reported
from raxel.cli.outputs import (
    check_outputs,
    check_writable,
    exit_if_strict,
    write_results,
)
from raxel.cli.views import check_options
from raxel.errors import InputError
from raxel.evaluation.comparison import back_projection, expected_errors, spread_fields
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.diagnoses import (
    Diagnosis,
    diagnosis,
    known,
    mirror_lines,
    score_text,
    stage_lines,
)
from raxel.features.boards import detect_boards
from raxel.report import write_mirror_report
from raxel.sets import load_mirror_set

STAGE_OF_NAME = re.compile(r"-(\d{1,4})$")


def calibrate_mirror_set(options, say):
    """Fit a camera to each stage of a mirror set: all files are written, or none."""
    mirror_set = load_mirror_set(options.set)
    if options.model != "auto":
        raise InputError(
            f"--model: found {options.model}, but {mirror_set.description} is a mirror "
            "set (spline model); leave --model out"
        )
    if options.central:
        raise InputError(
            f"--central: {mirror_set.description} is a mirror set, whose camera is not "
            "central; leave --central out"
        )
    check_options(mirror_set, options)
    outputs = stage_files(options.out, len(mirror_set.steps) + 1)
    check_outputs(options, mirror_set, [options.out, *outputs])
    views = mirror_views(mirror_set, say)
    try:
        found = calibrate_mirror(views, say=say)
    except InputError as fault:
        raise type(fault)(f"{mirror_set.description}: {fault}") from fault
    expected = expected_errors(mirror_set, views, found, say)
    result = _result(mirror_set, views, found, outputs, *expected)
    for label, text in (*mirror_lines(result), *stage_lines(result)):
        print(f"{mirror_set.name}: {label}: {text}")
    flags = [Diagnosis.reported("mirror", text) for text in found.flags]
    sets = mirror_set.image_sets.values()
    result |= reported(flags + [w for one in sets for w in of_pitch(one.target)])
    if options.report:
        say(f"drawing the report of {len(found.cameras)} stages")
    names, cameras = [*outputs, options.out], [*found.cameras, found.cameras[-1]]
    write_results(
        options,
        result,
        dict(zip(names, cameras, strict=True)),
        lambda folder: write_mirror_report(folder, mirror_set, found, result),
    )
    exit_if_strict(options, result)


def stage_files(out, count):
    """mirror-0.npz, mirror-1.npz, ... next to mirror.npz: the cameras of the stages."""
    path = Path(out)
    return [str(path.with_name(f"{path.stem}-{k}{path.suffix}")) for k in range(count)]


def _result(mirror_set, views, found, outputs, errors, with_viewer):
    """What is written to --json; errors, with_viewer: of `expected_errors`."""
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
        "stages": [
            _stage(mirror_set, found, k, path) | {"predicted_ray_error_deg": error}
            for k, (path, error) in enumerate(zip(outputs, errors, strict=True))
        ],
        "bundle": {
            "corners_variance": found.bundle.variance,
            "freedom": int(found.bundle.freedom),
            "converged": bool(found.bundle.converged),
        },
    }


def _primary(views, found):
    """The first shape: how well rays meet, and the poses of the monitor."""
    primary = found.primary
    return {
        "points_from_rays_mm": known(np.nanmean(primary.mirror.misses)),
        "residual_mm": spread_fields(primary.residuals),
        "platter_rms_px": found.poses.rms_px,
        "grids": [
            {
                "first": views.grids[0].name,
                "second": view.name,
                "distance_mm": motion.distance,
                "distance_sd_mm": known(motion.distance_sd),
                "angle_deg": float(np.degrees(motion.angle)),
                "angle_sd_deg": known(np.degrees(motion.angle_sd)),
            }
            for view, motion in zip(views.grids[1:], primary.motions, strict=True)
        ],
    }


def _stage(mirror_set, found, stage, path):
    """One stage: the data of its shape, and its residuals."""
    fields = {
        "camera": path,
        "functions": list(found.cameras[stage].grid.shape),
        "residual_mm": spread_fields(found.residuals_mm(stage)),
    }
    if stage == 0:
        return fields
    step, update = mirror_set.steps[stage - 1], found.updates[stage - 1]
    grid = next(view.grid for view in found.views if view.view.name == step.after)
    return fields | {
        "before": step.before,
        "after": step.after,
        "deflection_mm": step.deflection_mm,
        "T_camera_grid": found.bundle.T_camera_grid[grid].tolist(),
        "step_by_step_residual_mm": spread_fields(update.residuals),
        "corners": int(np.count_nonzero(update.used)),
        "wrong_corners": int(np.count_nonzero(update.wrong)),
        "support": {
            "along_u": update.support.along_u.tolist(),
            "along_v": update.support.along_v.tolist(),
            "reach": update.support.reach.tolist(),
        },
        "flags": list(update.flags),
    }


def evaluate_mirror_set(options, say):
    """Score a camera of one stage on the boards of `evaluate` of that stage's step."""
    check_writable(options.json)
    mirror_set = load_mirror_set(options.set)
    check_options(mirror_set, options)
    check_outputs(options, mirror_set, read=[options.camera])
    camera = load_camera(options.camera)
    check_size(options.camera, camera, mirror_set.stages)
    stage, by = _stage_to_score(options, mirror_set)
    views, missed = _boards(mirror_set, stage, say)
    projected = [back_projection(camera, view) for view in views]
    result = {"set": mirror_set.name, "camera": options.camera, "stage": stage}
    result |= _scores(evaluate_camera(camera, views), projected) | {"left_out": missed}
    print(
        f"{mirror_set.name}: stage {stage} ({by}), boards to evaluate: "
        f"{score_text(result)}"
    )
    whole = result["back_projection_mm"]
    if whole["corners"]:
        print(
            f"{mirror_set.name}: back-projection with the fitted poses: mean "
            f"{whole['mean']:.3f} mm, RMS {whole['rms']:.3f} mm, {whole['corners']} "
            "corners"
        )
    unposed = [
        diagnosis("no-pose", file=one.name, reason=one.reason)
        for one in projected
        if one.reason
    ]
    result |= reported(of_left_out(missed) + unposed)
    write_results(options, result)
    exit_if_strict(options, result)


def _stage_to_score(options, mirror_set):
    """(number of the stage, how it is known)"""
    last = len(mirror_set.steps)
    stage, by = last, "the last"
    if options.stage is not None:
        stage, by = options.stage, "by --stage"
    elif named := STAGE_OF_NAME.search(Path(options.camera).stem):
        stage, by = int(named[1]), f"by the name of {Path(options.camera).name}"
    if stage > last:
        raise InputError(
            f"{mirror_set.description}: stages.steps: no stage {stage} ({by}); give "
            f"--stage 1 to {last}"
        )
    if stage == 0 or not mirror_set.steps[stage - 1].evaluate:
        where = f"stages.steps[{stage - 1}].evaluate" if stage else "stages.steps"
        raise InputError(
            f"{mirror_set.description}: {where}: no image to score stage {stage} "
            f"({by}); add one, or give another --stage"
        )
    return stage, by


def _boards(mirror_set, stage, say):
    """(BoardViews of the stage's boards to evaluate, [{file, reason}] of others)"""
    named = {view.label: view for view in mirror_set.stages.views}
    wanted = [named[name] for name in mirror_set.steps[stage - 1].evaluate]
    boards = detect_boards(mirror_set.stages, views=wanted, say=say)
    missed = [
        {"file": board.view.label, "reason": board.detection.reason}
        for board in boards
        if not board.detection.found
    ]
    if len(missed) == len(boards):
        raise InputError(
            f"{mirror_set.stages.description}: {missed[0]['file']}: no board found: "
            f"{missed[0]['reason']}; take images of the whole board in the mirror"
        )
    return board_views(mirror_set.stages, boards), missed


def _scores(evaluation, projected):
    """The scores, with the back-projection at the fitted pose of each board."""
    result = evaluation.fields()
    for image, one in zip(result["images"], projected, strict=True):
        T = one.T_camera_grid
        image["T_camera_grid_by_rays"] = None if T is None else T.tolist()
        image["back_projection_mm"] = _distances(one.distances_mm)
    whole = np.concatenate([one.distances_mm for one in projected])
    return result | {"back_projection_mm": _distances(whole)}


def _distances(distances):
    if len(distances) == 0:
        return {"mean": None, "rms": None, "corners": 0}
    return {
        "mean": float(np.mean(distances)),
        "rms": float(np.sqrt(np.mean(distances**2))),
        "corners": len(distances),
    }
