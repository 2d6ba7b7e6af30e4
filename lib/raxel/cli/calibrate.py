"""`raxel calibrate SET --model NAME --out camera.npz --json F --report FOLDER`"""

import functools
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from raxel.calibration.generic.central_test import centrality_of_views
from raxel.calibration.parametric.opencv_fits import found_corners
from raxel.cli import findings
from raxel.cli.models import (
    CENTRAL_FITS,
    FITS,
    MIN_N_VIEWS,
    MISFITS,
    PUPILS,
    STAGES,
    TABLES,
)
from raxel.cli.outputs import (
    check_outputs,
    check_writable,
    exit_if_strict,
    write_results,
)
from raxel.cli.sets import check_result_folder, opened_set, write_used_set
from raxel.cli.views import check_options, seen_in
from raxel.errors import CalibrationError, InputError
from raxel.evaluation import json_fields
from raxel.evaluation.board_corners import (
    at_nominal_positions,
    board_corners,
    without_wrong_corners,
)
from raxel.evaluation.comparison import compare_models, remembering
from raxel.evaluation.coverage import covered_cells
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.diagnoses import (
    camera_lines,
    comparison_lines,
    explained,
    known,
    overview,
    summary,
)
from raxel.evaluation.distortion import MIN_N_BOARDS
from raxel.evaluation.focal_length import focal_length_sd, focal_length_warnings
from raxel.evaluation.misfit import misfit
from raxel.evaluation.ray_errors import (
    errors_of_formula,
    errors_of_table,
    errors_with_deviation,
    next_place,
)
from raxel.evaluation.split_half import split_half
from raxel.report import write_report
from raxel.report.page import PAGE
from raxel.sets.model import Words, words_of

FOLDS = 4


class Fitting(NamedTuple):
    """fits: function of each model; views; size: (width, height); unit: of lengths;
    words: of the target; say: for progress."""

    fits: dict
    views: list
    size: tuple
    unit: str
    words: Words
    say: Callable

    def fitted(self, model, views, **more):
        """The Fitted model of these views."""
        return self.fits[model](views, self.size, self.unit, **more)


def calibrate(options, say):
    """Fit the requested model to the set's views for calibration."""
    check_writable(options.out, options.json)
    image_set = opened_set(options)
    check_outputs(options, image_set, [options.out], [options.corners, options.points])
    check_options(image_set, options)
    check_result_folder(options, image_set)
    views = image_set.views_for("calibrate")
    needed = MIN_N_VIEWS[options.model]
    if len(views) < needed:
        raise InputError(
            f"{image_set.description}: views: found {len(views)} for calibration, "
            f"--model {options.model} requires {needed}"
            f"{findings.unused_text(image_set)}; add views with other tilts"
        )
    seen = seen_in(image_set, views, options, say)
    seen.check_enough(image_set, needed, f"--model {options.model}")
    details = [("", text) for text in seen.lines()]
    fits = CENTRAL_FITS if options.central else FITS
    words, size = words_of(image_set.target), (image_set.width, image_set.height)
    task = Fitting(fits, seen.views, size, image_set.target.unit, words, say)
    try:
        result, warnings, fitted, evaluation, halves = _calibrated(
            image_set.name, task, options.model, details
        )
    except InputError as fault:
        # Wrong corners or points are corrected in the file that they are from.
        where = options.corners or options.points or f"{image_set.description}: views"
        raise type(fault)(f"{where}: {fault}", code=fault.code) from fault
    result |= seen.fields()
    result["left_out"] = seen.left_out() + result["left_out"]
    excluded = findings.of_left_out(result["left_out"])
    result |= findings.sorted_fields(excluded + seen.warnings + warnings)
    if options.report:
        say(f"drawing the report of {len(seen.entries)} images")
    drawn = image_set, seen.entries, seen.views, fitted, evaluation, result, halves
    write_results(
        options,
        result,
        {options.out: fitted.camera},
        lambda folder: write_report(folder, *drawn),
    )
    write_used_set(options, image_set, seen.size())
    _print_summary(result, words, details, options)
    exit_if_strict(options, result)


def _print_summary(result, words, details, options):
    """The overview, the strongest warning and the place of the results; with --verbose
    all details and all warnings."""
    lines, warnings = [*overview(result, words)], result["warnings"]
    if options.verbose:
        lines = [*details, *lines]
    lines += [("warning", text) for text in warnings[: None if options.verbose else 1]]
    for label, text in lines:
        print(f"{label}: {text}".removeprefix(": "))
    where = options.report and f"{options.report}/{PAGE}"
    places = [where or options.json or options.out]
    if warnings[1:] and not options.verbose:
        places.append(f"further warnings: {len(warnings) - 1}, see --verbose")
    print(f"results: {'; '.join(places)}")


def _calibrated(name, task, asked, details):
    """(result for the JSON file, warnings, Fitted, its Evaluation, SplitHalf); adds
    lines (label, text) to the details."""
    _, views, size, unit, words, _ = task
    result, warnings = {"set": name, "model": asked, "unit": unit}, []
    whole = functools.cache(lambda model: task.fitted(model, task.views))
    fit = functools.cache(functools.partial(_fitted, task, whole))
    if asked == "auto":
        comparison = _compared(task, whole, fit)
        result["model"], result["chosen_because"] = comparison.choice()
        result["cross_validation"] = comparison.fields()
        warnings += comparison.diagnoses()
        details += comparison_lines(result["cross_validation"], words)
    model = result["model"]
    fitted, right, corners = fit(model)
    images, used = _used(fitted, right.evaluation.images, right.views)
    sd = _focal_length_sd(fitted, images, used)
    result["focal_length_sd_by_tilt"] = known(sd)
    warnings += focal_length_warnings(sd, words)
    result["camera"] = json_fields.camera_fields(fitted.camera, views)
    result |= fitted.details | right.whole.fields()
    details += camera_lines(result, words)
    found = misfit(images, used)
    result["misfit"] = found.fields()
    result |= right.fields(fitted.details.get("wrong_points", ()))
    result["board_shape"] = json_fields.shape_fields(fitted.board, views)
    if model in TABLES:
        central = _central_test(images, used, size)
        result["one_centre"] = json_fields.central_fields(central)
    right_px = right.evaluation.rms_px
    lenses = "" if asked == "auto" else "try --model kannala-brandt or unified, "
    warnings += findings.warnings_of(result, right_px, words, lenses)
    distance = fitted.camera.board_distance = _board_distance(images, used)
    fitted.camera.board_cells = covered_cells(used, *size)
    if fitted.lens:
        of_corners = corners.ray_covariance if fitted.corners else None
        fitted.camera.error_nodes = errors_of_formula(
            fitted.camera, distance, *fitted.lens, of_corners
        )
    halves = split_half(fitted.camera, images, used, fitted.shape)
    if halves and model in TABLES:
        fitted.camera.error_nodes = errors_of_table(fitted.camera, halves)
    elif halves and halves.deviation is not None:
        fitted.camera.error_nodes = errors_with_deviation(
            fitted.camera, distance, halves.deviation
        )
    result["next_image"] = next_place(fitted.camera)
    tests = {"board_corners": corners, "stability": halves}
    tests["beyond_boards"] = halves and halves.beyond
    result |= {name: test and test.fields() for name, test in tests.items()}
    details += summary(result, words, MIN_N_BOARDS)
    warnings += findings.agreement_warnings(corners, halves, fitted, unit, words)
    values = {"words": words, "model": model, "untried": _untried(asked, result)}
    values["explained"] = any(explained(each, found.rms_px) for each in warnings)
    warnings += _misfit_warnings(found, asked, right, fitted, values)
    warnings += findings.coverage_warnings(result["camera"], used, words)
    if fitted.shape:
        board = "unit", "board_shape", "board_corners"
        fitted.camera.board = {key: result[key] for key in board}
    return result, warnings, fitted, right.whole, halves


def _fitted(task, whole, model):
    """`_with_corners` of a model; whole: the function that fits it to all views. Of
    boards that do not determine the focal length, tables have other errors than lens
    models have: these are tested first."""
    views, words = task.views, task.words
    task.say(f"{model}: fitting {len(views)} {words.target}s")
    try:
        return _with_corners(task, model, whole(model))
    except CalibrationError:
        if model in TABLES:
            lens = task.fitted("kannala-brandt", views)
            images = evaluate_camera(lens.camera, views, lens.shape).images
            list(focal_length_warnings(_focal_length_sd(lens, images, views), words))
        raise


def _focal_length_sd(fitted, images, views):
    scatter_px = misfit(images, views).scatter_px
    return focal_length_sd(fitted.camera, images, views, fitted.shape, scatter_px)


def _with_corners(task, model, fitted):
    """(Fitted, its WrongCorners, BoardCorners), fitted again with displaced corners
    of the board where halves of the images support them. An image that is inconsistent
    with the others is no evidence about the board."""
    views = task.views
    right = without_wrong_corners(fitted.camera, views, fitted.shape)
    scores = right.whole.images
    images, seen = map(list, _used(fitted, scores, views))
    corners = board_corners(fitted.camera, images, seen, fitted.shape)
    halves = (
        corners
        and corners.used
        and split_half(fitted.camera, images, seen, fitted.shape)
    )
    if halves and halves.outlier:
        odd = [view.name for view in seen].index(halves.outlier.name)
        del images[odd], seen[odd]
        corners = board_corners(fitted.camera, images, seen, fitted.shape)
    if corners and corners.used:
        task.say(f"{model}: fitting again, with the displaced corners of the board")
        fitted = fitted._replace(corners=(views[0].points, corners.offsets))
        nominal = at_nominal_positions(fitted.camera, scores, views, fitted.shape)
        again = task.fitted(model, nominal)
        fitted = again._replace(corners=fitted.corners)
        right = without_wrong_corners(fitted.camera, views, fitted.shape)
    return fitted, right, corners


def _used(fitted, images, views):
    """(ImageScores, views) of those that went into the fit."""
    pairs = zip(images, views, strict=True)
    return zip(*(p for p in pairs if p[1].name not in fitted.unused), strict=True)


def _board_distance(images, views):
    """Median distance of the middles of boards from the origin of the camera frame."""
    distances = [
        np.linalg.norm(T[:3, :2] @ found_corners(view)[1].mean(axis=0) + T[:3, 3])
        for T, view in zip([i.T_camera_grid for i in images], views, strict=True)
        if T is not None
    ]
    return float(np.median(distances)) if distances else None


def _central_test(images, views, size):
    """CentralTest of the views with a pose, None for fewer than three."""
    poses = [score.T_camera_grid for score in images]
    posed = [k for k, T in enumerate(poses) if T is not None]
    if len(posed) < 3:
        return None
    used = [views[k] for k in posed]
    return centrality_of_views(used, *size, np.array([poses[k] for k in posed]))


def _untried(asked, result):
    """Advice of models that gave no camera or were not tried."""
    if asked != "auto":
        return "try --model auto, "
    tried = result["cross_validation"].items()
    missing = any(name in TABLES and "refused" in found for name, found in tried)
    return "add overlapping views, " if missing else ""


def _misfit_warnings(found, asked, right, fitted, about):
    """Yield the warnings of the Misfit of the views that went into the fit, and of
    all."""
    words, model = about["words"], about["model"]
    blamed = "auto" if asked == "auto" and model not in TABLES else model
    about |= {"code": MISFITS[blamed]}
    few = len(right.views) - len(fitted.unused) < MIN_N_BOARDS
    untested = fitted.board is None and few
    bent = f"bent {words.target} (untested)" if untested else ""
    yield from findings.misfit_warnings(found, bent=bent, **about)
    whole = misfit(right.evaluation.images, right.views)
    if fitted.unused and whole.large and not found.large and not whole.odd_boards:
        yield from findings.misfit_warnings(
            whole, scope=f" all {words.target}s", **about
        )


def _compared(task, whole, fit):
    """ModelComparison by cross-validation, of further STAGES as long as the best model
    so far does not fit. All views decide if the entrance pupil of a model moves."""
    folds = min(FOLDS, len(task.views))
    builders, parts = {}, Counter()

    def build(name, views):
        parts[name] += 1
        task.say(f"cross-validation: {name}, part {parts[name]} of {folds}")
        more = {}
        if name in PUPILS:
            pupil = whole(name).details["pupil"]
            more["pupil"] = "moving" if pupil and pupil["moves"] else "fixed"
        fitted = task.fitted(name, views, **more)
        return fitted.camera, fitted.shape

    for stage, largest in STAGES:
        builders |= {
            name: remembering(functools.partial(build, name)) for name in stage
        }
        comparison = compare_models(builders, task.views, folds)
        if any(each.n_scored for each in comparison.own.values()):
            _, right, _ = fit(comparison.best())
            found = misfit(right.evaluation.images, right.views)
            if not found.rms_px > largest * found.scatter_px:
                break
    return comparison
