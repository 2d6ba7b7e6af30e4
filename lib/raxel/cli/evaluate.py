"""`raxel evaluate camera.npz SET --json F`"""

from pathlib import Path

import numpy as np

from raxel.calibration.views.correspondence import TERMS, BoardShape
from raxel.cameras.registry import load_camera
from raxel.cli import findings
from raxel.cli.outputs import check_outputs, check_writable, write_results
from raxel.cli.views import check_options, seen_in
from raxel.errors import InputError
from raxel.evaluation.board_corners import without_wrong_corners
from raxel.evaluation.diagnoses import diagnosis, score_text
from raxel.evaluation.misfit import misfit
from raxel.io.documents import shown, validate
from raxel.io.files import read_json
from raxel.sets import load_set
from raxel.sets.model import words_of

SCHEMA = Path(__file__).with_name("board_shape.schema.json")
UNMARKED = "all: no view is marked evaluate"
# How far a board may extend beyond, or end within, the one whose shape is used: some of
# its outermost corners may be visible in no image.
MAX_EXTENSION, MIN_EXTENT = 0.01, 0.5
MAX_SLOPE = 0.5  # of half a side, or in length: more is no board
ADVICE = "give the file of a camera from the same board"


def evaluate(options, say):
    """Score the camera on the set's views for evaluation, or all if none is marked."""
    if options.stage is not None:
        raise InputError(f"--stage: {options.set} is not a mirror set; leave it out")
    check_writable(options.json)
    image_set = load_set(options.set)
    check_outputs(
        options,
        image_set,
        read=[options.camera, options.corners, options.points, options.board],
    )
    check_options(image_set, options)
    camera = load_camera(options.camera)
    check_size(options.camera, camera, image_set)
    marked = image_set.views_for("evaluate")
    views = marked or image_set.views
    seen = seen_in(image_set, views, options, say)
    seen.check_enough(image_set, 1, "an evaluation")
    unit, words = image_set.target.unit, words_of(image_set.target)
    shape = options.board and read_shape(options.board, unit, seen.views)
    right = without_wrong_corners(camera, seen.views, shape)
    found = misfit(right.evaluation.images, right.views)
    result = {
        "set": image_set.name,
        "camera": options.camera,
        "board": "as stated" if shape is None else options.board,
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
    lines = [*seen.lines()]
    if not marked:
        lines.insert(0, f"no view is marked evaluate: all {len(views)} are scored")
    if options.board:
        used = "as specified, like in" if shape is None else "with the shape of"
        lines.append(f"{words.target}s {used} {options.board}")
    for text in (*lines, score_text(result, words)):
        print(f"{image_set.name}: {text}")
    result |= findings.reported(warnings)
    write_results(options, result)


def check_size(path, camera, image_set):
    """Raise InputError unless camera and set have the same image size."""
    size = camera.width, camera.height
    if size != (image_set.width, image_set.height):
        raise InputError(
            f"{path}: width, height: found {size[0]} x {size[1]}, but resolution in "
            f"{image_set.description} is {image_set.width} x {image_set.height}; "
            "give a camera and a set of the same size"
        )


def read_shape(path, unit, views):
    """The BoardShape with which a camera was fitted, None for a board as specified.

    path: of what `raxel calibrate --json` wrote; unit: of the evaluated set; views:
    BoardViews or DenseViews of it. Raises InputError for another file or board.
    """
    data = read_json(path)
    if not isinstance(data, dict) or "board_shape" not in data:
        raise InputError(
            f"{path}: board_shape: missing; give the file of raxel calibrate --json"
        )
    if data["board_shape"] is None:
        return None
    validate({key: data.get(key) for key in ("unit", "board_shape")}, path, SCHEMA)
    if data["unit"] != unit:
        raise InputError(
            f"{path}: unit: found {shown(data['unit'])}, and the set is in {unit}; "
            + ADVICE
        )
    found = data["board_shape"]
    shape = BoardShape(
        np.array(found["middle"]),
        np.array(found["size"]) / 2,
        np.array([found[name]["value"] * found[name]["used"] for name in TERMS]),
    )
    _check_board(path, shape, found["corners"], views)
    return shape if shape.values.any() else None


def _check_board(path, shape, corners, views):
    """Raise InputError for a shape of another board, or of an impossible one."""
    own = findings.corners_of(views)
    if corners != own:
        raise InputError(
            f"{path}: board_shape.corners: found {_counted(corners)}, and the set has "
            f"{_counted(own)}; {ADVICE}"
        )
    points = np.concatenate(
        [view.points[np.isfinite(view.pixels[:, 0])] for view in views]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    ends = shape.middle - shape.half, shape.middle + shape.half
    extension = np.maximum(ends[0] - low, high - ends[1]).max() / shape.half.max()
    small = (high - low < 2 * MIN_EXTENT * shape.half).any()
    if extension > MAX_EXTENSION or small:
        span, area = (
            " to ".join(f"({x:.4g}, {y:.4g})" for x, y in pair)
            for pair in (ends, (low, high))
        )
        raise InputError(
            f"{path}: board_shape: found one from {span}, and the set's corners are in "
            f"{area}; {ADVICE}"
        )
    steepest = np.abs(shape.values / [*[shape.half.min()] * 3, 1.0]).max()
    if steepest > MAX_SLOPE:
        raise InputError(
            f"{path}: board_shape: found bends or a stretch of {steepest:.2g} of the "
            f"board (at most {MAX_SLOPE:g}); give the file as it was written"
        )


def _counted(corners):
    return f"{corners[0]} x {corners[1]} corners" if corners else "a monitor"
