"""The generalised essential matrix of seventeen or more matched rays, linearly (5.30).

Each pair gives one equation, linear in the nine entries of E = [u]x R and the nine of R
(`geometry.line_motion`). Taken as one system of eighteen it has more than one solution
wherever pairs share points of a rig: with each ray through the same point in both
views, R = I, E = 0 solves it, and so does R = v v^T where all rays meet a line along v.
E stays single: it is found under |E| = 1 with the entries of R left free, that is, by
least squares in what the columns of R do not reach. R follows from E, and u from R,
with its length and sign.

Moments are about the point next to all rays; where all rays meet a line, about a point
of that line, since only there its R is v v^T. They are in units of the rays' distance
from that point, and directions are brought to unit second moments. Where the rays come
near to one point, the columns of R are noise and take information from E. The
eight-point system of a central camera is therefore solved beside it, and the better
motion is taken.

Sources: Pless 2003, doi:10.1109/CVPR.2003.1211520; Li, Hartley, Kim 2008,
doi:10.1109/CVPR.2008.4587545 (what the system leaves open); Hartley 1997,
doi:10.1109/34.601246 (normalisation).
"""

import numpy as np

from raxel.errors import CalibrationError
from raxel.multiview.epipolar import essential_matrix, motion_of_essential
from raxel.multiview.generalised_motion import described, need_length, to_length
from raxel.multiview.motion_samples import squared_gaps, turning_pairs
from raxel.multiview.ray_gaps import along_sphere, gaps, matched_rays

FEWEST_CENTRAL, FEWEST_LINEAR = 8, 17
# Singular values of exact pairs below this share of the largest are zero.
OPEN = 1e-9
# Least over second least singular value: below, all rays meet a line.
AXIAL = 1e-3
FLAT = 1e-12  # share of the largest second moment that rays in one plane are given


def generalised_pose(rays_1, rays_2, *, length=None):
    """Motion from matched rays of a general camera, linearly.

    rays: NoisyRays (N,), or as for `angular_rays`, N >= 17, or 8 where the rays come
    near to one point; length: mm, of the shift of the rays' centre where it is known.
    Returns GeneralisedPose of the candidate with least `gaps` among those that put most
    points ahead. Raises CalibrationError for rays as `matched_rays`, for rays through
    one point without a length, and where the pairs leave the motion open.
    """
    pairs = matched_rays(rays_1, rays_2, fewest=FEWEST_CENTRAL)
    need_length(pairs, length)
    found, turning = linear_motions(pairs, length), turning_pairs(pairs)
    R, u, margin = min(found, key=lambda motion: _rank(motion, pairs, turning))
    everything = np.ones(len(pairs.rays_1.origins), bool)
    steps = np.eye(6) if length is None else along_sphere(u)
    return described(pairs, everything, R, u, margin, steps)


def linear_motions(pairs, length=None):
    """[(R, u, margin), ...]: candidates of both linear systems, about the centre."""
    d_1, d_2 = pairs.rays_1.directions, pairs.rays_2.directions
    found, refusal = [], None
    for system in (_seventeen, _eight):
        try:
            E, margin = system(pairs)
        except CalibrationError as fault:
            refusal = fault
            continue
        T = motion_of_essential(E, d_1, d_2)[0]
        # The twin of a rotation under E is turned by half a turn about u.
        twin = 2 * np.outer(T[:3, 3], T[:3, 3]) - np.eye(3)
        for R in (T[:3, :3], twin @ T[:3, :3]):
            found += [(R, u, margin) for u in shifts_of(R, T[:3, 3], pairs, length)]
    if not found:
        raise CalibrationError(
            "motion: the pairs leave it open to a linear solution; their points lie on"
            " a plane or are repeated, or the camera did not move",
            code="degenerate-points",
        ) from refusal
    return found


def generalised_equations(pairs):
    """The equations' (N, 9) for E and (N, 9) for R, both row by row; mm, with moments
    about the centre."""
    (p_1, d_1, _), (p_2, d_2, _) = pairs.rays_1, pairs.rays_2
    m_1, m_2 = np.cross(p_1, d_1), np.cross(p_2, d_2)
    return _products(d_2, d_1), _products(d_2, m_1) + _products(m_2, d_1)


def shifts_of(R, axis, pairs, length=None):
    """Shifts [u, ...] that go with a rotation: least squares where the length is open,
    which noise makes too short, and both ways along the axis (3,) of E."""
    (p_1, d_1, _), (p_2, d_2, _) = pairs.rays_1, pairs.rays_2
    n = np.cross(d_1 @ R.T, d_2)
    gap = np.einsum("ni,ni->n", n, p_1 @ R.T - p_2)
    u = -np.linalg.lstsq(n, gap, rcond=None)[0]
    if length is not None:
        return [to_length(u, length), length * axis, -length * axis]
    far = max(np.linalg.norm(u), pairs.spread)
    return [u, far * axis, -far * axis]


def _seventeen(pairs):
    """(E, margin) of the generalised system, its entries of R left free."""
    count = len(pairs.rays_1.origins)
    if count < FEWEST_LINEAR or not pairs.spread:
        raise CalibrationError(
            f"motion: {count} pairs of rays; {FEWEST_LINEAR} or more that do not pass"
            " through one point are needed",
            code="too-few-rays",
        )
    W_1, W_2 = (_whitening(rays.directions) for rays in (pairs.rays_1, pairs.rays_2))
    origin = _on_axis(pairs)
    pairs = pairs._replace(
        rays_1=pairs.rays_1.moved(origin), rays_2=pairs.rays_2.moved(origin)
    )
    A_E, A_R = generalised_equations(pairs)
    A_E = (A_E.reshape(-1, 3, 3) @ W_1.T).swapaxes(1, 2) @ W_2.T
    A_E = A_E.swapaxes(1, 2).reshape(-1, 9)
    U, s, _ = np.linalg.svd(A_R / pairs.spread, full_matrices=False)
    Q = U[:, s > OPEN * s[0]]
    rest = np.linalg.qr(A_E - Q @ (Q.T @ A_E), mode="r")
    values, Vt = np.linalg.svd(rest)[1:]
    # Of few pairs, repeated, nothing but rounding is left.
    if not values[7] > OPEN * np.linalg.norm(A_E):
        raise CalibrationError(
            "motion: the generalised system has no single solution",
            code="degenerate-points",
        )
    E = W_2.T @ Vt[8].reshape(3, 3) @ W_1
    return E, values[7] / max(values[8], 1e-300)


def _eight(pairs):
    """(E, margin) of the central system."""
    d_1, d_2 = pairs.rays_1.directions, pairs.rays_2.directions
    if len(d_1) == FEWEST_CENTRAL:
        # The first equation twice changes nothing, and there are nine.
        d_1, d_2 = np.vstack([d_1, d_1[:1]]), np.vstack([d_2, d_2[:1]])
    return essential_matrix(d_1, d_2)


def _on_axis(pairs):
    """(3,): point next to the centre on the line that all rays meet, if there is one,
    else the centre."""
    o, d = (
        np.concatenate([getattr(rays, name) for rays in (pairs.rays_1, pairs.rays_2)])
        for name in ("origins", "directions")
    )
    # L . M of two lines that meet, usual order, with M = (moment, direction).
    rows = np.concatenate([d, np.cross(o, d) / pairs.spread], axis=1)
    values, Vt = np.linalg.svd(np.linalg.qr(rows, mode="r"))[1:]
    moment, along = pairs.spread * Vt[5, :3], Vt[5, 3:]
    if not values[5] < AXIAL * values[4] or along @ along < AXIAL:
        return np.zeros(3)
    return np.cross(along, moment) / (along @ along)


def _rank(motion, pairs, turning):
    """Least for the motion to take: half of the points ahead of the rays' pivots, and
    then small gaps."""
    R, u, _ = motion
    ahead = np.isfinite(squared_gaps(R[None], u[None], turning, 0.0))
    residuals = gaps(R, u, pairs)
    return np.mean(ahead) <= 0.5, residuals @ residuals


def _products(a, b):
    return (a[:, :, None] * b[:, None, :]).reshape(-1, 9)


def _whitening(d):
    """W (3, 3) that gives W d, over directions (N, 3), a unit second moment."""
    moment = d.T @ d / len(d)
    return np.linalg.inv(
        np.linalg.cholesky(moment + FLAT * np.trace(moment) * np.eye(3))
    )
