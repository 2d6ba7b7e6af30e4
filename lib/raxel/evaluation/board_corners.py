"""Do the board's corners lie where they are said to lie?

A camera takes in much of what a dent, a lifted corner or a bad print does to a board's
corners, and rays are then off by several times what is stated. But one board is in all
photographs: what its corners do in its own frame they do in each, and noise, light and
a lens do not. So the residuals of all photographs are asked together for displacements
of the corners, along the board and out of it, each photograph through its own view. The
poses, a correction of the camera by a field over the image, and the bends and the
stretch that a fit may take are free beside them.

The displacements are polynomials of the place on the board, orthogonal over its
lattice, in groups by their degree: what bends slowly is smooth, a misprinted row is
not. Each group is held against how far photographs differ from each other in the same
displacements, whatever makes them do so, and never against less than the scatter of
single corners. Squares that are larger some ways than others are fewer than ways (F. E.
Satterthwaite 1946, doi:10.2307/3002019), and their ratio has Fisher's distribution.

How far a corner is off is the mean that remains of a Gaussian prior, as wide as the
group itself shows (B. Efron and C. Morris 1973, doi:10.1080/01621459.1973.10481350).

A finder that errs alike on each board, at its rim say, does the same. So does a lens
that the camera does not follow where all boards are seen alike.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.views.board_shape import board_points
from raxel.calibration.views.near_copies import once_each
from raxel.evaluation.apart import apart, inverse_root
from raxel.evaluation.corrections import (
    correction_fields,
    polynomials,
    seen_on,
    without_turns,
)
from raxel.evaluation.pixel_pose import pixels_by_point, pose_jacobian
from raxel.geometry.poses import transform

SURE = 1e-4  # p-value, times the number of groups
FEWEST_BOARDS = 6
HIGHEST = (2, 3, 5, 8, np.inf)  # degree of each group
MOST_MODES = 80  # along each axis, the smoothest first
WIDTH, RAYLEIGH = 6.0, 1.1774  # of wrong corners; median distance at unit scale
LEAST_SD_PX = 0.01  # of a coordinate: no corner is known better


class BoardCorners(NamedTuple):
    """Where a board's corners lie beyond where a fit takes them to be.

    offsets and sd (K, 3): of each corner, in the board's frame and unit, and standard
    deviations, 0 where no group of displacements shows; p_value: how often a board that
    is as stated shows as much, of the group that shows most, times their number;
    rays_px: RMS by which these offsets move the rays of a lens that is free to follow
    them, after the best rotation, where boards were seen; columns: of the lattice.
    """

    offsets: np.ndarray
    sd: np.ndarray
    p_value: float
    rays_px: float
    columns: int

    @property
    def as_stated(self):
        """Whether nothing is to be said."""
        return self.p_value > SURE

    @property
    def worst(self):
        """Number of the corner that lies farthest off."""
        return int(np.argmax(np.linalg.norm(self.offsets, axis=1)))

    @property
    def place(self):
        """(column, row) of that corner, from 0."""
        return self.worst % self.columns, self.worst // self.columns

    @property
    def distance(self):
        """(how far that corner is off, standard deviation of that)."""
        offset, sd = self.offsets[self.worst], self.sd[self.worst]
        length = np.linalg.norm(offset)
        return float(length), float(np.linalg.norm(offset * sd) / max(length, 1e-300))

    @property
    def rms(self):
        """RMS distance of all corners."""
        return float(np.sqrt(np.mean(np.sum(self.offsets**2, axis=1))))


class _Group(NamedTuple):
    """own (M,) bool: its displacements; p_value; variance: of a coordinate, with what
    photographs differ by."""

    own: np.ndarray
    p_value: float
    variance: float


def board_corners(camera, scores, views, shape=None):
    """BoardCorners of a camera on the BoardViews it was fitted to.

    scores: ImageScores of all corners that were found, wrong ones among them; shape:
    the board's BoardShape, None for one that is as stated.

    None where it cannot be told: fewer than six boards, boards of several sizes, or
    views that know the point of every pixel.
    """
    pairs = [
        (score, view)
        for score, view in zip(scores, views, strict=True)
        if np.isfinite(score.rms_px)
    ]
    pairs = once_each(pairs)
    if len(pairs) < FEWEST_BOARDS or any(view.every_pixel for _, view in pairs):
        return None
    if len({(view.columns, view.rows) for _, view in pairs}) > 1:
        return None
    fields = correction_fields(camera, pairs)
    if fields is None:
        return None
    view = pairs[0][1]
    absorbed, modes, degree = _displacements(view)
    moves = np.concatenate([absorbed, modes], axis=2)
    found = [
        _board(camera, *pair, right, shape, fields.mixing, moves)
        for pair, right in zip(
            pairs, _right([score for score, _ in pairs]), strict=True
        )
    ]
    squares = np.array([square for square, _ in found])
    count = fields.shapes.shape[2] + absorbed.shape[2]
    share, left = _without_first(squares, count)
    normal, right = left[:, :-1, :-1], left[:, :-1, -1]
    free = sum(each for _, each in found) - count
    variance = _scatter(left.sum(axis=0), free)
    groups, lowest = [], -1
    for highest in HIGHEST:
        own = (degree > lowest) & (degree <= highest)
        lowest = highest
        if own.any():
            tested = _tested(normal[:, own][:, :, own], right[:, own], variance)
            groups.append(_Group(own, *tested))
    p_value = min(1.0, len(groups) * min(group.p_value for group in groups))
    shown = [group for group in groups if group.p_value < SURE / len(groups)]
    mean, covariance = _estimated(normal.sum(axis=0), right.sum(axis=0), shown)
    sd = np.sqrt(np.einsum("kam,mn,kan->ka", modes, covariance, modes, optimize=True))
    change = (share.T @ mean)[: fields.shapes.shape[2]]
    seen = [seen_on(each, camera, fields.pixels) for _, each in pairs]
    seen = np.any(seen, axis=0)
    moved = without_turns(fields.turns[seen], fields.shapes[seen]) @ change
    rays = float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))
    return BoardCorners(modes @ mean, sd, p_value, rays, view.columns)


# ------------------------------------------------------------------- the displacements


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
    an RMS of 1 and orthogonal over the lattice, row by row; the first MOST_MODES."""
    in_column, in_row = _orthogonal(columns), _orthogonal(rows)
    degree = np.add.outer(np.arange(rows), np.arange(columns)).ravel()
    first = np.argsort(degree, kind="stable")[:MOST_MODES]
    return np.kron(in_row, in_column)[:, first], degree[first]


def _orthogonal(count):
    values = np.polynomial.legendre.legvander(np.linspace(-1, 1, count), count - 1)
    return np.sqrt(count) * np.linalg.qr(values)[0]


# ------------------------------------------------------------------------ the equations


def _board(camera, score, view, right, shape, mixing, moves):
    """Of a view, its pose free: the matrix of squares of corrections, displacements of
    the board and residuals, in this order; and how many coordinates are free."""
    off, solid = score.residuals_px[right], board_points(view.points[right], shape)
    places, T = view.pixels[right] - off, score.T_camera_grid
    by_point = pixels_by_point(camera, places, transform(T, solid)) @ T[:3, :3]
    by_moves = np.einsum("kab,kbm->kam", by_point, moves[right])
    corrected = polynomials(places, camera) @ mixing
    rows = np.concatenate([corrected, by_moves, off[..., None]], axis=2)
    rows = rows.reshape(off.size, rows.shape[2])
    of_pose, _ = np.linalg.qr(pose_jacobian(camera, places, solid, T))
    rows = rows - of_pose @ (of_pose.T @ rows)
    return rows.T @ rows, max(off.size - of_pose.shape[1], 0)


def _right(scores):
    """(n, K) bool: corners that count. One that is far off counts where it is so in
    most photographs: then it is the board's, and no finder's mistake."""
    distances = np.linalg.norm([score.residuals_px for score in scores], axis=2)
    widest = WIDTH * max(np.nanmedian(distances) / RAYLEIGH, LEAST_SD_PX)
    found, far = np.isfinite(distances), distances > widest
    shared = far.sum(axis=0) > found.sum(axis=0) / 2
    return found & (~far | shared)


def _without_first(squares, count):
    """(share, squares left (n, ., .)): of views' squares, with the first `count` taken
    from the others as all views together ask; share (M, count): of the displacements,
    what these take of each, with the sign of the change that the others bring."""
    whole = squares.sum(axis=0)
    taken = whole[count:, :count] @ np.linalg.pinv(
        whole[:count, :count], hermitian=True
    )
    rest = np.hstack([-taken, np.eye(len(whole) - count)])
    return taken[:-1], rest @ squares @ rest.T


def _scatter(left, free):
    """Variance of a coordinate: of what all displacements leave."""
    root, _ = inverse_root(left[:-1, :-1])
    squares = left[-1, -1] - np.sum((root.T @ left[:-1, -1]) ** 2)
    return max(squares / max(free - root.shape[1], 1), LEAST_SD_PX**2)


def _tested(normal, right, variance):
    """(p-value, variance with what photographs differ by) of displacements, by the
    equations (n, M, M) and (n, M) of each photograph."""
    from scipy.stats import f as fisher

    differ = apart(normal, right)
    variance = max(differ.variance, variance)
    root, _ = inverse_root(normal.sum(axis=0))
    ratio = np.mean((root.T @ right.sum(axis=0)) ** 2) / variance
    freedom = differ.several, (len(right) - 1) * differ.several
    return float(fisher.sf(ratio, *freedom)), float(variance)


def _estimated(normal, right, groups):
    """Mean (M,) and covariance (M, M) of displacements, those of other groups being 0;
    the prior of each is as wide as its squares show."""
    mean, covariance = np.zeros(len(normal)), np.zeros(normal.shape)
    if not groups:
        return mean, covariance
    prior = np.zeros(len(normal))
    for own, _, variance in groups:
        block, asked = normal[np.ix_(own, own)], right[own]
        shown = asked @ asked - variance * np.trace(block)
        prior[own] = max(shown, 0.0) / np.sum(block**2)
    variance = max(group.variance for group in groups)
    on = prior > 0
    inside = np.ix_(on, on)
    covariance[inside] = np.linalg.inv(
        normal[inside] / variance + np.diag(1 / prior[on])
    )
    mean[on] = covariance[inside] @ right[on] / variance
    return mean, covariance
