"""The linear stage of CGSP: camera centre and grid poses from rays (thesis 4.1.2).

CGSP is the thesis's central generic calibration by a synthetic pinhole camera: the base
grid takes the picture. World = base grid (grid 0), z = 0. Reflection in the base plane
is an exact second solution, which data cannot exclude: ``side`` is the sign of C_z.
With grid axes x right, y down, z into the board as the camera sees it, C_z < 0.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.synthetic_pinhole import (
    PINHOLE_METHODS,
    conic_system,
    grid_pose,
    scaled,
)
from raxel.errors import CalibrationError, InputError
from raxel.geometry.homography import homography_dlt, normalising
from raxel.geometry.homography_stream import across, fit_homography
from raxel.geometry.robust_homography import robust_start

SUBSET = 20_000  # pairs of rays that outliers are looked for among, as in the thesis
FEWEST = 4  # rays that two grids must share
# A system determined worse than this is refused even when there is no noise to see.
DEGENERATE = 1e-9
# The third singular value must stand out this far above the noise of the coefficients.
NOISE_MARGIN = 5.0
FEWEST_INLIERS = 0.5  # share of the rays common to two grids


class CgspSolution(NamedTuple):
    """centre (3,) and T_base_grid (n, 4, 4), the first the identity, in the base frame.

    degeneracy: third over first singular value of the system for the centre. It tends
    to 0 as grids become parallel; below about 0.03 the centre deserves suspicion.
    margin: the third singular value over the noise of the coefficients; below 5 the
    grids cannot be told from parallel ones.
    homographies: (n, 3, 3) from each grid to the base, the first the identity.
    inliers: (n, N) bool: rays that the homography of a grid was fitted to; for the
    base, those of any.
    """

    centre: np.ndarray
    T_base_grid: np.ndarray
    degeneracy: float
    margin: float
    homographies: np.ndarray
    inliers: np.ndarray


def linear_cgsp(
    points,
    seen=None,
    *,
    side=-1,
    pinhole="sturm-maybank",
    robust=None,
    rng=None,
    weights=None,
    subset=SUBSET,
):
    """Camera centre and grid poses by CGSP's linear stage, (4.2) to (4.14).

    points: (n, N, 2), n >= 3: where N rays meet every grid, mm; grid 0 is the base.
    seen: (n, N) bool; default: where the points are finite. A grid uses every ray that
    it shares with the base, so no ray needs to meet all grids.
    side: sign of C_z. pinhole: a name of PINHOLE_METHODS, see `synthetic_pinhole`.
    robust: None fits all points; "ransac" leaves out pairs that do not agree with the
    homography of their grid, by the noise that the data show; a number does so by this
    standard deviation (mm, on the base grid, per axis). Both draw from rng, a numpy
    Generator, and look among ``subset`` random rays; all others are judged by what
    these agree on. weights: (n, N) factors of the equations of grids 1 to n-1.

    Memory: a few bytes a ray beside the points, whatever N is.
    Returns CgspSolution. Raises CalibrationError, naming the grid: fewer than three
    grids, fewer than four common rays, more than half outliers, grids parallel to the
    base or to each other, no real solution, points behind the centre.
    """
    points = np.asarray(points, float)
    if len(points) < 3:
        raise CalibrationError(
            f"CGSP: {len(points)} grids given; three or more are needed"
        )
    if robust is not None and rng is None:
        raise ValueError("robust: needs rng, a numpy Generator")
    finite = np.isfinite(points[..., 0]) & np.isfinite(points[..., 1])
    seen = finite if seen is None else np.asarray(seen, bool) & finite
    fits = []
    for k in range(1, len(points)):
        factors = None if weights is None else weights[k]
        fits.append(_homography(points, seen, k, robust, rng, factors, subset))
    return _solution(points, fits, side, pinhole)


def _homography(points, seen, k, robust, rng, weights, subset):
    """HomographyFit of grid k to the base."""
    both = seen[0] & seen[k]
    common = np.flatnonzero(both)
    if len(common) < FEWEST:
        raise CalibrationError(
            f"CGSP: grid {k} and the base (grid 0) share {len(common)} rays; at least"
            f" {FEWEST} are needed: the grids must overlap in the image"
        )
    try:
        if robust is None:
            few = common[:: max(1, len(common) // subset)]
            start, limit = homography_dlt(points[k, few], points[0, few]), np.inf
        else:
            few = common
            if len(common) > subset:
                few = np.sort(rng.choice(common, subset, replace=False))
            sigma = None if robust == "ransac" else robust
            start, limit = robust_start(points[k, few], points[0, few], rng, sigma)
        fit = fit_homography(
            points[k], points[0], start, use=both, limit=limit, weights=weights
        )
    except InputError as error:
        raise CalibrationError(f"CGSP: grid {k} and the base: {error}") from None
    if fit.count < FEWEST_INLIERS * len(common):
        raise CalibrationError(
            f"CGSP: grid {k} and the base: {len(common) - fit.count} of"
            f" {len(common)} common rays ({100 * (1 - fit.count / len(common)):.0f} %)"
            " agree with no one homography; more than half are outliers, or the camera"
            " has no single centre"
        )
    return fit


def _solution(points, fits, side, pinhole):
    base = normalising(_some(points[0], np.any([f.inliers for f in fits], axis=0)))
    homographies, noise = [], []
    for k, fit in enumerate(fits, start=1):
        H, sd = _normalised(fit, base, normalising(_some(points[k], fit.inliers)))
        homographies.append(H)
        noise.append(sd)
    homographies = np.stack(homographies)
    degeneracy, margin = _determined(homographies, max(noise))
    x, y, square = PINHOLE_METHODS[pinhole](homographies)
    if not square > 0:
        raise CalibrationError(
            "CGSP: C_z^2 is negative; the points are too noisy for these tilts"
        )
    centre = np.array([x, y, np.sign(side) * np.sqrt(square)]) / base[0, 0]
    centre[:2] -= base[:2, 2] / base[0, 0]
    poses = [np.eye(4)]
    for k, fit in enumerate(fits, start=1):
        in_front = _in_front(fit, points[k])
        try:
            poses.append(grid_pose(fit.H, centre, in_front))
        except CalibrationError as error:
            raise CalibrationError(f"CGSP: grid {k}: {error}") from None
    inliers = np.stack([fit.inliers for fit in fits])
    return CgspSolution(
        centre,
        np.stack(poses),
        degeneracy,
        margin,
        np.stack([np.eye(3)] + [fit.H for fit in fits]),
        np.concatenate([inliers.any(axis=0)[None], inliers]),
    )


def _some(points, use):
    """Points (M, 2) of the rays in use: all, or an even choice of many."""
    picked = np.flatnonzero(use)
    return points[picked[:: max(1, len(picked) // SUBSET)]]


def _normalised(fit, base, grid):
    """H (3, 3) between normalised frames, scaled, and the noise of its entries."""
    back = np.linalg.inv(grid)
    H = base @ fit.H @ back
    change = across(H.ravel()) @ np.kron(base, back.T)
    size = np.sqrt(np.sum(H[:, :2] ** 2) / 2)
    noise = np.sqrt(np.trace(change @ fit.covariance @ change.T)) / size
    return scaled(H), noise


def _in_front(fit, points):
    """Mean sign of (H q)_z over the points (N, 2) of a grid."""
    picked = _some(points, fit.inliers)
    return float(np.mean(np.sign(picked @ fit.H[2, :2] + fit.H[2, 2])))


def _determined(homographies, noise):
    """Degeneracy and margin; CalibrationError where the centre is open."""
    singular = np.linalg.svd(conic_system(homographies), compute_uv=False)
    degeneracy = singular[2] / singular[0]
    # Exact points leave rounding alone.
    margin = singular[2] / max(noise, 1e-15)
    if degeneracy < DEGENERATE or margin < NOISE_MARGIN:
        raise CalibrationError(
            f"CGSP: {_parallel(homographies, noise)} (singular-value ratio"
            f" {degeneracy:.1e}); tilt the grids differently"
        )
    return float(degeneracy), float(margin)


def _parallel(homographies, noise):
    """Which grids cannot be told from parallel ones, in words."""
    tilts = np.hypot(homographies[:, 2, 0], homographies[:, 2, 1])
    floor = NOISE_MARGIN * max(noise, DEGENERATE)
    flat = [str(k) for k, tilt in enumerate(tilts, start=1) if tilt < floor]
    if flat:
        return f"parallel to the base within the noise: grid {', '.join(flat)}"
    return "the grids are parallel to each other within the noise"
