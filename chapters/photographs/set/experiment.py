"""Trials of this page, their conditions and constants."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from chapters.shared.images.reading import ALL_NAMES, MODELS, PEER
from raxel.calibration import (
    MOVES,
    UNDECIDED,
    BoardView,
    board_views,
    calibrate_cgsp,
    calibrate_generic,
    calibrate_lens,
    calibrate_opencv_fisheye,
    calibrate_spline,
    calibrate_zhang,
)
from raxel.errors import InputError
from raxel.evaluation import (
    corrected_view,
    distortion_residual,
    evaluate_camera,
    scoring_grid,
    synthetic_plane,
)
from raxel.features import CHARUCO, DEFAULT_DETECTOR, as_8_bit, detect_boards
from raxel.multiview import PerspectiveView, resample, source_pixels
from raxel.sets import Charuco, load_set, read_image

# Undistorted view of an image through a given model.


SUPERSAMPLED = 2
MARGIN = 0.9  # corners lie within this share of the image's half size
SMALLEST_ZOOM = 0.25
MIN_N_CORNERS = 12  # a homography takes four; the rest show distortion
COVERED_PERCENT = 98  # of the corners; one near 90 degrees would shrink all


def reduced(image, width_px):
    """Return a smaller copy of an 8-bit image, (h, width_px), averaged over areas."""
    import cv2

    height, width = image.shape
    if width <= width_px:
        return image
    size = width_px, max(1, round(height * width_px / width))
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA)


def undistorted(image_set, cameras, boards, width_px):
    """Return one image undistorted by every camera, with masks and corners.

    The view is centred on mid-image, or on the board where mid-image has no ray (a
    mirror shows the camera there). Both views have the magnification of the image at
    that pixel, times a common zoom that keeps the corners inside.
    """
    if not boards or not cameras:
        return {"reason": "no camera to look through"}
    board = _farthest_out(image_set, cameras, boards)
    planes, reasons, towards = view_planes(cameras, board.view)
    shown = boards if towards == "mid-image" else [board]
    zoom = _zoom(image_set, cameras, planes, shown)
    image = as_8_bit(read_image(image_set, image_set.views[board.index]))
    result = {
        "reason": "",
        "view": board.index,
        "towards": towards,
        "zoom": zoom,
        "original": reduced(image, width_px),
        "corners": board.view.pixels,
    }
    shared = _seen_by_all(cameras, board)
    result["taken"] = {
        "distortion_px": distortion_rms(board.view, board.view.pixels, shared)
    }
    for model, camera in cameras.items():
        result[model] = {"reason": reasons.get(model, "")}
        if model in planes:
            view = _view_of(image_set, planes[model], zoom, width_px)
            result[model] |= _resampled(camera, view, image)
            corners = _corners(camera, view, board.view.pixels)
            result[model]["corners"] = corners
            result[model]["distortion_px"] = distortion_rms(
                board.view, corners * image_set.width / view.width / zoom, shared
            )
    return result


def _farthest_out(image_set, cameras, boards):
    """Return the board farthest from mid-image whose outline all cameras see."""
    middle = np.array([image_set.width - 1, image_set.height - 1]) / 2

    def reach(board):
        view, seen = board.view, _seen_by_all(cameras, board)
        last = view.columns * view.rows - 1
        rim = seen[[0, view.columns - 1, last + 1 - view.columns, last]]
        distance = np.linalg.norm(view.pixels - middle, axis=1)
        return rim.all(), np.mean(distance * seen)

    return max(boards, key=reach)


def _seen_by_all(cameras, board):
    """Return which corners (N,) have a ray of every camera."""
    rays = [camera.rays(board.view.pixels) for camera in cameras.values()]
    return np.all([r.valid for r in rays], axis=0)


def distortion_rms(view, corners, shared):
    """Return the RMS residual (px) of a homography from the board to its corners."""
    use = shared & np.isfinite(corners[:, 0])
    if np.count_nonzero(use) < MIN_N_CORNERS:
        return np.nan
    residuals = distortion_residual(corners[use], view.points[use])
    return np.sqrt(np.mean(np.sum(residuals**2, axis=1)))


def view_planes(cameras, view):
    """Return {model: SyntheticPlane}, {model: reason}, and the centre of the view."""
    sizes = {(c.width, c.height) for c in cameras.values()}
    middle = (np.array(sizes.pop()) - 1) / 2
    towards = {"mid-image": middle, "the board": np.nanmean(view.pixels, axis=0)}
    for name, pixel in towards.items():  # noqa: B007
        planes, reasons = {}, {}
        for model, camera in cameras.items():
            try:
                planes[model] = synthetic_plane(camera, pixel)
            except InputError as refusal:
                reasons[model] = refusal.code
        if not reasons:
            break
    return planes, reasons, name


def _zoom(image_set, cameras, planes, boards):
    """Return a zoom of at most 1, smaller where the corners need a wider view."""
    half = np.array([image_set.width, image_set.height]) / 2
    zooms = [1.0]
    for model, plane in planes.items():
        pixels = np.concatenate([board.view.pixels for board in boards])
        rays = cameras[model].rays(pixels).directions
        seen, valid = corrected_view(rays, plane)
        offset = np.abs(seen[valid] - plane.principal_pixel) / half
        if len(offset):
            needed = np.percentile(offset.max(axis=1), COVERED_PERCENT)
            zooms.append(MARGIN / max(needed, 1e-9))
    return float(max(min(zooms), SMALLEST_ZOOM))


def _view_of(image_set, plane, zoom, width_px):
    """Return the pinhole at the camera's centre that views the plane."""
    width = min(width_px, image_set.width)
    height = round(width * image_set.height / image_set.width)
    focal = plane.px_per_unit * zoom * width / image_set.width
    K = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    T = plane.T_camera_plane
    centre = T[:3, 3] - T[:3, 2]
    return PerspectiveView(K, T[:3, :3], centre, width, height)


def _resampled(camera, view, image):
    """Return {picture, mask}: grey values, and pixels with a source (255)."""
    import cv2

    fine = np.diag([SUPERSAMPLED, SUPERSAMPLED, 1.0])
    fine[:2, 2] = (SUPERSAMPLED - 1) / 2
    size = SUPERSAMPLED * view.width, SUPERSAMPLED * view.height
    sources = source_pixels(
        camera, view._replace(K=fine @ view.K, width=size[0], height=size[1])
    )
    mask = np.uint8(255) * camera.in_image(sources)
    return {
        name: cv2.resize(whole, (view.width, view.height), interpolation=cv2.INTER_AREA)
        for name, whole in (("picture", resample(image, sources)), ("mask", mask))
    }


def _corners(camera, view, pixels):
    """Return image pixels (N, 2) in the view, NaN where there is no ray."""
    directions = camera.rays(pixels).directions @ view.R_camera_view
    ahead = np.where(directions[:, 2:] > 0, directions[:, 2:], np.nan)
    return (directions / ahead @ view.K.T)[:, :2]


# Study of one image set: corners, cameras, and their held-out errors.
#
# Each function does one condition of the experiment and returns plain numbers and
# arrays. What cannot be done comes back as a reason, in words; it is a result like any
# other.


COVERAGE_PX = 160
LENSES = ("kannala_brandt", "unified")


class Size(NamedTuple):
    """Size of the study: images, held-out parts, widths of stored images.

    In larger sets, ``images`` are selected evenly. Sets with at most ``leave_one_out``
    images hold out one image at a time.
    """

    images: float
    folds: int
    leave_one_out: int
    thumbnail_px: int
    picture_px: int


SIZES = {
    "quick": Size(8, folds=2, leave_one_out=3, thumbnail_px=160, picture_px=220),
    "full": Size(np.inf, folds=5, leave_one_out=10, thumbnail_px=240, picture_px=440),
}


class Found(NamedTuple):
    """A detected board: index of its view in the set, its use, its corners."""

    index: int
    use: str
    view: BoardView


def conditions_of(image_set, size):
    """Return the conditions: every image, the calibration, every held-out part."""
    taken = views_taken(image_set, size)
    images = [
        {"part": "image", "view": index, "image": image_set.views[index].label}
        for index in taken
    ]
    count = sum(image_set.views[index].use == "calibrate" for index in taken)
    if count > size.leave_one_out:
        count = size.folds
    folds = [{"part": "fold", "fold": fold} for fold in range(count)]
    return [*images, {"part": "fit"}, *folds]


def views_taken(image_set, size):
    """Return the indices of the views used: all, or as many as `size` has images."""
    count = len(image_set.views)
    if count <= size.images:
        return list(range(count))
    return np.linspace(0, count - 1, size.images).round().astype(int).tolist()


def settings_of(image_set):
    """Return the settings of the set for the page."""
    target = image_set.target
    return {
        "set": image_set.name,
        "camera": image_set.camera,
        "width_px": image_set.width,
        "height_px": image_set.height,
        "columns": target.columns,
        "rows": target.rows,
        "pitch_mm": target.pitch_mm,
        "unit": target.unit,
        "detector": detector_of(target),
        "images": [view.label for view in image_set.views],
        "uses": [view.use for view in image_set.views],
        "licence": str(image_set.origin.get("licence", "")),
        "source": str(image_set.origin.get("source", "")),
    }


def detector_of(target):
    """Return the detector of the corners; a ChArUco board has its own."""
    return CHARUCO if isinstance(target, Charuco) else DEFAULT_DETECTOR


@cache
def board_in(folder, index):
    """Return the library's Board of one image, detected once per job."""
    image_set = load_set(folder)
    views = [image_set.views[index]]
    return detect_boards(image_set, DEFAULT_DETECTOR, views)[0]


def boards_of(folder, size):
    """Return every detected board of the views used, in their order."""
    image_set = load_set(folder)
    return [
        Found(index, image_set.views[index].use, seen)
        for index in views_taken(image_set, size)
        for seen in board_views(image_set, [board_in(folder, index)])
    ]


def image_part(folder, image_set, index, size):
    """Return detection and corners of one image, with a small copy."""
    found = board_in(folder, index).detection
    image = as_8_bit(read_image(image_set, image_set.views[index]))
    result = {
        "found": found.found,
        "reason": found.reason,
        "columns": found.columns,
        "rows": found.rows,
        "thumbnail": reduced(image, size.thumbnail_px),
    }
    if found.found:
        result["corners"] = found.corners
    return result


def calibrated(boards, image_set, rng):
    """Return every model from the same boards: {model: calibration or None}, reasons.

    All models assume flat boards, as the compared methods do, and are scored on them.
    """
    views = [board.view for board in boards]
    width, height = image_set.width, image_set.height
    unit = image_set.target.unit
    builders = {
        "zhang": lambda: calibrate_zhang(views, width, height),
        "general": lambda: calibrate_generic(views, width, height, rng=rng, units=unit),
        PEER: lambda: calibrate_opencv_fisheye(views, width, height),
        "kannala_brandt": lambda: calibrate_lens(
            views, width, height, "kannala-brandt", board="flat"
        ),
        "unified": lambda: calibrate_lens(
            views, width, height, "unified", board="flat"
        ),
        "spline": lambda: calibrate_spline(
            views, width, height, rng=rng, units=unit, board="flat"
        ),
        "cgsp": lambda: calibrate_cgsp(views, width, height, rng=rng, units=unit),
    }
    models, reasons = {}, {}
    for model, build in builders.items():
        try:
            models[model], reasons[model] = build(), ""
        except InputError as refusal:
            models[model], reasons[model] = None, refusal.code
    return models, reasons


def fit_part(image_set, boards, size, rng):
    """Return the cameras from all images for calibration, and their fitted errors."""
    used = [board for board in boards if board.use == "calibrate"]
    models, reasons = calibrated(used, image_set, rng)
    cameras = _cameras(models)
    result = {model: {"reason": why} for model, why in reasons.items()}
    for model, camera in cameras.items():
        result[model]["image_with_ray"] = share_of_image(camera)
    if models["zhang"]:
        result["zhang"] |= zhang_numbers(models["zhang"])
    if models["general"]:
        result["general"] |= general_numbers(models["general"], used)
    for model in LENSES:
        if models[model]:
            result[model] |= lens_numbers(models[model])
    result["calibrated"] = np.array([board.index for board in used])
    result["views"] = {
        str(board.index): scores(cameras, board.view) for board in boards
    }
    compared = {m: c for m, c in cameras.items() if m in MODELS}
    result["undistorted"] = undistorted(image_set, compared, boards, size.picture_px)
    return result


def share_of_image(camera):
    """Return the share of the image's pixels with a ray of the camera."""
    grid = scoring_grid(camera.width, camera.height)
    return float(camera.rays(grid).valid.mean())


def zhang_numbers(calibration):
    """Return the parameters of Zhang's camera, and the board's poses."""
    K = calibration.camera.K
    k1, k2 = calibration.camera.radial
    return {
        "fx_px": K[0, 0],
        "fy_px": K[1, 1],
        "u0_px": K[0, 2],
        "v0_px": K[1, 2],
        "k1": k1,
        "k2": k2,
        "rms_px": calibration.rms_px,
        "T_camera_grid": calibration.T_camera_grid,
    }


def lens_numbers(calibration):
    """Return the terms of a parametric model, and the test for a pupil shift."""
    test = calibration.pupil
    numbers = {n: v for n, v in test._asdict().items() if type(v) is not str}
    verdict = {name: test.verdict == name for name in (MOVES, UNDECIDED)}
    return {
        "terms": len(calibration.formula.names),
        "wrong_corners": len(calibration.wrong),
        "pupil": {n: float(v) for n, v in (numbers | verdict).items()},
    }


def general_numbers(calibration, boards):
    """Return the number of rays, the boards used, and the excluded ones with reason."""
    mask = calibration.camera.mask
    return {
        "rays": int(np.count_nonzero(mask)),
        "share_with_ray": calibration.share_with_ray,
        "boards": len(calibration.used),
        "rms_deg": calibration.rms_deg,
        "left_out": {
            str(boards[k].index): why for k, why in calibration.left_out.items()
        },
        "coverage": reduced(np.uint8(255) * mask, COVERAGE_PX),
    }


def fold_part(image_set, boards, fold, parts, rng):
    """Return held-out errors of cameras from all images but one part."""
    used = [board for board in boards if board.use == "calibrate"]
    kept_out = used[fold :: min(parts, max(len(used), 1))]
    if fold >= len(used):
        return {"kept_out": 0}
    rest = [board for board in used if board not in kept_out]
    models, reasons = calibrated(rest, image_set, rng)
    cameras = _cameras(models)
    return {model: {"reason": why} for model, why in reasons.items()} | {
        "kept_out": len(kept_out),
        "views": {str(b.index): scores(cameras, b.view) for b in kept_out},
    }


def _cameras(models):
    return {model: m.camera for model, m in models.items() if m is not None}


def scores(cameras, view):
    """Return the errors of each camera in one view, with only the board's pose fitted.

    `own`: on every corner with a ray of the camera. `same`: on corners with a ray of
    both compared cameras.
    """
    result = {"corners": int(np.count_nonzero(np.isfinite(view.pixels[:, 0])))}
    own = {m: evaluate_camera(c, [view]).images[0] for m, c in cameras.items()}
    for model, score in own.items():
        result[model] = {"own": errors(score, score.residuals_px)}
    if not set(MODELS) <= set(cameras):
        return result
    cameras = {m: c for m, c in cameras.items() if m in ALL_NAMES}
    compared = {model: cameras[model] for model in MODELS}
    both = np.all([c.rays(view.pixels).valid for c in compared.values()], axis=0)
    shared = view._replace(pixels=np.where(both[:, None], view.pixels, np.nan))
    same = {m: evaluate_camera(c, [shared]).images[0] for m, c in cameras.items()}
    answered = np.all(
        [np.isfinite(same[model].residuals_px) for model in MODELS], axis=0
    )
    for model, score in same.items():
        residuals = np.where(answered, score.residuals_px, np.nan)
        result[model]["same"] = errors(score, residuals)
    return result


def errors(score, residuals):
    """Return the numbers of one ImageScore, in px over residuals (N, 2)."""
    lengths = np.linalg.norm(residuals, axis=1)
    lengths = lengths[np.isfinite(lengths)]
    known = len(lengths) > 0
    return {
        "corners": len(lengths),
        "rms_px": np.sqrt(np.mean(lengths**2)) if known else np.nan,
        "median_px": np.median(lengths) if known else np.nan,
        "mean_deg": score.mean_deg,
        "reason": score.reason,
        "residuals_px": residuals,
    }
