"""`raxel evaluate camera.npz SET --json F`"""

from raxel.cameras.registry import load_camera
from raxel.cli import described, scores
from raxel.cli.board_shape import read_shape
from raxel.cli.outputs import check_written
from raxel.cli.seen import check_options, seen_in
from raxel.cli.warnings import of_left_out, print_warnings
from raxel.cli.wrong_points import wrong_fields, wrong_points, wrong_warnings
from raxel.errors import InputError
from raxel.evaluation.board_corners import without_wrong_corners
from raxel.evaluation.misfit import misfit
from raxel.io.files import check_can_be_written, write_json
from raxel.sets import load_set
from raxel.sets.model import words_of

# (what a misfit says, what to do about it)
DOES_NOT_FIT = (
    "this camera does not fit",
    "is it the camera of this set, at the same zoom and focus?",
)
BENT = (
    "a {target} that bends does not fit as a flat one; --board takes its shape from "
    "what raxel calibrate --json wrote"
)
UNMARKED = "all: no view is marked evaluate"


def evaluate(options, say):
    """Score the camera on the set's views for evaluation, or all if none is marked."""
    if options.stage is not None:
        raise InputError(
            f"--stage: found with {options.set}, which is no mirror set; leave it out"
        )
    if options.json:
        check_can_be_written(options.json)
    image_set = load_set(options.set)
    read = options.camera, options.corners, options.points, options.board
    check_written([options.json], [image_set], read)
    check_options(image_set, options)
    camera = load_camera(options.camera)
    check_size(options.camera, camera, image_set)
    marked = image_set.views_for("evaluate")
    views = marked or image_set.views
    seen = seen_in(image_set, views, options, say)
    seen.check_enough(image_set, 1, "an evaluation")
    shape = None
    if options.board:
        shape = read_shape(options.board, image_set.target.unit, seen.views)
    right = without_wrong_corners(camera, seen.views, shape)
    evaluation = right.whole
    missed, words = seen.left_out(), words_of(image_set.target)
    wrong = wrong_fields(wrong_points({}, right), evaluation.n_scored)
    found = misfit(right.evaluation.images, right.views)
    warnings = of_left_out(missed) + seen.warnings
    warnings += wrong_warnings(wrong, right.evaluation.rms_px, words)
    warnings += described.misfit_warnings(found, *DOES_NOT_FIT, words)
    if found.large and shape is None:
        warnings.append(BENT.format(target=words.target))
    if options.json:
        result = {"set": image_set.name, "camera": options.camera}
        result["board"] = "as stated" if shape is None else options.board
        result["views_scored"] = "marked evaluate" if marked else UNMARKED
        result |= scores.as_json(evaluation)
        result |= seen.fields()
        result |= {"left_out": missed, "misfit": described.misfit_fields(found)}
        write_json(options.json, result | wrong | {"warnings": warnings})
    if not marked:
        print(
            f"{image_set.name}: no view is marked evaluate: all {len(views)} are scored"
        )
    for line in seen.lines():
        print(f"{image_set.name}: {line}")
    if options.board:
        taken = "as stated, as there" if shape is None else "with the shape of"
        print(f"{image_set.name}: {words.target}s are taken {taken} {options.board}")
    print(scores.line(image_set.name, evaluation, words.point))
    print_warnings(warnings)


def check_size(path, camera, image_set):
    """Raise InputError unless camera and set have the same image size."""
    size = camera.width, camera.height
    if size != (image_set.width, image_set.height):
        raise InputError(
            f"{path}: width, height: found {size[0]} x {size[1]}, but resolution in "
            f"{image_set.description} is {image_set.width} x {image_set.height}; "
            "give a camera and a set of the same size"
        )
