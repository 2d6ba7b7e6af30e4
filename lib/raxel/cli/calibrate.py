"""`raxel calibrate SET --model NAME --out camera.npz --json F --report FOLDER`"""

import functools
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from raxel.calibration.generic.central_test import centrality_of_views
from raxel.cli import described, models, scores
from raxel.cli.beyond import beyond_fields, beyond_warnings
from raxel.cli.board_corners import corner_fields, corner_line, corner_warnings
from raxel.cli.board_shape import not_asked, shape_fields, shape_line, shape_warnings
from raxel.cli.models import DOES_NOT_FIT, FEWEST_VIEWS, FITS
from raxel.cli.outputs import check_written
from raxel.cli.seen import check_options, seen_in
from raxel.cli.stability import stability_fields, stability_line, stability_warnings
from raxel.cli.warnings import of_left_out, print_warnings
from raxel.cli.wrong_points import wrong_fields, wrong_points, wrong_warnings
from raxel.errors import InputError
from raxel.evaluation.board_corners import board_corners, without_wrong_corners
from raxel.evaluation.comparison import compare_models
from raxel.evaluation.misfit import misfit
from raxel.evaluation.split_half import split_half
from raxel.io.files import check_can_be_written, together, write_json
from raxel.report import check_report, new_report, write_report
from raxel.sets import load_set
from raxel.sets.model import words_of

FOLDS = 4


def calibrate(options, say):
    """Fit the asked model to the set's views for calibration."""
    for path in filter(None, (options.out, options.json)):
        check_can_be_written(path)
    if options.json and Path(options.json).resolve() == Path(options.out).resolve():
        raise InputError(
            f"{options.json}: --json and --out name the same file; give two names"
        )
    image_set = load_set(options.set)
    read = options.corners, options.points
    check_written([options.out, options.json], [image_set], read)
    if options.report:
        others = options.out, options.json, *read
        check_report(options.report, image_set, others)
    check_options(image_set, options)
    views = image_set.views_for("calibrate")
    needed = FEWEST_VIEWS[options.model]
    if len(views) < needed:
        raise InputError(
            f"{image_set.description}: views: found {len(views)} to calibrate with, "
            f"--model {options.model} needs {needed}; take more, at other tilts"
        )
    seen = seen_in(image_set, views, options, say)
    seen.check_enough(image_set, needed, f"--model {options.model}")
    for line in seen.lines():
        print(f"{image_set.name}: {line}")
    try:
        found = _calibrated(image_set, seen.views, options.model, say)
    except InputError as fault:
        # What the corners or points are wrong in is mended where they stand.
        where = options.corners or options.points or f"{image_set.description}: views"
        raise type(fault)(f"{where}: {fault}") from fault
    result, fitted, evaluation, halves = found
    result |= seen.fields()
    result["left_out"] = seen.left_out() + result["left_out"]
    warnings = of_left_out(result["left_out"]) + seen.warnings
    result["warnings"] = warnings + result["warnings"]
    print_warnings(result["warnings"])
    report = new_report(options.report) if options.report else nullcontext()
    with report as folder, together() as place:
        # Drawn first, and put in its place when all else is written.
        if folder:
            say(f"drawing the report of {len(seen.entries)} images")
            of_set = folder, image_set, seen.entries, seen.views
            write_report(*of_set, fitted, evaluation, result, halves)
        fitted.camera.save(place(options.out))
        if options.json:
            write_json(place(options.json), result)


def _calibrated(image_set, views, asked, say):
    """(result for the JSON file, Fitted, its Evaluation on the views, SplitHalf)"""
    words = words_of(image_set.target)
    size = image_set.width, image_set.height
    model, comparison = asked, None
    if asked == "auto":
        comparison = _compare(views, size, image_set.target.unit, say)
        model, why = comparison.choice()
        _print(comparison, words)
        print(f"{image_set.name}: {model} chosen: {why}", flush=True)
    fit = FITS[model]
    say(f"{model}: fitting {len(views)} {words.target}s")
    fitted = fit(views, size, image_set.target.unit)
    camera, details = fitted.camera, fitted.details
    right = without_wrong_corners(camera, views, fitted.shape)
    evaluation = right.whole
    fields = described.camera_fields(camera, views)
    name = f"{image_set.name}: {model}, fitted {words.target}s"
    print(scores.line(name, evaluation, words.point))
    for line in (
        *described.camera_lines(fields, words.target),
        *models.lines(details, image_set.target.unit),
        shape_line(fitted.board, image_set.target.unit, words.target),
    ):
        print(f"{image_set.name}: {line}")
    result = {"set": image_set.name, "model": model, "unit": image_set.target.unit}
    result |= {"camera": fields, **details, **scores.as_json(evaluation)}
    result["board_shape"] = shape_fields(fitted.board, views)
    wrong = wrong_fields(wrong_points(details, right), evaluation.n_scored)
    found, warnings = _misfit(model, asked, right, fitted, words)
    warnings += wrong_warnings(wrong, right.evaluation.rms_px, words)
    result |= {"misfit": described.misfit_fields(found), **wrong}
    if model in models.TABLES:
        test = _central_or_not(right, size, details)
        result["one_centre"] = described.centre_fields(test)
        lengths = result["unit"], words.target
        print(f"{image_set.name}: {described.centre_line(test, *lengths)}")
        warnings += described.centre_warnings(test, *lengths)
    warnings += shape_warnings(fitted.board, result["unit"], words.target)
    whole = _used(fitted, evaluation.images, views)
    corners = board_corners(fitted.camera, *whole, fitted.shape)
    result["board_corners"] = corner_fields(corners)
    print(f"{image_set.name}: {corner_line(corners, result['unit'], words)}")
    images, used = _used(fitted, right.evaluation.images, right.views)
    halves = split_half(fitted.camera, images, used, fitted.shape)
    result["stability"] = stability_fields(halves)
    beyond = halves.beyond if halves else None
    result["beyond_boards"] = beyond_fields(beyond)
    print(f"{image_set.name}: {stability_line(halves, words)}")
    # Of a camera that does not fit all is said; its halves differ, too.
    if not found.large:
        warnings += corner_warnings(corners, fitted.board, result["unit"], words)
        warnings += stability_warnings(halves, words)
        warnings += beyond_warnings(beyond, words)
    warnings += described.coverage_warnings(fields, words.target)
    warnings += described.few_warnings(used, words.target)
    if comparison:
        result["chosen_because"] = why
        result["cross_validation"] = _cross_validation(comparison)
        warnings = comparison.doubts() + warnings
    return result | {"warnings": warnings}, fitted, evaluation, halves


def _left_out(details):
    """Names of the views that did not go into the fit."""
    return {entry["file"] for entry in details["left_out"]}


def _central_or_not(right, size, details):
    """CentralTest of the views that went into the fit, None where there is none."""
    out = _left_out(details)
    pairs = [
        (view, score.T_camera_grid)
        for view, score in zip(right.views, right.evaluation.images, strict=True)
        if view.name not in out and score.T_camera_grid is not None
    ]
    if len(pairs) < 3:
        return None
    used, poses = zip(*pairs, strict=True)
    return centrality_of_views(used, *size, np.array(poses))


def _used(fitted, images, views):
    """(ImageScores, views) of those that went into the fit."""
    out = _left_out(fitted.details)
    pairs = zip(images, views, strict=True)
    return zip(*(pair for pair in pairs if pair[1].name not in out), strict=True)


def _misfit(model, asked, right, fitted, words):
    """(Misfit of the views that went into the fit, warnings)"""
    out = _left_out(fitted.details)
    pairs = list(zip(right.evaluation.images, right.views, strict=True))
    used = [pair for pair in pairs if pair[1].name not in out]
    found = misfit(*zip(*used, strict=True))
    blamed = "auto" if asked == "auto" and model not in models.TABLES else model
    warnings = described.misfit_warnings(found, *DOES_NOT_FIT[blamed], words)
    bent = not_asked(fitted.board, len(used), words.target)
    warnings = [warning + bent for warning in warnings]
    if out and not found.large:
        whole = misfit(*zip(*pairs, strict=True))
        if whole.large and not whole.odd_board:
            what = f"{DOES_NOT_FIT[blamed][0]} all of"
            cure = DOES_NOT_FIT[blamed][1]
            warnings += described.misfit_warnings(whole, what, cure, words)
    return found, warnings


def _compare(views, size, unit, say):
    """Cross-validate all models on the same parts."""

    def build(fit, name, views):
        say(f"cross-validation: {name} on {len(views)} views")
        fitted = fit(views, size, unit)
        return fitted.camera, fitted.shape

    builders = {name: functools.partial(build, f, name) for name, f in FITS.items()}
    return compare_models(builders, views, min(FOLDS, len(views)))


def _print(comparison, words):
    """How each model did, for people."""
    for name, evaluation in comparison.own.items():
        print(scores.line(f"{name}, kept-out {words.target}s", evaluation, words.point))
    for name, evaluation in comparison.common.items():
        name = f"{name}, {words.point}s that all can answer for"
        print(scores.line(name, evaluation, words.point))
    for name, reason in comparison.refused.items():
        print(f"{name}: not possible: {reason}")


def _cross_validation(comparison):
    tried = {}
    for name, evaluation in comparison.own.items():
        tried[name] = {"own": scores.summary(evaluation)}
        tried[name]["counted_rms_px"] = scores.known(comparison.errors_px[name])
        tried[name]["parts_left_out"] = list(evaluation.left_out.values())
        if name in comparison.common:
            tried[name]["common"] = scores.summary(comparison.common[name])
    for name, reason in comparison.refused.items():
        tried[name] = {"refused": reason}
    return tried
