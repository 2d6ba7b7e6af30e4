"""Pose of a board by its reprojection error in px, for a camera of any kind.

A camera that does not fit is off by other amounts in px than in angle: far from the
axis of a wide lens a pinhole turns a small angle into many px. The pose that is best in
angle is then not the best in px, and each error is judged at its own best pose.
"""

import numpy as np

from raxel.calibration.pose.three_point import moved_pose
from raxel.geometry.damped import damped_step
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import cross_matrix, transform

STEP_PX = 0.5  # to each side, for the derivatives of the rays
MOST_STEPS = 50
ENOUGH = 1e-6  # a cost that falls by a smaller share is at rest
ROUNDING_PX = 1e-11


def refine_pose_in_pixels(camera, pixels, points, T_camera_grid):
    """Pose that minimises the squared distances in px of posed points from pixels.

    camera: any Camera that projects; pixels: (N, 2), found; points: (N, 2) on a flat
    board, or (N, 3) in its frame; T_camera_grid: (4, 4), the start. Those corners count
    that the camera can project from the start. A step that puts one of them where the
    camera has no pixel is not taken: no pose is better for having lost its worst
    corners, and the error is never larger than at the start. Levenberg-Marquardt; how a
    pixel moves with its point comes from the rays around it.

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
    for _ in range(MOST_STEPS):
        if cost <= len(off) * ROUNDING_PX**2:
            break
        jacobian = pose_jacobian(camera, found - off, solid, T)
        gradient = jacobian.T @ -off.ravel()
        step = damped_step(jacobian.T @ jacobian, gradient, damping)
        if -step @ gradient <= ENOUGH * cost:
            break
        trial = moved_pose(T, step)
        new = found - camera.project(transform(trial, solid)).pixels
        new_cost = np.sum(new**2)
        if new_cost < cost:
            at_rest = cost - new_cost <= ENOUGH * cost
            T, off, cost = trial, new, new_cost
            damping = max(damping / 10, 1e-12)
            if at_rest:
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
    across the ray: the pseudo-inverse of B is what is asked for.
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
