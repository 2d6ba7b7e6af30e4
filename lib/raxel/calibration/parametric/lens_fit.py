"""Fit of a lens model without initial values: start, selection of terms, covariance.

The start uses no lens model: poses of all boards follow from the azimuths of their
corners. The adjustment of model and poses (`raxel.calibration.parametric.lens_bundle`)
then proceeds from few terms to all, and back to those that the data support (Schwarz's
criterion).

Source: G. Schwarz 1978, doi:10.1214/aos/1176344136.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from raxel.calibration.parametric.lens_bundle import (
    N_FRAME_PARAMETERS,
    OUTLIER_SCALES,
    AdjustedLens,
    LensFormula,
    adjusted,
    board_information,
    posed_residuals,
    start_without,
    tukey_pull,
)
from raxel.errors import CalibrationError
from raxel.geometry.poses import pose

# Covariance from the scatter between images (cluster-robust), for corners of one image
# with correlated errors. Light, blur, motion or a misfit of the lens model shift
# neighbouring corners together. There are fewer independent corners than corners, and a
# covariance that treats them as independent is too small. The disagreement between
# images shows by how much: image i, with a free pose, requests a step by its gradient
# g_i, and g_i g_i' measures the effect of its corners, whatever correlates them. The
# fit has followed them, so a share a_i = N^-1/2 N_i N^-1/2 is lost, and (I - a_i)^-1/2
# restores it. A dozen images determine one common factor well, and one factor for each
# parameter badly. The estimate of each parameter is therefore shrunk towards the common
# one, by as much as it fluctuates. Errors are at least those of independent corners:
# the common factor is 1 or more, and smaller values in some direction, which are
# fluctuations, are raised to it. So no parameter or combination of parameters has a
# smaller standard deviation than with independent corners. The excess is estimated with
# the number of images minus one degrees of freedom: normalised errors have Student's
# distribution, and the reported variance is that of such errors. In 150 simulated sets
# each of 6, 8, 14 and 30 boards with two lenses, with independent and correlated
# corners, errors of focal lengths are 0.87 to 1.04 times the reported value (RMS).
# Sources: K.-Y. Liang and S. L. Zeger 1986, doi:10.1093/biomet/73.1.13; A. C. Cameron
# and D. L. Miller 2015, doi:10.3368/jhr.50.2.317, with the correction of Bell and
# McCaffrey; shrinkage, O. Ledoit and M. Wolf 2004, doi:10.1016/S0047-259X(03)00096-4.


# Smallest over largest eigenvalue: below, a direction is undetermined.
MIN_EIGENVALUE_RATIO = 1e-15
MAX_IMAGE_SHARE = 0.95  # information of one image on a direction, over that of all
MIN_DEGREES_OF_FREEDOM = 3  # with fewer, Student's variance is infinite


class ClusteredCovariance(NamedTuple):
    """covariance (P, P), of errors; alone (P, P), for independent corners; estimated
    (P, P): from the scatter between images, without the factor for their small number,
    for tests whose distribution includes it; factor of standard deviations: common
    ratio to those of independent corners; step (P,): to the minimum."""

    covariance: np.ndarray
    alone: np.ndarray
    estimated: np.ndarray
    factor: float
    step: np.ndarray


def clustered_covariance(normal, gradient, variance):
    """ClusteredCovariance of parameters at a minimum.

    normal (n, P, P) and gradient (n, P) of each image's sum of squares, its pose
    eliminated; variance: of a coordinate, in the same squares.
    """
    count = len(normal)
    root, scale = _inverse_root(normal.sum(axis=0))
    own = np.swapaxes(root, 0, 1) @ (normal / scale[:, None] / scale) @ root
    steps = (gradient / scale) @ root
    shares, axes = np.linalg.eigh(own)
    given_back = 1 / np.sqrt(1 - np.clip(shares, 0, MAX_IMAGE_SHARE))
    along = np.einsum("nij,ni->nj", axes, steps) * given_back
    steps_alone = np.einsum("nij,nj->ni", axes, along) / np.sqrt(variance)
    mixed = _mixed(steps_alone)
    free = max(count - 1, MIN_DEGREES_OF_FREEDOM)
    wider = np.eye(len(mixed)) + (mixed - np.eye(len(mixed))) * free / (free - 2)
    outer = variance / np.outer(scale, scale)
    covariance, estimated = (outer * (root @ of @ root.T) for of in (wider, mixed))
    factor = float(np.sqrt(np.trace(wider) / len(wider)))
    step = root @ steps.sum(axis=0) / scale
    alone = outer * (root @ root.T)
    return ClusteredCovariance(covariance, alone, estimated, factor, step)


def _mixed(steps):
    """Covariance (K, K) of the sum of steps (n, K), at least 1 in each direction."""
    each, identity = steps.T @ steps, np.eye(steps.shape[1])
    common = np.trace(each) / len(identity)
    separation = np.sum((each - common * identity) ** 2)
    # Expected deviation from the common value by fluctuation alone.
    squares = np.sum(steps**2, axis=1)
    chance = np.sum(squares**2) - np.sum(each**2) / len(steps)
    share = min(chance / max(separation, np.finfo(float).tiny), 1.0)
    size, axes = np.linalg.eigh(
        (1 - share) * each + share * max(common, 1.0) * identity
    )
    return (axes * np.maximum(size, 1.0)) @ axes.T


def _inverse_root(normal):
    """(W, scale): W W' is the pseudo-inverse of a normal matrix over its scales."""
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    size, axes = np.linalg.eigh(normal / np.outer(scale, scale))
    determined = size > MIN_EIGENVALUE_RATIO * size[-1]
    return axes[:, determined] / np.sqrt(size[determined]), scale


# Start for any lens with an axis: poses of boards without a lens model. The radial law
# of a lens does not change the azimuth. Seen from the point c where the axis meets the
# image, a corner (u, v) has the direction of its board point's offset (x, y) across the
# axis, (u - c_u) y = (v - c_v) x, x = h1 . (X, Y, 1), y = h2 . (X, Y, 1). This is
# linear in h1, h2 for each board, and gives its pose except the depth. It holds for
# angles beyond 90 degrees, for mirrors, and for an entrance-pupil shift along the axis.
# The depths, and the choice between the two mirrored tilts, follow with an initial law:
# r = F theta for fisheyes, or r = F tan theta for perspective lenses. F and c are found
# by search. A law with the opposite curvature selects the mirrored tilts, from which no
# fit converges to the right solution: both laws are tried. Source of the constraint: R.
# Y. Tsai, IEEE J. Robotics and Automation 3(4), 1987, doi:10.1109/JRA.1987.1087109.


N_TRIAL_CENTRES = 21  # per axis, over the middle of the image
CENTRE_SPREAD = 0.6  # extent of the trial centres, over the image's sides
N_REWEIGHTINGS = 5  # against outliers
# Smallest angle at the image edge, and number of trial angles up to the widest.
MIN_EDGE_ANGLE_RAD, N_FOCAL_LENGTHS = 0.08, 25


class StartLaw(NamedTuple):
    """angle: r / F -> theta; radius: inverse; turned: derivative of r / F by theta;
    widest: rad at the image edge; k1: of r = F theta (1 + k1 theta^2), near the
    axis."""

    angle: Callable
    radius: Callable
    turned: Callable
    widest: float
    k1: float


LAWS = (
    StartLaw(lambda x: x, lambda theta: theta, np.ones_like, 3.05, 0.0),
    StartLaw(np.arctan, np.tan, lambda x: 1 + x**2, 1.3, 1 / 3),
)


class AlignedStart(NamedTuple):
    """centre (2,) px, intersection of axis and image; focal_px and k1, of r = F theta
    (1 + k1 theta^2); T_camera_grid (n, 4, 4)."""

    centre: np.ndarray
    focal_px: float
    k1: float
    T_camera_grid: np.ndarray


def aligned_starts(pixels, points, seen, width, height):
    """AlignedStarts to choose from, of either law, about the image centre and about the
    best-fitting centre.

    pixels: (n, M, 2), points: (n, M, 2) on n boards; seen: (n, M) bool.
    """
    middle = (np.array([width, height]) - 1) / 2
    return [
        _started(law, pixels, points, seen, centre)
        for centre in (middle, _best_centre(pixels, points, seen, width, height))
        for law in LAWS
    ]


def _best_centre(pixels, points, seen, width, height):
    """Centre with the best alignment of boards: a coarse and a fine grid search."""
    middle = (np.array([width, height]) - 1) / 2
    size = np.array([width, height], float)
    moments = _moments(pixels - middle, *_normalised(points, seen), seen, size.max())
    best, reach = np.zeros(2), CENTRE_SPREAD * size / 2 / size.max()
    for _ in range(3):
        ends = np.linspace(-1, 1, N_TRIAL_CENTRES)
        tried = best + np.stack(np.meshgrid(ends, ends), -1).reshape(-1, 2) * reach
        best = tried[np.argmin([_misalignment(moments, c) for c in tried])]
        reach = 2 * reach / (N_TRIAL_CENTRES - 1)
    return middle + best * size.max()


def _moments(offsets, flat, _, seen, size):
    """(n, 6, 6, 6): products of the rows' parts without c, with c_u and with c_v."""
    u, v = np.where(seen[..., None], offsets / size, 0.0).transpose(2, 0, 1)
    flat = np.where(seen[..., None], flat, 0.0)
    zero = np.zeros_like(flat)
    parts = np.stack(
        [
            np.concatenate([-v[..., None] * flat, u[..., None] * flat], axis=2),
            np.concatenate([zero, -flat], axis=2),
            np.concatenate([flat, zero], axis=2),
        ]
    )
    return np.einsum("anmi,bnmj->abnij", parts, parts)


def _misalignment(moments, c):
    """Sum over boards of the least squared residual of unit vectors (h1, h2)."""
    weights = np.array([1.0, *c])
    normal = np.einsum("a,b,abnij->nij", weights, weights, moments)
    return np.sum(np.linalg.eigvalsh(normal)[:, 0])


def _started(law, pixels, points, seen, centre):
    offsets = np.where(seen[..., None], pixels - centre, 0.0)
    radius = np.linalg.norm(offsets, axis=2)
    h1, h2 = _aligned(offsets, points, seen)
    rims = np.geomspace(law.widest, MIN_EDGE_ANGLE_RAD, N_FOCAL_LENGTHS)
    lengths = radius.max() / law.radius(rims)
    rotations, shifts = _two_tilts(h1, h2)
    fits = [_depths(law, rotations, shifts, points, seen, radius, f) for f in lengths]
    best = int(np.argmin([cost.sum() for _, _, cost in fits]))
    sign, depth, _ = fits[best]
    rows = np.arange(len(points))
    return AlignedStart(
        np.asarray(centre, float),
        float(lengths[best]),
        law.k1,
        pose(rotations[sign, rows], np.column_stack([shifts, depth])),
    )


def _normalised(points, seen):
    """(X, Y, 1) (n, M, 3) about each board's centre, in units of its size, and the
    matrices (n, 3, 3) of this normalisation."""
    count = seen.sum(axis=1)[:, None]
    inside = np.where(seen[..., None], points, 0.0)
    middle = inside.sum(axis=1) / count
    offset = np.where(seen[..., None], points - middle[:, None], 0.0)
    size = np.sqrt((offset**2).sum(axis=(1, 2)) / count[:, 0])
    matrix = np.zeros((len(points), 3, 3))
    matrix[:, [0, 1], [0, 1]] = 1 / size[:, None]
    matrix[:, :2, 2] = -middle / size[:, None]
    matrix[:, 2, 2] = 1.0
    flat = np.concatenate([offset / size[:, None, None], np.ones((*seen.shape, 1))], 2)
    return flat, matrix


def _aligned(offsets, points, seen):
    """h1, h2 (n, 3) of every board, reweighted by the tangential distances."""
    flat, matrix = _normalised(points, seen)
    weights = seen.astype(float)
    for _ in range(N_REWEIGHTINGS):
        rows = np.concatenate([-offsets[..., 1:] * flat, offsets[..., :1] * flat], 2)
        normal = np.einsum("nmi,nm,nmj->nij", rows, weights, rows)
        h = np.linalg.eigh(normal)[1][:, :, 0].reshape(-1, 2, 3)
        across = np.einsum("nij,nmj->nmi", h, flat)
        length = np.maximum(np.linalg.norm(across, axis=2), 1e-12)
        miss = np.einsum("nmi,ni->nm", rows, h.reshape(-1, 6)) / length
        scale = 1.4826 * np.median(np.abs(miss[seen])) + 1e-12
        weights = seen / (1 + (miss / (3 * scale)) ** 2) / length**2
        weights /= weights.max(axis=1, keepdims=True)
    outward = np.einsum("nmi,nmi,nm->n", across, offsets, weights)
    h = (h * np.sign(outward)[:, None, None]) @ matrix
    return h[:, 0], h[:, 1]


def _two_tilts(h1, h2):
    """Rotations (2, n, 3, 3) with both tilts, and shifts (n, 2).

    The third components w of the rotation's first columns complete them to unit length:
    with M = [h1; h2] over the columns, M^T M = s^2 (I - w w^T).
    """
    M = np.stack([h1[:, :2], h2[:, :2]], axis=1)
    _, s, Vt = np.linalg.svd(M)
    w = np.sqrt(np.maximum(1 - (s[:, 1] / s[:, 0]) ** 2, 0))[:, None] * Vt[:, 1]
    top = M / s[:, :1, None]
    rotations = []
    for third in (w, -w):
        pair = np.concatenate([top, third[:, None]], axis=1)
        last = np.cross(pair[..., 0], pair[..., 1])
        rotations.append(np.concatenate([pair, last[..., None]], axis=2))
    return np.stack(rotations), np.stack([h1[:, 2], h2[:, 2]], axis=1) / s[:, :1]


def _depths(law, rotations, shifts, points, seen, radius, focal_px):
    """For a law and F: tilt (n,) 0 or 1, depth (n,), and cost (n,) px^2 (robust)."""
    theta = np.clip(law.angle(radius / focal_px), 1e-6, np.pi - 1e-3)
    across = np.einsum("nij,nmj->nmi", rotations[0, :, :2, :2], points)
    rho = np.linalg.norm(across + shifts[:, None], axis=2)
    tilted = np.einsum("knj,nmj->knm", rotations[:, :, 2, :2], points)
    gap = rho / np.tan(theta) - tilted  # depth estimated from each point
    # Derivative of r / F with the depth.
    turn = np.where(seen, np.sin(theta) ** 2 / np.maximum(rho, 1e-12), 0.0)
    turn = turn * law.turned(radius / focal_px)
    weights = np.broadcast_to(turn**2, gap.shape)
    for _ in range(N_REWEIGHTINGS):
        depth = np.sum(weights * gap, 2) / np.maximum(np.sum(weights, 2), 1e-300)
        miss = focal_px * turn * (gap - depth[..., None])
        scale = 1.4826 * np.median(np.abs(miss[:, seen])) + 1e-12
        weights = turn**2 / (1 + (miss / (3 * scale)) ** 2)
    # Residuals beyond a tenth of the image's radius have equal cost.
    limit = (radius.max() / 10) ** 2
    cost = np.sum(np.where(seen, miss**2 / (1 + miss**2 / limit), 0.0), axis=2)
    tilt = np.argmin(cost, axis=0)
    rows = np.arange(len(points))
    return tilt, depth[tilt, rows], cost[tilt, rows]


MAX_N_RADIAL_TERMS, MAX_N_DECENTRING_TERMS, MAX_N_PUPIL_TERMS = 4, 4, 3
MIN_N_PARAMETERS = N_FRAME_PARAMETERS + 1  # with one radial term
START_XI = (0.0, 1.0, 2.0)  # a pinhole, a paraboloid, a fisheye
N_FOLDS = 5  # of the boards, for cross-validation
# Curvature of a loss over its weights: 0.89 for Gaussian residuals. Heavier tails do
# not determine the curvature.
MIN_CURVATURE_RATIO = 0.5
MIN_RESIDUAL_PX = 1e-6  # smaller residuals count as exact
FIT_CACHE_SIZE = 8  # sets of boards whose fits are cached


class FormulaFit(NamedTuple):
    """A lens model, and its adjustment to boards."""

    formula: LensFormula
    result: AdjustedLens


class GivenBoards:
    """Input of a lens fit. Equal for equal numbers: a comparison requests several
    models, and B-spline ray fields based on them, for the same parts of the boards."""

    def __init__(self, boards, width, height):
        self.boards, self.width, self.height = boards, width, height
        parts = ((part.shape, part.tobytes()) for part in boards)
        self._numbers = (width, height, *parts)

    def __eq__(self, other):
        return self._numbers == other._numbers

    def __hash__(self):
        return hash(self._numbers)


@lru_cache(maxsize=FIT_CACHE_SIZE)
def start_of(given):
    """Best fit of r = F theta (1 + k1 theta^2) over all starts."""
    boards, width, height = given.boards, given.width, given.height
    fits = []
    for start in aligned_starts(
        boards.pixels, boards.points[..., :2], boards.seen, width, height
    ):
        formula = LensFormula("kannala-brandt", int(start.k1 != 0), 0, 0)
        values = [start.focal_px, start.focal_px, *start.centre, start.k1]
        values = values[: len(formula.names)]
        fit = FormulaFit(
            formula, adjusted(formula, values, start.T_camera_grid, boards, "cauchy")
        )
        fits.append(refitted(fit, formula._replace(radial=1), boards, "cauchy"))
    sound = [fit for fit in fits if np.isfinite(fit.result.cost)]
    if not sound:
        raise CalibrationError(
            "lens formula: no start leads to poses of the boards; check that corners "
            "are in row order",
            code="no-start",
        )
    return min(sound, key=lambda fit: np.median(fit.result.scales))


def fitted_law(law, start, boards, pupil, board=()):
    """FormulaFit of a law, with the terms that the data support; pupil: maximum number
    of its terms; board: the terms of its shape."""
    firsts = [start] if law == "kannala-brandt" else _on_spheres(start, boards)
    widest = [_widened(first, boards, pupil, board) for first in firsts]
    widest.sort(key=lambda fit: np.median(fit.result.scales))
    scales = widest[0].result.scales
    best = _thinned(widest[0], boards, scales)
    for other in widest[1:]:
        # A fit with fewer terms is not better, only simpler.
        if _criterion(other, boards, MIN_N_PARAMETERS) < _criterion(best, boards):
            other = _thinned(other, boards, scales)
            best = min(best, other, key=lambda fit: _criterion(fit, boards))
    return best


def _widened(fit, boards, pupil, board):
    """FormulaFit with all terms, `pupil` terms of the pupil, and those of the board."""
    for radial, decentring, moving in (
        (2, 2, min(pupil, 1)),
        (MAX_N_RADIAL_TERMS, MAX_N_DECENTRING_TERMS, pupil),
    ):
        wider = LensFormula(fit.formula.base, radial, decentring, moving, board)
        fit = refitted(fit, wider, boards, "tukey")
    return fit


def _on_spheres(start, boards):
    """Best FormulaFit of a unified sphere with one radial term and, where it images all
    points, that of a perspective lens: no free xi converges to 0."""
    values, poses = start.result.values, start.result.T_camera_grid

    def fitted(base, *xi):
        formula = LensFormula(base, 1, 0, 0)
        first = np.array([*values[:4], *xi, 0.0])
        return FormulaFit(formula, adjusted(formula, first, poses, boards, "cauchy"))

    free = [fitted("unified", xi) for xi in START_XI]
    best = min(free, key=lambda fit: np.median(fit.result.scales))
    flat = fitted("perspective")
    return [best, flat] if np.isfinite(flat.result.cost) else [best]


def refitted(fit, formula, boards, loss, scales=None):
    """FormulaFit of another model, starting from the result of a fit."""
    start = start_without(fit.formula, formula, fit.result, boards)
    result = adjusted(formula, *start, boards, loss, scales)
    return FormulaFit(formula, result)


def _thinned(fit, boards, scales):
    """FormulaFit after backward elimination of the terms without a benefit."""
    fit = refitted(fit, fit.formula, boards, "tukey", scales)
    best = _criterion(fit, boards)
    while True:
        tried = [
            refitted(fit, formula, boards, "tukey", scales)
            for formula in _narrower(fit.formula)
        ]
        least = min(tried, key=lambda other: _criterion(other, boards), default=None)
        if least is None or _criterion(least, boards) > best:
            return fit
        fit, best = least, _criterion(least, boards)


def _narrower(formula):
    """Models with one step fewer terms of one kind; a pupil shift and the board's shape
    stay."""
    if formula.radial > 1:
        yield formula._replace(radial=formula.radial - 1)
    if formula.decentring:
        yield formula._replace(decentring=formula.decentring - 2)
    if formula.pupil > 1:
        yield formula._replace(pupil=formula.pupil - 1)


def _criterion(fit, boards, terms=None):
    """Schwarz's criterion from a fit's loss and its number of parameters (those of the
    model by default)."""
    count = 2 * np.count_nonzero(boards.seen)
    cost = max(fit.result.cost, count * MIN_RESIDUAL_PX**2)
    terms = len(fit.formula.names) if terms is None else terms
    return count * np.log(cost) + terms * np.log(count)


def held_out_squares(fit, boards):
    """Mean squared distance (n,) px^2 on each board, held out with its near copies from
    fits with the same terms. A corner counts as at most OUTLIER_SCALES scales of its
    board. NaN where fewer than two other boards are left."""
    n, scales = len(boards.seen), fit.result.scales
    poses, squares = fit.result.T_camera_grid, np.full(n, np.nan)
    groups = boards.groups
    parts = min(N_FOLDS, groups.max() + 1)
    for part in range(parts):
        out = groups % parts == part
        if n - out.sum() < 2:
            continue
        inside, retained = boards.some(~out), boards.some(out)
        found = adjusted(
            fit.formula, fit.result.values, poses[~out], inside, "tukey", scales[~out]
        )
        errors = posed_residuals(fit.formula, found.values, poses[out], retained)
        most = (OUTLIER_SCALES * scales[out, None]) ** 2
        errors = np.minimum(np.nan_to_num(np.sum(errors**2, axis=2), nan=np.inf), most)
        squares[out] = np.sum(np.where(retained.seen, errors, 0.0), axis=1)
        squares[out] /= retained.seen.sum(axis=1)
    return squares


def covariance_of(fit, boards):
    """ClusteredCovariance of the parameters, from the residuals. Near copies count
    together, as corners of one image do.

    The weight of an outlier decreases with its distance, so the loss has a smaller
    curvature than its weights (P. J. Huber and E. M. Ronchetti 2009, section 7.6,
    doi:10.1002/9780470434697).
    """
    found = fit.result
    squares = np.sum(found.residuals**2, axis=2)
    weight, slope = tukey_pull(np.where(boards.seen, squares, np.inf), found.scales)
    right = weight > 0
    curved = max(np.sum(slope) / np.sum(weight), MIN_CURVATURE_RATIO)
    free = max(free_of(fit, boards) - 2 * np.count_nonzero(boards.seen & ~right), 1)
    pulls = np.sum(weight[right] ** 2 * squares[right])
    variance = pulls / free / (curved * np.mean(weight[right]))
    information = board_information(
        fit.formula, found.values, found.T_camera_grid, boards, found.scales
    )
    normal, gradient = (boards.of_groups(each) for each in information)
    return clustered_covariance(
        normal * curved, gradient, max(variance, MIN_RESIDUAL_PX**2)
    )


def error_covariance(fit, boards):
    """Covariance (P, P) of the errors of the parameters, factor of standard deviations
    as in ClusteredCovariance, and (formula, values, covariance) of all terms that move
    rays: the next radial term has the value 0, and the others compensate it.

    Schwarz's criterion leaves out terms that the boards do not prove, and a lens may
    have them. Its differences are twice the logarithms of posterior odds (Kass and
    Raftery 1995, doi:10.1080/01621459.1995.10476572): the next radial term k, estimated
    with the variance v from n coordinates, has the odds exp(k^2 / 2v) / n^(1/2). With
    it the parameters would change by a step. Their errors are of mean square covariance
    with the term, plus that step, at its probability, and covariance without otherwise.
    A free xi is such a term itself.
    """
    found = covariance_of(fit, boards)
    if fit.formula.base == "unified":
        terms = fit.formula, fit.result.values.copy(), found.covariance
        return found.covariance, found.factor, terms
    wider = fit.formula._replace(radial=fit.formula.radial + 1)
    values = fit.formula.moved_to(wider, fit.result.values)
    other = covariance_of(FormulaFit(wider, fit.result._replace(values=values)), boards)
    own = [wider.names.index(name) for name in fit.formula.names]
    k = wider.names.index(f"k{wider.radial}")
    gain = other.step[k] ** 2 / other.covariance[k, k]
    count = 2 * np.count_nonzero(boards.seen)
    share = 1 / (1 + np.exp((np.log(count) - gain) / 2))
    covariance = share * (other.covariance + np.outer(other.step, other.step))
    covariance[np.ix_(own, own)] += (1 - share) * found.covariance
    return covariance[np.ix_(own, own)], found.factor, (wider, values, covariance)


def free_of(fit, boards):
    """Number of coordinates minus number of parameters."""
    count = 2 * np.count_nonzero(boards.seen)
    return max(count - len(fit.formula.names) - 6 * len(boards.seen), 1)
