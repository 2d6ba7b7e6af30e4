"""Residual distortion after a calibration, in px (thesis section 2.5) and as an angle.

Pixels are mapped to their rays, the rays meet a synthetic image plane perpendicular to
the principal ray, and a homography from the known metric grid is removed. The remainder
is distortion. The homography also absorbs much of a wrong centre or pose; the angular
residual shows these.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.pose.three_point import moved_pose
from raxel.calibration.views.correspondence import board_points, once_each
from raxel.cameras.core.base import Camera
from raxel.errors import InputError
from raxel.geometry.homography import (
    apply_homography,
    homography_dlt,
    refine_homography,
)
from raxel.geometry.least_squares import damped_step
from raxel.geometry.planes import intersect_rays_plane, on_plane
from raxel.geometry.poses import cross_matrix, nearest_rotation, pose, transform


class SyntheticPlane(NamedTuple):
    """Hold the image plane of a distortion-free view.

    Attributes
    ----------
    T_camera_plane : ndarray, shape (4, 4)
        Pose of the plane z = 0, its origin on the principal ray, x along the u axis of
        the image.
    px_per_unit : float
        Pixels per length on the plane, such that the view is as large as the image at
        the principal pixel.
    principal_pixel : ndarray, shape (2,)
        Pixel that the image and the view share.

    References
    ----------
    Thesis 2.5.1.
    """

    T_camera_plane: np.ndarray
    px_per_unit: float
    principal_pixel: np.ndarray


def synthetic_plane(
    camera: Camera, principal_pixel: ArrayLike | None = None, distance: float = 1.0
) -> SyntheticPlane:
    """Return the plane perpendicular to the ray of a principal pixel.

    The distance does not matter where all rays start at one point. For a non-central
    camera it does. In front of a mirror, even a central one, the origins of all rays
    must lie before the plane.

    Parameters
    ----------
    camera : Camera
        Any camera.
    principal_pixel : array_like, shape (2,), or None
        Pixel (u, v); None for the centre of the image.
    distance : float
        Distance of the plane along the ray, in the unit of the camera.

    Returns
    -------
    SyntheticPlane
        The plane.

    Raises
    ------
    InputError
        If the camera has no rays around the pixel.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.evaluation import synthetic_plane
    >>> K = np.array([[800.0, 0, 320], [0, 800.0, 240], [0, 0, 1]])
    >>> camera = PerspectiveCamera(K, (0, 0), width=640, height=480)
    >>> plane = synthetic_plane(camera, principal_pixel=(320, 240))
    >>> round(plane.px_per_unit, 3)
    800.0
    """
    if principal_pixel is None:
        principal_pixel = (camera.width - 1) / 2, (camera.height - 1) / 2
    pixel = np.asarray(principal_pixel, float)
    steps = np.array([[0, 0], [0.5, 0], [-0.5, 0], [0, 0.5], [0, -0.5]])
    rays = camera.rays(pixel + steps)
    if not rays.valid.all():
        raise InputError(
            f"synthetic plane: no rays around pixel {pixel.tolist()}; give a principal"
            " pixel inside the calibrated area"
        )
    normal = rays.directions[0]
    along_u = rays.directions[1] - rays.directions[2]
    along_u = along_u - (along_u @ normal) * normal
    along_u /= np.linalg.norm(along_u)
    rotation = np.column_stack([along_u, np.cross(normal, along_u), normal])
    T = pose(rotation, rays.origins[0] + distance * normal)
    hits = intersect_rays_plane(rays.origins, rays.directions, T).points
    per_pixel = np.stack([hits[1] - hits[2], hits[3] - hits[4]])
    scale = 1.0 / np.sqrt(abs(np.linalg.det(per_pixel)))
    return SyntheticPlane(T, float(scale), pixel)


def corrected_view(
    directions: ArrayLike, plane: SyntheticPlane, origins: ArrayLike = (0.0, 0.0, 0.0)
) -> tuple[np.ndarray, np.ndarray]:
    """Return where rays appear in the distortion-free view.

    Parameters
    ----------
    directions : array_like, shape (N, 3)
        Directions of the rays, camera frame.
    plane : SyntheticPlane
        Image plane of the view.
    origins : array_like, shape (3,) or (N, 3)
        Origins of the rays, camera frame: that of ``plane.T_camera_plane``.

    Returns
    -------
    pixels : ndarray, shape (N, 2)
        Pixels of the view; NaN where a ray does not meet the plane ahead.
    valid : ndarray of bool, shape (N,)
        Whether a ray meets the plane.
    """
    hits = intersect_rays_plane(origins, directions, plane.T_camera_plane)
    return plane.principal_pixel + plane.px_per_unit * hits.points, hits.valid


def distortion_residual(corrected: np.ndarray, metric: np.ndarray) -> np.ndarray:
    """Return the residual vectors after the homography from the metric grid.

    The homography maps `metric` to `corrected` and minimises the distances there (DLT,
    then refinement).

    Parameters
    ----------
    corrected : ndarray, shape (N, 2)
        Points in the corrected view, px; N >= 5.
    metric : ndarray, shape (N, 2)
        Positions of the points on their plane.

    Returns
    -------
    ndarray, shape (N, 2)
        Corrected less mapped points, px.

    Raises
    ------
    InputError
        As `homography_dlt`.

    References
    ----------
    Thesis 2.5.1 and 2.5.2.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.evaluation import distortion_residual
    >>> from raxel.sets import Chessboard
    >>> metric = Chessboard(4, 3, 20.0).points()
    >>> bool(np.abs(distortion_residual(2 * metric + 5, metric)).max() < 1e-6)
    True
    """
    H = refine_homography(homography_dlt(metric, corrected), metric, corrected)
    return corrected - apply_homography(H, metric)


def angular_residual(
    directions: ArrayLike, reference: ArrayLike, *, aligned: bool = True
) -> NDArray[np.float64]:
    """Return the angles between two sets of unit directions.

    Parameters
    ----------
    directions, reference : array_like, shape (N, 3)
        Unit directions.
    aligned : bool
        Whether the rotation that best maps one set to the other (least squares) is
        applied first. Cameras whose frames were chosen independently require it.

    Returns
    -------
    ndarray, shape (N,)
        Angles, rad.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.evaluation import angular_residual
    >>> axes = np.eye(3)
    >>> angular_residual(axes, axes[[1, 2, 0]], aligned=False).round(4).tolist()
    [1.5708, 1.5708, 1.5708]
    >>> bool(angular_residual(axes, axes[[1, 2, 0]]).max() < 1e-9)
    True
    """
    directions, reference = np.asarray(directions, float), np.asarray(reference, float)
    if aligned:
        directions = directions @ nearest_rotation(reference.T @ directions).T
    across = np.linalg.norm(np.cross(directions, reference), axis=1)  # type: ignore[arg-type]
    return np.arctan2(across, np.sum(directions * reference, axis=1))


# Pose of a board by its reprojection error in px, for any camera. The errors of a
# camera that does not fit differ in px and in angle: far from the axis of a wide lens,
# a small angle is many px of a pinhole. The pose with the smallest angles is then not
# the one with the smallest px errors. Each error is evaluated at its own best pose.


STEP_PX = 0.5  # to each side, for the derivatives of the rays
MAX_N_STEPS = 50
COST_TOL = 1e-6  # relative decrease of the cost at convergence
ROUNDING_PX = 1e-11


def refine_pose_in_pixels(camera, pixels, points, T_camera_grid):
    """Pose that minimises the squared distances in px of posed points from pixels.

    camera: any Camera that projects; pixels: (N, 2), found; points: (N, 2) on a flat
    board, or (N, 3) in its frame; T_camera_grid: (4, 4), the start. Only corners
    count that the camera can project at the start. A step that moves one of them to
    where the camera has no pixel is rejected: losing the worst corners is no
    improvement. The error is never larger than at the start. Levenberg-Marquardt; the
    derivatives of pixels come from the rays around them.

    Returns the pose (4, 4) and residuals (N, 2), found less projected, NaN for corners
    that do not count.
    """
    pixels, solid = np.asarray(pixels, float), np.asarray(points, float)
    if solid.shape[1] == 2:
        solid = on_plane(solid)
    T = np.array(T_camera_grid, float)
    residuals = pixels - camera.project(transform(T, solid)).pixels
    counted = np.isfinite(residuals[:, 0])
    found, solid, off = pixels[counted], solid[counted], residuals[counted]
    cost, damping = np.sum(off**2), 1e-6
    for _ in range(MAX_N_STEPS):
        if cost <= len(off) * ROUNDING_PX**2:
            break
        jacobian = pose_jacobian(camera, found - off, solid, T)
        gradient = jacobian.T @ -off.ravel()
        step = damped_step(jacobian.T @ jacobian, gradient, damping)
        if -step @ gradient <= COST_TOL * cost:
            break
        trial = moved_pose(T, step)
        new = found - camera.project(transform(trial, solid)).pixels
        new_cost = np.sum(new**2)
        if new_cost < cost:
            converged = cost - new_cost <= COST_TOL * cost
            T, off, cost = trial, new, new_cost
            damping = max(damping / 10, 1e-12)
            if converged:
                break
        else:
            damping *= 10
            if damping > 1e8:
                break
    residuals[counted] = off
    return T, residuals


def pose_jacobian(camera, pixels, solid, T):
    """(2N, 6): how projected pixels of points (N, 3) in the board's frame move with the
    step of `moved_pose`.

    Zero for a pixel around which there are too few rays: it then pulls at no step, and
    still counts in what a step leads to.
    """
    along = np.broadcast_to(np.eye(3), (len(solid), 3, 3))
    motion = T[:3, :3] @ np.concatenate([-cross_matrix(solid), along], axis=2)
    by_point = pixels_by_point(camera, pixels, transform(T, solid))
    return (by_point @ motion).reshape(-1, 6)


def pixels_by_point(camera, pixels, points):
    """Derivatives (N, 2, 3) of pixels by points that they see; zero where unknown.

    With X = o(p) + l d(p) a change of X across the ray is B dp, and B = o' + l d'
    across the ray: the pseudo-inverse of B gives the derivatives.
    """
    steps = STEP_PX * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    around = (pixels + steps[:, None]).reshape(-1, 2)
    rays = camera.rays(around)
    o, d = (a.reshape(5, -1, 3) for a in (rays.origins, rays.directions))
    distance = np.linalg.norm(points - o[0], axis=1)
    at = o + distance[:, None] * d
    across = np.stack([_slope(at[[0, 1, 2]]), _slope(at[[0, 3, 4]])], axis=2)
    along = np.einsum("ni,nik->nk", d[0], across)
    across = across - d[0][:, :, None] * along[:, None, :]
    square = np.swapaxes(across, 1, 2) @ across
    known = np.isfinite(square).all(axis=(1, 2))
    size = np.trace(square, axis1=1, axis2=2)
    known &= np.linalg.det(np.where(known[:, None, None], square, 0)) > 1e-16 * size**2
    by_point = np.zeros((len(pixels), 2, 3))
    by_point[known] = np.linalg.solve(square[known], np.swapaxes(across[known], 1, 2))
    return by_point


def _slope(values):
    """Change per px of values (3, N, 3) at the middle and a step to either side.

    From both sides where both are known, else from one.
    """
    middle, after, before = values
    both = (after - before) / (2 * STEP_PX)
    one = np.where(np.isfinite(after), after - middle, middle - before) / STEP_PX
    return np.where(np.isfinite(both), both, one)


# Normal equations of each image for parameters that all images share. Each image's
# pose is free and eliminated. The joint solution leaves the scatter of single
# corners. What one image requires beyond the joint solution is of scatter alone too,
# if each corner errs independently: its squares then have a known sum, and whatever
# moves the corners of one image together makes that sum larger.


MIN_N_BOARDS = 6  # three in each half
OUTLIER_SIGMAS, RAYLEIGH = (
    6.0,
    1.1774,
)  # of wrong corners; median distance at unit scale
MIN_SD_PX = 0.01  # of a coordinate: no corner is known better
SINGULAR_TOL = 1e-9  # of the largest eigenvalue: undetermined


def scored_pairs(scores, views):
    """[(ImageScore, view), ...] of all views with a score, near copies once."""
    pairs = zip(scores, views, strict=True)
    return once_each([pair for pair in pairs if np.isfinite(pair[0].rms_px)])


def near_corners(pairs):
    """(K,) bool of each view: corners within OUTLIER_SIGMAS of their scatter."""
    distances = [np.linalg.norm(score.residuals_px, axis=1) for score, _ in pairs]
    typical = np.nanmedian(np.concatenate(distances)) / RAYLEIGH
    return [own <= OUTLIER_SIGMAS * max(typical, MIN_SD_PX) for own in distances]


def image_equations(camera, pairs, shape, corners, fields, moves=None):
    """(normal (n, K, K), right (n, K), variance, squares (n,)) of images, for shared
    parameters.

    The parameters are factors of CorrectionFields and, after these, of displacements
    (N, 3, M) of the board's points, in its frame: moves. variance: of a coordinate
    about the joint solution; squares: of the residuals, px^2; corners: (N,) bool of
    each view, those that count; shape: BoardShape or None.
    """
    squares, free = [], 0
    for (score, view), own in zip(pairs, corners, strict=True):
        off, solid = score.residuals_px[own], board_points(view.points[own], shape)
        pixels, T = view.pixels[own] - off, score.T_camera_grid
        along = np.broadcast_to(np.eye(3), (len(solid), 3, 3))
        shifts = [-cross_matrix(solid), along] + ([] if moves is None else [moves[own]])
        by_point = pixels_by_point(camera, pixels, transform(T, solid)) @ T[:3, :3]
        by_shift = by_point @ np.concatenate(shifts, axis=2)
        corrected = fields.terms(pixels, camera) @ fields.mixing
        rows = [corrected, by_shift[..., 6:], off[..., None]]
        rows = np.concatenate(rows, axis=2)
        rows = rows.reshape(off.size, rows.shape[2])
        of_pose, _ = np.linalg.qr(by_shift[..., :6].reshape(off.size, 6))
        rows = rows - of_pose @ (of_pose.T @ rows)
        squares.append(rows.T @ rows)
        free += max(off.size - 6, 0)
    squares = np.array(squares)
    whole = squares.sum(axis=0)
    root, _ = inverse_root(whole[:-1, :-1])
    left = whole[-1, -1] - np.sum((root.T @ whole[:-1, -1]) ** 2)
    variance = max(left / max(free - root.shape[1], 1), MIN_SD_PX**2)
    return squares[:, :-1, :-1], squares[:, :-1, -1], variance, squares[:, -1, -1]


def inverse_root(normal):
    """W of W W', the pseudo-inverse of a normal matrix, and its axes."""
    size, axes = np.linalg.eigh(normal)
    known = size > SINGULAR_TOL * size[-1]
    return axes[:, known] / np.sqrt(size[known]), axes[:, known]


def within_groups(normal, right, groups):
    """(variance, freedom): of scatter that explains how far images lie from the joint
    solution of their group, and the number of independent squares.

    normal (n, K, K), right (n, K): their equations; groups: (n,) bool each. As squares
    are larger in some directions than in others, each image has fewer than directions
    (F. E. Satterthwaite 1946, doi:10.2307/3002019).
    """
    expected, products = 0.0, 0.0
    for group in groups:
        root, axes = inverse_root(normal[group].sum(axis=0))
        share = root.T @ normal[group] @ root
        joint = root @ (root.T @ right[group].sum(axis=0))
        excess = (right[group] - normal[group] @ joint) @ root @ axes.T
        expected += np.einsum("nii->", share) - np.sum(share**2)
        products = products + excess.T @ excess
    squares = np.trace(products)
    several = squares**2 / np.sum(products**2)
    return squares / expected, (len(right) - len(groups)) * several
