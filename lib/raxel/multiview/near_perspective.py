"""A nearly perspective view by a camera that has no centre (5.3.4, Fig. 5.19).

Its rays meet in no point, so what a pinhole would have seen depends on where things
are. A guess of the scene, a plane or a range for every pixel, says where the view's own
rays end; there the camera is asked which pixel looks. Where the guess is right the view
is exact; elsewhere it keeps part of the distortion, the caustic one.
Source: Swaminathan, Grossberg, Nayar 2003, doi:10.1109/CVPR.2003.1211522 (scene
geometry that is only assumed).
"""

import numpy as np

from raxel.cameras.core.base import closest_point, pixel_grid
from raxel.errors import InputError
from raxel.geometry.planes import intersect_rays_plane, on_plane
from raxel.geometry.poses import inverse_pose, rotate, transform
from raxel.multiview.perspective_view import PerspectiveView
from raxel.multiview.plane_points import checked_picture, checked_plane, plane_locations
from raxel.multiview.plane_view import remap_to_plane

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
    seen, as `raxel.multiview.plane_view.remap_to_plane`. Raises InputError as that, and
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
