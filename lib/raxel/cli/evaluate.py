"""`raxel evaluate camera.npz SET --json F`"""

from raxel.calibration.board_views import board_views
from raxel.cameras.io import load_camera
from raxel.cli import described, scores
from raxel.cli.boards import boards_for, check_enough, left_out
from raxel.cli.outputs import check_written
from raxel.cli.warnings import of_left_out, print_warnings
from raxel.errors import InputError
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.misfit import misfit
from raxel.files import check_can_be_written, write_json
from raxel.sets import load_set

# (what a misfit says, what to do about it)
DOES_NOT_FIT = (
    "this camera does not fit",
    "is it the camera of this set, at the same zoom and focus?",
)
UNMARKED = "all: no view is marked evaluate"


def evaluate(options, say):
    """Score the camera on the set's views for evaluation, or all if none is marked."""
    if options.json:
        check_can_be_written(options.json)
    image_set = load_set(options.set)
    check_written([options.json], [image_set], [options.camera, options.corners])
    camera = load_camera(options.camera)
    check_size(options.camera, camera, image_set)
    marked = image_set.views_for("evaluate")
    views = marked or image_set.views
    boards = boards_for(image_set, views, options, say)
    check_enough(image_set, boards, 1, "an evaluation")
    seen = board_views(image_set, boards)
    evaluation = evaluate_camera(camera, seen)
    missed = left_out(boards)
    found = misfit(evaluation.images, seen)
    warnings = of_left_out(missed) + described.misfit_warnings(found, *DOES_NOT_FIT)
    if options.json:
        result = {"set": image_set.name, "camera": options.camera}
        result["views_scored"] = "marked evaluate" if marked else UNMARKED
        result |= scores.as_json(evaluation)
        result |= {"left_out": missed, "misfit": described.misfit_fields(found)}
        write_json(options.json, result | {"warnings": warnings})
    if not marked:
        print(
            f"{image_set.name}: no view is marked evaluate: all {len(views)} are scored"
        )
    print(scores.line(image_set.name, evaluation))
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
