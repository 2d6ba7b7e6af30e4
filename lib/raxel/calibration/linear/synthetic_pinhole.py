"""A pinhole camera whose image plane is the base grid: its centre and grid poses.

The rays of any central camera meet the base grid in a picture without distortion, and
the homographies from the other grids to this picture are all that a plane-based pinhole
calibration needs (thesis 4.1.1). Two such methods stand here behind one interface, in
``PINHOLE_METHODS``: name -> function(homographies) -> (x, y, square of C_z).

- ``sturm-maybank``: two linear equations for the image of the absolute conic per
  homography, (4.6) to (4.10). P. Sturm and S. Maybank, CVPR 1999,
  doi:10.1109/CVPR.1999.786974.
- ``circle``: each homography leaves the centre one circle; the point nearest to all of
  them, those of well tilted grids above all. The two vanishing points of perpendicular
  directions see the centre under a right angle, whatever the directions.

The thesis also tried Wang and Liu (2006), does not describe it, and it could not be
recovered; the circle is the natural other way to use the vanishing line, not theirs.

Homographies map (x, y, 1) on a grid to the base plane, both in any unit.
"""

import numpy as np

from raxel.errors import CalibrationError
from raxel.geometry.poses import nearest_rotation, pose

# A system determined worse than this is refused even when there is no noise to see.
DEGENERATE = 1e-9
# The third singular value must stand out this far above the noise of the coefficients.
NOISE_MARGIN = 5.0
# Share of a grid's points that may lie behind the centre before it is refused.
BEHIND = 0.25


def scaled(H):
    """Homographies (..., 3, 3) with |h_1|^2 + |h_2|^2 = 2, so that all weigh alike."""
    size = np.sqrt(np.sum(H[..., :2] ** 2, axis=(-2, -1)) / 2)
    return H / size[..., None, None]


def conic_rows(H):
    """Rows (..., 2, 4) of (4.8) and (4.9) for (w_11, w_13, w_23, w_33) of (4.6).

    H: (..., 3, 3). Twice (4.9): then a turn of the grid in its own plane only turns the
    pair of rows.
    """

    def row(g, h):
        return np.stack(
            [
                g[0] * h[0] + g[1] * h[1],
                g[0] * h[2] + g[2] * h[0],
                g[1] * h[2] + g[2] * h[1],
                g[2] * h[2],
            ],
            axis=-1,
        )

    first, second = (np.moveaxis(H[..., k], -1, 0) for k in (0, 1))
    rows = row(first, first) - row(second, second), 2 * row(first, second)
    return np.stack(rows, axis=-2)


def conic_system(homographies):
    """Matrix (..., 2 (n - 1), 4) of (4.8), (4.9) of homographies (..., n - 1, 3, 3),
    scaled."""
    rows = conic_rows(scaled(homographies))
    return rows.reshape(*rows.shape[:-3], -1, 4)


def sturm_maybank(homographies):
    """x, y and the square of z of the centre, by (4.6) to (4.10).

    homographies: (..., n - 1, 3, 3), at least two, coordinates of about unit size.
    """
    null = np.linalg.svd(conic_system(homographies))[2][..., 3, :]
    w_11, w_13, w_23, w_33 = np.moveaxis(null, -1, 0)
    x, y = -w_13 / w_11, -w_23 / w_11
    return x, y, w_33 / w_11 - x**2 - y**2


def circle_of(H):
    """The circle on which one homography puts the centre: v_0 (2,), axis (2,), radius.

    v_0 lies in the base plane; the circle about it is perpendicular to the base plane
    and to the axis, the direction of the grid's vanishing line.
    """
    d = H[2, :2]
    length = np.hypot(*d)
    along = (H[:2, 1] * d[0] - H[:2, 0] * d[1]) / length
    v_0 = H[:2, :2] @ d / length**2
    radius = np.hypot(*along) / length
    return v_0, along / np.hypot(*along), radius


def circle(homographies):
    """As `sturm_maybank`: the nearest point to the circles of `circle_of`.

    homographies as there, `scaled`. Being on a circle is linear in x, y and S = |C|^2:
    in the circle's plane, and S - 2 v_0 . (x, y) = radius^2 - v_0^2. Either equation is
    scaled to a distance, and counts by the squared length of (h_31, h_32), the tilt:
    the less a grid is tilted, the less is known of its circle, and there is none of a
    grid parallel to the base.
    """
    rows, values = [], []
    for H in homographies:
        weight = H[2, 0] ** 2 + H[2, 1] ** 2
        if weight == 0:
            continue
        v_0, axis, radius = circle_of(H)
        rows.append(weight * np.array([*axis, 0.0]))
        values.append(weight * (axis @ v_0))
        share = weight / (2 * radius)
        rows.append(share * np.array([*(-2 * v_0), 1.0]))
        values.append(share * (radius**2 - v_0 @ v_0))
    x, y, square = np.linalg.lstsq(np.array(rows), np.array(values), rcond=None)[0]
    return x, y, square - x**2 - y**2


PINHOLE_METHODS = {"sturm-maybank": sturm_maybank, "circle": circle}


def centre_of(homographies, noise, side=-1, pinhole="sturm-maybank"):
    """The centre (3,) in the base frame, its degeneracy and its margin.

    homographies: (n - 1, 3, 3), two or more, `scaled`, coordinates of about unit size;
    noise: standard deviation of their entries, as a length; side: sign of C_z; pinhole:
    a name of PINHOLE_METHODS. degeneracy: third over first singular value of (4.8) and
    (4.9) for all grids; margin: the third over the noise.

    Raises CalibrationError for grids that are parallel, to the base or to each other,
    as far as the noise lets one tell, and where C_z is not real; ValueError for a side
    or a method that is none.
    """
    if pinhole not in PINHOLE_METHODS:
        raise ValueError(f"pinhole: {pinhole!r}; expected one of {[*PINHOLE_METHODS]}")
    if side not in (-1, 1):
        raise ValueError(f"side: {side!r}; expected -1 or 1, the sign of C_z")
    degeneracy, margin = _determination(homographies, noise)
    if degeneracy < DEGENERATE or margin < NOISE_MARGIN:
        raise CalibrationError(
            f"linear stage: {_parallel(homographies, noise)} (singular-value ratio"
            f" {degeneracy:.1e}); tilt the grids differently"
        )
    x, y, square = PINHOLE_METHODS[pinhole](homographies)
    if not square > 0:
        raise CalibrationError(
            "linear stage: C_z^2 is negative; the points are too noisy for these tilts,"
            " or the rays do not meet in one point",
            code="negative-square",
        )
    centre = np.array([x, y, side * np.sqrt(square)])
    return centre, float(degeneracy), float(margin)


def margins_of(homographies, noise):
    """The margins (...) that `centre_of` gives, NaN where it refuses.

    homographies: (..., n - 1, 3, 3), as there; noise: (...). Sturm and Maybank's method
    says whether C_z is real.
    """
    degeneracy, margin = _determination(homographies, noise)
    square = sturm_maybank(homographies)[2]
    refused = (degeneracy < DEGENERATE) | (margin < NOISE_MARGIN) | ~(square > 0)
    return np.where(refused, np.nan, margin)


def _determination(homographies, noise):
    """Degeneracy and margin, as `centre_of` says."""
    singular = np.linalg.svd(conic_system(homographies), compute_uv=False)
    # Exact points leave rounding alone.
    margin = singular[..., 2] / np.maximum(noise, 1e-15)
    return singular[..., 2] / singular[..., 0], margin


def _parallel(homographies, noise):
    """Which grids cannot be told from parallel ones, in words."""
    tilts = np.hypot(homographies[:, 2, 0], homographies[:, 2, 1])
    floor = NOISE_MARGIN * max(noise, DEGENERATE)
    flat = [str(k) for k, tilt in enumerate(tilts, start=1) if tilt < floor]
    if flat:
        return f"parallel to the base as far as the noise tells: grid {', '.join(flat)}"
    return "the grids are parallel to each other as far as the noise tells"


def grid_pose(H, centre, in_front):
    """T_base_grid (4, 4) of a grid by (4.11) to (4.14), with the errata's signs.

    H: (3, 3); centre: (3,) in the base frame; in_front: mean sign of (H q)_z over the
    grid's points q. These lie on the side of the centre where the base plane is.
    Raises CalibrationError for points on both sides.
    """
    if abs(in_front) < 1 - 2 * BEHIND:
        raise CalibrationError(
            "linear stage: points of a grid lie on both sides of the camera centre",
            code="behind-centre",
        )
    x, y, z = centre
    M = np.array([[-z, 0.0, x], [0.0, -z, y], [0.0, 0.0, 1.0]])
    G = np.linalg.solve(M, H)
    sign = -np.sign(z) * np.sign(in_front)
    s = sign / np.mean(np.linalg.norm(G[:, :2], axis=0))
    return pose(nearest_rotation(s * G[:, :2]), s * G[:, 2] + centre)
