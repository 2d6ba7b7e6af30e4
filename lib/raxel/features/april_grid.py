"""AprilTag grids of Kalibr: OpenCV detects the tags, this library localises corners.

Black squares touch the corners of the tags, so that a corner is a saddle of the grey
levels, as on a chessboard. Its window ends at the border of the code and at the next
tag.
"""

import cv2
import numpy as np

from raxel.features.charuco import (
    MIN_N_BEYOND,
    N_PIXELS,
    dictionary_of,
    find_markers,
    other_target,
    row_length,
    with_other_target,
)
from raxel.features.chessboard.corners import (
    FULL_EFFORT,
    asymmetry,
    squares_around,
    symmetry_shift,
)
from raxel.features.chessboard.grids import (
    MAX_ASYMMETRY,
    MAX_CORNER_SD_PX,
    MAX_LATTICE_MISFIT,
    MAX_SHARP_SD_PX,
    N_DENSE_SAMPLES,
    SAMPLING_SD_PX,
    Patches,
    add_shift_variance,
    localise_in_windows,
    noise_ratio,
    replace_rows,
)
from raxel.features.chessboard.saddles import levels_of, noise_sd, sharp_level
from raxel.features.circles import resized
from raxel.features.detector import Detection, as_8_bit, rejected
from raxel.geometry.homography import apply_homography, homography_dlt

# Cells of a code and of the black border, along a side of a tag.
CODE_CELLS = {"16h5": 4, "25h9": 5, "36h10": 6, "36h11": 6}
BORDER_CELLS = (1, 2)
# Margin of the threshold in contrasts of the image, which separates squares that touch
# tags in a blurred image; and in grey levels, for tags in dark parts of the image.
MARGIN_CONTRASTS, MIN_MARGIN = 0.25, 7.0
# One tag has four orientations that all fit; two determine the orientation.
MIN_N_TAGS = 2
# Largest error of the step between tags; among those of a wrong row length, half of the
# steps, along rows, are right.
MAX_STEP_ERROR = 0.5
# Steps of a patch at which its squares are sampled: they must be within one tone.
SAMPLED_STEPS = 0.4
# Corners of a tag in the order of OpenCV: row and column.
CORNERS = ((0, 0), (0, 1), (1, 1), (1, 0))
UNIT_SQUARE = np.array(CORNERS, float)[:, ::-1]


def find_april_grid(image, target):
    """Detect the AprilTag grid `target` (`raxel.sets.AprilGrid`) in an image: a
    Detection.

    image: (height, width), uint8 or uint16. The tags determine the order of the
    corners, so parts of the grid may be missing. A corner is NaN where its tag is not
    decoded, where the black square at it is missing or occluded, or where its predicted
    SD is above a third of a pixel.
    """
    grey = as_8_bit(image)
    numbers, tags, border = _detect_tags(grey, target.family)
    columns, rows = target.tags
    inside = (numbers >= target.first_id) & (numbers < target.first_id + columns * rows)
    placed = np.full((rows, columns, 4, 2), np.nan)
    row, column = np.divmod(numbers[inside] - target.first_id, columns)
    placed[rows - 1 - row, column] = tags[inside]
    placed = _consistent(_upright(placed, target), target)
    n_placed = np.isfinite(placed[..., 0, 0]).sum()
    if np.sum(~inside) >= MIN_N_BEYOND or n_placed < max(MIN_N_TAGS, len(numbers) / 2):
        reason = (
            f"{len(numbers)} tags of {target.family} detected, {MIN_N_TAGS} required; "
            "check target.family, and the focus of the image"
        )
        detection = rejected(target.columns, target.rows, reason)
        return with_other_target(detection, _explanation(grey, target, numbers, tags))
    points, sd = _localise(grey, placed, target, border)
    if not np.isfinite(sd).any():
        reason = (
            f"{n_placed} tags of {target.family} detected, but no black squares at "
            "their corners, as on grids of Kalibr; use such a grid"
        )
        return rejected(target.columns, target.rows, reason)
    return Detection(
        True, points.reshape(-1, 2), target.columns, target.rows, sd=sd.ravel()
    )


def _detect_tags(grey, family):
    """Numbers (N,), outlines (N, 4, 2) px and cells of the border of the tags."""
    small = resized(grey, N_PIXELS)
    parameters = cv2.aruco.DetectorParameters()
    dictionary = dictionary_of(f"APRILTAG_{family}")

    def detect(border, margin):
        parameters.markerBorderBits = border
        parameters.adaptiveThreshConstant = margin
        detector = cv2.aruco.ArucoDetector(dictionary, parameters)
        tags, numbers, _ = detector.detectMarkers(small)
        numbers = [] if numbers is None else np.ravel(numbers)
        return dict(zip(map(int, numbers), tags, strict=True))

    margin = MARGIN_CONTRASTS * np.ptp(np.percentile(grey, (5, 95)))
    found = [(detect(border, margin), border) for border in BORDER_CELLS]
    outlines, border = max(found, key=lambda one: len(one[0]))
    outlines = detect(border, MIN_MARGIN) | outlines
    scale = np.divide(grey.shape, small.shape)[::-1]
    tags = (np.reshape(list(outlines.values()), (-1, 4, 2)) + 0.5) * scale - 0.5
    return np.array(list(outlines), int), tags, border


def _consistent(tags, target):
    """Tags (rows, columns, 4, 2), NaN where they are not where neighbours place them.

    tags: from `_upright`. The sides of two neighbours give the step between them.
    """
    centres = tags.mean(axis=2)
    votes = np.zeros(centres.shape[:2])
    ratio = target.pitch_mm / target.tag_mm / 2
    a, b, c, d = np.moveaxis(tags, 2, 0)
    # Along columns, then, with both axes exchanged, along rows.
    for side, turn in ((d - a + c - b, False), (b - a + c - d, True)):
        at, step, count = (
            each.swapaxes(0, 1) if turn else each
            for each in (centres, ratio * side, votes)
        )
        expected = (step[:-1] + step[1:]) / 2
        away = np.linalg.norm(np.diff(at, axis=0) - expected, axis=2)
        away = away / np.linalg.norm(expected, axis=2)
        vote = np.select([away < MAX_STEP_ERROR, away >= MAX_STEP_ERROR], [2, -3])
        count[:-1] += vote
        count[1:] += vote
    return np.where((votes < 0)[..., None, None], np.nan, tags)


def _upright(placed, target):
    """Tags (rows, columns, 4, 2) with the upper left corner first, then clockwise.

    Generators of tags differ by rotations of the code. All tags of a grid have one
    orientation: that for which a homography fits best.
    """
    known = np.isfinite(placed[..., 0, 0])
    if not known.any():
        return placed
    columns, rows = target.tags
    lattice = target.points().reshape(rows, 2, columns, 2, 2)
    corners = np.stack([lattice[:, i, :, j] for i, j in CORNERS], axis=2)
    source = corners[known].reshape(-1, 2)

    def misfit(rotated):
        pixels = rotated[known].reshape(-1, 2)
        H = homography_dlt(source, pixels)
        return np.sum((apply_homography(H, source) - pixels) ** 2)

    return min((np.roll(placed, k, axis=2) for k in range(4)), key=misfit)


def _localise(grey, tags, target, border):
    """Corners (rows, columns, 2) and SDs (rows, columns) px, NaN where uncertain.

    tags: (rows, columns, 4, 2), from `_upright`.
    """
    known = np.isfinite(tags[..., 0, 0])
    row, column = (
        np.add.outer(2 * index, step).ravel()
        for index, step in zip(np.nonzero(known), np.transpose(CORNERS), strict=True)
    )
    cells = CODE_CELLS[target.family] + 2 * border
    clear = min(border / cells, target.pitch_mm / target.tag_mm - 1)
    patches = _patches(tags[known], clear / SAMPLED_STEPS)
    grey = grey.astype(np.float32)
    noise = noise_sd(grey)
    smooth, sharp = levels_of(grey, noise)[0], sharp_level(grey, noise)
    found = localise_in_windows(patches, smooth, FULL_EFFORT)
    better = localise_in_windows(patches._replace(p=found.points), sharp, FULL_EFFORT)
    replace_rows(
        found, better, np.arange(len(row)), better.good & (better.sd < MAX_SHARP_SD_PX)
    )
    patches = patches._replace(p=found.points)
    disagreement = np.full((target.rows, target.columns, 2), np.nan)
    disagreement[row, column] = found.disagreement
    own = np.hypot(found.sd * noise_ratio(disagreement)[row, column], SAMPLING_SD_PX)
    own = add_shift_variance(own, symmetry_shift(patches, smooth, N_DENSE_SAMPLES))
    certain = found.good & (found.misfit <= MAX_LATTICE_MISFIT)
    certain &= (own <= MAX_CORNER_SD_PX) & squares_around(patches, smooth).alternate
    certain &= asymmetry(patches, smooth) <= MAX_ASYMMETRY
    points = np.full(disagreement.shape, np.nan)
    sd = np.full(points.shape[:2], np.nan)
    points[row[certain], column[certain]] = found.points[certain]
    sd[row[certain], column[certain]] = own[certain]
    return points, sd


def _patches(tags, step):
    """`Patches` of the corners of tags (N, 4, 2); step: in sides of a tag."""
    square = UNIT_SQUARE.astype(np.float32)
    maps = [cv2.getPerspectiveTransform(square, one.astype(np.float32)) for one in tags]
    maps = np.array(maps).reshape(-1, 3, 3)

    def at(a, b):
        offset = step * np.array([a, b])
        return apply_homography(maps, UNIT_SQUARE + offset).reshape(-1, 2)

    p, right, left, below, above = (
        at(*way) for way in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))
    )
    w = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / 4
    bends = (right + left) / 2 - p, (below + above) / 2 - p
    return Patches(p, (right - left) / 2, (below - above) / 2, *bends, w)


def _explanation(grey, target, numbers, tags):
    """Why the tags of an image are not those of the target."""
    columns, rows = target.tags
    last = target.first_id + columns * rows - 1
    if len(numbers) < MIN_N_TAGS:
        markers = find_markers(grey)
        if markers is None or not markers.is_tag_grid:
            return other_target(grey, markers)
        family = markers.dictionary.removeprefix("APRILTAG_")
        same = family == target.family
        return (
            ""
            if same
            else f"the image shows tags of {family}; set target.family: {family}"
        )
    shown = row_length(numbers - min(target.first_id, numbers.min()), tags)
    text = (
        f"{len(numbers)} tags of {target.family} with ids {numbers.min()} to "
        f"{numbers.max()} in rows of {shown}, but the target has ids "
        f"{target.first_id} to {last} in rows of {columns}"
    )
    wrong = "rows and first_id" if shown == columns else f"columns: {shown}, and rows"
    return f"{text}; set target.{wrong}"
