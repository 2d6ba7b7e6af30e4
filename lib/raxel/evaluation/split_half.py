"""Split-half test of a calibration: do halves of the images give the same camera?

A board of the wrong length, images of two cameras, a rolling shutter: a camera and the
boards' poses absorb most of these, and the residuals hardly grow. But what is absorbed
depends on the images. So these are divided, in several ways, and each half corrects
the camera by a field of its own over the image: all polynomials of third degree in the
pixel's position, its boards' poses fitted with them. The two fields should differ by
what the scatter of the corners allows.

Corners of one image may err together, by blur, by light, by what a lens formula does
not model. Then halves differ by more than scatter without a fault between them. So
their difference is compared with how far images of the same half differ, whatever
moves them: halves give different cameras where they differ by more than that. Where
images differ from each other by more than MAX_FACTOR times what scatter explains,
whichever way they are divided, that is reported, too: a rolling shutter does so where
boards moved differently in each, and no mean of them is known to be right.

One image may differ from all others: cropped, rotated or mirrored, say. Then it is one
part of a division, and all others are the second. And images of two cameras may be
mixed in a way that no such division approaches (`raxel.evaluation.misfit`).

A step of least squares from the fitted camera is each half's fit: no camera is fitted
again, so this takes little time, is the same for formulas and smooth rays (OpenCV's fit
has no covariance), and holds where pupils move, at the distances of the boards. What a
common rotation of all rays does is no disagreement, and what the halves do not
determine is not compared. A table of rays has errors of its own, which change from
pixel to pixel and which no corner's scatter contains. Images of one half differ by them
as those of two do; so its halves are compared, but how far images differ from each
other is no fault of theirs, and is not judged.

Which faults show in which division: boards stretched along one side, where they are
rotated or tilted another way; a camera that changed, in the order of the images; a
rolling shutter, where boards were at other distances or moved another way. A stretch
that is the same for boards all oriented alike, or a shutter that does the same to all
of them, makes all halves wrong alike, and no division shows it.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc

from raxel.evaluation.coverage import BeyondBoards, beyond_boards
from raxel.evaluation.distortion import (
    MIN_N_BOARDS,
    image_equations,
    near_corners,
    scored_pairs,
    within_groups,
)
from raxel.evaluation.misfit import (
    FocalLengths,
    correction_fields,
    focal_lengths,
    rms_moved,
    seen_on,
    with_radial_terms,
    without_turns,
)
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import rotate, transform

# p-value, times the number of divisions, below which halves disagree. It assumes that
# correlated errors of corners have the same size in all directions. As they do not,
# sets with shared errors as large as the independent ones have p < 1e-3 in one of
# forty, p < 1e-4 in one of a hundred.
P_THRESHOLD, FOCAL_P_THRESHOLD, OUTLIER_P_THRESHOLD = 1e-5, 1e-4, 1e-5
MIN_DIFFERENCE_PX, MIN_RATIO = 0.1, 1.5  # of a relevant disagreement
# Ratio of the differences between images to scatter: above that of corners with shared
# errors as large as their independent ones (at most 2.8). And the resulting difference
# between the rays of halves, twice that of the rays of all.
MAX_FACTOR, MAX_FACTOR_PX = 2.8, 0.5
MIN_N_PIXELS = 6  # inside boards of both halves
UNKNOWN_SD_PX = 2.0  # SD, RMS over the image, above which a correction is not compared


class Division(NamedTuple):
    """Two halves of the boards, and how far they disagree.

    name: by what they were divided; halves: (names, names) of the boards;
    disagreement_px: RMS distance between where the halves see the same ray, after the
    best rotation, over the part of the image in which both saw boards; scatter_px: what
    the scatter of single corners leads one to expect of that; allowed_px: that with
    what images of one half differ by; p_value: how often halves of such images differ
    as much as these, over the whole image; field (N, 2) px: of the second half less the
    first, NaN where not both saw boards.
    """

    name: str
    halves: tuple
    disagreement_px: float
    scatter_px: float
    allowed_px: float
    p_value: float
    field: np.ndarray

    @property
    def times(self):
        """Ratio of the disagreement to the expected one."""
        return self.disagreement_px / self.allowed_px

    def fields(self):
        """The division for JSON."""
        keys = "disagreement_px", "scatter_px", "allowed_px", "p_value"
        return {"divided_by": self.name} | {key: getattr(self, key) for key in keys}


class OutlierImage(NamedTuple):
    """An image that gives another camera than all others. name: its view's; times: how
    many times as far as it lies from them as they lie from each other; p_value: of
    that, times the number of images; rays_px: RMS by which it moves the rays of all,
    after the best rotation, where boards were seen."""

    name: str
    times: float
    p_value: float
    rays_px: float


class SplitHalf(NamedTuple):
    """divisions: list of Division by p-value, first the one of least p-value of those
    that are significant; without any, the one with the largest ratio to expectation.

    pixels (N, 2): of their fields; p_value: of the first, times how many there are;
    same_camera: whether no division is significant; factor: ratio of the differences
    between images to their scatter, 1 or more; steady: whether that is less than
    MAX_FACTOR, or less than MAX_FACTOR_PX in all divisions, or that of a table. focal,
    outlier, beyond, deviation: None for a table, and where not determined; deviation
    (P, P): covariance of `with_radial_terms` by which the lens may depart from the fit.
    """

    divisions: list
    pixels: np.ndarray
    p_value: float
    same_camera: bool
    factor: float
    steady: bool
    focal: FocalLengths | None = None
    outlier: OutlierImage | None = None
    beyond: BeyondBoards | None = None
    deviation: np.ndarray | None = None

    @property
    def one_focal(self):
        """Whether images agree on one focal length."""
        return self.focal is None or self.focal.p_value > FOCAL_P_THRESHOLD

    @property
    def stable(self):
        """Whether there is nothing to report."""
        fine = self.same_camera and self.steady and self.one_focal
        return fine and self.outlier is None

    def fields(self):
        """The test for JSON."""
        worst = self.divisions[0]
        return worst.fields() | {
            "stable": self.stable,
            "same_camera": self.same_camera,
            "p_value": self.p_value,
            "photographs_over_scatter": self.factor,
            "focal_lengths": self.focal and self.focal._asdict(),
            "odd_one": self.outlier and self.outlier._asdict(),
            "halves": [list(names) for names in worst.halves],
            "divisions": [each.fields() for each in self.divisions],
        }


def split_half(camera, scores, views, shape=None):
    """SplitHalf of a camera on the views it was fitted to; scores: their ImageScores;
    shape: the board's BoardShape, None for one that is as stated.

    None where it cannot be tested: fewer than six boards, or halves that never saw the
    same part of the image.
    """
    pairs = scored_pairs(scores, views)
    if len(pairs) < MIN_N_BOARDS:
        return None
    fields = correction_fields(camera, pairs)
    if fields is None:
        return None
    of_boards = camera, pairs, shape, near_corners(pairs)
    normal, right, variance, _ = image_equations(*of_boards, fields)
    seen = np.array([seen_on(view, camera, fields.pixels) for _, view in pairs])
    names = np.array([view.name for _, view in pairs], object)
    divisions = []
    for name, first in halves_of(pairs):
        both = seen[first].any(axis=0) & seen[~first].any(axis=0)
        difference = _difference(normal, right, first, variance)
        if difference and np.count_nonzero(both) >= MIN_N_PIXELS:
            halves = tuple(names[first]), tuple(names[~first])
            found = _disagreement(*difference, fields, both, variance)
            divisions.append(Division(name, halves, *found))
    if not divisions:
        return None
    within, _ = within_groups(normal, right, [np.ones(len(pairs), bool)])
    within = max(within, variance)
    factor, table = float(np.sqrt(within / variance)), camera.kind == "general"
    found = _judged(divisions, fields.pixels, factor, table)
    if table:
        return found
    seen = seen.any(axis=0)
    longer = _longer(fields, camera)
    focal = focal_lengths(normal, right, longer, variance, names)
    if focal:
        moved = rms_moved(fields, seen, focal.sd * longer)
        focal = focal._replace(rays_px=moved)
    outlier = _outlier(normal, right, fields, seen, variance, names)
    beyond = deviation = None
    fields = correction_fields(camera, pairs, with_radial_terms)
    if fields is not None:
        normal, *_ = image_equations(*of_boards, fields)
        covariance = within * np.linalg.pinv(normal.sum(axis=0), hermitian=True)
        errors = camera.pixel_covariance(fields.pixels)
        own = np.sqrt(np.trace(errors, axis1=1, axis2=2))
        views = [view for _, view in pairs]
        beyond = beyond_boards(fields, covariance, views, seen, own)
        deviation = fields.mixing @ covariance @ fields.mixing.T
    return found._replace(
        focal=focal, outlier=outlier, beyond=beyond, deviation=deviation
    )


def halves_of(pairs):
    """Yields (by what boards are divided, (n,) bool: which are the first half).

    By their order, and by where the board was and how it was oriented: by nothing that
    depends on the errors of corners, so halves of a sound set differ by chance only.
    pairs: [(ImageScore, BoardView), ...], whose poses are known.
    """
    n = len(pairs)
    T = np.array([score.T_camera_grid for score, _ in pairs])
    middles = np.array([np.nanmean(view.pixels, axis=0) for _, view in pairs])
    centres = np.array([view.points.mean(axis=0) for _, view in pairs])
    at = transform(T, on_plane(centres)[:, None])[:, 0]
    distance = np.linalg.norm(at, axis=1)
    # The direction to the camera in the board's own frame.
    x, y, _ = rotate(np.swapaxes(T, 1, 2), at[:, None])[:, 0].T / distance
    along, normal = T[:, :3, 0], T[:, :3, 2]
    yield "order of the images", np.arange(n) < n // 2
    yield "every other image", np.arange(n) % 2 == 0
    for name, values in (
        ("left and right in the image", middles[:, 0]),
        ("top and bottom in the image", middles[:, 1]),
        ("near and far", distance),
        ("tilted much and little", np.hypot(x, y)),
        ("tilted about one side of the board and the other", np.abs(x) - np.abs(y)),
        ("tilted about one diagonal of the board and the other", x * y),
        ("turned in the image", np.abs(along[:, 1]) - np.abs(along[:, 0])),
        ("leaning to the left and to the right", normal[:, 0]),
        ("leaning up and down", normal[:, 1]),
    ):
        yield name, np.argsort(np.argsort(values, kind="stable")) < n // 2


def _difference(normal, right, first, variance):
    """(root (K, L), x (L,), within, p_value) of the images of which (n,) bool are the
    first part, and the others; None where they determine nothing in common.

    The correction of the first less that of the others is root x, in L directions that
    both determine, and x scatters as a coordinate; within: variance of a coordinate
    that explains how images of one part differ; p_value: of x.
    """
    own = normal[first].sum(axis=0)
    share = own @ np.linalg.pinv(normal.sum(axis=0), hermitian=True)
    excess = right[first].sum(axis=0) - share @ right.sum(axis=0)
    size, axes = np.linalg.eigh(own - share @ own)
    known = size > variance / UNKNOWN_SD_PX**2
    if not known.any():
        return None
    root = axes[:, known] / np.sqrt(size[known])
    x = root.T @ excess
    within, freedom = within_groups(normal, right, [first, ~first])
    within = max(within, variance)
    p_value = fdtrc(len(x), freedom, np.mean(x**2) / within)
    return root, x, within, float(p_value)


def _disagreement(root, x, within, p_value, fields, both, variance):
    """(disagreement_px, scatter_px, allowed_px, p_value, field) of a difference; both
    (N,) bool: where both halves saw boards."""
    shapes = without_turns(fields.turns[both], fields.shapes[both] @ root)
    field = np.full(fields.pixels.shape, np.nan)
    field[both] = -shapes @ x
    size = np.sqrt(np.mean(np.sum(field[both] ** 2, axis=1)))
    spread = np.sqrt(np.mean(np.sum(shapes**2, axis=(1, 2))))
    scatter, allowed = np.sqrt(variance) * spread, np.sqrt(within) * spread
    return float(size), float(scatter), float(allowed), p_value, field


def _judged(divisions, pixels, factor, table):
    """The SplitHalf of divisions; table: whether images differ by the errors of single
    rays, too."""
    limit = P_THRESHOLD / len(divisions)
    significant = [
        each
        for each in divisions
        if each.p_value < limit
        and each.times > MIN_RATIO
        and each.disagreement_px > MIN_DIFFERENCE_PX
    ]
    if significant:
        worst = min(significant, key=lambda each: each.p_value)
    else:
        worst = max(divisions, key=lambda each: each.times)
    divisions = sorted(divisions, key=lambda each: (each is not worst, each.p_value))
    p_value = min(1.0, len(divisions) * worst.p_value)
    erratic = factor > MAX_FACTOR and any(
        each.disagreement_px > max(MIN_RATIO * each.scatter_px, MAX_FACTOR_PX)
        for each in divisions
    )
    steady = table or not erratic
    return SplitHalf(divisions, pixels, p_value, not significant, factor, steady)


def _outlier(normal, right, fields, seen, variance, names):
    """The OutlierImage or None; seen (N,) bool: the pixels of the fields inside
    boards."""
    alone = np.eye(len(names), dtype=bool)
    found = [_difference(normal, right, first, variance) for first in alone]
    p_values = [each[-1] if each else 1.0 for each in found]
    worst = int(np.argmin(p_values))
    p_value = len(names) * p_values[worst]
    if p_value > OUTLIER_P_THRESHOLD:
        return None
    root, x, within, _ = found[worst]
    share = np.linalg.pinv(normal.sum(axis=0), hermitian=True) @ normal[worst]
    moved = rms_moved(fields, seen, share @ root @ x)
    if moved < MIN_DIFFERENCE_PX:
        return None
    times = float(np.sqrt(np.mean(x**2) / within))
    return OutlierImage(names[worst], times, p_value, moved)


def _longer(fields, camera):
    """The correction (K,) of a camera whose focal length grows, by 1 for all of it."""
    middle = (np.array([camera.width, camera.height]) - 1) / 2
    longer = without_turns(fields.turns, (fields.pixels - middle)[..., None])
    return np.linalg.lstsq(fields.shapes.reshape(longer.size, -1), longer.ravel())[0]
