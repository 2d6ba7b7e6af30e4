"""`raxel evaluate mirror-2.npz MIRRORSET --stage N --json F`"""

import re
from pathlib import Path

import numpy as np

from raxel.calibration.views.boards import board_views
from raxel.cameras.registry import load_camera
from raxel.cli.evaluate import check_size
from raxel.cli.mirror import BOARD_OPTIONS, check_mirror_written, check_no_options
from raxel.cli.warnings import of_left_out, print_warnings, warning_fields
from raxel.errors import InputError
from raxel.evaluation.comparison import back_projection
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.diagnoses import diagnosis, score_text
from raxel.features.boards import detect_boards
from raxel.io.files import check_can_be_written, write_json
from raxel.sets import load_mirror_set

STAGE_OF_NAME = re.compile(r"-(\d{1,4})$")


def evaluate_mirror_set(options, say):
    """Score a camera of one stage on the boards of `evaluate` of that stage's step."""
    if options.json:
        check_can_be_written(options.json)
    mirror_set = load_mirror_set(options.set)
    check_no_options(options, mirror_set, (*BOARD_OPTIONS, "board"))
    check_mirror_written([options.json], mirror_set, [options.camera])
    camera = load_camera(options.camera)
    check_size(options.camera, camera, mirror_set.stages)
    stage, by = _stage(options, mirror_set)
    views, missed = _boards(mirror_set, stage, say)
    evaluation = evaluate_camera(camera, views)
    projected = [back_projection(camera, view) for view in views]
    warnings = of_left_out(missed)
    for one in projected:
        if one.reason:
            warnings.append(diagnosis("no-pose", file=one.name, reason=one.reason))
    scores = _as_json(evaluation, projected)
    if options.json:
        result = {"set": mirror_set.name, "camera": options.camera, "stage": stage}
        result |= scores | {"left_out": missed} | warning_fields(warnings)
        write_json(options.json, result)
    label = f"{mirror_set.name}: stage {stage} ({by}), boards to evaluate"
    print(f"{label}: {score_text(scores)}")
    whole = scores["back_projection_mm"]
    if whole["corners"]:
        print(
            f"{mirror_set.name}: back-projection with the fitted poses: mean "
            f"{whole['mean']:.3f} mm, RMS {whole['rms']:.3f} mm, {whole['corners']} "
            "corners"
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


def _as_json(evaluation, projected):
    """The scores, with the back-projection at the fitted pose of each board."""
    result = evaluation.fields()
    for image, one in zip(result["images"], projected, strict=True):
        T = one.T_camera_grid
        image["T_camera_grid_by_rays"] = None if T is None else T.tolist()
        image["back_projection_mm"] = _fields(one.distances_mm)
    whole = np.concatenate([one.distances_mm for one in projected])
    return result | {"back_projection_mm": _fields(whole)}


def _fields(distances):
    if len(distances) == 0:
        return {"mean": None, "rms": None, "corners": 0}
    rms = float(np.sqrt(np.mean(distances**2)))
    return {"mean": float(np.mean(distances)), "rms": rms, "corners": len(distances)}
