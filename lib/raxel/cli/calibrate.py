"""`raxel calibrate SET --model auto|zhang|generic --out camera.npz --json F`"""

import functools
from pathlib import Path

import numpy as np

from raxel.calibration.board_views import board_views
from raxel.calibration.generic import calibrate_generic
from raxel.calibration.zhang import calibrate_zhang
from raxel.cli import scores
from raxel.cli.boards import boards_for, check_enough, left_out
from raxel.cli.outputs import check_written
from raxel.errors import InputError
from raxel.evaluation.comparison import compare_models
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.features.boards import check_chessboard
from raxel.files import check_can_be_written, together, write_json
from raxel.sets import load_set

SEED = 0
FOLDS = 4
FEWEST_VIEWS = {"zhang": 2, "generic": 3, "auto": 3}


def calibrate(options, say):
    """Fit the asked model to the set's views for calibration."""
    for path in filter(None, (options.out, options.json)):
        check_can_be_written(path)
    if options.json and Path(options.json).resolve() == Path(options.out).resolve():
        raise InputError(
            f"{options.json}: --json and --out name the same file; give two names"
        )
    image_set = load_set(options.set)
    check_written([options.out, options.json], [image_set], [options.corners])
    check_chessboard(image_set)
    views = image_set.views_for("calibrate")
    needed = FEWEST_VIEWS[options.model]
    if len(views) < needed:
        raise InputError(
            f"{image_set.description}: views: found {len(views)} to calibrate with, "
            f"--model {options.model} needs {needed}; take more, at other tilts"
        )
    boards = boards_for(image_set, views, options, say)
    check_enough(image_set, boards, needed, f"--model {options.model}")
    try:
        result, camera = _calibrated(image_set, boards, options.model, say)
    except InputError as fault:
        kind = type(fault)
        raise kind(f"{image_set.description}: views: {fault}") from fault
    result |= {"left_out": left_out(boards) + result["left_out"]}
    with together() as place:
        camera.save(place(options.out))
        if options.json:
            write_json(place(options.json), result)


def _calibrated(image_set, boards, model, say):
    """(result for the JSON file, camera)"""
    views = board_views(image_set, boards)
    size = image_set.width, image_set.height
    comparison = None
    if model == "auto":
        comparison = _compare(views, size, image_set.target.unit, say)
        model, why = comparison.choice()
        _print(comparison)
        print(f"{image_set.name}: {model} chosen: {why}", flush=True)
    fit = FITS[model]
    say(f"{model}: fitting {len(views)} boards")
    camera, details = fit(views, size, image_set.target.unit)
    evaluation = evaluate_camera(camera, views)
    print(scores.line(f"{image_set.name}: {model}, fitted boards", evaluation))
    result = {"set": image_set.name, "model": model, "unit": image_set.target.unit}
    result |= {"camera": _described(camera), **details, **scores.as_json(evaluation)}
    if comparison:
        result["chosen_because"] = why
        result["cross_validation"] = _cross_validation(comparison)
    return result, camera


def _zhang(views, size, unit):
    return calibrate_zhang(views, *size).camera, {"left_out": []}


def _generic(views, size, unit):
    rng = np.random.default_rng(SEED)
    found = calibrate_generic(views, *size, rng=rng, units=unit)
    left_out = [
        {"file": views[index].name, "reason": reason}
        for index, reason in sorted(found.left_out.items())
    ]
    used = [views[index].name for index in found.used]
    ways = [found.interpolation[index] for index in found.used]
    return found.camera, {
        "used": used,
        "left_out": left_out,
        "share_of_pixels_with_ray": found.share_with_ray,
        "adjusted_rms_deg": found.rms_deg,
        "interpolation": {way: ways.count(way) for way in ("homographic", "smooth")},
    }


FITS = {"zhang": _zhang, "generic": _generic}


def _compare(views, size, unit, say):
    """Cross-validate all models on the same parts."""

    def build(fit, name, views):
        say(f"cross-validation: {name} on {len(views)} boards")
        return fit(views, size, unit)[0]

    builders = {name: functools.partial(build, f, name) for name, f in FITS.items()}
    return compare_models(builders, views, min(FOLDS, len(views)))


def _print(comparison):
    """How each model did, for people."""
    for name, evaluation in comparison.own.items():
        print(scores.line(f"{name}, kept-out boards", evaluation))
    for name, evaluation in comparison.common.items():
        print(scores.line(f"{name}, corners that all can answer for", evaluation))
    for name, reason in comparison.refused.items():
        print(f"{name}: not possible: {reason}")


def _cross_validation(comparison):
    models = {}
    for name, evaluation in comparison.own.items():
        models[name] = {"own": scores.summary(evaluation)}
        models[name]["parts_left_out"] = list(evaluation.left_out.values())
        if name in comparison.common:
            models[name]["common"] = scores.summary(comparison.common[name])
    for name, reason in comparison.refused.items():
        models[name] = {"refused": reason}
    return models


def _described(camera):
    described = {"kind": camera.kind, "width": camera.width, "height": camera.height}
    if camera.kind == "perspective":
        described |= {"K": camera.K.tolist(), "radial": camera.radial.tolist()}
    return described
