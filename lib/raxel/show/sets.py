"""An image set as a scene: its camera, and targets where their pictures put them."""

import numpy as np

from raxel.calibration.parametric.opencv_fits import calibrate_zhang
from raxel.calibration.views.boards import board_views
from raxel.cameras.io import load_camera
from raxel.errors import CalibrationError, InputError
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.features.boards import check_chessboard, detect_boards
from raxel.io.files import read_json
from raxel.sets.model import ActiveGrid, Chessboard
from raxel.show.rigs import posed_targets

FEWEST_VIEWS = 2
# A camera that fits its set comes nearer to the corners than this.
TRUSTED_PX = 2.0
OTHER_CAMERA = (
    "for another camera run raxel calibrate, then raxel show SET --camera CAMERA"
)


def set_scene(image_set, camera=None, say=None, boards=None):
    """Where the targets of a set stood before its camera, in the camera's frame.

    camera: any of `raxel.cameras`; the boards found in the pictures are posed to fit
    its rays. Without one, the truth of a rendered set is shown. A set with neither is
    calibrated by Zhang's method, which is quick and fits an ordinary lens; the note
    says which of the three it was, and with what error. say: a callable told one line
    per image. boards: Boards of the set that are known already; they are not looked
    for, and count more than a truth. Raises InputError, one line, where none of them
    gives a pose.
    """
    if camera is None and boards is None and image_set.truth is not None:
        return _true_scene(image_set)
    if isinstance(image_set.target, ActiveGrid):
        raise InputError(
            f"{image_set.description}: target.kind: found active_grid, and no truth "
            "that says where it stood; boards alone are posed by their pictures: run "
            "raxel calibrate and raxel show CAMERA, or raxel show RIG for a rig"
        )
    check_chessboard(image_set)
    if boards is None:
        boards = detect_boards(image_set, say=say)
    views = board_views(image_set, boards)
    if len(views) < (FEWEST_VIEWS if camera is None else 1):
        raise InputError(
            f"{image_set.description}: views: board found in {len(views)} of "
            f"{len(boards)} images; check target.columns and target.rows"
        )
    how = "poses fitted to the camera given"
    if camera is None:
        how = f"camera by Zhang's method, quick and for ordinary lenses; {OTHER_CAMERA}"
        camera = _quick_camera(image_set, views)
    return _posed_scene(image_set, camera, views, how)


def _true_scene(image_set):
    folder = image_set.folder / image_set.truth
    found = read_json(folder / "poses.json")
    try:
        named = found["T_camera_target"]
        poses = np.array([named[view.label] for view in image_set.views], float)
        if poses.shape[1:] != (4, 4):
            raise ValueError(f"poses of shape {poses.shape[1:]}")
    except (KeyError, TypeError, ValueError) as fault:
        raise InputError(
            f"{folder / 'poses.json'}: T_camera_target: no pose (4, 4) for every view "
            f"({fault}); render the set anew"
        ) from fault
    uses = [view.use for view in image_set.views]
    note = f"{image_set.name}: {len(poses)} targets in their true poses."
    camera = load_camera(folder / "camera.npz")
    return posed_targets(camera, [image_set.target] * len(poses), poses, uses, note)


def _quick_camera(image_set, views):
    try:
        return calibrate_zhang(views, image_set.width, image_set.height).camera
    except CalibrationError as fault:
        raise InputError(
            f"{image_set.description}: views: {fault}; {OTHER_CAMERA}"
        ) from fault


def _posed_scene(image_set, camera, views, how):
    scores = evaluate_camera(camera, views)
    posed = [
        (score, view)
        for score, view in zip(scores.images, views, strict=True)
        if score.T_camera_grid is not None
    ]
    if not posed:
        raise InputError(
            f"{image_set.description}: views: no board has a pose that fits the "
            f"camera ({scores.images[0].reason}); is it the camera of this set?"
        )
    uses = {view.label: view.use for view in image_set.views}
    pitch = image_set.target.pitch_mm
    note = (
        f"{image_set.name}: {len(posed)} of {len(image_set.views)} boards; {how}. "
        f"Median distance of corners from where this puts them: {scores.median_px:.2g} "
        "px."
    )
    if scores.median_px > TRUSTED_PX:
        note += " That is much: these places are not to be trusted."
    return posed_targets(
        camera,
        [Chessboard(view.columns, view.rows, pitch) for _, view in posed],
        np.stack([score.T_camera_grid for score, _ in posed]),
        [uses[view.name] for _, view in posed],
        note,
    )
