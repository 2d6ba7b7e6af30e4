"""Undistorted view of an image through a given model."""

import numpy as np

from raxel.errors import InputError
from raxel.evaluation import corrected_view, distortion_residual, synthetic_plane
from raxel.features.detector import as_8_bit
from raxel.multiview.perspective_view import PerspectiveView, resample, source_pixels
from raxel.sets import read_image

SUPERSAMPLED = 2
MARGIN = 0.9  # corners lie within this share of the picture's half size
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
            result[model] |= _picture(camera, view, image)
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


def _picture(camera, view, image):
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
