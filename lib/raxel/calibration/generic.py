"""The standard generic method for central cameras, complete: Algorithm 1 (section 2.4).

Chessboards in any pose, no camera model: points by interpolation between corners (the
thesis's is "homographic", the default takes a smooth one where cells are bent) or as
pixels have read them from an active grid, centre and poses of three boards linearly,
bundle adjustment, the other boards one after the other by three-point pose on the rays
known so far, bundle adjustment over all, and a ray for every pixel that a board covers.

Nothing here knows the truth. Which three boards begin is decided by how well they
determine the centre (the margin of the linear stage), then by what they lead to: the
most boards that agree, with the smallest angles between rays and points.

Sources: thesis section 2.4; P. Sturm and S. Ramalingam, ECCV 2004,
doi:10.1007/978-3-540-24671-8_1.
"""

import itertools
from typing import NamedTuple

import numpy as np

from raxel.calibration.board_rays import ray_table
from raxel.calibration.board_samples import sample_boards
from raxel.calibration.bundle import (
    bundle_adjust_fixed_centre,
    ray_point_residuals,
)
from raxel.calibration.correspondence import check_view
from raxel.calibration.generic_linear import (
    LinearSolution,
    grid_pair,
    linear_as_printed,
    margin_of_pairs,
    normalising_similarity,
    solve_grid_pairs,
)
from raxel.calibration.interpolation import interpolated_view
from raxel.calibration.parallel_boards import refuse_parallel
from raxel.calibration.three_point import pose_from_rays
from raxel.cameras.general import GeneralCamera
from raxel.errors import CalibrationError
from raxel.geometry.poses import nearest_rotation, pose, transform

OBSERVATIONS = 30_000  # pixel-board pairs of the final adjustment
COARSE = 2  # while boards are chosen, every second sample each way will do
CLEAREST = 12  # boards that are tried with one base
FEWEST_COMMON = 40  # coarse samples that two boards must share to be compared
CANDIDATES = 3  # first triples tried, each with another base
POSED = 400  # samples a pose is found from
AGREES = 0.6  # share of those within THRESHOLD_PX for a board to be taken in
THRESHOLD_PX = 3.0


class GenericCalibration(NamedTuple):
    """The camera and how it came about.

    camera: GeneralCamera; its frame has the centre as origin, z close to the ray of
    mid-image and x along the image's u (as the rays of a plain fisheye fit best).
    centre (3,): in the base board's frame; T_base_grid (m, 4, 4) and T_camera_grid
    (m, 4, 4): poses of the boards in `used` (indices of views; the first three began,
    the very first is the base). left_out: {index: reason}. share_with_ray: share of the
    image's pixels. rms_deg: root mean square angle between rays and their points, of
    the rays that two or more of the used boards share, as adjusted.
    linear: the LinearSolution that it began with. interpolation: for each view,
    "homographic" or "smooth", as taken, or "none" where every pixel was read.
    """

    camera: GeneralCamera
    centre: np.ndarray
    T_base_grid: np.ndarray
    T_camera_grid: np.ndarray
    used: list
    left_out: dict
    share_with_ray: float
    rms_deg: float
    linear: LinearSolution
    interpolation: tuple


class _Start(NamedTuple):
    boards: tuple
    linear: LinearSolution


class _Growth(NamedTuple):
    """Boards taken in, their poses, ray directions of the samples, angles' RMS."""

    boards: list
    T_base_grid: np.ndarray
    directions: np.ndarray
    rms: float
    reasons: dict
    start: _Start


def calibrate_generic(
    views,
    width,
    height,
    *,
    rng,
    linear="well conditioned",
    units="mm",
    side=-1,
    interpolation="by need",
):
    """A general central camera from three or more overlapping views of a board.

    views: BoardViews or DenseViews; width, height: the image in px; rng: numpy
    Generator (RANSAC).
    linear: "well conditioned" or "as printed" (with t_z as corrected). units: of the
    board's points, "mm" or "pitch". side: sign of C_z in the base board's frame: -1 for
    corners ordered so that x turns clockwise into y in the image. interpolation:
    between corners, "homographic" as in the thesis, "smooth" or "by need" (for each
    board the one that errs less; see `raxel.calibration.interpolation`).

    Returns GenericCalibration. Raises CalibrationError, in one line, when fewer than
    three boards overlap enough, boards are parallel, or the linear stage fails on all;
    InputError for views whose counts do not fit.
    """
    if linear not in ("well conditioned", "as printed"):
        raise ValueError(f"linear: {linear!r}; 'well conditioned' or 'as printed'")
    views = [check_view(view) for view in views]
    if len(views) < 3:
        raise CalibrationError(
            f"generic calibration: boards to calibrate with: {len(views)}; three or"
            " more overlapping boards at different tilts are needed"
        )
    filled = [interpolated_view(view, interpolation) for view in views]
    views, chosen = zip(*filled, strict=True)
    samples = sample_boards(views, width, height, OBSERVATIONS)
    coarse = samples.thinned(COARSE)
    growths, failures = [], []
    for start in _starts(coarse, linear, side)[:CANDIDATES]:
        try:
            growths.append(_grown(coarse, start, rng))
        except CalibrationError as error:
            failures.append(str(error))
    if not growths:
        raise CalibrationError(f"generic calibration: {failures[0]}")
    best = max(growths, key=lambda g: (len(g.boards), -g.rms))
    refuse_parallel(best.T_base_grid[:, :3, :3], "generic calibration", needed=3)
    return _completed(views, width, height, units, samples, best, chosen)


# ------------------------------------------------------------- the first three boards


def _starts(samples, linear, side):
    """_Starts with different bases, the best determined first.

    Raises CalibrationError with the reason that stopped most when there is none.
    """
    pairs = _grid_pairs(samples)
    starts, failures = [], []
    for base in range(len(samples.points)):
        for boards in _ranked(pairs, base, failures)[:CLEAREST]:
            try:
                solution = _linear(samples, pairs, boards, linear, side)
            except CalibrationError as error:
                failures.append(str(error))
                continue
            starts.append(_Start(boards, solution))
            break
    if not starts and not failures:
        raise CalibrationError(
            "generic calibration: no board overlaps two others in the image; take more"
            " pictures whose boards share an area"
        )
    if not starts:
        reason = max(set(failures), key=lambda text: (failures.count(text), text))
        raise CalibrationError(f"generic calibration: no three boards begin: {reason}")
    return sorted(starts, key=lambda start: -start.linear.margin)


def _ranked(pairs, base, failures):
    """Triples (base, j, k), the best determined centre first."""
    others = sorted(
        (k for b, k in pairs if b == base), key=lambda k: pairs[base, k].noise
    )
    margins = {}
    for j, k in itertools.combinations(others[:CLEAREST], 2):
        try:
            margins[base, j, k] = margin_of_pairs([pairs[base, j], pairs[base, k]])
        except CalibrationError as error:
            failures.append(str(error))
    return sorted(margins, key=lambda boards: -margins[boards])


def _linear(samples, pairs, boards, variant, side):
    """LinearSolution of three boards; as printed, with the margin of the other."""
    base, j, k = boards
    solution = solve_grid_pairs([pairs[base, j], pairs[base, k]], side)
    if variant == "well conditioned":
        return solution
    common = samples.seen[list(boards)].all(axis=0)
    printed = linear_as_printed(
        *samples.points[list(boards)][:, common], side=side, tz="corrected"
    )
    return printed._replace(margin=solution.margin)


def _grid_pairs(samples):
    """{(base, other): GridPair} of all boards with enough common samples."""
    points, seen = samples.points, samples.seen
    similarities = [
        normalising_similarity(p[s]) if s.any() else None
        for p, s in zip(points, seen, strict=True)
    ]
    pairs = {}
    for a, b in itertools.permutations(range(len(points)), 2):
        both = seen[a] & seen[b]
        if np.count_nonzero(both) < FEWEST_COMMON:
            continue
        try:
            pairs[a, b] = grid_pair(
                points[a][both], points[b][both], similarities[a], similarities[b]
            )
        except CalibrationError:
            continue  # a strip of points: as good as no overlap
    return pairs


# ------------------------------------------------------------------ the other boards


def _grown(samples, start, rng):
    """_Growth from three boards to all that agree, most common rays first."""
    centre = start.linear.centre
    boards, poses = list(start.boards), start.linear.T_base_grid
    poses, directions, rms = _adjusted(samples, boards, centre, poses)
    waiting = [k for k in range(len(samples.points)) if k not in boards]
    reasons = {}
    while waiting:
        known = np.isfinite(directions[:, 0])
        waiting.sort(key=lambda k: -np.count_nonzero(samples.seen[k] & known))
        threshold = THRESHOLD_PX * _radians_per_px(samples, directions)
        for k in waiting:
            usable = samples.seen[k] & known
            T, reasons[k] = _posed(
                directions[usable], samples.points[k, usable], rng, threshold
            )
            if T is not None:
                break
        else:
            break
        waiting.remove(k)
        del reasons[k]
        T[:3, 3] += centre
        boards.append(k)
        poses = np.concatenate([poses, T[None]])
        poses, directions, rms = _adjusted(samples, boards, centre, poses)
    return _Growth(boards, poses, directions, rms, reasons, start)


def _posed(directions, points, rng, threshold):
    """Pose (4, 4) of one board from known rays, or None and the reason."""
    if len(points) < FEWEST_COMMON:
        return None, f"shares {len(points)} samples with the known rays; too few"
    picked = rng.permutation(len(points))[:POSED]
    try:
        found = pose_from_rays(
            directions[picked], points[picked], rng, threshold, metric="angle"
        )
    except CalibrationError as error:
        return None, str(error)
    share = np.mean(found.inliers)
    if share < AGREES:
        return None, (
            f"its pose agrees with {100 * share:.0f} % of the known rays to within"
            f" {THRESHOLD_PX:g} px; {100 * AGREES:.0f} % are needed"
        )
    return found.T_camera_grid.copy(), ""


def _adjusted(samples, boards, centre, poses, tolerance=1e-5):
    """Poses, directions (M, 3) and RMS angle after adjustment with the centre fixed."""
    points, seen = samples.points[boards], samples.seen[boards]
    poses, directions, _, _ = bundle_adjust_fixed_centre(
        points, seen, centre, poses, tolerance=tolerance
    )
    residuals = ray_point_residuals(points, seen, centre, poses, directions)
    lengths = np.linalg.norm(transform(poses, _flat(points)) - centre, axis=2)
    shared = seen & (np.sum(seen, axis=0) >= 2)
    sines = np.linalg.norm(residuals, axis=2)[shared] / lengths[shared]
    return poses, directions, float(np.sqrt(np.mean(sines**2)))


def _radians_per_px(samples, directions):
    """Median angle between rays of neighbouring samples, per pixel."""
    known = np.isfinite(directions[:, 0])
    pixels, rays = samples.pixels[known], directions[known]
    order = np.lexsort((pixels[:, 0], pixels[:, 1]))
    pixels, rays = pixels[order], rays[order]
    beside = np.all(np.diff(pixels, axis=0) == [samples.step, 0], axis=1)
    gaps = np.linalg.norm(rays[1:] - rays[:-1], axis=1)[beside]
    return np.median(gaps) / samples.step


def _flat(points):
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)


# -------------------------------------------------------------------------- the table


def _completed(views, width, height, units, samples, growth, chosen):
    """GenericCalibration from the boards chosen: final adjustment, table, frame."""
    centre, boards = growth.start.linear.centre, growth.boards
    poses, directions, rms = _adjusted(
        samples, boards, centre, growth.T_base_grid, tolerance=1e-9
    )
    table = ray_table([views[k] for k in boards], poses, centre, width, height)
    mask = np.isfinite(table[..., 0])
    rotation = _camera_axes(samples, directions, width, height)
    T_camera_base = pose(rotation, -rotation @ centre)
    camera = GeneralCamera(table @ rotation.T, mask, units=units)
    return GenericCalibration(
        camera,
        centre,
        poses,
        T_camera_base @ poses,
        boards,
        growth.reasons,
        float(np.mean(mask)),
        float(np.degrees(rms)),
        growth.start.linear,
        chosen,
    )


def _camera_axes(samples, directions, width, height):
    """Rotation camera from base: z mid-image, x along u, as far as the rays tell.

    The rotation that maps the known rays best to those of a plain fisheye whose angle
    per pixel is theirs.
    """
    known = np.isfinite(directions[:, 0])
    offset = samples.pixels[known] - np.array([width - 1, height - 1]) / 2
    radius = np.linalg.norm(offset, axis=1)
    angle = radius * _radians_per_px(samples, directions)
    across = offset / np.maximum(radius, 1e-12)[:, None] * np.sin(angle)[:, None]
    nominal = np.column_stack([across, np.cos(angle)])
    return nearest_rotation(nominal.T @ directions[known])
