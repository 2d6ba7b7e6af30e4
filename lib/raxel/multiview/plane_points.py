"""Points of a plane with a known pose that a general camera's pixels see (5.3.4).

The plane is the only scene model needed to remove all distortion, for any camera. Its
rays are intersected with the plane; points, a circle and whole images follow.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import Camera, closest_point, pixel_grid
from raxel.errors import InputError
from raxel.geometry.planes import intersect_rays_plane, on_plane
from raxel.geometry.poses import cross_matrix, inverse_pose, rotate, transform
from raxel.multiview.fits.circles import CircleFit, fit_circle
from raxel.multiview.ray_noise import are_rotations
from raxel.multiview.views import PerspectiveView, remap_to_plane

STEP_PX = 0.5  # to either side, for derivatives of points by pixels
TANGENT_STEP_RAD = 1e-4  # along a circle, for its tangent
PIXELS_AT_ONCE = 1 << 17
MAX_N_PIXELS = 1 << 28
MAX_COORDINATE_MM = 1e100


class PlanePoints(NamedTuple):
    """Points of a plane that pixels see.

    Attributes
    ----------
    points : ndarray of shape (N, 2)
        Points in the plane's frame, mm; NaN if not valid.
    valid : ndarray of shape (N,)
        Whether a pixel sees the plane, bool.
    per_px : ndarray of shape (N, 2, 2)
        Derivatives of the points by their pixels, mm/px.
    """

    points: np.ndarray
    valid: np.ndarray
    per_px: np.ndarray


class CircleOnPlane(NamedTuple):
    """Circle of a plane, measured in an image.

    Attributes
    ----------
    fit : CircleFit
        Circle through the points.
    points : ndarray of shape (n, 2)
        Points of the edge in the plane's frame.
    used : ndarray of shape (N,)
        Pixels that the points come from, bool.
    """

    fit: CircleFit
    points: np.ndarray
    used: np.ndarray


def points_on_plane(
    camera: Camera, pixels: ArrayLike, T_camera_plane: ArrayLike
) -> PlanePoints:
    """Return the points of a plane that pixels see.

    A pixel is not valid without a ray, or if its ray does not meet the plane ahead of
    its origin. The same holds for the rays of its neighbours at half a pixel.

    Parameters
    ----------
    camera : Camera
        Any camera.
    pixels : array_like of shape (N, 2)
        Pixels, px.
    T_camera_plane : array_like of shape (4, 4)
        Pose of the plane z = 0, mm.

    Returns
    -------
    PlanePoints
        Points in the plane's frame with their derivatives.

    Raises
    ------
    InputError
        For an invalid pose, and pixels of another shape.

    References
    ----------
    Thesis 5.3.4.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.multiview import points_on_plane
    >>> K = np.array([[500, 0, 320], [0, 500, 240], [0, 0, 1.0]])
    >>> T_camera_plane = np.eye(4)
    >>> T_camera_plane[2, 3] = 1000.0
    >>> camera = PerspectiveCamera(K, [], 640, 480)
    >>> points_on_plane(camera, [[370, 240]], T_camera_plane).points.round(6).tolist()
    [[100.0, 0.0]]
    """
    pixels, T_camera_plane = np.asarray(pixels, float), checked_plane(T_camera_plane)
    if pixels.ndim != 2 or pixels.shape[1] != 2:
        raise InputError(f"plane: found pixels {pixels.shape}; give (N, 2)")
    steps = STEP_PX * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1.0]])
    rays = camera.rays((pixels + steps[:, None]).reshape(-1, 2))
    hits = intersect_rays_plane(rays.origins, rays.directions, T_camera_plane).points
    middle, right, left, below, above = hits.reshape(5, -1, 2)
    per_px = np.stack([right - left, below - above], axis=2) / (2 * STEP_PX)
    valid = np.isfinite(middle).all(axis=1) & np.isfinite(per_px).all(axis=(1, 2))
    return PlanePoints(np.where(valid[:, None], middle, np.nan), valid, per_px)


def circle_outline(
    camera: Camera,
    T_camera_plane: ArrayLike,
    centre: ArrayLike,
    radius: float,
    count: int = 360,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return where a camera shows a circle of a plane, to search for its edge there.

    An approximately known camera suffices. Values are NaN where the camera does not
    show the circle, or outside its image.

    Parameters
    ----------
    camera : Camera
        Any camera.
    T_camera_plane : array_like of shape (4, 4)
        Pose of the plane z = 0, mm.
    centre : array_like of shape (2,)
        Centre in the plane's frame, mm.
    radius : float
        Radius, mm.
    count : int
        Number of points.

    Returns
    -------
    pixels : ndarray of shape (count, 2)
        Outline, px.
    normals : ndarray of shape (count, 2)
        Unit normals of the outline, away from the inside of the circle.
    scale : ndarray of shape (count,)
        Pixels across the outline per length on the plane, px/mm.

    Raises
    ------
    InputError
        For an invalid pose or circle.
    """
    T_camera_plane = checked_plane(T_camera_plane)
    if np.shape(centre) != (2,) or not (0 < radius < np.inf):
        raise InputError(
            f"circle: found centre {np.shape(centre)} and radius {radius}; give (2,) "
            "and a length above 0"
        )
    angles = 2 * np.pi * np.arange(count) / count

    def shown(angle, r):
        around = r * np.column_stack([np.cos(angle), np.sin(angle)]) + centre
        return camera.project(transform(T_camera_plane, on_plane(around))).pixels

    pixels = shown(angles, radius)
    along = shown(angles + TANGENT_STEP_RAD, radius) - shown(
        angles - TANGENT_STEP_RAD, radius
    )
    outward = shown(angles, radius * (1 + TANGENT_STEP_RAD)) - pixels
    normals = np.column_stack([-along[:, 1], along[:, 0]])
    with np.errstate(invalid="ignore", divide="ignore"):
        normals *= np.sign(np.sum(normals * outward, axis=1))[:, None]
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    seen = camera.in_image(pixels) & np.isfinite(normals).all(axis=1)
    removed = np.where(seen, 1.0, np.nan)
    scale = np.sum(normals * outward, axis=1) / (TANGENT_STEP_RAD * radius)
    return pixels * removed[:, None], normals * removed[:, None], scale * removed


def measured_circle(
    camera: Camera,
    pixels: ArrayLike,
    T_camera_plane: ArrayLike,
    sigma_px: ArrayLike | None = None,
    pose_covariance: ArrayLike | None = None,
) -> CircleOnPlane:
    """Measure a circle of a plane from pixels of its edge.

    The thesis calls this a double evaluation: the pose came from the same camera.
    Residuals and radius cannot show ray errors that are common to corners and circle.

    Parameters
    ----------
    camera : Camera
        Any camera.
    pixels : array_like of shape (N, 2)
        Pixels of the edge, such as `raxel.features.edge_profiles` finds, px. Pixels
        that are not finite or do not see the plane are excluded.
    T_camera_plane : array_like of shape (4, 4)
        Pose of the plane, known or estimated from corners, mm.
    sigma_px : float or array_like of shape (N,), optional
        Standard deviation of the edge, px, propagated to the plane by the camera's
        local scale. None: equal on the plane and unknown.
    pose_covariance : array_like of shape (6, 6), optional
        Covariance of (w, s), the error of the pose as R exp([w]x), t + R s. None: the
        plane is taken as known.

    Returns
    -------
    CircleOnPlane
        Circle fit, its points and the pixels used.

    Raises
    ------
    InputError
        As `fit_circle`.

    References
    ----------
    Thesis 5.3.4.
    """
    seen = points_on_plane(camera, pixels, T_camera_plane)
    _check_uncertainty(len(seen.valid), sigma_px, pose_covariance)
    points = seen.points[seen.valid]
    fit = fit_circle(points)
    spread = np.ones(len(points))
    if sigma_px is not None:
        outward = (points - fit.centre) / _lengths(points - fit.centre)
        per_px = np.einsum("ni,nij->nj", outward, seen.per_px[seen.valid])
        of_edge = np.broadcast_to(sigma_px, len(seen.valid))[seen.valid]
        spread = of_edge * _lengths(per_px)[:, 0]
        fit = fit_circle(points, spread)
    if pose_covariance is not None:
        rays = camera.rays(np.asarray(pixels, float)[seen.valid])
        by_pose = _moved_by_pose(
            points, rotate(inverse_pose(T_camera_plane), rays.directions)
        )
        J = _circle_by_pose(fit.centre, points, by_pose, spread)
        covariance = fit.covariance + J @ np.asarray(pose_covariance) @ J.T
        fit = fit._replace(covariance=covariance)
    return CircleOnPlane(fit, points, seen.valid)


def checked_plane(T_camera_plane: ArrayLike) -> NDArray[np.float64]:
    """Pose (4, 4) of a plane as floats; InputError for an invalid pose."""
    T = np.asarray(T_camera_plane, float)
    if T.shape != (4, 4) or not (
        np.isfinite(T).all()
        and are_rotations(T[:3, :3])
        and np.abs(T).max() < MAX_COORDINATE_MM
    ):
        raise InputError(
            f"plane: pose: found no rigid motion ({T.shape}); give a finite rotation "
            "and translation, (4, 4)"
        )
    return T


def _check_uncertainty(count, sigma_px, pose_covariance):
    if np.shape(sigma_px) not in ((), (count,)):
        raise InputError(
            f"circle: sigma: found shape {np.shape(sigma_px)} for {count} pixels; give "
            "one, or one for each"
        )
    given = pose_covariance is not None
    if given and not (
        np.shape(pose_covariance) == (6, 6) and np.isfinite(pose_covariance).all()
    ):
        raise InputError(
            f"circle: pose covariance: found shape {np.shape(pose_covariance)}; give "
            "(6, 6), finite"
        )


def _moved_by_pose(points, directions):
    """Derivatives (N, 2, 6) by a plane's pose of points (N, 2) where rays meet it.

    directions: (N, 3) of the rays in the plane's frame; columns: w, s.
    """
    # In the plane's moved frame the old point is at X - s - w x X, and the ray returns
    # from there to z = 0.
    moved = np.concatenate(
        [
            cross_matrix(on_plane(points)),
            np.broadcast_to(-np.eye(3), (len(points), 3, 3)),
        ],
        axis=2,
    )
    slope = directions[:, :2] / directions[:, 2:]
    return moved[:, :2] - slope[:, :, None] * moved[:, 2:]


def _circle_by_pose(centre, points, by_pose, spread):
    """Derivatives (3, 6) of centre and radius by the pose, with the fit's weights."""
    outward = (points - centre) / _lengths(points - centre)
    A = np.column_stack([outward, np.ones(len(points))]) / spread[:, None]
    separation = np.einsum("ni,nij->nj", outward, by_pose) / spread[:, None]
    return np.linalg.lstsq(A, separation, rcond=None)[0]


def _lengths(vectors):
    return np.linalg.norm(vectors, axis=1, keepdims=True)


def plane_image(
    camera: Camera,
    image: np.ndarray,
    T_camera_plane: ArrayLike,
    corner: ArrayLike,
    size: Sequence[float] | NDArray[np.float64],
    per_px: float,
) -> tuple[np.ndarray, NDArray[np.bool_]]:
    """Return a camera's image laid out on a plane, without its distortion.

    Parameters
    ----------
    camera : Camera
        Any camera.
    image : ndarray of shape (H, W) or (H, W, C)
        Whole image of the camera.
    T_camera_plane : array_like of shape (4, 4)
        Pose of the plane z = 0, mm.
    corner : array_like of shape (2,)
        Upper left corner of the part shown, plane's frame, mm.
    size : array_like of shape (2,)
        Width and height of the part shown, mm.
    per_px : float
        Length of a pixel of the new image, mm. Pixel (u, v) has its centre at
        corner + per_px (u + 1/2, v + 1/2).

    Returns
    -------
    image, seen : ndarray
        As `remap_to_plane`.

    Raises
    ------
    InputError
        As `remap_to_plane`. Also for an image that is not the camera's, and a new image
        without a size or beyond MAX_N_PIXELS.

    References
    ----------
    Thesis, Fig. 5.18.
    """
    check_image_size(np.divide(size, per_px) if per_px > 0 else (np.nan, np.nan))
    location = plane_locations(camera, image, T_camera_plane) - corner
    return remap_to_plane(image, _near(location, size), None, None, size, per_px)


def plane_locations(camera, image, T_camera_plane):
    """Position on a plane that each pixel of a camera's image sees: (H, W, 2).

    NaN where none. Raises InputError for an image that is not of the camera's size, and
    an invalid pose.
    """
    T_camera_plane = checked_plane(T_camera_plane)
    shape = np.shape(image)[:2]
    if shape != (camera.height, camera.width):
        raise InputError(
            f"image: found {shape[1]} x {shape[0]} px; give the camera's "
            f"{camera.width} x {camera.height}"
        )
    location = np.empty((*shape, 2))
    rows = max(1, PIXELS_AT_ONCE // camera.width)
    for top in range(0, camera.height, rows):
        count = min(rows, camera.height - top)
        rays = camera.rays(pixel_grid(camera.width, count) + [0, top])
        hits = intersect_rays_plane(rays.origins, rays.directions, T_camera_plane)
        location[top : top + count] = hits.points.reshape(count, -1, 2)
    return location


def check_image_size(size_px):
    """Reject an image size (width, height), px, that is not allowed."""
    with np.errstate(over="ignore"):
        fits = np.shape(size_px) == (2,) and np.prod(size_px) <= MAX_N_PIXELS
    if not (fits and np.min(size_px) > 0):
        raise InputError(
            f"plane image: found a size of {np.asarray(size_px).tolist()} px; give a "
            f"size and a scale above 0 for at most {MAX_N_PIXELS} pixels"
        )


def _near(location, size):
    """Locations, NaN where they are far outside an image of this size."""
    margin = np.max(size)
    with np.errstate(invalid="ignore"):
        far = (location < -margin) | (location > np.asarray(size) + margin)
    return np.where(far.any(axis=2, keepdims=True), np.nan, location)


# Nearly perspective view by a non-central camera (5.3.4, Fig. 5.19). Its rays meet in
# no point, so the image of a pinhole camera depends on the scene. An assumed scene, a
# plane or a range for every pixel, gives the end points of the view's rays, and the
# camera projects these. Where the assumption is correct the view is exact; elsewhere it
# keeps the caustic part of the distortion. Source: Swaminathan, Grossberg, Nayar 2003,
# doi:10.1109/CVPR.2003.1211522 (assumed scene geometry).


VIEW_GRID_SIZE = 61  # rays per axis that determine a view
MIN_N_PLANE_RAYS = 3  # rays that must meet the plane


def view_of_plane(
    camera: Camera,
    T_camera_plane: ArrayLike,
    per_px: float,
    corner: Sequence[float] | NDArray[np.float64] | None = None,
    size: Sequence[float] | NDArray[np.float64] | None = None,
) -> PerspectiveView:
    """Return the pinhole nearest to a camera's rays that views a part of a plane.

    The pinhole is the point nearest to the rays that meet this part, behind a mirror.
    It points at the middle of the part, and its image holds all of it.

    Parameters
    ----------
    camera : Camera
        Any camera.
    T_camera_plane : array_like of shape (4, 4)
        Pose of the plane, mm. Its x and y axes become right and down in the image.
    per_px : float
        Length of a pixel on the plane at the middle of the view, mm.
    corner, size : array_like of shape (2,), optional
        The part in the plane's frame, mm. None: all that the camera sees of it, which
        is too much for a plane visible as far as its horizon.

    Returns
    -------
    PerspectiveView
        The virtual pinhole.

    Raises
    ------
    InputError
        If fewer than three rays meet the part, and for an invalid pose, part or scale.

    References
    ----------
    Thesis 5.3.4, Fig. 5.19. Swaminathan, Grossberg, Nayar 2003,
    doi:10.1109/CVPR.2003.1211522.
    """
    T_camera_plane = checked_plane(T_camera_plane)
    if not 0 < per_px < np.inf:
        raise InputError(
            f"near-perspective view: found a scale of {per_px}; give a length above 0"
        )
    if (corner is None) != (size is None) or (
        corner is not None
        and size is not None
        and not np.shape(corner) == np.shape(size) == (2,)
    ):
        raise InputError(
            f"near-perspective view: found corner {corner} and size {size}; give both, "
            "two numbers each, or neither"
        )
    steps = np.array([camera.width, camera.height]) - 1
    rays = camera.rays(
        pixel_grid(VIEW_GRID_SIZE, VIEW_GRID_SIZE) * steps / (VIEW_GRID_SIZE - 1)
    )
    hits = intersect_rays_plane(rays.origins, rays.directions, T_camera_plane)
    met = hits.valid & rays.valid
    if corner is not None:
        low, high = np.asarray(corner), np.asarray(corner) + size
        inside = (hits.points >= low) & (hits.points <= high)
        met = met & inside.all(axis=1)
    if np.count_nonzero(met) < MIN_N_PLANE_RAYS:
        raise InputError(
            f"near-perspective view: {np.count_nonzero(met)} of {VIEW_GRID_SIZE**2} "
            "rays meet the chosen part of the plane; give a part that the camera sees"
        )
    if corner is None:
        low, high = hits.points[met].min(axis=0), hits.points[met].max(axis=0)
    centre = closest_point(rays._replace(valid=met))
    middle = transform(T_camera_plane, on_plane((low + high)[None] / 2))[0]
    R = _facing(middle - centre, T_camera_plane[:3, 1])
    focal = np.linalg.norm(middle - centre) / per_px
    x, y = np.stack([low, [high[0], low[1]], high, [low[0], high[1]]]).T
    ring = transform(T_camera_plane, on_plane(np.column_stack([x, y])))
    seen = (ring - centre) @ R
    places = focal * seen[:, :2] / seen[:, 2:]
    first, last = np.floor(places.min(axis=0)), np.ceil(places.max(axis=0))
    K = np.array([[focal, 0, -first[0]], [0, focal, -first[1]], [0, 0, 1]])
    check_image_size(last - first + 1)
    width, height = (last - first).astype(int) + 1
    return PerspectiveView(K, R, centre, int(width), int(height))


def view_pixels(view: PerspectiveView, points: ArrayLike) -> NDArray[np.float64]:
    """Return where a view shows points of the camera frame.

    Parameters
    ----------
    view : PerspectiveView
        Virtual pinhole.
    points : array_like of shape (N, 3)
        Points in the camera frame, mm.

    Returns
    -------
    ndarray of shape (N, 2)
        Pixels, px; NaN for points behind the view.
    """
    seen = (np.asarray(points, float) - view.centre) @ view.R_camera_view @ view.K.T
    ahead = np.where(seen[:, 2:] > 0, seen[:, 2:], np.nan)
    return seen[:, :2] / ahead


def view_over_plane(
    camera: Camera, image: np.ndarray, view: PerspectiveView, T_camera_plane: ArrayLike
) -> tuple[np.ndarray, NDArray[np.bool_]]:
    """Return a camera's image as a view shows it, with the scene assumed on a plane.

    It uses the camera's rays alone: mirrors find rays of pixels faster than pixels of
    points.

    Parameters
    ----------
    camera : Camera
        Any camera.
    image : ndarray of shape (H, W) or (H, W, C)
        Whole image of the camera.
    view : PerspectiveView
        Virtual pinhole.
    T_camera_plane : array_like of shape (4, 4)
        Pose of the plane z = 0, mm.

    Returns
    -------
    image, seen : ndarray
        As `remap_to_plane`, of the view's height and width.

    Raises
    ------
    InputError
        As `remap_to_plane`, and for an image that is not the camera's.

    References
    ----------
    Thesis, Fig. 5.19.
    """
    on = plane_locations(camera, image, T_camera_plane)
    points = transform(T_camera_plane, on_plane(on.reshape(-1, 2)))
    places = view_pixels(view, points).reshape(on.shape)
    size = view.width, view.height
    far = (np.abs(places) > 2 * max(size)).any(axis=2)
    places[far] = np.nan
    # There a pixel's centre is half a pixel from its border.
    return remap_to_plane(image, places + 0.5, None, None, size, 1.0)


def shown_in_view(
    camera: Camera, view: PerspectiveView, pixels: ArrayLike, T_camera_plane: ArrayLike
) -> NDArray[np.float64]:
    """Return where a camera's pixels appear in a view over a plane.

    The inverse of `view_over_plane`.

    Parameters
    ----------
    camera : Camera
        Any camera.
    view : PerspectiveView
        Virtual pinhole.
    pixels : array_like of shape (N, 2)
        Pixels of the camera, px.
    T_camera_plane : array_like of shape (4, 4)
        Pose of the plane z = 0, mm.

    Returns
    -------
    ndarray of shape (N, 2)
        Pixels of the view, px; NaN if a ray does not meet the plane.

    Raises
    ------
    InputError
        For an invalid pose.
    """
    T_camera_plane = checked_plane(T_camera_plane)
    rays = camera.rays(pixels)
    hits = intersect_rays_plane(rays.origins, rays.directions, T_camera_plane)
    return view_pixels(view, transform(T_camera_plane, on_plane(hits.points)))


def facing_plane(
    T_camera_plane: ArrayLike, viewpoint: ArrayLike, offset: float
) -> NDArray[np.float64]:
    """Return a plane moved along its normal towards a viewpoint.

    A relief is best assumed at its mean height above the plate that holds it.

    Parameters
    ----------
    T_camera_plane : array_like of shape (4, 4)
        Pose of the plane z = 0, mm.
    viewpoint : array_like of shape (3,)
        Point in the camera frame, mm.
    offset : float
        Length of the shift, mm.

    Returns
    -------
    ndarray of shape (4, 4)
        Pose of the moved plane, mm.

    Raises
    ------
    InputError
        For an invalid pose.
    """
    T_camera_plane = checked_plane(T_camera_plane)
    side = transform(inverse_pose(T_camera_plane), np.asarray(viewpoint)[None])[0, 2]
    moved = np.array(T_camera_plane, float)
    normal = rotate(moved, np.array([[0.0, 0.0, np.sign(side)]]))[0]
    moved[:3, 3] += offset * normal
    return moved


def _facing(ahead, down):
    """R_camera_view (3, 3): z along `ahead`, y as close to `down` as possible."""
    z = ahead / np.linalg.norm(ahead)
    y = down - z * (z @ down)
    y /= np.linalg.norm(y)
    return np.column_stack([np.cross(y, z), y, z])
