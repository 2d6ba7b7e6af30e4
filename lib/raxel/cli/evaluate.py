"""`raxel evaluate camera.npz SET --json F`"""

from raxel.cameras.registry import load_camera
from raxel.cli import findings
from raxel.cli.outputs import (
    check_outputs,
    check_writable,
    exit_if_strict,
    write_results,
)
from raxel.cli.sets import opened_set
from raxel.cli.views import check_options, seen_in
from raxel.errors import InputError
from raxel.evaluation.board_corners import without_wrong_corners
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.diagnoses import diagnosis, score_text
from raxel.evaluation.json_fields import read_shape
from raxel.evaluation.misfit import misfit
from raxel.io.files import read_json
from raxel.sets.model import words_of

UNMARKED = "all: no view is marked evaluate"
AS_SPECIFIED = {"board_shape": None}  # the board of a camera file without one


def evaluate(options, say):
    """Score the camera on the set's views for evaluation, or all if none is marked."""
    if options.stage is not None:
        raise InputError(f"--stage: {options.set} is not a mirror set; leave it out")
    check_writable(options.json)
    shape_file = options.board if isinstance(options.board, str) else None
    options.board = None if shape_file else options.board
    image_set = opened_set(options)
    check_outputs(
        options,
        image_set,
        read=[options.camera, options.corners, options.points, shape_file],
    )
    check_options(image_set, options)
    camera = load_camera(options.camera)
    check_size(options.camera, camera, image_set)
    marked = image_set.views_for("evaluate")
    views = marked or image_set.views
    seen = seen_in(image_set, views, options, say)
    seen.check_enough(image_set, 1, "an evaluation")
    unit, words = image_set.target.unit, words_of(image_set.target)
    lines, shape = [*seen.lines()], None
    source, board = shape_file or options.camera, camera.board or AS_SPECIFIED
    board = read_json(shape_file) if shape_file else board
    try:
        shape = read_shape(board, source, unit, seen.views)
    except InputError as fault:
        if shape_file:
            raise
        lines.append(f"board of the camera not used: {fault}")
    right = without_wrong_corners(camera, seen.views, shape)
    found = misfit(right.evaluation.images, right.views)
    result = {
        "set": image_set.name,
        "camera": options.camera,
        "board": "as stated" if shape is None else source,
        "views_scored": "marked evaluate" if marked else UNMARKED,
        **right.whole.fields(),
        **seen.fields(),
        **right.fields(),
        "left_out": seen.left_out(),
        "misfit": found.fields(),
    }
    warnings = findings.of_left_out(result["left_out"]) + seen.warnings
    warnings += findings.warnings_of(result, right.evaluation.rms_px, words)
    warnings += findings.misfit_warnings(found, "camera-misfit", words)
    if found.large and shape is None:
        warnings.append(diagnosis("bent-board", words))
    if not marked:
        lines.insert(0, f"no view is marked evaluate: all {len(views)} are scored")
    if shape:
        lines.append(f"{words.target}s with the shape of {source}")
    elif shape_file:
        lines.append(f"{words.target}s as specified, like in {source}")
    lines.append(score_text(result, words))
    if shape:
        result["as_specified"] = evaluate_camera(camera, seen.views).totals()
        text = score_text(result["as_specified"], words)
        lines.append(f"{words.target}s as specified: {text}")
    for text in lines:
        print(f"{image_set.name}: {text}")
    result |= findings.reported(warnings)
    write_results(options, result)
    exit_if_strict(options, result)


def check_size(path, camera, image_set):
    """Raise InputError unless camera and set have the same image size."""
    size = camera.width, camera.height
    if size != (image_set.width, image_set.height):
        raise InputError(
            f"{path}: width, height: found {size[0]} x {size[1]}, but resolution in "
            f"{image_set.description} is {image_set.width} x {image_set.height}; "
            "give a camera and a set of the same size"
        )
