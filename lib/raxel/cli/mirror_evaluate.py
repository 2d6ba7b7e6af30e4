"""`raxel evaluate mirror-2.npz MIRRORSET --stage N --json F`"""

import re
from pathlib import Path

import numpy as np

from raxel.calibration.views.boards import board_views
from raxel.cameras.registry import load_camera
from raxel.cli import scores
from raxel.cli.evaluate import check_size
from raxel.cli.mirror import NOT_OF_A_MIRROR, check_mirror_written
from raxel.cli.warnings import of_left_out, print_warnings
from raxel.errors import InputError
from raxel.evaluation.comparison import back_projection
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.features.boards import detect_boards
from raxel.io.files import check_can_be_written, write_json
from raxel.sets import load_mirror_set

STAGE_OF_NAME = re.compile(r"-(\d{1,4})$")


def evaluate_mirror_set(options, say):
    """Score a camera of one stage on the boards of `evaluate` of that stage's step."""
    if options.json:
        check_can_be_written(options.json)
    mirror_set = load_mirror_set(options.set)
    for option in (*NOT_OF_A_MIRROR, "board"):
        if getattr(options, option, None):
            raise InputError(
                f"--{option}: found with {mirror_set.description}, a mirror set; "
                "leave it out"
            )
    check_mirror_written([options.json], mirror_set, [options.camera])
    camera = load_camera(options.camera)
    check_size(options.camera, camera, mirror_set.stages)
    stage, by = _stage(options, mirror_set)
    views, missed = _boards(mirror_set, stage, say)
    evaluation = evaluate_camera(camera, views)
    cast = [back_projection(camera, view) for view in views]
    warnings = of_left_out(missed)
    warnings += [f"{one.name}: {one.reason}" for one in cast if one.reason]
    if options.json:
        result = {"set": mirror_set.name, "camera": options.camera, "stage": stage}
        result |= _as_json(evaluation, cast)
        result |= {"left_out": missed, "warnings": warnings}
        write_json(options.json, result)
    name = f"{mirror_set.name}: stage {stage} ({by}), boards to evaluate"
    print(scores.line(name, evaluation))
    whole = np.concatenate([one.distances_mm for one in cast])
    if len(whole):
        print(
            f"{mirror_set.name}: back-projection at the boards' own poses: mean "
            f"{np.mean(whole):.3f} mm, rms {_rms(whole):.3f} mm, {len(whole)} corners"
        )
    print_warnings(warnings)


def _stage(options, mirror_set):
    """(number of the stage, how it is known)"""
    last = len(mirror_set.steps)
    named = STAGE_OF_NAME.search(Path(options.camera).stem)
    stage, by = last, "the last"
    if options.stage is not None:
        stage, by = options.stage, "by --stage"
    elif named:
        stage, by = int(named[1]), f"by the name of {Path(options.camera).name}"
    if stage > last:
        raise InputError(
            f"{mirror_set.description}: stages.steps: found {last}, stage {stage} "
            f"({by}) is not among them; give --stage 1 to {last}"
        )
    if stage == 0 or not mirror_set.steps[stage - 1].evaluate:
        where = f"stages.steps[{stage - 1}].evaluate" if stage else "stages.steps"
        raise InputError(
            f"{mirror_set.description}: {where}: found no photograph to score stage "
            f"{stage} ({by}) with; name one, or give --stage for another"
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
            f"{missed[0]['reason']}; photograph the whole board in the mirror"
        )
    return board_views(mirror_set.stages, boards), missed


def _as_json(evaluation, cast):
    """The scores, with what is cast back at each board's own pose."""
    result = scores.as_json(evaluation)
    for image, one in zip(result["images"], cast, strict=True):
        T = one.T_camera_grid
        image["T_camera_grid_by_rays"] = None if T is None else T.tolist()
        image["back_projection_mm"] = _fields(one.distances_mm)
    whole = np.concatenate([one.distances_mm for one in cast])
    return result | {"back_projection_mm": _fields(whole)}


def _fields(distances):
    if len(distances) == 0:
        return {"mean": None, "rms": None, "corners": 0}
    return {
        "mean": float(np.mean(distances)),
        "rms": _rms(distances),
        "corners": len(distances),
    }


def _rms(distances):
    return float(np.sqrt(np.mean(distances**2)))
