"""Motion between two views from matched rays: epipolar geometry without an image plane.

A point that two central cameras see along unit directions d_1, d_2 satisfies
d_2^T E d_1 = 0 with E = [t]x R (thesis 4.25). Directions carry no lens: fields of view
beyond 180 degrees need nothing else, as long as "ahead" means ahead along the ray.

T_2_1 maps points of view 1 to view 2, X_2 = R X_1 + t. Rays tell t up to its length:
|t| = 1 here.
Sources: Hartley 1997, doi:10.1109/34.601246 (normalisation); Nister 2004,
doi:10.1109/TPAMI.2004.17 (decomposition).
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import CalibrationError
from raxel.geometry.poses import pose

FEWEST = 8
# Singular values of exact pairs below this share of the largest are zero.
OPEN = 1e-9


class RelativePose(NamedTuple):
    """T_2_1 (4, 4) with a translation of length 1; essential: (3, 3), |E| = sqrt 2.

    rms: root mean square angle (radians) by which a pair's rays would have to turn to
    meet; ahead: share of the pairs that meet ahead along both rays; margin: eighth over
    ninth singular value of the linear system. Near 1 the motion is open: the points lie
    on a plane, or nothing but a rotation happened.
    """

    T_2_1: np.ndarray
    essential: np.ndarray
    rms: float
    ahead: float
    margin: float


def essential_matrix(directions_1, directions_2):
    """E (3, 3) from matched unit directions (N, 3), N >= 8, by linear least squares.

    Both sets of directions are brought to unit second moments before the system of nine
    columns is solved, so that a target in a small part of the field counts like one all
    around. The solution is projected to two equal singular values and a zero. Returns
    E with |E| = sqrt 2, sign open, and the margin of `RelativePose`. Raises
    CalibrationError for fewer than eight pairs, values that are not finite, and pairs
    that leave E open.
    """
    d_1, d_2 = _checked(directions_1, directions_2)
    to_1, to_2 = _whitening(d_1), _whitening(d_2)
    rows = _rows(d_1 @ to_1.T, d_2 @ to_2.T)
    values, Vt = np.linalg.svd(np.linalg.qr(rows, mode="r"))[1:]
    if not values[7] > OPEN * values[0]:
        raise CalibrationError(
            "epipolar geometry: the rays leave the motion open; their points lie on a"
            " plane or are repeated, or the camera only turned",
            code="degenerate-points",
        )
    E = to_2.T @ Vt[8].reshape(3, 3) @ to_1
    return _projected(E), float(values[7] / max(values[8], 1e-300))


def relative_pose(directions_1, directions_2):
    """Motion from matched rays, linearly (4.25).

    Arguments and errors as `essential_matrix`. Of the four motions that belong to E,
    the one is taken for which most points lie ahead along both their rays. Returns
    RelativePose.
    """
    d_1, d_2 = _checked(directions_1, directions_2)
    E, margin = essential_matrix(d_1, d_2)
    T, ahead = motion_of_essential(E, d_1, d_2)
    rms = float(np.sqrt(np.mean(epipolar_angles(T, d_1, d_2) ** 2)))
    return RelativePose(T, E, rms, ahead, margin)


def motion_of_essential(E, directions_1, directions_2):
    """(T_2_1, share): of the four motions of E the one with most points ahead.

    E: (3, 3); directions: (N, 3). share: of points ahead along both rays.
    """
    U, _, Vt = np.linalg.svd(E)
    U, Vt = U * np.sign(np.linalg.det(U)), Vt * np.sign(np.linalg.det(Vt))
    W = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    candidates = [
        pose(U @ turn @ Vt, sign * U[:, 2]) for turn in (W, W.T) for sign in (1.0, -1.0)
    ]
    shares = [
        np.mean(np.all(depths(T, directions_1, directions_2) > 0, axis=1))
        for T in candidates
    ]
    best = int(np.argmax(shares))
    return candidates[best], float(shares[best])


def depths(T_2_1, directions_1, directions_2):
    """Where matched rays pass nearest to each other: (N, 2), along ray 1 and ray 2.

    In units of the length of the translation; negative behind the camera, infinite or
    NaN for parallel rays.
    """
    q = np.asarray(directions_1) @ T_2_1[:3, :3].T
    d, t = np.asarray(directions_2), T_2_1[:3, 3]
    cosine = np.einsum("ni,ni->n", q, d)
    with np.errstate(divide="ignore", invalid="ignore"):
        first = (cosine * (d @ t) - q @ t) / (1 - cosine**2)
        second = (d @ t - cosine * (q @ t)) / (1 - cosine**2)
    return np.stack([first, second], axis=1)


def epipolar_angles(T_2_1, directions_1, directions_2):
    """Angles (N,) in radians, with sign, by which matched rays miss each other.

    To first order the root of the sum of squared angles by which both rays of a pair
    have to turn to meet (Sampson's error, on the sphere).
    """
    T_2_1, d = np.asarray(T_2_1, float), np.asarray(directions_2)
    t, q = T_2_1[:3, 3], np.asarray(directions_1) @ T_2_1[:3, :3].T
    gap = np.cross(q, d) @ t
    room = np.maximum(2 - (q @ t) ** 2 - (d @ t) ** 2 - 2 * gap**2, 1e-12)
    return gap / np.sqrt(room)


def _rows(d_1, d_2):
    """The equations (4.25): (..., N, 9), for the entries of E row by row."""
    return (d_2[..., :, None] * d_1[..., None, :]).reshape(*d_1.shape[:-1], 9)


def _whitening(d):
    """A (3, 3) that gives A d, over directions (N, 3), a unit second moment."""
    values, vectors = np.linalg.eigh(d.T @ d / len(d))
    # Rays in one plane have no third direction to scale.
    values = np.maximum(values, 1e-12 * values[2])
    return (vectors / np.sqrt(values)) @ vectors.T


def _projected(E):
    """Nearest (..., 3, 3) with singular values 1, 1, 0."""
    U, _, Vt = np.linalg.svd(E)
    return U[..., :2] @ Vt[..., :2, :]


def _checked(directions_1, directions_2):
    d_1, d_2 = np.asarray(directions_1, float), np.asarray(directions_2, float)
    if d_1.ndim != 2 or d_1.shape[1] != 3 or d_1.shape != d_2.shape:
        raise CalibrationError(
            f"epipolar geometry: found directions {d_1.shape} and {d_2.shape}; give two"
            " equal arrays (N, 3)",
            code="shape",
        )
    if len(d_1) < FEWEST:
        raise CalibrationError(
            f"epipolar geometry: {len(d_1)} pairs of rays; {FEWEST} or more are needed",
            code="too-few-rays",
        )
    bad = np.count_nonzero(~np.isfinite(d_1 + d_2).all(axis=1))
    if bad:
        raise CalibrationError(
            f"epipolar geometry: {bad} of {len(d_1)} pairs are not finite; remove them",
            code="not-finite",
        )
    return d_1, d_2
