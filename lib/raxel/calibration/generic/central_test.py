"""Test of centrality: distance of the rays from one point, compared with noise.

The rays of a central camera meet in one point. Free lines always fit the points better,
since they have two more unknowns each. Two questions follow.

*Is the gain more than noise?* An F test compares the decrease of the sum of squares per
additional unknown with the residual sum of squares per degree of freedom. It estimates
the noise from the lines, so it needs no given one. Window averaging correlates the
errors of neighbouring pixels, so a sum of their squares scatters as if there were
fewer; the degrees of freedom are divided by that factor.

*How large is the distance?* The mean squared distance of the lines from the best point,
minus the contribution of the noise of points and poses.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc, fdtrc, ndtri

from raxel.calibration.adjust.consistent import adjust_consistent
from raxel.calibration.adjust.free_lines import relax_centrality
from raxel.calibration.views.dense import sample_boards
from raxel.calibration.views.interpolation import interpolated_view
from raxel.errors import CalibrationError
from raxel.geometry.planes import intersect_rays_plane
from raxel.geometry.poses import inverse_pose

# Test of whether a camera calibrated as central is central, on the views of its fit,
# with the same targets and initial poses, and a free line for each pixel of a sample.
# Nearby pixels have correlated errors: the decoder of an active grid averages over a
# window, and points between the corners of a board are interpolated from them; one cell
# apart, errors have a correlation of a quarter. So sampled pixels are a window or a
# cell apart.


MAX_N_OBSERVATIONS = 30_000  # approximate maximum number of pixel-view pairs
DECODER_WINDOW_PX = 7  # side of the averaging window of the decoder


def centrality_of_views(views, width, height, T_camera_grid):
    """CentralTest of a camera by the views that it was fitted to, or None.

    views: BoardViews or DenseViews; width, height: image size, px; T_camera_grid
    (n, 4, 4): their poses, in the frame of the camera's centre, initial values of the
    adjustments. Active grids use their predicted standard deviations. None where too
    few pixels see three views, or too many are outliers.
    """
    if all(view.every_pixel for view in views):
        alike_px = DECODER_WINDOW_PX
    else:
        cells = [v.area() / ((v.columns - 1) * (v.rows - 1)) for v in views]
        alike_px = np.sqrt(np.median(cells))
        views = [interpolated_view(view, "by need")[0] for view in views]
    area = sum(view.area() for view in views)
    separation = min(MAX_N_OBSERVATIONS, area / alike_px**2)
    samples = sample_boards(views, width, height, separation)
    sigma = None
    if all(view.every_pixel and view.sd is not None for view in views):
        u, v = samples.pixels.T
        sigma = np.stack([view.sigma[v, u] for view in views])
    T_base_camera = inverse_pose(T_camera_grid[0])
    start = T_base_camera[:3, 3], T_base_camera @ T_camera_grid
    try:
        return centrality_test(samples.points, samples.seen, *start, sigma=sigma)
    except CalibrationError:
        return None


MAX_N_RAYS = 10_000  # spread evenly over those that see three grids
CENTRAL_P_THRESHOLD = 1e-3
GROSS_SIGMAS = 8.0  # distance of a gross error from its line, in standard deviations
# Of the rays: with more gross errors, lines follow some of them.
MIN_CLEAN_FRACTION = 0.8
MAX_N_ROUNDS = 4  # of the rejection of rays with gross errors
CHI2_MEDIAN = 2 * np.log(2)  # two degrees of freedom
DOWNWEIGHT_RATIO = 4.0  # times the median variance: beyond, a line has less weight
NORMAL_QUANTILE_95 = ndtri(0.95)


class CentralTest(NamedTuple):
    """Hold the result of `centrality_test`.

    Attributes
    ----------
    p_value : float
        Probability under noise alone of so much better a fit of free lines than of rays
        through one point.
    distance_mm : float
        RMS distance of the lines from that point, mm, without the contribution of
        noise; 0 where noise explains it.
    at_least_mm, at_most_mm : float
        Its one-sided 95 % bounds, mm.
    p_of_noise : float
        Probability of so large residuals of the central camera under the given noise;
        NaN without one.
    noise_ratio : float
        Noise of the lines over the given one; NaN without one.
    rays : int
        Number of tested rays.
    centre : ndarray, shape (3,)
        Centre of the central camera, mm.
    """

    p_value: float
    distance_mm: float
    at_least_mm: float
    at_most_mm: float
    p_of_noise: float
    noise_ratio: float
    rays: int
    centre: np.ndarray

    @property
    def central(self):
        """Return whether the test does not reject one centre.

        Errors that are alike, as those of a decoder, also make free lines fit better.
        So a distance that may be 0 counts as central whatever the p-value.
        """
        return self.p_value >= CENTRAL_P_THRESHOLD or self.at_least_mm == 0

    def __str__(self):
        bounds = f"{self.at_least_mm:.3g} to {self.at_most_mm:.3g} mm"
        if self.central:
            return (
                f"central within noise: {self.rays} rays pass at most"
                f" {self.at_most_mm:.3g} mm from one point (RMS; p {self.p_value:.2g})"
            )
        return (
            f"not central: {self.rays} rays pass {self.distance_mm:.3g} mm ({bounds})"
            f" from one point (RMS; p {self.p_value:.1g})"
        )


def centrality_test(
    points: ArrayLike,
    seen: np.ndarray | None,
    centre: np.ndarray,
    T_base_grid: np.ndarray,
    *,
    sigma: np.ndarray | None = None,
    window: int = 1,
) -> CentralTest:
    """Test whether the rays of a camera meet in one point.

    Rays with a point GROSS_SIGMAS standard deviations or more from their line are
    excluded. Of more than MAX_N_RAYS rays every k-th is tested, which reduces the
    correlation of neighbours.

    Parameters
    ----------
    points
        (n, N, 2), points of N rays on n >= 3 grids, mm.
    seen
        (n, N) bool. None: where the points are finite.
    centre, T_base_grid
        (3,) and (n, 4, 4), a central calibration as the start, base frame.
    sigma
        Predicted standard deviations of the points, as `adjust_consistent`.
    window
        Side of the square over which the decoder has averaged, px, where the rays are
        those of neighbouring pixels. 1 for rays far from each other.

    Returns
    -------
    CentralTest
        p-value, distance of the lines from one point and its bounds.

    Raises
    ------
    CalibrationError
        As `adjust_consistent` and `relax_centrality`. Also for fewer than ten rays that
        see three grids, and a fifth or more with gross errors ("too-few-rays").
    """
    points = np.asarray(points, float)
    seen = np.isfinite(points).all(axis=2) if seen is None else np.asarray(seen, bool)
    rays = np.flatnonzero(np.count_nonzero(seen, axis=0) >= 3)
    if len(rays) < 10:
        raise CalibrationError(
            f"central or not: {len(rays)} rays see three grids; ten or more are "
            "required",
            code="too-few-rays",
        )
    step = -(-len(rays) // MAX_N_RAYS)
    rays = rays[::step]
    alike = correlation(window, step)
    if sigma is not None and np.ndim(sigma):
        sigma = np.asarray(sigma)[:, rays]
    chosen, rounds, least = points[:, rays], 0, MIN_CLEAN_FRACTION * len(rays)
    while True:
        central = adjust_consistent(
            chosen, seen[:, rays], centre, T_base_grid, sigma=sigma, tolerance=1e-4
        )
        lines = relax_centrality(chosen, central, tolerance=1e-4)
        keep = lines.used
        if rounds < MAX_N_ROUNDS:
            keep = keep & _without_gross_errors(chosen, central, lines)
        if keep.all():
            break
        # Both must be fitted to the same points.
        sigma = sigma[:, keep] if sigma is not None and np.ndim(sigma) else sigma
        chosen, rays, rounds = chosen[:, keep], rays[keep], rounds + 1
        if len(rays) < least:
            raise CalibrationError(
                f"central or not: {len(rays)} rays are free of gross errors, too few "
                "for the test; check the points",
                code="too-few-rays",
            )
    return _judged(central, lines, alike, sigma is not None)


def _without_gross_errors(points, central, lines):
    """(N,) bool: rays whose points are all near their line, within the noise."""
    w = np.moveaxis(central.whitening.astype(float), 2, 0)
    errors = np.stack(
        [
            intersect_rays_plane(lines.origins, lines.directions, T).points - own
            for T, own in zip(lines.T_base_grid, points, strict=True)
        ]
    )
    x, y = np.moveaxis(errors, 2, 0)
    squares = (w[0] * x + w[1] * y) ** 2 + (w[2] * y) ** 2
    counted = (w[0] > 0) & lines.used
    usual = np.median(squares[counted]) / CHI2_MEDIAN
    return ~(counted & (squares > GROSS_SIGMAS**2 * usual)).any(axis=0)


def correlation(window, step=1):
    """Ratio of the scatter of squared errors, averaged over a square, to independent
    ones.

    The errors of pixels k and m apart along the axes have the correlation
    (1 - k / window)(1 - m / window); the variance of a sum of squares grows by the sum
    of these squared. With every `step`-th pixel only, it is that much less, but at
    least 1.
    """
    separation = np.arange(-window + 1, window)
    along = np.sum((1 - np.abs(separation) / window) ** 2)
    return max(1.0, along**2 / step)


def _judged(central, lines, alike, stated):
    more = central.degrees_of_freedom - lines.degrees_of_freedom
    saved = (central.cost - lines.cost) / more
    ratio = saved / (lines.cost / lines.degrees_of_freedom)
    p = fdtrc(more / alike, lines.degrees_of_freedom / alike, ratio)
    square, deviation = _squared_distance(central, lines, alike)
    low, high = (
        square - NORMAL_QUANTILE_95 * deviation,
        square + NORMAL_QUANTILE_95 * deviation,
    )
    p_of_noise = noise_ratio = np.nan
    if stated:
        p_of_noise = chdtrc(central.degrees_of_freedom / alike, central.cost / alike)
        noise_ratio = lines.noise
    square, low, high = (float(np.sqrt(max(s, 0.0))) for s in (square, low, high))
    return CentralTest(
        float(p),
        square,
        low,
        high,
        float(p_of_noise),
        float(noise_ratio),
        int(lines.used.sum()),
        central.centre,
    )


def _squared_distance(central, lines, alike):
    """Mean squared distance from one point without the noise's share, and its SD.

    All lines have equal weight, except those with poorly determined offsets.
    """
    used = lines.used
    b, own = lines.offsets[used], lines.offset_covariance[used]
    follows, axes = lines.offset_of_poses[used], lines.axes[used]
    variance = np.trace(own, axis1=1, axis2=2) / 2
    weight = np.minimum(1.0, DOWNWEIGHT_RATIO * np.median(variance) / variance) ** 2
    weight /= weight.sum()
    # The best point takes three unknowns from the offsets.
    normal = np.einsum("n,nka,nla->kl", weight, axes, axes)
    pull = np.einsum("n,nka,na->k", weight, axes, b)
    inverse = np.linalg.inv(normal)
    b = b - np.swapaxes(axes, 1, 2) @ (inverse @ pull)
    turned = np.einsum("n,nka,nap->kp", weight, axes, follows)
    follows = follows - np.swapaxes(axes, 1, 2) @ (inverse @ turned)
    together = np.einsum("n,nap,naq->pq", weight, follows, follows) @ lines.covariance
    noise = 2 * np.sum(weight * variance) + np.trace(together)
    # Neglected: the share 3 / N of the noise that the three unknowns absorb.
    square = float(np.sum(weight * np.sum(b**2, axis=1)) - noise)
    alone = np.sum(weight**2 * np.einsum("nab,nab->n", own, own)) * alike
    signal = np.clip(np.einsum("na,nb->nab", b, b) - own, 0, None)
    crossed = np.sum(weight**2 * np.einsum("nab,nab->n", own, signal)) * alike
    common = np.einsum("n,nap,na->p", weight, follows, b)
    common = common @ lines.covariance @ common if square > 0 else 0.0
    spread = 2 * alone + 4 * crossed + 2 * np.trace(together @ together) + 4 * common
    return square, float(np.sqrt(spread))
