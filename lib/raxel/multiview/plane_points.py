"""What a general camera's pixels see of a plane whose pose is known (5.3.4).

No model of the scene but its plane is needed to take all distortion out, whatever the
camera. Its rays are met with the plane; points, a circle and whole pictures follow.
"""

from typing import NamedTuple

import numpy as np

from raxel.cameras.core.base import closest_point, pixel_grid
from raxel.errors import InputError
from raxel.geometry.planes import intersect_rays_plane, on_plane
from raxel.geometry.poses import cross_matrix, inverse_pose, rotate, transform
from raxel.multiview.fits.circles import CircleFit, fit_circle
from raxel.multiview.ray_noise import are_rotations
from raxel.multiview.views import PerspectiveView, remap_to_plane

STEP_PX = 0.5  # to either side, for how points move with pixels
STEP_TURN = 1e-4  # radians along a circle, for its tangent
PIXELS_AT_ONCE = 1 << 17
MOST_PIXELS = 1 << 28
FARTHEST = 1e100  # mm


class PlanePoints(NamedTuple):
    """points: (N, 2) in the plane's frame, NaN where not valid; valid: (N,) bool.

    per_px: (N, 2, 2) derivatives of the points by their pixels.
    """

    points: np.ndarray
    valid: np.ndarray
    per_px: np.ndarray


class CircleOnPlane(NamedTuple):
    """A circle of a plane, measured in a picture.

    fit: the `CircleFit` to points (n, 2) in the plane's frame; used: (N,) bool, the
    pixels that they come from.
    """

    fit: CircleFit
    points: np.ndarray
    used: np.ndarray


def points_on_plane(camera, pixels, T_camera_plane):
    """Where pixels (N, 2) see the plane z = 0 of T_camera_plane (4, 4): `PlanePoints`.

    camera: any Camera. Not valid are pixels without a ray, or whose ray, or that of a
    neighbour half a pixel off, does not meet the plane ahead of its origin. Raises
    InputError for a pose that is none, and pixels of another shape.
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


def circle_outline(camera, T_camera_plane, centre, radius, count=360):
    """Where a camera shows a circle of a plane: places to look for its edge.

    centre: (2,), radius: in the plane's frame. Returns pixels (count, 2), unit normals
    (count, 2) of the outline there, away from the circle's inside, and scale (count,),
    px across the outline per length on the plane; NaN where the camera does not show
    the circle, or beyond its picture. The camera may be one that is roughly known.
    Raises InputError for a pose or circle that is none.
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
    along = shown(angles + STEP_TURN, radius) - shown(angles - STEP_TURN, radius)
    outward = shown(angles, radius * (1 + STEP_TURN)) - pixels
    normals = np.column_stack([-along[:, 1], along[:, 0]])
    with np.errstate(invalid="ignore", divide="ignore"):
        normals *= np.sign(np.sum(normals * outward, axis=1))[:, None]
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    seen = camera.in_image(pixels) & np.isfinite(normals).all(axis=1)
    gone = np.where(seen, 1.0, np.nan)
    scale = np.sum(normals * outward, axis=1) / (STEP_TURN * radius)
    return pixels * gone[:, None], normals * gone[:, None], scale * gone


def measured_circle(
    camera, pixels, T_camera_plane, sigma_px=None, pose_covariance=None
):
    """The circle through points of its edge, carried along rays to their plane (5.3.4).

    pixels: (N, 2) of the edge, such as `raxel.features.edge_profiles` finds; those that
    are not finite or do not see the plane are left out. T_camera_plane: (4, 4), known,
    or estimated from corners. sigma_px: standard deviation of the edge's place, a
    number or (N,), None where equal on the plane and unknown; each is carried to the
    plane by the camera's own scale there. pose_covariance: (6, 6) of (w, s), the error
    of the pose as R exp([w]x), t + R s; None: the circle's covariance is that of a
    plane that is known. Returns CircleOnPlane. Raises InputError as `fit_circle`.

    The thesis calls this a double evaluation: the pose came from the same camera. The
    residuals and the radius cannot show rays that are wrong in the same way at corners
    and circle.
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


def checked_plane(T_camera_plane):
    """A plane's pose (4, 4) as floats; InputError for what is no rotation and shift."""
    T = np.asarray(T_camera_plane, float)
    if T.shape != (4, 4) or not (
        np.isfinite(T).all() and are_rotations(T[:3, :3]) and np.abs(T).max() < FARTHEST
    ):
        raise InputError(
            f"plane: the pose {T.shape} is none; give (4, 4), a rotation and a shift, "
            "finite"
        )
    return T


def _check_uncertainty(count, sigma_px, pose_covariance):
    if np.shape(sigma_px) not in ((), (count,)):
        raise InputError(
            f"circle: sigma {np.shape(sigma_px)} of {count} pixels; give one, or one "
            "for each"
        )
    given = pose_covariance is not None
    if given and not (
        np.shape(pose_covariance) == (6, 6) and np.isfinite(pose_covariance).all()
    ):
        raise InputError(
            f"circle: found a pose's covariance {np.shape(pose_covariance)}; give (6, "
            "6), finite"
        )


def _moved_by_pose(points, directions):
    """How points (N, 2) where rays meet a plane move with its pose: (N, 2, 6).

    directions: (N, 3) of the rays in the plane's frame; columns: w, s.
    """
    # In the plane's moved frame the old point is at X - s - w x X, and the ray leads
    # from there back to z = 0.
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
    """How centre and radius move with the pose (3, 6), points weighted as fitted."""
    outward = (points - centre) / _lengths(points - centre)
    A = np.column_stack([outward, np.ones(len(points))]) / spread[:, None]
    apart = np.einsum("ni,nij->nj", outward, by_pose) / spread[:, None]
    return np.linalg.lstsq(A, apart, rcond=None)[0]


def _lengths(vectors):
    return np.linalg.norm(vectors, axis=1, keepdims=True)


def plane_picture(camera, image, T_camera_plane, corner, size, per_px):
    """A camera's picture laid out on a plane: its distortion is gone (Fig. 5.18).

    image: (H, W) or (H, W, C), whole, of the camera; corner: (2,) the upper left of
    what is wanted and size: (width, height), in the plane's frame, mm; per_px: mm per
    pixel of the new picture, whose pixel (u, v) has its centre at corner +
    per_px (u + 1/2, v + 1/2). Returns picture and seen as `remap_to_plane`. Raises
    InputError as that, for an image that is not the camera's, and for a picture without
    a size or beyond MOST_PIXELS.
    """
    checked_picture(np.divide(size, per_px) if per_px > 0 else (np.nan, np.nan))
    location = plane_locations(camera, image, T_camera_plane) - corner
    return remap_to_plane(image, _near(location, size), None, None, size, per_px)


def plane_locations(camera, image, T_camera_plane):
    """The place on a plane that each pixel of a camera's image sees: (H, W, 2).

    NaN where none. Raises InputError for an image that is not of the camera's size, and
    a pose that is none.
    """
    T_camera_plane = checked_plane(T_camera_plane)
    shape = np.shape(image)[:2]
    if shape != (camera.height, camera.width):
        raise InputError(
            f"image: found {shape[1]} x {shape[0]} px; the camera's has "
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


def checked_picture(size_px):
    """Refuse a picture (width, height), px, that nobody can have."""
    with np.errstate(over="ignore"):
        fits = np.shape(size_px) == (2,) and np.prod(size_px) <= MOST_PIXELS
    if not (fits and np.min(size_px) > 0):
        raise InputError(
            f"picture: found a size of {np.asarray(size_px).tolist()} px; give a part "
            f"and a scale, all above 0, that make {MOST_PIXELS} pixels at most"
        )


def _near(location, size):
    """Locations, NaN where they are far outside a picture of this size."""
    margin = np.max(size)
    with np.errstate(invalid="ignore"):
        far = (location < -margin) | (location > np.asarray(size) + margin)
    return np.where(far.any(axis=2, keepdims=True), np.nan, location)


# A nearly perspective view by a camera that has no centre (5.3.4, Fig. 5.19). Its
# rays meet in no point, so what a pinhole would have seen depends on where things
# are. A guess of the scene, a plane or a range for every pixel, says where the view's
# own rays end; there the camera is asked which pixel looks. Where the guess is right
# the view is exact; elsewhere it keeps part of the distortion, the caustic one.
# Source: Swaminathan, Grossberg, Nayar 2003, doi:10.1109/CVPR.2003.1211522 (scene
# geometry that is only assumed).


GRID = 61  # rays each way that a view is chosen by
FEWEST = 3  # of them that meet the plane


def view_of_plane(camera, T_camera_plane, per_px, corner=None, size=None):
    """The pinhole nearest to a camera's rays, looking at a part of a plane.

    camera: any Camera; T_camera_plane: (4, 4), whose x and y axes become right and down
    in the picture; per_px: length on the plane, at the view's middle, of a pixel;
    corner (2,), size (2,): the part in the plane's frame, all that the camera sees of
    it if not given, which is too much of a plane that is seen as far as its horizon.
    The pinhole is the point nearest to the rays that meet this part, behind a mirror;
    it looks at the part's middle, and the picture holds all of it. Returns
    PerspectiveView. Raises InputError where hardly a ray meets the part, and for a
    pose, part or scale that is none.
    """
    T_camera_plane = checked_plane(T_camera_plane)
    if not 0 < per_px < np.inf:
        raise InputError(
            f"near-perspective view: found a scale of {per_px}; give a length above 0"
        )
    if (corner is None) != (size is None) or (
        corner is not None and not np.shape(corner) == np.shape(size) == (2,)
    ):
        raise InputError(
            f"near-perspective view: found corner {corner} and size {size}; give both, "
            "two numbers each, or none"
        )
    steps = np.array([camera.width, camera.height]) - 1
    rays = camera.rays(pixel_grid(GRID, GRID) * steps / (GRID - 1))
    hits = intersect_rays_plane(rays.origins, rays.directions, T_camera_plane)
    met = hits.valid & rays.valid
    if corner is not None:
        low, high = np.asarray(corner), np.asarray(corner) + size
        inside = (hits.points >= low) & (hits.points <= high)
        met = met & inside.all(axis=1)
    if np.count_nonzero(met) < FEWEST:
        raise InputError(
            f"near-perspective view: {np.count_nonzero(met)} of {GRID**2} rays meet the"
            " wanted part of the plane; does the camera see it?"
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
    checked_picture(last - first + 1)
    width, height = (last - first).astype(int) + 1
    return PerspectiveView(K, R, centre, int(width), int(height))


def view_pixels(view, points):
    """Where a PerspectiveView shows points (N, 3) of the camera frame: (N, 2) px.

    NaN for points behind it.
    """
    seen = (np.asarray(points, float) - view.centre) @ view.R_camera_view @ view.K.T
    ahead = np.where(seen[:, 2:] > 0, seen[:, 2:], np.nan)
    return seen[:, :2] / ahead


def view_over_plane(camera, image, view, T_camera_plane):
    """A camera's image as the view shows it, the scene assumed on a plane (Fig. 5.19).

    By the camera's rays alone, as mirrors find rays of pixels faster than pixels of
    points. image: (H, W) or (H, W, C), whole. Returns picture (height, width[, C]) and
    seen, as `raxel.multiview.views.remap_to_plane`. Raises InputError as that, and
    for an image that is not the camera's.
    """
    on = plane_locations(camera, image, T_camera_plane)
    points = transform(T_camera_plane, on_plane(on.reshape(-1, 2)))
    places = view_pixels(view, points).reshape(on.shape)
    size = view.width, view.height
    far = (np.abs(places) > 2 * max(size)).any(axis=2)
    places[far] = np.nan
    # There a pixel's centre is half a pixel from its border.
    return remap_to_plane(image, places + 0.5, None, None, size, 1.0)


def shown_in_view(camera, view, pixels, T_camera_plane):
    """Where what the camera sees at pixels (N, 2) lands in a view over a plane: (N, 2).

    The inverse of `view_over_plane`; NaN where a ray does not meet the plane. Raises
    InputError for a pose that is none.
    """
    T_camera_plane = checked_plane(T_camera_plane)
    rays = camera.rays(pixels)
    hits = intersect_rays_plane(rays.origins, rays.directions, T_camera_plane)
    return view_pixels(view, transform(T_camera_plane, on_plane(hits.points)))


def facing_plane(T_camera_plane, viewpoint, offset):
    """The plane moved by `offset` towards a viewpoint (3,), along its normal (4, 4).

    A relief is best assumed at its mean height above the plate that holds it. Raises
    InputError for a pose that is none.
    """
    T_camera_plane = checked_plane(T_camera_plane)
    side = transform(inverse_pose(T_camera_plane), np.asarray(viewpoint)[None])[0, 2]
    moved = np.array(T_camera_plane, float)
    normal = rotate(moved, np.array([[0.0, 0.0, np.sign(side)]]))[0]
    moved[:3, 3] += offset * normal
    return moved


def _facing(ahead, down):
    """R_camera_view (3, 3): z along `ahead`, y as nearly along `down` as can be."""
    z = ahead / np.linalg.norm(ahead)
    y = down - z * (z @ down)
    y /= np.linalg.norm(y)
    return np.column_stack([np.cross(y, z), y, z])
