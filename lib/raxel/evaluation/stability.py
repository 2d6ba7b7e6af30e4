"""Do halves of the photographs tell of the same camera?

A board of the wrong length, pictures of two cameras, a shutter that rolls: a camera and
the boards' poses take in most of what these do, and the residuals hardly grow. But
what is taken in hangs on which photographs there were. So these are divided, in several
ways, and each half corrects the camera by a field of its own over the image: all
polynomials of third degree in the pixel's place, its boards' poses fitted with them.
The two fields should differ by what the scatter of the corners allows.

Corners of one photograph may err together, by blur, by light, by what a lens formula
leaves undone. Then halves differ by more than scatter says, and no fault need lie
between them. So what they differ by is held against how far photographs of the same
half do, whatever moves them: halves tell of different cameras where they lie beyond
that. And where photographs differ from each other by more than twice what scatter
explains, whichever way they are divided, that is said, too: a shutter does so where
boards moved differently in each, and no mean of them is known to be right.

Photographs of two cameras may be mixed in a way that no such division comes near. So
how far apart the focal lengths lie that photographs ask for is held against how far
they differ in all else (`raxel.evaluation.one_way`). And one photograph may differ from
all others: a picture that was cropped or turned, say (`raxel.evaluation.odd_one`).

A step of least squares from the fitted camera is each half's fit: no camera is fitted
anew, so this asks little time, serves formulas and smooth rays alike (of OpenCV's fit
nobody states a covariance), and holds where pupils move, at the distances of the
boards. What a common rotation of all rays does is no disagreement, and what the halves
do not determine is not compared. Where the corners were not found by one of the halves
nothing is said in px. A table of rays has errors of its own, which change from pixel to
pixel and which no corner's scatter holds. Photographs of one half differ by them as
those of two do; so its halves are compared, but how far photographs differ from each
other is no fault of theirs, and is not judged.

Which faults show in which division: boards stretched along one side, where they are
turned or tilted another way; a camera that changed, in the order of the photographs; a
shutter, where boards were at other distances or moved another way. A stretch that is
the same for boards all turned and tilted alike, or a shutter that does the same to all
of them, makes all halves wrong alike, and no division shows it.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.views.board_shape import board_points
from raxel.calibration.views.near_copies import once_each
from raxel.evaluation.apart import apart
from raxel.evaluation.beyond_boards import BeyondBoards, beyond_boards
from raxel.evaluation.corrections import (
    correction_fields,
    polynomials,
    seen_on,
    with_radial_terms,
    without_turns,
)
from raxel.evaluation.odd_one import odd_one
from raxel.evaluation.one_way import OneWay, one_way
from raxel.evaluation.pixel_pose import pose_jacobian
from raxel.evaluation.ways_to_divide import ways_to_divide

# p-value, times the number of divisions, below which halves disagree. It takes corners
# that err together to do so alike in all ways; as they do not, those that share as much
# as each errs for itself show less than 1e-3 in one set of forty, 1e-4 in one of a
# hundred.
SURE, SURE_FOCAL, SURE_ODD = 1e-5, 1e-4, 1e-5
LEAST_PX, TIMES = 0.1, 1.5  # disagreement that matters: at least, and beyond scatter
# Times scatter by which photographs differ from each other: more than corners do that
# share as much with their neighbours as each errs for itself (2.8 at most). And what it
# does to rays of halves, half of which it does to those of all.
ERRATIC, ERRATIC_PX = 2.8, 0.5
FEWEST_BOARDS = 6  # three a half
FEWEST_PIXELS = 6  # that both halves saw
UNKNOWN_PX = 2.0  # SD, RMS over the image, from which on a correction is not compared
WIDTH, RAYLEIGH = 6.0, 1.1774  # of wrong corners; median distance at unit scale
LEAST_SD_PX = 0.01  # of a coordinate: no corner is known better


class Division(NamedTuple):
    """Two halves of the boards, and how far they disagree.

    name: by what they were divided; halves: (names, names) of the boards;
    disagreement_px: RMS distance between where the halves see the same ray, after the
    best rotation, over the part of the image in which both saw boards; scatter_px: what
    the scatter of single corners leads one to expect of that; allowed_px: that with
    what photographs of one half differ by; p_value: how often halves of such
    photographs differ as much as these, over the whole image; field (N, 2) px: of the
    second half less the first, NaN where not both saw boards.
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
        """How many times as far apart as one has to expect."""
        return self.disagreement_px / self.allowed_px

    @property
    def matters(self):
        """Whether the halves are so far apart that it is worth a word."""
        return self.times > TIMES and self.disagreement_px > LEAST_PX

    @property
    def erratic(self):
        """Whether they are so far apart for corners that err for themselves."""
        least = max(TIMES * self.scatter_px, ERRATIC_PX)
        return self.disagreement_px > least


class OddPhotograph(NamedTuple):
    """One that tells of another camera than all others do. name: its view's; times: how
    many times as far it lies from them as they lie from each other; p_value: of that,
    of as many as there are; rays_px: RMS by which it moves the rays of all, after the
    best rotation, where boards were seen."""

    name: str
    times: float
    p_value: float
    rays_px: float


class Stability(NamedTuple):
    """divisions: list of Division by p-value, first the one of least p-value of those
    that matter; where there is none, the one most times as far apart as expected.

    pixels (N, 2): of their fields; p_value: of the first, times how many there are;
    same_camera: whether no division matters with a p-value so small; factor: how many
    times as far as scatter explains photographs differ from each other, 1 or more;
    steady: whether that is less than ERRATIC, or shows in no division by ERRATIC_PX, or
    is that of a table; focal: OneWay, by how much each photograph asks for a focal
    length of its own, relative; None where too few tell, and of a table; odd:
    OddPhotograph, None where there is none, and of a table; beyond: BeyondBoards, what
    all photographs say of rays where no board was, None of a table, which has none."""

    divisions: list
    pixels: np.ndarray
    p_value: float
    same_camera: bool
    factor: float
    steady: bool
    focal: OneWay | None = None
    odd: OddPhotograph | None = None
    beyond: BeyondBoards | None = None

    @property
    def one_focal(self):
        """Whether photographs are of one focal length, as far as can be told."""
        return self.focal is None or self.focal.p_value > SURE_FOCAL

    @property
    def stable(self):
        """Whether nothing is to be said."""
        fine = self.same_camera and self.steady and self.one_focal
        return fine and self.odd is None


class _Systems(NamedTuple):
    """What n boards, each with its pose free, say of the corrections: normal (n, K, K),
    right (n, K); squares, free: of what the poses leave, and coordinates less poses, of
    all together."""

    normal: np.ndarray
    right: np.ndarray
    squares: float
    free: int


def stability(camera, scores, views, shape=None):
    """Stability of a camera on the views it was fitted to; scores: their ImageScores;
    shape: the board's BoardShape, None for one that is as stated.

    None where it cannot be told: fewer than six boards, or halves that never saw the
    same part of the image.
    """
    pairs = [
        (score, view)
        for score, view in zip(scores, views, strict=True)
        if np.isfinite(score.rms_px)
    ]
    pairs = once_each(pairs)
    if len(pairs) < FEWEST_BOARDS:
        return None
    fields = correction_fields(camera, pairs)
    if fields is None:
        return None
    distances = np.linalg.norm(
        np.concatenate([score.residuals_px for score, _ in pairs]), axis=1
    )
    widest = WIDTH * max(np.nanmedian(distances) / RAYLEIGH, LEAST_SD_PX)
    boards = _systems(camera, pairs, shape, fields.mixing, widest)
    variance = _scatter(boards)
    seen = np.array([seen_on(view, camera, fields.pixels) for _, view in pairs])
    names = np.array([view.name for _, view in pairs], object)
    divisions = []
    for name, first in ways_to_divide(pairs):
        both = seen[first].any(axis=0) & seen[~first].any(axis=0)
        found = _compared(boards, first, fields, both, variance)
        if found is not None:
            halves = tuple(names[first]), tuple(names[~first])
            divisions.append(Division(name, halves, *found))
    if not divisions:
        return None
    factor, _ = _apart(boards, [np.ones(len(pairs), bool)], variance)
    table = camera.kind == "general"
    found = _judged(divisions, fields.pixels, factor, table)
    if table:
        return found
    equations = boards.normal, boards.right
    focal = one_way(*equations, _longer(fields, camera), variance)
    odd = _odd(equations, fields, seen.any(axis=0), variance, names)
    beyond = _beyond(camera, pairs, shape, widest, variance * factor**2)
    return found._replace(focal=focal, odd=odd, beyond=beyond)


def _beyond(camera, pairs, shape, widest, variance):
    """The BeyondBoards of all boards; variance: of a coordinate, with all that moves
    the corners of a photograph."""
    fields = correction_fields(camera, pairs, with_radial_terms)
    if fields is None:
        return None
    boards = _systems(camera, pairs, shape, fields.mixing, widest, with_radial_terms)
    covariance = variance * np.linalg.pinv(boards.normal.sum(axis=0), hermitian=True)
    views = [view for _, view in pairs]
    seen = np.any([seen_on(view, camera, fields.pixels) for view in views], axis=0)
    return beyond_boards(fields, covariance, views, seen)


def _odd(equations, fields, seen, variance, names):
    """The OddPhotograph of boards, None where none is; seen (N,) bool: the pixels of
    the fields where boards were seen."""
    found = odd_one(*equations, variance)
    if found is None or found.p_value > SURE_ODD:
        return None
    shapes = without_turns(fields.turns[seen], fields.shapes[seen])
    moved = np.sqrt(np.mean(np.sum((shapes @ found.change) ** 2, axis=1)))
    by_chance = np.einsum("nak,kl,nal->n", shapes, found.spread, shapes, optimize=True)
    if moved < max(LEAST_PX, TIMES * np.sqrt(variance * np.mean(by_chance))):
        return None
    name = names[found.index]
    return OddPhotograph(name, found.times, found.p_value, float(moved))


def _judged(divisions, pixels, factor, table):
    """The Stability of what was found; table: whether photographs differ by the errors
    of single rays, too."""
    limit = SURE / len(divisions)
    apart = [each for each in divisions if each.matters and each.p_value < limit]
    if apart:
        worst = min(apart, key=lambda each: each.p_value)
    else:
        worst = max(divisions, key=lambda each: each.times)
    divisions = sorted(divisions, key=lambda each: (each is not worst, each.p_value))
    p_value = min(1.0, len(divisions) * worst.p_value)
    erratic = factor > ERRATIC and any(each.erratic for each in divisions)
    steady = table or not erratic
    return Stability(divisions, pixels, p_value, not apart, factor, steady)


# ---------------------------------------------------------------------- the corrections


def _systems(camera, pairs, shape, mixing, widest, terms=polynomials):
    """The _Systems of views, of corners no more than `widest` px off."""
    normal, right, squares, free = [], [], 0.0, 0
    for score, view in pairs:
        off = score.residuals_px
        near = np.linalg.norm(off, axis=1) <= widest
        off = off[near]
        places, solid = view.pixels[near] - off, board_points(view.points[near], shape)
        by_pose = pose_jacobian(camera, places, solid, score.T_camera_grid)
        shapes = (terms(places, camera) @ mixing).reshape(off.size, mixing.shape[1])
        of_pose, _ = np.linalg.qr(by_pose)
        shapes = shapes - of_pose @ (of_pose.T @ shapes)
        off = off.ravel() - of_pose @ (of_pose.T @ off.ravel())
        normal.append(shapes.T @ shapes)
        right.append(shapes.T @ off)
        squares += float(off @ off)
        free += max(len(off) - by_pose.shape[1], 0)
    return _Systems(np.array(normal), np.array(right), squares, free)


def _scatter(boards):
    """Variance of a coordinate: of what poses and one correction by all boards leave.
    So what the camera does to all boards alike, of which no half tells, does not count
    as scatter."""
    normal, right = boards.normal.sum(axis=0), boards.right.sum(axis=0)
    taken = right @ np.linalg.pinv(normal, hermitian=True) @ right
    free = max(boards.free - len(right), 1)
    return max((boards.squares - taken) / free, LEAST_SD_PX**2)


def _apart(boards, parts, variance):
    """(factor, freedom): how many times as far as scatter explains boards lie from what
    their part, of those given as (n,) bool, says together, 1 or more; and how many
    independent squares that is told by."""
    found = [apart(boards.normal[part], boards.right[part]) for part in parts]
    whole = sum(found[1:], found[0])
    factor = np.sqrt(max(whole.variance / variance, 1.0))
    return float(factor), (len(boards.right) - len(parts)) * whole.several


# ------------------------------------------------------------------------ the divisions


def _longer(fields, camera):
    """The correction (K,) of a camera whose focal length grows, by 1 for all of it."""
    middle = (np.array([camera.width, camera.height]) - 1) / 2
    longer = without_turns(fields.turns, (fields.pixels - middle)[..., None])
    return np.linalg.lstsq(fields.shapes.reshape(longer.size, -1), longer.ravel())[0]


def _compared(boards, first, fields, both, variance):
    """(disagreement_px, scatter_px, allowed_px, p_value, field) of the boards that are
    the first half, (n,) bool, and the others; both (N,) bool: where both saw boards.
    None where that is nowhere."""
    from scipy.stats import f as fisher

    normal, right = boards.normal[first].sum(axis=0), boards.right[first].sum(axis=0)
    # What one half says beyond what both together say, and its covariance.
    share = normal @ np.linalg.pinv(boards.normal.sum(axis=0), hermitian=True)
    beyond = right - share @ boards.right.sum(axis=0)
    size, axes = np.linalg.eigh(normal - share @ normal)
    told = size > variance / UNKNOWN_PX**2
    if not told.any() or np.count_nonzero(both) < FEWEST_PIXELS:
        return None
    size, axes = size[told], axes[:, told]
    along = axes.T @ beyond
    factor, freedom = _apart(boards, (first, ~first), variance)
    ratio = np.mean(along**2 / size) / (variance * factor**2)
    p_value = fisher.sf(ratio, len(size), freedom)
    shapes = without_turns(fields.turns[both], fields.shapes[both] @ axes)
    field = np.full(fields.pixels.shape, np.nan)
    field[both] = -shapes @ (along / size)
    disagreement = np.sqrt(np.mean(np.sum(field[both] ** 2, axis=1)))
    squares = np.mean(np.sum(shapes**2, axis=1), axis=0)
    scatter = float(np.sqrt(variance * np.sum(squares / size)))
    return float(disagreement), scatter, factor * scatter, float(p_value), field
