"""Test whether the corners of a board are at their nominal positions.

A camera absorbs much of what a dent, a lifted corner or a bad print does to a board,
and the errors of its rays are then several times the predicted ones. But the same board
is in all images: displaced corners have the same effect in the frame of the board in
each image, noise, light and the lens do not. Therefore the residuals of all images
together determine displacements of the corners, in the plane of the board and out of
it. The poses, a correction of the camera by a field over the image, and the bends and
the stretch that a fit may use are free parameters, too.

The displacements are polynomials of the position on the board, orthogonal over its
lattice, in groups by degree: a slow bend is smooth, a misprinted row is not. The
squares of each group are compared with the differences between images in the same
displacements, and never with less than the scatter of single corners. Where squares
have different sizes, their effective number is smaller (F. E. Satterthwaite 1946,
doi:10.2307/3002019); their ratio has an F distribution.

The displacement of a corner is the posterior mean for a Gaussian prior, whose width the
group itself determines (B. Efron and C. Morris 1973,
doi:10.1080/01621459.1973.10481350).

A detector with the same error on each board, e.g. at its edge, has the same effect. So
has a lens that the model does not fit, if all boards have similar poses. Therefore a
fit uses displacements (K. H. Strobl and G. Hirzinger 2011,
doi:10.1109/ICCVW.2011.6130369) only where halves of the images support them, by all
divisions of the split-half test: each half determines a correction of the camera and
displacements of its own. With these it should predict the boards of the other half
better, and the rays of both halves should agree better, than without displacements.
"""

from collections import Counter
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc

from raxel.calibration.views.correspondence import board_points
from raxel.evaluation.cross_validation import Evaluation, evaluate_camera
from raxel.evaluation.diagnoses import known
from raxel.evaluation.distortion import (
    MIN_N_BOARDS,
    image_equations,
    inverse_root,
    near_corners,
    scored_pairs,
    within_groups,
)
from raxel.evaluation.misfit import correction_fields, rms_moved, seen_on
from raxel.evaluation.split_half import MIN_N_PIXELS, UNKNOWN_SD_PX, halves_of
from raxel.geometry.poses import transform

P_THRESHOLD = 1e-4  # p-value, times the number of groups
DEGREE_LIMITS = (-1, 2, 3, 5, 8, np.inf)  # limits of the groups
MAX_N_MODES = 108  # along each axis, the smoothest first


class BoardCorners(NamedTuple):
    """Displacements of a board's corners from the positions that a fit assumes.

    offsets and sd (K, 3): of each corner, in the board's frame and unit, and standard
    deviations; 0 where no group of displacements is significant; p_value: of the most
    significant group, under the nominal positions, times the number of groups; rays_px:
    RMS by which these offsets move the rays of a lens that is free to follow them,
    after the best rotation, in the area of the boards; columns: of the lattice; pitch:
    its squares' side. held_out_px: RMS distance of boards predicted by the other half
    of the images, halves_px: RMS difference between the rays of both; each for the
    nominal and for the displaced positions, the median of all divisions; NaN where no
    group is significant. ray_covariance (P, P): of the coefficients of `polynomials`
    by which errors of the offsets move rays.
    """

    offsets: np.ndarray
    sd: np.ndarray
    p_value: float
    rays_px: float
    columns: int
    pitch: float = np.nan
    held_out_px: tuple = (np.nan, np.nan)
    halves_px: tuple = (np.nan, np.nan)
    ray_covariance: np.ndarray | None = None

    @property
    def used(self):
        """Whether both tests on halves support the displacements."""
        return all(
            after < before for before, after in (self.held_out_px, self.halves_px)
        )

    @property
    def as_stated(self):
        """Whether the corners have no significant displacement."""
        return self.p_value > P_THRESHOLD

    @property
    def worst(self):
        """Number of the corner with the largest displacement."""
        return int(np.argmax(np.linalg.norm(self.offsets, axis=1)))

    @property
    def distance(self):
        """(displacement of that corner, its standard deviation)."""
        offset, sd = self.offsets[self.worst], self.sd[self.worst]
        length = np.linalg.norm(offset)
        return float(length), float(np.linalg.norm(offset * sd) / max(length, 1e-300))

    @property
    def rms(self):
        """RMS distance of all corners."""
        return float(np.sqrt(np.mean(np.sum(self.offsets**2, axis=1))))

    def fields(self):
        """The positions for JSON; corners are numbered row by row."""
        keys = "as_stated", "p_value", "rays_px", "worst", "used", "columns", "pitch"
        found = {key: getattr(self, key) for key in keys}
        for key in ("held_out_px", "halves_px"):
            before, after = map(known, getattr(self, key))
            found[key] = {"nominal": before, "displaced": after}
        return found | {"offsets": self.offsets.tolist(), "sd": self.sd.tolist()}


def board_corners(camera, scores, views, shape=None):
    """BoardCorners of a camera on the BoardViews it was fitted to.

    scores: ImageScores of all corners that were found, wrong ones among them; shape:
    the board's BoardShape, None for one that is as stated.

    None where it cannot be estimated: fewer than six boards, boards of several sizes,
    or views that know the point of every pixel.
    """
    pairs = scored_pairs(scores, views)
    sizes = {(view.columns, view.rows) for _, view in pairs}
    dense = any(view.every_pixel for _, view in pairs)
    if len(pairs) < MIN_N_BOARDS or dense or len(sizes) > 1:
        return None
    fields = correction_fields(camera, pairs)
    if fields is None:
        return None
    view = pairs[0][1]
    absorbed, modes, degree = _displacements(view)
    moves = np.concatenate([absorbed, modes], axis=2)
    counted = _counted(pairs)
    whole = image_equations(camera, pairs, shape, counted, fields, moves)
    taken, normal, right = _without_first(*whole[:2], len(degree))
    groups = [
        (degree > low) & (degree <= high) for low, high in pairwise(DEGREE_LIMITS)
    ]
    groups = [own for own in groups if own.any()]
    tests = [_tested(normal, right, own, whole[2]) for own in groups]
    p_values, variances, ratios = zip(*tests, strict=True)
    p_value = min(1.0, len(groups) * min(p_values))
    prior = np.transpose(groups) @ ratios * (p_value <= P_THRESHOLD)
    normal, right = normal.sum(axis=0), right.sum(axis=0)
    mean = _posterior(normal, right, prior)
    covariance = _posterior(normal, np.eye(len(degree)), prior)
    scale = np.sqrt(np.transpose(groups) @ variances)
    covariance = scale[:, None] * covariance * scale
    sd = np.sqrt(np.einsum("kam,mn,kan->ka", modes, covariance, modes, optimize=True))
    seen = np.array([seen_on(each, camera, fields.pixels) for _, each in pairs])
    n_fields = fields.shapes.shape[2]
    rays = rms_moved(fields, seen.any(axis=0), (taken @ mean)[:n_fields])
    pitch = float(np.linalg.norm(view.points[1] - view.points[0]))
    moved = fields.mixing @ taken[:n_fields]
    found = BoardCorners(
        modes @ mean, sd, p_value, rays, view.columns, pitch,
        ray_covariance=moved @ covariance @ moved.T,
    )  # fmt: skip
    if found.as_stated:
        return found
    free = np.full(len(taken), np.ptp(view.points, axis=0).max() ** 2)
    free[:n_fields] = UNKNOWN_SD_PX**2
    priors = [np.concatenate([free / whole[2], own]) for own in (0 * prior, prior)]
    squares, differences = _halves_tested(whole, priors, pairs, fields, seen)
    held_out = np.sqrt(squares / np.count_nonzero(counted))
    return found._replace(held_out_px=tuple(held_out), halves_px=tuple(differences))


def _halves_tested(equations, priors, pairs, fields, seen):
    """(2, 2): squares of the residuals of boards that the other half predicts, px^2,
    and RMS difference between the rays of halves, px, by each of the priors; medians of
    all divisions. seen (n, N) bool: pixels of the fields on each board."""
    normal, right, _, squares = equations
    found = []
    for _, first in halves_of(pairs):
        both = seen[first].any(axis=0) & seen[~first].any(axis=0)
        if np.count_nonzero(both) < MIN_N_PIXELS:
            continue
        tested = []
        for prior in priors:
            sums = [
                (normal[k].sum(axis=0), right[k].sum(axis=0)) for k in (first, ~first)
            ]
            one, other = (_posterior(*each, prior) for each in sums)
            by_other = np.where(first[:, None], other, one)
            moved = np.einsum("nij,nj->ni", normal, by_other) - 2 * right
            left = np.sum(squares) + np.sum(by_other * moved)
            change = (one - other)[: fields.shapes.shape[2]]
            tested.append((left, rms_moved(fields, both, change)))
        found.append(np.transpose(tested))
    return np.median(found or [np.full((2, 2), np.nan)], axis=0)


def at_nominal_positions(camera, scores, views, board):
    """The views as they would be if no corner were displaced.

    The pixels of corners are moved by what their displacements do to the image, at the
    poses of their ImageScores; so any fit can use displacements. board: BoardShape with
    displaced corners.
    """
    moved, flat = [], board._replace(corners=None)
    for score, view in zip(scores, views, strict=True):
        if score.T_camera_grid is not None:
            nominal, seen = (
                camera.project(
                    transform(score.T_camera_grid, board_points(view.points, each))
                ).pixels
                for each in (flat, board)
            )
            view = view._replace(pixels=view.pixels + np.nan_to_num(nominal - seen))
        moved.append(view)
    return moved


def _displacements(view):
    """What a fit may take of the board, (K, 3, 4): its stretch, bends and twist; other
    displacements, (K, 3, M), of 1 RMS each; and their degree (M,). What a pose does and
    a scale of all are in neither."""
    values, of = _polynomials(view.columns, view.rows)
    r = view.points - view.points.mean(axis=0)
    x, y = (r / np.sqrt(np.mean(np.sum(r**2, axis=1)))).T
    along, out = np.eye(3)[:2], np.eye(3)[2]
    stretch = np.stack([x, -y, 0 * x], axis=1)[..., None]
    shear = np.stack([y, x, 0 * x], axis=1)[..., None]
    bends = out[:, None] * np.stack([x**2, x * y, y**2], axis=1)[:, None]
    flat = [axis[:, None] * values[:, None, of > 1] for axis in along]
    rises = out[:, None] * values[:, None, of > 2]
    degree = np.concatenate([[1], of[of > 1], of[of > 1], of[of > 2]])
    absorbed = np.concatenate([stretch, bends], axis=2)
    return absorbed, np.concatenate([shear, *flat, rises], axis=2), degree


def _polynomials(columns, rows):
    """(values (K, P), degree (P,)): products of polynomials in column and row, all of
    an RMS of 1 and orthogonal over the lattice, row by row; the first MAX_N_MODES."""
    in_column, in_row = _orthogonal(columns), _orthogonal(rows)
    degree = np.add.outer(np.arange(rows), np.arange(columns)).ravel()
    first = np.argsort(degree, kind="stable")[:MAX_N_MODES]
    return np.kron(in_row, in_column)[:, first], degree[first]


def _orthogonal(count):
    values = np.polynomial.legendre.legvander(np.linspace(-1, 1, count), count - 1)
    return np.sqrt(count) * np.linalg.qr(values)[0]


def _counted(pairs):
    """(n, K) bool: corners that count. One that is far off counts where it is so in
    most images: then it is the board's, and no detector's mistake."""
    found = np.isfinite([score.residuals_px[:, 0] for score, _ in pairs])
    near = np.array(near_corners(pairs))
    shared = (found & ~near).sum(axis=0) > found.sum(axis=0) / 2
    return near | found & shared


def _without_first(normal, right, count):
    """(taken (P, M), normal (n, M, M), right (n, M)): equations of the last `count`
    parameters, less what the first P take of them in the joint solution; taken: the
    change of the first by each of the last."""
    whole = normal.sum(axis=0)
    inverse = np.linalg.pinv(whole[:-count, :-count], hermitian=True)
    taken = inverse @ whole[:-count, -count:]
    rest = np.vstack([-taken, np.eye(count)])
    joint = inverse @ right[:, :-count].sum(axis=0)
    return taken, rest.T @ normal @ rest, (right - normal[:, :, :-count] @ joint) @ rest


def _tested(normal, right, own, variance):
    """(p-value, variance of a coordinate that explains how images differ, variance of
    the prior over that) of own (M,) displacements, by the equations of each image."""
    normal, right = normal[:, own][:, :, own], right[:, own]
    within, freedom = within_groups(normal, right, [np.ones(len(right), bool)])
    within, normal, joint = max(within, variance), normal.sum(axis=0), right.sum(axis=0)
    root, _ = inverse_root(normal)
    ratio = np.mean((root.T @ joint) ** 2) / within
    p_value = float(fdtrc(freedom / (len(right) - 1), freedom, ratio))
    # As wide as the squares of the displacements show.
    prior = max(joint @ joint / within - np.trace(normal), 0.0) / np.sum(normal**2)
    return p_value, within, prior


def _posterior(normal, right, prior):
    """Mean (M,) of parameters with independent priors of mean 0; prior (M,): their
    variances over that of scatter."""
    system = np.eye(len(prior)) + prior[:, None] * normal
    return np.linalg.solve(system, (prior * right.T).T)


# Outlier corners: those that do not fit although their neighbours do. A model misfit, a
# pose with the influence of wrong corners, a rolling shutter: all move neighbours
# alike. A corner that a detector confused with another one has no such neighbours.
# Therefore each residual is compared with the median of those around it on the
# lattice, or with their extrapolation where they have a slope, and the differences
# with their scatter. Outliers are no evidence about the camera: they are counted and
# named, and the other corners determine whether the camera fits.


# Limit in standard deviations, as in the robust fits of lenses: of the differences, or
# of the board's residuals where the camera does not fit it. No corner is more accurate
# than MIN_SD_PX.
OUTLIER_SIGMAS, MIN_SD_PX = 6.0, 0.01
RAYLEIGH = 1.1774  # median distance of two coordinates that scatter by 1
MIN_N_NEIGHBOURS = 3
NEIGHBOURS = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
# Fraction of a residual: an error of one corner does not move two of its neighbours so
# far in the same direction.
MIN_SHARED_FRACTION = 0.25
MAX_N_ROUNDS = 5  # until no further one is found: poses improve without the first


class WrongCorners(NamedTuple):
    """whole: the camera's Evaluation on all corners; views: those given, without wrong
    corners; evaluation: the Evaluation on these; wrong: [(name of the view, number of
    the corner, error in px)]."""

    whole: Evaluation
    views: list
    evaluation: Evaluation
    wrong: list

    def fields(self, rejected=()):
        """The wrong corners for JSON; rejected: {file, corner, distance_px} of those
        that a fit gave no weight."""
        wrong = {(name, n): px for name, n, px in self.wrong}
        wrong |= {(e["file"], e["corner"]): e["distance_px"] for e in rejected}
        count = self.whole.n_scored
        return {
            "wrong_points": [
                {"file": name, "corner": n, "distance_px": px}
                for (name, n), px in sorted(wrong.items())
            ],
            "share_of_wrong_points": len(wrong) / count if count else None,
            "wrong_points_of": dict(Counter(name for name, _ in sorted(wrong))),
        }


def without_wrong_corners(camera, views, shape=None):
    """WrongCorners of a camera on BoardViews or DenseViews; shape: as of
    `evaluate_camera`."""
    whole = found = evaluate_camera(camera, views, shape)
    left, alone = list(views), {}
    for _ in range(MAX_N_ROUNDS):
        places = _outliers(found.images, left)
        if not any(own.any() for own in places):
            break
        for k, own in enumerate(places):
            off = np.linalg.norm(found.images[k].residuals_px, axis=1)
            alone |= {(k, int(n)): float(off[n]) for n in np.flatnonzero(own)}
            pixels = left[k].pixels.copy()
            pixels[own] = np.nan
            left[k] = left[k]._replace(pixels=pixels)
        found = evaluate_camera(camera, left, shape)
    wrong = [(views[k].name, n, px) for (k, n), px in sorted(alone.items())]
    return WrongCorners(whole, left, found, wrong)


def _outliers(scores, views):
    """(N,) bool of each view: corners with errors that their neighbours lack."""
    found = [_from_neighbours(*pair) for pair in zip(scores, views, strict=True)]
    typical = np.concatenate([off for off, _ in found])
    typical = typical[np.isfinite(typical)]
    if len(typical) == 0:
        return [shared & False for _, shared in found]
    single, alone = np.median(typical), []
    for (off, shared), score in zip(found, scores, strict=True):
        distances = np.linalg.norm(score.residuals_px, axis=1)
        own = np.nanmedian(distances) if np.isfinite(distances).any() else single
        widest = OUTLIER_SIGMAS * max(single / RAYLEIGH, own / RAYLEIGH, MIN_SD_PX)
        alone.append((np.fmin(off, distances) > widest) & ~shared)
    return alone


def _from_neighbours(score, view):
    """Distances (N,) px of residuals from what those around them lead one to expect,
    NaN where there are too few; and (N,) bool: two of these go the same way."""
    lattice = score.residuals_px.reshape(view.rows, view.columns, 2)
    padded = np.pad(lattice, ((2, 2), (2, 2), (0, 0)), constant_values=np.nan)

    def moved(i, j):
        return padded[2 + i : 2 + i + view.rows, 2 + j : 2 + j + view.columns]

    near = np.stack([moved(*step) for step in NEIGHBOURS])
    on = np.stack([2 * moved(i, j) - moved(2 * i, 2 * j) for i, j in NEIGHBOURS])
    off = [np.linalg.norm(lattice - _median(each), axis=2) for each in (near, on)]
    along = np.nan_to_num(np.sum(near * lattice, axis=3), nan=-np.inf)
    second = np.sort(along, axis=0)[-2]
    shared = second > MIN_SHARED_FRACTION * np.sum(lattice**2, axis=2)
    return np.fmin(*off).ravel(), shared.ravel()


def _median(around):
    """Median (rows, columns, 2) of those (8, rows, columns, 2) that are finite; NaN
    where they are fewer than MIN_N_NEIGHBOURS."""
    enough = np.isfinite(around[..., 0]).sum(axis=0) >= MIN_N_NEIGHBOURS
    middle = np.full(around.shape[1:], np.nan)
    middle[enough] = np.nanmedian(around[:, enough], axis=0)
    return middle
