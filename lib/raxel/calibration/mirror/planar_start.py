"""Primary calibration in one step, where the mirror begins flat (5.2.1).

One picture will do of a grid in the mirror whose pose is known, because the camera sees
it directly as well, or in a platter. The grid and its image are symmetric about the
mirror's plane.

Frame: the viewer's; mm.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.sightings import normalised, seen_pose, sighting
from raxel.calibration.pose.three_point import placed_points
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.damped import descend, gauss_newton
from raxel.geometry.poses import tangent_bases
from raxel.geometry.spline_grid import spline_grid

STEPS, AT_REST, ROUNDING_PX = 50, 1e-12, 1e-9
# px, rms: corners in a mirror that is flat lie as near to where it puts them.
BENT_PX = 3.0
LOOKS = 40  # places along each side at which the spline is fitted to the plane


class PlanarStart(NamedTuple):
    """camera: SplineMirrorCamera of the flat mirror; plane (4,): (n, d), n.x + d = 0
    with n towards the camera; covariance (3, 3): of two turns of n about its tangents,
    radians, and of d, mm; rms_px: distance of the corners from where the plane puts
    them, which is large for a mirror that is not flat."""

    camera: SplineMirrorCamera
    plane: np.ndarray
    covariance: np.ndarray
    rms_px: float


def calibrate_flat(
    viewer,
    view,
    T_camera_grid,
    *,
    shape=(7, 3),
    degree=(2, 2),
    angle=0.0,
    quantity="inverse depth",
    span=None,
):
    """PlanarStart from one view of a grid of known pose in a flat mirror.

    viewer: the calibrated central camera; view: a BoardView or DenseView of the grid in
    the mirror; T_camera_grid: (4, 4), its true pose, in the view's coordinates; shape,
    degree, angle, quantity, span: as for `calibrate_primary`. The distance spline only
    comes near to a plane. Raises CalibrationError where the corners are not those of a
    flat mirror.
    """
    seen = sighting(viewer, view, "flat mirror")
    if not np.isfinite(seen.sd).all():
        seen = seen.alike()
    real = placed_points(seen.points, np.asarray(T_camera_grid, float))
    plane = _between(real, placed_points(seen.points, seen_pose(seen)))
    plane, costs, _ = descend(
        lambda plane: _system(seen, real, plane),
        _moved,
        plane,
        iterations=STEPS,
        tolerance=AT_REST,
        rounding=len(real) * ROUNDING_PX**2,
    )
    J = _jacobian(seen, real, plane)
    covariance = np.linalg.inv(J.T @ J)
    if seen.unknown_sd:
        covariance *= costs[-1] / max(2 * len(real) - 3, 1)
    off = seen.residuals(_image(real, plane)).reshape(-1, 2) * seen.sd[:, None]
    rms_px = float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
    if not rms_px <= BENT_PX:
        raise CalibrationError(
            f"flat mirror: corners lie {rms_px:.1f} px (rms) from where a plane puts "
            "them; the mirror is bent, or the grid's pose is another",
            code="not-flat",
        )
    spanned = normalised(viewer, np.asarray(view.pixels, float))
    if span is not None:
        spanned = np.concatenate([spanned, span])
    grid = spline_grid(spanned, shape, degree, angle)
    camera = SplineMirrorCamera.fitted(viewer, grid, _points(grid, plane), quantity)
    return PlanarStart(camera, plane, covariance, rms_px)


def _between(real, image):
    """The plane (n, d) about which points (N, 3) are the images of others."""
    apart = image - real
    n = -np.linalg.svd(apart, full_matrices=False)[2][0]
    n *= -np.sign(np.sum(apart @ n))
    d = -np.mean((real + image) @ n) / 2
    if not d > 0:
        raise InputError(
            "flat mirror: the plane between the grid and its image passes behind the "
            "camera; check T_camera_grid"
        )
    return np.append(n, d)


def _image(points, plane):
    return points - 2 * (points @ plane[:3] + plane[3])[:, None] * plane[:3]


def _moved(plane, step):
    n = plane[:3] + tangent_bases(plane[None, :3])[0] @ step[:2]
    return np.append(n / np.linalg.norm(n), plane[3] + step[2])


def _system(seen, real, plane):
    off = seen.residuals(_image(real, plane))
    if not np.isfinite(off).all():
        return np.inf, None
    return gauss_newton(off, lambda: _jacobian(seen, real, plane))


def _jacobian(seen, real, plane):
    n, tangents = plane[:3], tangent_bases(plane[None, :3])[0]
    height = real @ n + plane[3]
    motion = np.empty((len(real), 3, 3))
    # X' = X - 2 (n.X + d) n, with n turned by its tangents, and d.
    lifted = real @ tangents
    motion[:, :, :2] = -2 * lifted[:, None] * n[:, None]
    motion[:, :, :2] -= 2 * height[:, None, None] * tangents
    motion[:, :, 2] = -2 * n
    return seen.change(_image(real, plane), motion)


def _points(grid, plane):
    """Points (N, 3) of the plane all over the grid's box."""
    u, v = (np.linspace(b[0], b[-1], LOOKS) for b in grid.breaks)
    p = grid.unturned(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    along = np.column_stack([p, np.ones(len(p))])
    return -plane[3] / (along @ plane[:3])[:, None] * along
