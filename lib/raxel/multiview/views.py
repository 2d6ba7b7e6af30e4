"""Views without distortion: perspective, panoramic, and of a plane.

Rays of a non-central camera do not meet in one point. A view of such a camera has its
centre at the point nearest to the rays, and is exact at one distance from there.

`remap_to_plane` resamples an image on a plane with a known point for each pixel. An
active grid (phase-shift structured light) gives each pixel its point of the plane. This
removes the distortion of any image of the same camera without a model (thesis 3.3.4).
The plane's view shows no depth; for a central camera, the result is the image of a
pinhole camera whose image plane is the grid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import Camera, closest_point, pixel_grid
from raxel.cameras.lenses.perspective import PerspectiveCamera
from raxel.errors import InputError
from raxel.geometry.pixel_cells import usual_step, whole_cells

# Image of a pinhole camera: undistortion through a camera's rays.


STEP_PX = 4.0
PERSPECTIVE_GRID_SIZE = 101
SHIFT_GRID_SIZE = 41
MAX_VIEW_ANGLE_RAD = np.radians(60)
MIN_SLOPE = 1e-9
BLOCK = 1 << 16
OUTSIDE_PIXEL = -10.0
# Range of points that represent directions, mm: beyond any mirror of the camera.
FAR_RANGE_MM = 1e6


class PerspectiveView(NamedTuple):
    """Virtual pinhole at the centre of a camera.

    Attributes
    ----------
    K : ndarray of shape (3, 3)
        Calibration matrix, px.
    R_camera_view : ndarray of shape (3, 3)
        Rotation of directions of the view into the camera frame.
    centre : ndarray of shape (3,)
        Centre in the camera frame, mm.
    width, height : int
        Size, px.
    """

    K: np.ndarray
    R_camera_view: np.ndarray
    centre: np.ndarray
    width: int
    height: int

    def directions(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return unit directions (N, 3), in the camera frame, of pixels (N, 2)."""
        homogeneous = np.column_stack((pixels, np.ones(len(pixels))))
        straight = homogeneous @ np.linalg.inv(self.K).T
        straight /= np.linalg.norm(straight, axis=1, keepdims=True)
        return straight @ self.R_camera_view.T


def perspective_view(
    camera: Camera, fov: float | None = None, size: Sequence[int] | None = None
) -> PerspectiveView:
    """Return the pinhole that shows what a camera sees.

    A PerspectiveCamera keeps its K and loses its distortion. For any other camera the
    view points along the ray nearest to the middle of the image, with the u axis to the
    right. Its scale is that of the image there, or smaller, so that all rays within 60
    degrees of that one are in the view. With `fov` or `size` that direction is in the
    middle of the view.

    Parameters
    ----------
    camera : Camera
        Any camera.
    fov : float, optional
        Horizontal field of view, rad, between the outer edges of the pixels. None: as
        described.
    size : sequence of int, optional
        Width and height of the view, px. None: those of the camera.

    Returns
    -------
    PerspectiveView
        The virtual pinhole.

    Raises
    ------
    InputError
        For a camera with too few rays.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.multiview import perspective_view
    >>> K = np.array([[500, 0, 320], [0, 500, 240], [0, 0, 1.0]])
    >>> view = perspective_view(PerspectiveCamera(K, [-0.1], 640, 480))
    >>> view.directions([[320, 240]]).tolist()
    [[0.0, 0.0, 1.0]]
    """
    view = _whole_view(camera)
    if fov is None and size is None:
        return view
    width, height = size or (camera.width, camera.height)
    focal = view.K[0, 0] * width / camera.width
    if fov is not None:
        focal = width / (2 * np.tan(fov / 2))
    K = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    return view._replace(K=K, width=width, height=height)


def _whole_view(camera):
    """PerspectiveView in the size of the camera's image."""
    size = camera.width, camera.height
    if isinstance(camera, PerspectiveCamera):
        return PerspectiveView(camera.K, np.eye(3), np.zeros(3), *size)
    middle, R_camera_view, own_scale = _middle_frame(camera)
    rays = camera.rays(_grid(camera))
    focal = min(own_scale, _focal_that_holds(camera, rays, R_camera_view, middle))
    K = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])
    return PerspectiveView(K, R_camera_view, closest_point(rays), *size)


def _middle_frame(camera):
    """(middle pixel, R_camera_view with its ray as z and x to the right, px per rad)"""
    middle, rays = _middle_rays(camera)
    ahead = rays.directions[0]
    right = (rays.directions[1] - rays.directions[2]) / (2 * STEP_PX)
    down = (rays.directions[3] - rays.directions[4]) / (2 * STEP_PX)
    rad_per_px = np.sqrt(np.linalg.norm(right) * np.linalg.norm(down))
    if not rad_per_px > MIN_SLOPE:
        raise InputError(
            f"camera of kind {camera.kind}: neighbouring rays are parallel, so there "
            "is no view from one point; give a camera with diverging rays",
            code="parallel-rays",
        )
    x = right - ahead * (ahead @ right)
    x /= np.linalg.norm(x)
    return middle, np.column_stack((x, np.cross(ahead, x), ahead)), 1 / rad_per_px


def _focal_that_holds(camera, rays, R_camera_view, middle):
    """Largest focal length (px) with all rays within MAX_VIEW_ANGLE_RAD in the
    image."""
    size = np.array([camera.width, camera.height])
    seen = rays.directions[rays.valid] @ R_camera_view
    seen = seen[seen[:, 2] > np.cos(MAX_VIEW_ANGLE_RAD)]
    slopes = seen[:, :2] / seen[:, 2:]
    room = np.where(slopes > 0, size - 1 - middle, middle)
    return float((room / np.maximum(np.abs(slopes), MIN_SLOPE)).min())


def source_pixels(
    camera: Camera,
    view: PerspectiveView | CylindricalView | EquirectangularView,
    range_mm: float = FAR_RANGE_MM,
) -> NDArray[np.float32]:
    """Return the camera pixel that each pixel of a view shows.

    Parameters
    ----------
    camera : Camera
        Any camera.
    view : PerspectiveView, CylindricalView or EquirectangularView
        Any object with `directions`, `centre`, `width` and `height`.
    range_mm : float
        Distance from the centre at which the view of a non-central camera is exact, mm.

    Returns
    -------
    ndarray of shape (height, width, 2)
        Pixels, px, float32; far outside the image if the camera does not see a
        direction.
    """
    sources = np.full((view.height * view.width, 2), OUTSIDE_PIXEL, dtype=np.float32)
    rows = max(1, BLOCK // view.width)
    for top in range(0, view.height, rows):
        count = min(rows, view.height - top)
        pixels = pixel_grid(view.width, count) + [0, top]
        seen, valid = camera.project(range_mm * view.directions(pixels) + view.centre)
        block = sources[top * view.width : (top + count) * view.width]
        block[valid] = seen[valid]
    return sources.reshape(view.height, view.width, 2)


def range_shift(
    camera: Camera,
    view: PerspectiveView | CylindricalView | EquirectangularView,
    range_mm: float,
    distance_mm: float,
) -> float:
    """Return how far points at another distance are from where a view shows them.

    Parameters
    ----------
    camera : Camera
        Any camera.
    view : PerspectiveView, CylindricalView or EquirectangularView
        A view that is exact at a range.
    range_mm, distance_mm : float
        That range, and the other distance from the centre, mm.

    Returns
    -------
    float
        Largest shift over the view, px of the camera's image; 0 for a central camera,
        NaN where the camera sees neither.
    """
    steps = pixel_grid(SHIFT_GRID_SIZE, SHIFT_GRID_SIZE) / (SHIFT_GRID_SIZE - 1)
    ahead = view.directions(steps * [view.width - 1, view.height - 1])
    exact, other = (
        camera.project(length * ahead + view.centre)
        for length in (range_mm, distance_mm)
    )
    both = exact.valid & other.valid & camera.in_image(exact.pixels)
    shifts = np.linalg.norm((other.pixels - exact.pixels)[both], axis=1)
    return float(shifts.max(initial=0.0 if both.any() else np.nan))


def share_seen(sources: np.ndarray, camera: Camera) -> float:
    """Return the share of a view's pixels that the camera sees.

    Parameters
    ----------
    sources : ndarray of shape (height, width, 2)
        Pixels as from `source_pixels`, px.
    camera : Camera
        The camera of these pixels.

    Returns
    -------
    float
        Share of the pixels inside the image, 0 to 1.
    """
    last = np.array([camera.width, camera.height]) - 0.5
    return float(((sources >= -0.5) & (sources <= last)).all(axis=-1).mean())


def resample(image: np.ndarray, sources: np.ndarray) -> np.ndarray:
    """Return an image interpolated at source pixels.

    Parameters
    ----------
    image : ndarray of shape (H, W) or (H, W, 3)
        Image of the camera.
    sources : ndarray of shape (h, w, 2)
        Pixels as from `source_pixels`, px.

    Returns
    -------
    ndarray of shape (h, w) or (h, w, 3)
        The new image, black outside the old one.
    """
    import cv2

    u, v = np.ascontiguousarray(sources[..., 0]), np.ascontiguousarray(sources[..., 1])
    return cv2.remap(image, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)


def _middle_rays(camera):
    """Pixel closest to the image centre with rays around it, and those five rays.

    The rays are those of the pixel itself, then at STEP_PX right, left, below, above.
    """
    pixels = _grid(camera)
    middle = (np.array([camera.width, camera.height]) - 1) / 2
    order = np.argsort(np.linalg.norm(pixels - middle, axis=1), kind="stable")
    around = STEP_PX * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    crosses = pixels[order][:, None] + around
    valid = camera.rays(crosses.reshape(-1, 2)).valid.reshape(-1, 5).all(axis=1)
    if not valid.any():
        raise InputError(
            f"camera of kind {camera.kind}: no pixel has rays on all sides; calibrate "
            "with boards that cover more of the image"
        )
    cross = crosses[np.argmax(valid)]
    return cross[0], camera.rays(cross)


def _grid(camera):
    """Pixels (PERSPECTIVE_GRID_SIZE^2, 2), evenly spaced over the image."""
    size = np.array([camera.width, camera.height])
    return (
        pixel_grid(PERSPECTIVE_GRID_SIZE, PERSPECTIVE_GRID_SIZE)
        * (size - 1)
        / (PERSPECTIVE_GRID_SIZE - 1)
    )


# Panorama around a camera: an unrolled cylindrical image. Directions are given by
# azimuth, to the right of straight ahead, and elevation, upwards from the horizon. A
# cylinder of radius f px shows a direction at u = u_0 + f azimuth, v = v_0 - f
# tan(elevation): vertical lines of the world become columns, the horizon a row.


# Largest elevation of rays that determine the height of the image.
MAX_ELEVATION_RAD = np.radians(75)
CYLINDER_GRID_SIZE = 401
# Of the middle ray to the vertical: below it, its azimuth is poorly determined.
MIN_AHEAD_ANGLE_RAD = np.radians(30)


class CylindricalView(NamedTuple):
    """Upright cylinder about the centre of a camera, unrolled once around.

    Attributes
    ----------
    radius : float
        Radius, px.
    horizon : float
        Row of elevation 0, px.
    R_camera_view : ndarray of shape (3, 3)
        Rotation of directions of the view into the camera frame. In the view x is
        right, y down, and z points to the middle column.
    centre : ndarray of shape (3,)
        Centre in the camera frame, mm.
    width, height : int
        Size, px.
    """

    radius: float
    horizon: float
    R_camera_view: np.ndarray
    centre: np.ndarray
    width: int
    height: int

    @property
    def middle(self) -> float:
        """Column of azimuth 0, px."""
        return (self.width - 1) / 2

    def elevations(self, rows: ArrayLike) -> NDArray[np.float64]:
        """Return the elevations (N,), rad, of rows (N,), px."""
        return np.arctan((self.horizon - np.asarray(rows, float)) / self.radius)

    def directions(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return unit directions (N, 3), in the camera frame, of pixels (N, 2)."""
        azimuth = (pixels[:, 0] - self.middle) / self.radius
        drop = (pixels[:, 1] - self.horizon) / self.radius
        out = np.column_stack([np.sin(azimuth), drop, np.cos(azimuth)])
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        return out @ self.R_camera_view.T

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the pixels (N, 2) of points (N, 3) of the camera frame.

        NaN for points on the axis of the cylinder. Behind the camera the view begins
        anew: azimuth runs from -pi to pi.
        """
        x, y, z = ((points - self.centre) @ self.R_camera_view).T
        across = np.hypot(x, z)
        with np.errstate(divide="ignore", invalid="ignore"):
            v = self.horizon + self.radius * y / across
        u = self.middle + self.radius * np.arctan2(x, z)
        return np.where(across[:, None] > 0, np.column_stack([u, v]), np.nan)


class EquirectangularView(NamedTuple):
    """Upright sphere about the centre of a camera: columns are azimuths, rows
    elevations.

    Attributes
    ----------
    radius : float
        Scale, px per rad, along rows and columns.
    horizon, R_camera_view, centre, width, height
        As of a CylindricalView.
    """

    radius: float
    horizon: float
    R_camera_view: np.ndarray
    centre: np.ndarray
    width: int
    height: int

    def directions(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return unit directions (N, 3), in the camera frame, of pixels (N, 2)."""
        azimuth = (pixels[:, 0] - (self.width - 1) / 2) / self.radius
        drop = (pixels[:, 1] - self.horizon) / self.radius
        x, z = np.cos(drop) * np.sin(azimuth), np.cos(drop) * np.cos(azimuth)
        return np.column_stack([x, np.sin(drop), z]) @ self.R_camera_view.T


def cylindrical_view(
    camera: Camera, down: ArrayLike, ahead: ArrayLike, width: int
) -> CylindricalView:
    """Return the cylinder that holds the rays of a camera, once around.

    The height follows from the highest and the lowest ray within 75 degrees of the
    horizon, at the scale of the width. Rows end on the last whole pixel.

    Parameters
    ----------
    camera : Camera
        Any camera.
    down : array_like of shape (3,)
        Axis of the cylinder in the camera frame, of any length.
    ahead : array_like of shape (3,)
        Direction of the middle column in the camera frame, of any length; it is
        levelled.
    width : int
        Width once around, px.

    Returns
    -------
    CylindricalView
        The unrolled cylinder.

    Raises
    ------
    InputError
        With code ``outside-image`` without rays near the horizon,
        ``parallel-directions`` for parallel directions.
    """
    R_camera_view = _level_frame(down, ahead)
    scale = width / (2 * np.pi)
    return _panorama(CylindricalView, camera, R_camera_view, scale, 2 * np.pi)


def panoramic_view(
    kind: type[CylindricalView] | type[EquirectangularView],
    camera: Camera,
    down: ArrayLike | None = None,
    fov: float | None = None,
    size: Sequence[int] | None = None,
) -> CylindricalView | EquirectangularView:
    """Return the panorama that holds the rays of a camera.

    Its middle column is that of the ray nearest to the middle of the image, or of the
    upper edge of the image where this ray is within 30 degrees of the vertical.

    Parameters
    ----------
    kind : type
        CylindricalView or EquirectangularView.
    camera : Camera
        Any camera.
    down : array_like of shape (3,), optional
        Direction of the vertical in the camera frame, of any length. None: that of the
        columns in the middle of the image.
    fov : float, optional
        Horizontal field of view, rad, between the outer edges of the pixels. None: that
        of the camera, up to 2 pi.
    size : sequence of int, optional
        Width and height, px, with the horizon in the middle. None: the scale in the
        middle of the camera's image, and all rows with rays.

    Returns
    -------
    CylindricalView or EquirectangularView
        The panorama.

    Raises
    ------
    InputError
        As `cylindrical_view`, and for a camera with too few rays.
    """
    _, R_middle, scale = _middle_frame(camera)
    _, below, ahead = R_middle.T
    down = below if down is None else np.asarray(down, float)
    upright = abs(ahead @ down) > np.cos(MIN_AHEAD_ANGLE_RAD) * np.linalg.norm(down)
    R_camera_view = _level_frame(down, -below if upright else ahead)
    return _panorama(kind, camera, R_camera_view, scale, fov, size)


def _panorama(kind, camera, R_camera_view, scale, fov=None, size=None):
    """Panorama of a kind and a scale (px per rad); fov (rad) and size as of
    `panoramic_view`."""
    last, steps = [camera.width - 1, camera.height - 1], CYLINDER_GRID_SIZE
    rays = camera.rays(pixel_grid(steps, steps) * last / (steps - 1))
    seen = rays.directions[rays.valid] @ R_camera_view
    x, y, z = seen.T
    across = np.hypot(x, z)
    near = np.abs(y) <= np.tan(MAX_ELEVATION_RAD) * across
    if not near.any():
        raise InputError(
            f"camera of kind {camera.kind}: no ray is within "
            f"{np.degrees(MAX_ELEVATION_RAD):.0f} degrees of the horizon; check 'down'",
            code="outside-image",
        )
    azimuth = np.abs(np.arctan2(x, z))
    fov = fov or min(2 * float(azimuth[near].max()), 2 * np.pi)
    width, height = size or (max(round(scale * fov), 1), None)
    radius, horizon = width / fov, ((height or 1) - 1) / 2
    if height is None:
        drop = radius * np.arctan2(y, across)
        if kind is CylindricalView:
            drop = radius * y[near] / across[near]
        horizon = float(np.floor(-drop.min()))
        height = int(np.floor(drop.max() + horizon)) + 1
    return kind(radius, horizon, R_camera_view, closest_point(rays), width, height)


def _level_frame(down, ahead):
    """R_camera_view (3, 3): y down, z ahead and horizontal, x to the right."""
    y = np.asarray(down, float)
    x = np.cross(y, np.asarray(ahead, float))
    sizes = np.linalg.norm(y), np.linalg.norm(x)
    if not min(sizes) > 0:
        raise InputError(
            f"view: found down {list(map(float, down))} and ahead "
            f"{list(map(float, ahead))}; give two directions that are not parallel",
            code="parallel-directions",
        )
    y, x = y / sizes[0], x / sizes[1]
    return np.column_stack([x, y, np.cross(x, y)])


MAX_N_SUBSAMPLES = 8  # along each axis of a pixel of the new image
MAX_PIXEL_RATIO = 4  # pixels of the new image over those of the given one
TRIANGLE_EDGE_TOL = 1e-9  # barycentric: points this little outside count as inside
MIN_VARIANCE = 1e-12  # of an exact point


def plane_scale(location, mask=None):
    """(size, length per px) of an image of all that `remap_to_plane` can show.

    In the unit of the locations: the size from the grid's corner to the last visible
    position. A pixel of the new image is as long as the median step between
    neighbouring pixels of the given one, or longer to limit the new image to
    MAX_PIXEL_RATIO times its pixels. Raises InputError where no neighbours see a point.
    """
    location, _ = _checked(location[..., 0], location, None, mask)
    step = usual_step(location)
    if not step > 0:
        raise InputError(
            "location: no two neighbouring pixels see different positions (x, y); "
            "decode patterns of both axes"
        )
    size = np.nanmax(location.reshape(-1, 2), axis=0)
    if not (size > 0).all():
        raise InputError("location: all points are left of or above the grid; check it")
    most = MAX_PIXEL_RATIO * location[..., 0].size
    return tuple(size), max(step, float(np.sqrt(np.prod(size) / most)))


def remap_to_plane(
    image: np.ndarray,
    location: ArrayLike,
    sigma: ArrayLike | None,
    mask: ArrayLike | None,
    size_mm: Sequence[float] | NDArray[np.float64],
    mm_per_px: float,
) -> tuple[np.ndarray, NDArray[np.bool_]]:
    """Return what a camera sees as an image of the plane of an active grid.

    Between four pixels that see one piece of surface (`whole_cells`) values are linear
    in two triangles. Nothing is filled in outside. Positions seen by several parts of
    the image, as through facets, are averaged with weights 1/sigma^2. Where the camera
    resolves more than the new image, up to 8 x 8 samples of a pixel are averaged.
    Memory: a copy of the image and the new image as float, a byte a sample.

    Parameters
    ----------
    image : ndarray of shape (H, W) or (H, W, C)
        Image of the camera.
    location : array_like of shape (H, W, 2)
        Position that each pixel sees, mm from the upper left corner of the grid, x
        right and y down.
    sigma : array_like of shape (H, W, 2), optional
        Standard deviations of the positions, mm.
    mask : array_like of shape (H, W), optional
        Where a position counts, bool. None: all that are finite.
    size_mm : array_like of shape (2,)
        Width and height of the new image from the grid's corner, mm.
    mm_per_px : float
        Length of a pixel of the new image, mm. Pixel (u, v) has its centre at
        mm_per_px (u + 1/2, v + 1/2).

    Returns
    -------
    result : ndarray of shape (h, w) or (h, w, C)
        New image of the image's type, 0 where nothing is visible.
    seen : ndarray of shape (h, w)
        Whether at least half of the samples of a pixel are visible, bool.

    Raises
    ------
    InputError
        For shapes that do not match, and if no four pixels see one surface.

    References
    ----------
    Thesis 3.3.4.
    """
    image = np.asarray(image)
    location, sigma = _checked(image, location, sigma, mask)
    width, height = (math.floor(s / mm_per_px + 1e-9) for s in size_mm)
    if width < 1 or height < 1:
        raise InputError(
            f"size_mm: {tuple(size_mm)} at {mm_per_px} mm per px is less than one "
            "pixel; give a larger size"
        )
    whole = whole_cells(location, sigma)
    if not whole.any():
        raise InputError(
            "location: no four neighbouring pixels see one surface; check it"
        )
    fine = math.ceil(mm_per_px / max(usual_step(location), 1e-9))
    fine = min(max(fine, 1), MAX_N_SUBSAMPLES)
    places = location * (fine / mm_per_px) - 0.5  # of samples
    values = np.atleast_3d(image).astype(np.float32)
    sums = np.zeros((height, width, values.shape[2] + 1))
    hit = np.zeros((height * fine, width * fine), np.bool_)
    _add_cells(places, values, _weights(location, sigma), whole, fine, sums, hit)
    counts = np.count_nonzero(hit.reshape(height, fine, width, fine), axis=(1, 3))
    seen = 2 * counts >= fine * fine
    with np.errstate(invalid="ignore"):
        result = np.where(seen[..., None], sums[..., :-1] / sums[..., -1:], 0)
    if image.dtype.kind in "ui":
        result = np.rint(result)
    return result.reshape(height, width, *image.shape[2:]).astype(image.dtype), seen


def _checked(image, location, sigma, mask):
    """location and sigma as float arrays, NaN where they do not count."""
    location = np.array(location, float)
    location[~np.isfinite(location)] = np.nan
    shape = (*image.shape[:2], 2)
    found = {"location": location.shape}
    if sigma is not None:
        found["sigma"] = np.shape(sigma)
    if mask is not None:
        found["mask"] = (*np.shape(mask), 2)
        if np.shape(mask) == location.shape[:2]:
            location[~np.asarray(mask, bool)] = np.nan
    for name, given in found.items():
        if given != shape:
            raise InputError(
                f"{name}: found {given[0]} x {given[1]} pixels; give {shape[0]} x "
                f"{shape[1]}, as the image"
            )
    return location, None if sigma is None else np.asarray(sigma, float)


def _weights(location, sigma):
    if sigma is None:
        return np.ones(location.shape[:2])
    return 1 / np.maximum(np.sum(np.square(sigma), axis=2), MIN_VARIANCE)


@numba.njit(cache=True)
def _add_cells(places, values, weights, whole, fine, sums, hit):
    """Add both triangles of each whole cell; places: (H, W, 2), in samples."""
    rows, columns = whole.shape
    for v in range(rows):
        for u in range(columns):
            if whole[v, u]:
                corners = (v, u), (v, u + 1), (v + 1, u)
                _add_triangle(places, values, weights, corners, fine, sums, hit)
                corners = (v + 1, u + 1), (v + 1, u), (v, u + 1)
                _add_triangle(places, values, weights, corners, fine, sums, hit)


@numba.njit(cache=True)
def _add_triangle(places, values, weights, corners, fine, sums, hit):
    """Add weighted values, linear in the triangle, at the samples that it covers."""
    a, b, c = corners
    ax, ay = places[a]
    bx, by = places[b][0] - ax, places[b][1] - ay
    cx, cy = places[c][0] - ax, places[c][1] - ay
    twice = bx * cy - by * cx
    if twice == 0:
        return
    height, width = hit.shape
    first = max(math.ceil(ax + min(bx, cx, 0.0) - TRIANGLE_EDGE_TOL), 0)
    last = min(math.floor(ax + max(bx, cx, 0.0) + TRIANGLE_EDGE_TOL), width - 1)
    top = max(math.ceil(ay + min(by, cy, 0.0) - TRIANGLE_EDGE_TOL), 0)
    bottom = min(math.floor(ay + max(by, cy, 0.0) + TRIANGLE_EDGE_TOL), height - 1)
    channels = values.shape[2]
    for y in range(top, bottom + 1):
        for x in range(first, last + 1):
            of_b = ((x - ax) * cy - (y - ay) * cx) / twice
            of_c = ((y - ay) * bx - (x - ax) * by) / twice
            of_a = 1 - of_b - of_c
            if (
                of_a < -TRIANGLE_EDGE_TOL
                or of_b < -TRIANGLE_EDGE_TOL
                or of_c < -TRIANGLE_EDGE_TOL
            ):
                continue
            hit[y, x] = True
            weight = of_a * weights[a] + of_b * weights[b] + of_c * weights[c]
            at = sums[y // fine, x // fine]
            at[channels] += weight
            for k in range(channels):
                value = of_a * values[a][k] + of_b * values[b][k] + of_c * values[c][k]
                at[k] += weight * value
