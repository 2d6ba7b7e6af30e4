"""A building front in front of the lens of set 2: images, and straight lines."""

from functools import cache

import numpy as np

from chapters.shared.general.zoom_rigs import FACADE_ZOOM, rig_of, zoom_camera
from chapters.shared.methods import LINEAR
from raxel.evaluation import corrected_view, synthetic_plane
from raxel.geometry import inverse_pose, on_plane, pose, rotation_from_vector, transform
from raxel.lab import facade
from raxel.multiview import PerspectiveView, resample, source_pixels

EYE_MM = [600.0, -1600.0, -8500.0]
PITCH_DEG = 14.0
HALF_VIEW_DEG = 58.0
ON_EDGE = 120
MIN_ON_LINE = 6
OUTER = 0.8


def T_world_camera():
    """Return the pose of the camera in front of the building, tilted upwards."""
    R = rotation_from_vector(np.radians([PITCH_DEG, 0.0, 0.0]))
    return pose(R, EYE_MM)


def facade_image(rng):
    """Render the image that the camera of set 2 records of the front, uint8."""
    laboratory = rig_of(FACADE_ZOOM).laboratory()
    return laboratory.render(facade(), T_world_camera(), rng)


@cache
def edge_pixels():
    """Return true pixels (edges, points, 2) along the front's straight edges."""
    edges = facade().straight_edges
    share = np.linspace(0, 1, ON_EDGE)[:, None]
    points = edges[:, :1] + share * (edges[:, 1:] - edges[:, :1])
    flat = transform(inverse_pose(T_world_camera()), points.reshape(-1, 3))
    camera = zoom_camera(FACADE_ZOOM)
    seen = camera.project(flat)
    inside = seen.valid & camera.in_image(np.nan_to_num(seen.pixels, nan=-9))
    pixels = np.where(inside[:, None], seen.pixels, np.nan)
    return pixels.reshape(*points.shape[:2], 2)


def straightness(cameras):
    """Return RMS distances from straight lines in the outer fifth of the radius.

    Per generic method: its own and that of the parametric one, on the same points,
    in px of the corrected view and of the source image.
    """
    out = {}
    for method in (method for method in LINEAR if method in cameras):
        generic = cameras[method]
        pixels = outer_pixels(generic)
        pair = {"generic": generic, "parametric": cameras["parametric"]}
        shared = np.isfinite(pixels[..., 0])
        for camera in pair.values():
            shared &= has_view(camera, pixels)
        pixels = np.where(shared[..., None], pixels, np.nan)
        out[method] = {
            name: line_rms(camera, pixels) for name, camera in pair.items()
        } | {"points": int(np.count_nonzero(shared))}
    return out


def outer_pixels(generic):
    """Return edge pixels beyond 0.8 of the radius that the generic rays reach."""
    middle = (np.array([generic.width, generic.height]) - 1) / 2
    v, u = np.nonzero(generic.mask)
    reach = np.linalg.norm(np.column_stack([u, v]) - middle, axis=1).max()
    pixels = edge_pixels()
    outside = np.linalg.norm(pixels - middle, axis=-1) > OUTER * reach
    return np.where(outside[..., None], pixels, np.nan)


def has_view(camera, pixels):
    """Return which of the pixels (edges, points, 2) the corrected view shows."""
    seen, _ = in_view(camera, pixels.reshape(-1, 2))
    return np.isfinite(seen[:, 0]).reshape(pixels.shape[:2])


def line_rms(camera, pixels):
    """Return the RMS distance (px) of edge points from their lines, by scale."""
    corrected, source = [], []
    for edge in pixels:
        known = edge[np.isfinite(edge[:, 0])]
        if len(known) < MIN_ON_LINE:
            continue
        seen, plane = in_view(camera, known)
        foot = on_line(seen)
        corrected.append(np.linalg.norm(seen - foot, axis=1))
        back = source_pixels_of(camera, plane, foot)
        source.append(np.linalg.norm(known - back, axis=1))
    if not corrected:
        return {"edges": 0}
    scales = {"corrected": corrected, "source": source}
    return {"edges": len(corrected)} | {
        scale: np.sqrt(np.nanmean(np.concatenate(lengths) ** 2))
        for scale, lengths in scales.items()
    }


def on_line(points):
    """Return the feet (N, 2) of points on their best line (total least squares)."""
    centre = points.mean(axis=0)
    along = np.linalg.svd(points - centre)[2][0]
    return centre + ((points - centre) @ along)[:, None] * along


def corrected_images(image, cameras):
    """Return the image resampled for a pinhole, by method, and upright.

    Upright: the generic method's view on a plane parallel to the front's
    verticals, by the camera's true tilt.
    """
    out = {}
    for method, camera in cameras.items():
        R = synthetic_plane(camera).T_camera_plane[:3, :3]
        out[f"view.{method}"] = pinhole_image(image, camera, R)
    best = cameras.get("generic_as_printed")
    if best is not None:
        R = inverse_pose(T_world_camera())[:3, :3]
        out["view.upright"] = pinhole_image(image, best, R)
    return out


def edges_in_images(cameras):
    """Return the positions of the front's edges in the corrected images.

    Per method px (edges, points, 2) of its image, NaN where it shows nothing;
    "as_taken" are the true pixels of the source image.
    """
    pixels = edge_pixels()
    out = {"edges.as_taken": pixels}
    for method, camera in cameras.items():
        seen, plane = in_view(camera, pixels.reshape(-1, 2))
        K = view_matrix(camera)
        flat = (seen - plane.principal_pixel) / plane.px_per_unit
        shown = flat * K[0, 0] + K[:2, 2]
        size = np.array([camera.width, camera.height])
        inside = np.all((shown > -0.5) & (shown < size - 0.5), axis=1)
        shown = np.where(inside[:, None], shown, np.nan)
        out[f"edges.{method}"] = shown.reshape(pixels.shape)
    return out


def view_matrix(camera):
    """Return K of the pinhole of the corrected images."""
    middle = (np.array([camera.width, camera.height]) - 1) / 2
    focal = middle[0] / np.tan(np.radians(HALF_VIEW_DEG))
    return np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])


def pinhole_image(image, camera, R_camera_view):
    """Return the image resampled for a pinhole that looks along the view's z."""
    view = PerspectiveView(
        view_matrix(camera), R_camera_view, np.zeros(3), camera.width, camera.height
    )
    return resample(image, source_pixels(camera, view))


# From pixels to the corrected view of a calibrated camera, and back.


def source_pixels_of(camera, plane, corrected):
    """Return source pixels of points (M, 2) of the corrected view."""
    flat = (corrected - plane.principal_pixel) / plane.px_per_unit
    points = transform(plane.T_camera_plane, on_plane(flat))
    return camera.project(points).pixels


def in_view(camera, pixels):
    """Return points (N, 2) of the corrected view for pixels, NaN without one."""
    plane = synthetic_plane(camera)
    rays = camera.rays(pixels)
    seen, ahead = corrected_view(rays.directions, plane, np.nan_to_num(rays.origins))
    usable = (rays.valid & ahead)[:, None]
    return np.where(usable, seen, np.nan), plane
