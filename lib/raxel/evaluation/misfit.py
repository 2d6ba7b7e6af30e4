"""Test whether a camera fits its boards as well as their corners allow.

Noise moves every corner independently. A model misfit moves neighbours alike: another
lens projection, rays that miss the centre, a rolling shutter, boards of two cameras.
Therefore the second differences of the residuals along rows and columns of the lattice
show the scatter of single corners, whatever detector found them, and the excess of the
residuals is not the noise of the corners. The standard deviation that a detector
predicts is less informative: it includes the noise of the image, but not the print.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc

from raxel.evaluation.diagnoses import known
from raxel.evaluation.distortion import pixels_by_point, within_groups
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import cross_matrix, transform

# Residuals above this multiple of the scatter, with this excess, are a misfit. Boards
# that are not quite flat, and bent cells, reach 1.8 times; noise alone, 1.
MAX_SCATTER_RATIO = 2.2
MIN_EXCESS_PX = 0.25
# So are residuals this large, where they vary too fast to separate them from scatter.
MAX_RMS_PX = 3.0
MAX_SD_RATIO = 10.0
OUTLIER_RATIO = 2.5  # to the residuals of the next board, of outlier boards
# And where the total is not too large: to the median of all boards' residuals, with a
# minimum number of corners. If some scatter twice as much as others it is at most 2.2.
OUTLIER_MEDIAN_RATIO, OUTLIER_N_CORNERS = 3.0, 12
# The share of a second difference's variance: 1 + 4 + 1.
SECOND_DIFFERENCE = np.array([1.0, -2.0, 1.0]) / np.sqrt(6)


class Misfit(NamedTuple):
    """Residuals compared with the scatter of single corners.

    rms_px: of the residuals; scatter_px: RMS distance by which corners move on their
    own, NaN where no three neighbours are scored; sd_px: as the detector states it, the
    same kind of number, NaN where it states none; large: whether the residuals are more
    than the corners explain; odd_boards: names of the boards that make them so, or of
    one whose own are far larger than those of the others, the worst first.
    """

    rms_px: float
    scatter_px: float
    sd_px: float
    large: bool
    odd_boards: tuple[str, ...] = ()

    @property
    def beyond_px(self):
        """RMS of what neighbouring corners share."""
        return float(np.sqrt(max(self.rms_px**2 - self.scatter_px**2, 0.0)))

    def fields(self):
        """The comparison for JSON."""
        return {
            "fits": not self.large,
            "rms_px": known(self.rms_px),
            "scatter_px": known(self.scatter_px),
            "stated_sd_px": known(self.sd_px),
            "odd_board": self.odd_boards[0] if self.odd_boards else None,
            "odd_boards": list(self.odd_boards),
        }


def misfit(scores, views):
    """Misfit of a camera on boards; scores: their ImageScores; views: as scored."""
    pairs = [
        (score, view)
        for score, view in zip(scores, views, strict=True)
        if np.isfinite(score.rms_px)
    ]
    found = _misfit(pairs)
    if len(pairs) < 3:
        return found
    pairs.sort(key=lambda pair: pair[0].rms_px, reverse=True)
    rms = np.array([score.rms_px for score, _ in pairs])
    # At most a third: of more, the others may be the wrong ones.
    ratios = rms[: len(rms) // 3] / rms[1 : len(rms) // 3 + 1]
    count = int(np.argmax(ratios > OUTLIER_RATIO)) + 1
    odd = ratios[count - 1] > OUTLIER_RATIO
    if found.large:
        # One bad board pulls the camera, and so the others, with it.
        odd = odd or not _misfit(pairs[1:]).large
    else:
        scored = np.isfinite(pairs[0][0].residuals_px[:, 0]).sum()
        odd = odd and count == 1 and scored >= OUTLIER_N_CORNERS
        odd = odd and rms[0] > max(OUTLIER_MEDIAN_RATIO * np.median(rms), MIN_EXCESS_PX)
    names = tuple(score.name for score, _ in pairs[:count])
    return found._replace(odd_boards=names) if odd else found


def _misfit(pairs):
    if not pairs:
        return Misfit(np.nan, np.nan, np.nan, False)
    rms = _rms(np.concatenate([score.residuals_px for score, _ in pairs]))
    scatter = _rms(np.concatenate([_differences(*pair) for pair in pairs]))
    sd = np.sqrt(2) * _rms(np.concatenate([_stated(view) for _, view in pairs]))
    found = Misfit(rms, scatter, sd, False)
    smooth = rms > MAX_SCATTER_RATIO * scatter and found.beyond_px > MIN_EXCESS_PX
    plain = rms > MAX_RMS_PX and not rms <= MAX_SD_RATIO * sd
    return found._replace(large=bool(smooth or plain))


def _differences(score, view):
    """Second differences (M, 2) of residuals, as long as single corners' errors are."""
    lattice = score.residuals_px.reshape(view.rows, view.columns, 2)
    along = [
        np.einsum("k,kijc->ijc", SECOND_DIFFERENCE, np.stack([a[:-2], a[1:-1], a[2:]]))
        for a in (lattice, np.swapaxes(lattice, 0, 1))
    ]
    return np.concatenate([a.reshape(-1, 2) for a in along])


def _stated(view):
    sd = [] if view.sd is None else view.sd
    return np.reshape(sd, (-1, 1))


def _rms(vectors):
    """Root mean square length of those vectors (N, k) that are finite; NaN of none."""
    squares = np.sum(np.asarray(vectors, float) ** 2, axis=1)
    squares = squares[np.isfinite(squares)]
    return float(np.sqrt(squares.mean())) if len(squares) else np.nan


# Corrections of a camera: fields of possible pixel errors over the image. They are all
# polynomials of third degree in the pixel coordinates, along u and along v, without the
# effect of a common rotation of all rays, which is no error of a camera.


DEGREE = 3
N_ACROSS = 24  # pixels along the longer side at which fields are compared


def polynomials(pixels, camera):
    """(N, 2, P): each polynomial along u, then each along v."""
    size = np.array([camera.width, camera.height])
    x, y = ((2 * pixels - (size - 1)) / size.max()).T
    along = np.stack(
        [x**a * y**b for a in range(DEGREE + 1) for b in range(DEGREE + 1 - a)], axis=1
    )
    none = np.zeros_like(along)
    return np.stack(
        [np.hstack([along, none]), np.hstack([none, along])], axis=1
    )  # fmt: skip


class CorrectionFields(NamedTuple):
    """pixels (N, 2) that have a ray; shapes (N, 2, K): corrections of 1 px RMS each,
    without rotations; turns (N, 2, 3): what rotations do; mixing (P, K): the shapes'
    `terms`."""

    pixels: np.ndarray
    shapes: np.ndarray
    turns: np.ndarray
    mixing: np.ndarray
    terms: Callable = polynomials


def with_radial_terms(pixels, camera):
    """(N, 2, P + 2): these, and radial fields of fifth and of seventh degree, by which
    a lens departs from a formula that has fewer terms."""
    size = np.array([camera.width, camera.height])
    places = (2 * pixels - (size - 1)) / size.max()
    squares = np.sum(places**2, axis=1, keepdims=True)
    radial = np.stack([places * squares**2, places * squares**3], axis=2)
    return np.concatenate([polynomials(pixels, camera), radial], axis=2)


def correction_fields(camera, pairs, terms=polynomials):
    """The CorrectionFields of a camera, mixed of `terms`, None where hardly a pixel has
    a ray."""
    step = max(camera.width, camera.height) / N_ACROSS
    u = np.arange(step / 2, camera.width, step)
    v = np.arange(step / 2, camera.height, step)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2) - 0.5
    middles = [
        transform(score.T_camera_grid, on_plane(view.points)).mean(axis=0)
        for score, view in pairs
    ]
    rays = camera.rays(pixels)
    points = rays.origins + np.median(np.linalg.norm(middles, axis=1)) * rays.directions
    turns = pixels_by_point(camera, pixels, points) @ -cross_matrix(points)
    known = rays.valid & np.isfinite(turns).all(axis=(1, 2)) & turns.any(axis=(1, 2))
    pixels, turns = pixels[known], turns[known]
    powers = terms(pixels, camera)
    count = powers.shape[2]
    if len(pixels) < count:
        return None
    rest = without_turns(turns, powers).reshape(-1, count)
    size, axes = np.linalg.eigh(rest.T @ rest)
    # Three of the polynomials are nearly what the rotations do.
    mixing = axes[:, 3:] * np.sqrt(len(pixels) / size[3:])
    shapes = rest @ mixing
    shapes = shapes.reshape(len(pixels), 2, -1)
    return CorrectionFields(pixels, shapes, turns, mixing, terms)


def without_turns(turns, fields, seen=slice(None)):
    """Fields (N, 2, K) less the rotation, of turns (N, 2, 3), that makes them smallest
    at the seen pixels."""
    basis, flat = turns[seen].reshape(-1, 3), fields[seen].reshape(-1, fields.shape[2])
    return fields - turns @ np.linalg.lstsq(basis, flat)[0]


def rms_moved(fields, seen, change):
    """RMS px by which a correction (K,) moves the rays of pixels, seen (N,) bool, after
    the best rotation."""
    moved = without_turns(fields.turns[seen], fields.shapes[seen]) @ change
    return float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))


def seen_on(view, camera, pixels):
    """Which of the pixels (N, 2) lie on a view's board: (N,) bool."""
    u, v = np.rint(pixels).astype(int).T
    return view.covered(camera.width, camera.height)[v, u] > 0


# Do images differ more in focal length than in everything else? A lens that
# refocuses, a zoom that drifts, two cameras mixed: each image, its pose free,
# requires a focal length of its own. Scatter of single corners does not limit the
# differences, as corners of one image err together. But what moves them together
# moves them in other directions as well. So the squares of what images require of
# this one correction, beyond the joint solution, are compared with those of all
# others, this one being free in each image: their ratio has Fisher's distribution, of
# as many squares as there are (`raxel.evaluation.distortion`), where all
# directions are moved alike. No two groups need be separable for that, which takes a
# difference of several standard deviations of each image; many that differ by one are
# enough. Of 24 drawn sets of 14 images whose corners scatter by 0.1 px, by two
# pinholes mixed at random, 21 are reported with p < 1e-4 where focal lengths differ
# by 1 %, 13 at 0.75 % and 3 at 0.5 %. A test with known and independent scatter of
# corners would report 24, 22 and 11: corners that may err together cost the rest. Of
# focal lengths that scatter by 0.3 % (SD) 6 of 24 such sets are reported, and 8 by
# that test.


SINGULAR_TOL = 1e-9  # of the largest eigenvalue: undetermined by the images


class FocalLengths(NamedTuple):
    """sd: relative, by which images differ in focal length beyond what explains how
    they differ otherwise, 0 where nothing is beyond; times: ratio of the differences to
    explained ones; p_value: of that; shorter, longer: names of the images of two groups
    that explain the differences best; rays_px: RMS by which the SD moves rays."""

    sd: float
    times: float
    p_value: float
    shorter: tuple
    longer: tuple
    rays_px: float = np.nan


def focal_lengths(normal, right, direction, variance, names):
    """FocalLengths of n images; None where fewer than four determine the correction.

    normal (n, K, K) and right (n, K): each image's equations for shared corrections;
    direction (K,): the one that may differ; variance: of scatter, the least that
    explains how images differ; names (n,): of the images.
    """
    inverse = np.linalg.pinv(normal.sum(axis=0), hermitian=True)
    to_all = normal @ direction
    own = to_all @ direction
    excess = (right - normal @ (inverse @ right.sum(axis=0))) @ direction
    size, axes = np.linalg.eigh(np.diag(own) - to_all @ inverse @ to_all.T)
    known = size > SINGULAR_TOL * size[-1]
    free = np.count_nonzero(known)
    if free < 3:
        return None
    # The others, with this correction free in each image.
    share = to_all / np.maximum(own, np.finfo(float).tiny)[:, None]
    others = normal - share[:, :, None] * to_all[:, None]
    rest = right - share * (right @ direction)[:, None]
    explained, freedom = within_groups(others, rest, [np.ones(len(own), bool)])
    explained = max(explained, variance)
    along = axes[:, known].T @ excess
    ratio = np.mean(along**2 / size[known]) / explained
    # By corrections b of their own the excess is its covariance times b.
    sd = np.sqrt(max(ratio - 1, 0.0) * explained * free / np.sum(size[known]))
    p_value = fdtrc(free, freedom, ratio)
    groups = (tuple(names[group]) for group in _two_groups(excess, own))
    return FocalLengths(float(sd), float(np.sqrt(ratio)), float(p_value), *groups)


def _two_groups(excess, own):
    """Indices of images of shorter and of longer focal length: of all divisions at a
    limit, the one with the largest sum of squares between the groups."""
    order = np.argsort(excess / np.maximum(own, np.finfo(float).tiny))
    weight = np.cumsum(own[order])[:-1]
    between = np.cumsum(excess[order])[:-1] ** 2 / (weight * (own.sum() - weight))
    return np.split(order, [np.argmax(between) + 1])
