"""Is a lattice of corners a complete chessboard, and only a chessboard?"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from raxel.features.chessboard.corners import SQUARE_SAMPLES, sampled
from raxel.features.chessboard.grids import (
    AXES,
    MAX_CORNER_SD_PX,
    MAX_LATTICE_MISFIT,
    MIN_CORNERS_PER_MISSING,
    MIN_N_SIDE_CORNERS,
    MIN_ROW_FRACTION,
    Grid,
    is_nearly_complete,
    mask_corners,
    patches_of,
    predicted,
    shifted,
)
from raxel.features.chessboard.sides import (
    MIN_TURNED_FRACTION,
    MIN_TURNED_FRACTION_KNOWN_SIZE,
    line_named,
    runs_on_beyond,
    side_named,
    unequal_pitch,
)
from raxel.features.detector import as_8_bit
from raxel.features.lattice import lattice_fault

# Test of the squares between corners: one tone, straight edges. In lattice coordinates
# the border between two squares of a chessboard is the line from corner to corner,
# under any lens distortion. The border of a disc is an arc that bulges out of every
# disc, so out of the cells of one tone; distortion bends both sides of a line the same
# way. At the grey level of the corners the border between squares keeps its position
# under any blur and any camera response. If ink or light leaves a gap at the corners,
# their grey level is that of the gap. The border is then found at the mean of dark and
# bright.


# A lattice with fewer known corners is not tested.
MIN_KNOWN_FRACTION = 0.5
# Positions along an edge, in squares, at which its border is searched for: near its
# ends and at its centre; and positions across it.
ALONG_EDGE_SQUARES = np.array([0.2, 0.5, 0.8])
ACROSS_EDGE_SQUARES = np.linspace(-0.35, 0.35, 29)
# Bulge of the circle through the four corners of a square, between these positions.
CIRCLE_BULGE_SQUARES = float(
    np.sqrt(0.5) - np.sqrt(0.5 - (ALONG_EDGE_SQUARES[1] - ALONG_EDGE_SQUARES[0]) ** 2)
)
# The limit is half way between a square and a disc.
MAX_BULGE_SQUARES = CIRCLE_BULGE_SQUARES / 2
# The sampled part of a square, and the largest fraction of it of the other tone. A hole
# of a third of the square's side is detected.
INNER_RANGE_SQUARES, N_INNER_SAMPLES = (0.2, 0.8), 9
MAX_OTHER_TONE_FRACTION = 1 / 9


def shape_fault(grid, level):
    """Why the cells of a grid are not squares, or ''. level: `saddles.Level`.

    A lattice of which less than half is known is not tested.
    """
    known = grid.known
    if min(known.shape) < MIN_N_SIDE_CORNERS or known.mean() < MIN_KNOWN_FRACTION:
        return ""
    if abs(bulge_of(grid, level)) > MAX_BULGE_SQUARES:
        return "its cells are round; set target.kind: circles for a grid of circles"
    if other_tone(grid, level) > MAX_OTHER_TONE_FRACTION:
        return (
            "its cells are not of one tone; use a plain chessboard, or "
            "target.kind: charuco for a ChArUco board"
        )
    return ""


def bulge_of(grid, level):
    """How far borders bulge out of dark cells between their ends and their centre.

    In squares, negative for bright cells: the mean over all edges between neighbours, 0
    where no edge is usable. It is measured at the grey level of the corners, if the
    result scatters less between edges than squares differ from discs. Otherwise that
    level is the level of a cell, where noise crosses it, and the mean of dark and
    bright is used.
    """
    edges = np.concatenate([_edges(axis, grid, level) for axis in (0, 1)], axis=1)
    at_corners, in_middle = (row[np.isfinite(row)] for row in edges)
    if len(at_corners) and at_corners.std() < MAX_BULGE_SQUARES:
        return at_corners.mean()
    return in_middle.mean() if len(in_middle) else 0.0


def _edges(axis, grid, level):
    """Bulges (2, N) of the edges along columns (axis 0) or rows (1).

    At the grey level of the corners, and at the mean of dark and bright.
    """
    patches, i, j = patches_of(grid.points)
    number = np.full(grid.known.shape, -1)
    number[i, j] = np.arange(len(i))
    number = number if axis == 1 else number.T
    first, last = number[:, :-1].ravel(), number[:, 1:].ravel()
    both = (first >= 0) & (last >= 0)
    first, last = patches.of(first[both]), patches.of(last[both])
    along, across = np.meshgrid(ALONG_EDGE_SQUARES, ACROSS_EDGE_SQUARES, indexing="ij")
    a, b = along.ravel(), across.ravel()
    from_first = first.at(a, b) if axis == 1 else first.at(b, a)
    from_last = last.at(a - 1, b) if axis == 1 else last.at(b, a - 1)
    pixels = (1 - a[:, None]) * from_first + a[:, None] * from_last
    grey = sampled(level, pixels).reshape(-1, *along.shape)
    corners = sampled(level, np.stack([first.p, last.p], axis=1)).mean(axis=1)
    sides = grey[..., [0, -1]]
    brighter = np.sign((sides[..., 1] - sides[..., 0]).mean(axis=1))
    greys = corners, sides.mean(axis=(1, 2))
    return np.array([_edge_bulge(grey, at) * brighter for at in greys])


def _edge_bulge(grey, border_grey):
    """Offset (N,) of the border at the centre of edges from the border at their ends.

    grey: (N, along, across); border_grey: (N,). NaN where no border is found.
    """
    above = grey > border_grey[:, None, None]
    change = above[..., 1:] != above[..., :-1]
    nearest = np.where(
        change, np.abs(ACROSS_EDGE_SQUARES[1:] + ACROSS_EDGE_SQUARES[:-1]), np.inf
    )
    k = nearest.argmin(axis=-1)[..., None]
    low, high = (np.take_along_axis(grey, k + n, axis=-1)[..., 0] for n in (0, 1))
    rise = np.where(high != low, high - low, 1.0)
    share = (border_grey[:, None] - low) / rise
    border = ACROSS_EDGE_SQUARES[k[..., 0]] + share * (
        ACROSS_EDGE_SQUARES[1] - ACROSS_EDGE_SQUARES[0]
    )
    border = np.where(change.any(axis=-1), border, np.nan)
    return border[:, 1] - (border[:, 0] + border[:, 2]) / 2


def other_tone(grid, level):
    """Fraction of a cell that has the other tone: the median of dark or bright cells.

    The larger of both medians. The corners determine which cells are bright. The tone
    of a cell is that of its brightest or darkest tenth, since most of it may be
    occluded.
    """
    grey = _square_grey(grid, level)
    odd = np.add.outer(*map(np.arange, grid.known.shape)) % 2 == 1
    even_bright = np.nansum(np.where(odd, -grid.sign, grid.sign)) > 0
    bright = odd[:-1, :-1] != even_bright
    low, high = np.percentile(grey, (10, 90), axis=2)
    tone = np.where(bright, high, low)
    neighbours = _mean([shifted(tone, *d) for d in AXES])
    above = grey > ((tone + neighbours) / 2)[..., None]
    other_fraction = (above != bright[..., None]).mean(axis=2)
    known = np.isfinite(tone + neighbours)
    each = [other_fraction[known & (bright == one)] for one in (True, False)]
    return max(
        (np.median(fractions) for fractions in each if len(fractions)), default=0.0
    )


def _square_grey(grid, level):
    """Grey (rows - 1, columns - 1, N) inside the cells, NaN if a corner is missing."""
    p = grid.points
    ring = p[:-1, :-1], p[:-1, 1:], p[1:, :-1], p[1:, 1:]
    k = np.linspace(*INNER_RANGE_SQUARES, N_INNER_SAMPLES)
    t, s = (a.ravel() for a in np.meshgrid(k, k, indexing="ij"))
    weights = (1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t
    pixels = sum(
        q[..., None, :] * w[:, None] for q, w in zip(ring, weights, strict=True)
    )
    known = np.isfinite(pixels[..., 0, 0])
    grey = np.full(pixels.shape[:-1], np.nan)
    if known.any():
        grey[known] = sampled(level, pixels[known])
    return grey


def _mean(arrays):
    """The mean of the known values, NaN where all are missing."""
    stack = np.stack(arrays)
    known = np.isfinite(stack)
    count = np.where(known.any(axis=0), known.sum(axis=0), np.nan)
    return np.where(known, stack, 0).sum(axis=0) / count


# Smallest fraction of the corners of a board that must be certain.
MIN_CERTAIN_FRACTION = 2 / 3
MIN_NEXT_ROW_FRACTION = 0.34
BORDER_PX = 2.0
# Number of positions listed in a rejection.
MAX_NAMED_POSITIONS = 3
# An occluder leaves one or two sides of a board incomplete. More incomplete sides
# indicate a pattern that continues around the board.
MAX_RAGGED_SIDES = 2
# A lattice that was split off is on the next rings of the grid: number of rings,
# tolerance in steps, and smallest fraction of its nearby corners on the rings.
N_RINGS_BEYOND, ON_LATTICE_TOL_STEPS, MIN_ON_LATTICE_FRACTION = 3, 0.25, 0.6


class Verdict(NamedTuple):
    """A grid, its certain corners, and why it is not a board, or ''."""

    grid: Grid
    certain: Grid
    fault: str


def judge_grid(grid, image, known_size, part=False):
    """Judge whether a grid is a board that may be returned: `Verdict`.

    known_size: whether the size is given. If so, corners may be missing
    (`is_nearly_complete`). If not, every corner of the sides must be known, since an
    incomplete side does not determine where the board ends. part: whether the grid was
    selected from a larger lattice (`ends.board_within`), so that squares do continue
    beyond its sides.
    """
    certain = mask_corners(grid, uncertain_corners(grid))
    fault = _completeness_fault(grid, certain, image, known_size) or _geometry_fault(
        certain, image
    )
    fault = fault or ("" if part else _continuation_fault(grid, image, known_size))
    return Verdict(grid, certain, fault)


def uncertain_corners(grid):
    """Which corners (rows, columns) are too uncertain, or not a crossing of edges."""
    return grid.known & ~(
        (grid.sd <= MAX_CORNER_SD_PX) & (grid.misfit <= MAX_LATTICE_MISFIT)
    )


def _completeness_fault(grid, certain, image, known_size):
    """Why too many corners are missing or uncertain, or ''."""
    rows, columns = sorted(grid.known.shape)
    if min(rows, columns) < MIN_N_SIDE_CORNERS:
        return (
            f"a lattice of {columns} x {rows} corners is too small; a board has "
            f"at least {MIN_N_SIDE_CORNERS} x {MIN_N_SIDE_CORNERS}"
        )
    known = grid.known
    sides_hold = known[[0, -1]].all() and known[:, [0, -1]].all()
    sufficient = is_nearly_complete(grid, known_size) and (known_size or sides_hold)
    if sufficient and certain.count >= MIN_CERTAIN_FRACTION * known.size:
        return ""
    if sufficient or grid.complete:
        return (
            f"{_uncertain_text(grid, uncertain_corners(grid))}; two thirds of all "
            "must be certain"
        )
    if is_within_pattern(grid, image):
        return _pattern_fault(grid, known_size)
    what = (
        f"{grid.count} of {columns * rows} corners of a {columns} x {rows} lattice "
        "detected"
        f"{_positions_text(predicted(grid.points)[~grid.known], 'missing near')}"
    )
    what += f", {_emptiest_line_text(grid)}"
    if uncertain_corners(grid).any():
        what += f", {_uncertain_text(grid, uncertain_corners(grid))}"
    return what if known_size else f"{what}; give columns and rows"


def is_within_pattern(grid, image):
    """Whether squares continue around a board, as of tiles or checked cloth.

    Its sides are then incomplete or outside the image. A complete block of nine corners
    is required, which chance corners of letters or codes do not form.
    """
    known = grid.known
    if min(known.shape) < MIN_N_SIDE_CORNERS:
        return False
    if not sliding_window_view(known, (MIN_N_SIDE_CORNERS,) * 2).all(axis=(2, 3)).any():
        return False
    sides = known[0], known[-1], known[:, 0], known[:, -1]
    ragged = sum(side.mean() < MIN_ROW_FRACTION for side in sides)
    if is_nearly_complete(grid) or ragged < MAX_RAGGED_SIDES:
        return False
    return ragged > MAX_RAGGED_SIDES or len(open_sides(grid, image)) >= MAX_RAGGED_SIDES


def _pattern_fault(grid, known_size):
    """The rejection of a board within a larger pattern of squares."""
    part = (
        "no part of this size differs from the rest"
        if known_size
        else "its end was not found"
    )
    give = "" if known_size else "give columns and rows, or "
    return (
        f"squares continue around the board (tiles or checked cloth, {grid.count} "
        f"corners), and {part}; {give}use a white margin or a plain background"
    )


def _emptiest_line_text(grid):
    """The row or column with most missing corners, and the rule it violates."""
    lines = [(axis, k) for axis in (0, 1) for k in range(grid.known.shape[axis])]
    known = {line: grid.known.take(line[1], axis=line[0]) for line in lines}
    axis, k = min(lines, key=lambda line: known[line].mean())
    if MIN_CORNERS_PER_MISSING * (~known[axis, k]).sum() > len(known[axis, k]):
        rule = (
            "at most a third of a row or column may be missing, or half of a side of "
            "a known size"
        )
    else:
        ends = [line for line in lines if line[1] in (0, grid.known.shape[line[0]] - 1)]
        axis, k = min(ends, key=lambda line: known[line].mean())
        rule = "without a known size every side must be complete"
    lack = np.count_nonzero(~known[axis, k])
    line = line_named(grid, axis, k)
    return f"{lack} of {len(known[axis, k])} missing in {line} ({rule})"


def _uncertain_text(grid, which):
    """Why corners cannot be used."""
    count = np.count_nonzero(which)
    subject = f"{count} of {grid.count} corners" if count > 1 else "a corner"
    crossing = which & ~(grid.misfit <= MAX_LATTICE_MISFIT)
    worst = np.where(which & np.isfinite(grid.sd), grid.sd, 0).max()
    if crossing.sum() > count / 2:
        what = "unclear: their edges do not meet in one point"
    elif worst > MAX_CORNER_SD_PX:
        what = f"uncertain by up to {worst:.2f} px, limit {MAX_CORNER_SD_PX:.2f} px"
    else:
        what = "disturbed (occluder, edge of a shadow or reflection, or blur)"
    verb = "are" if count > 1 else "is"
    return f"{subject} {verb} {what}{_positions_text(grid.points[which], 'near')}"


def _positions_text(points, word):
    """Positions in the image: ' (near (u, v), ...)', the first few known ones."""
    points = points[np.isfinite(points[:, 0])]
    if not len(points):
        return ""
    shown = [f"({u:.0f}, {v:.0f})" for u, v in points[:MAX_NAMED_POSITIONS]]
    more = len(points) - len(shown)
    return f" ({word} {', '.join(shown)}{f' and {more} more' if more else ''})"


def _geometry_fault(grid, image):
    """What is wrong with the corners of a nearly complete grid, or ''."""
    corners, size = grid.points.reshape(-1, 2), grid.known.shape[::-1]
    return lattice_fault(corners, *size, image) or unequal_pitch(grid)


def _continuation_fault(grid, image, known_size):
    """The side beyond which the squares of a grid continue, as text, or ''."""
    share = MIN_TURNED_FRACTION_KNOWN_SIZE if known_size else MIN_TURNED_FRACTION
    side = runs_on_beyond(grid, as_8_bit(image), share)
    if not side:
        return ""
    return (
        f"squares continue beyond its {side}, of the board or of the background; "
        "add a white margin"
    )


def open_side(grid, image):
    """The side of a grid that may continue outside the image (`side_named`), or ''."""
    return next((name for _, name in open_sides(grid, image)), "")


def open_sides(grid, image):
    """[(axis, `side_named`)] of the sides that may continue outside the image.

    axis: 0 where rows may follow, 1 where columns. A board has ended where its next
    corners would be inside the image but were not found. Enough of the squares behind
    these must be inside to identify a corner (SQUARE_SAMPLES). At least
    MIN_NEXT_ROW_FRACTION of the next corners of a side must be inside.
    """
    height, width = image.shape
    lattice = np.where(grid.known[..., None], grid.points, predicted(grid.points))
    beyond = predicted(
        np.pad(lattice, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
    )
    sides = (
        (0, beyond[0, 1:-1], lattice[0]),
        (0, beyond[-1, 1:-1], lattice[-1]),
        (1, beyond[1:-1, 0], lattice[:, 0]),
        (1, beyond[1:-1, -1], lattice[:, -1]),
    )
    found = []
    for axis, following, last in sides:
        points = following + SQUARE_SAMPLES[0] * (following - last)
        points = points[np.isfinite(points[:, 0])]
        inside = np.all(
            (points > BORDER_PX) & (points < np.array([width, height]) - 1 - BORDER_PX),
            axis=1,
        )
        if len(points) and inside.mean() < MIN_NEXT_ROW_FRACTION:
            found.append((axis, side_named(points, grid.points[grid.known])))
    return found


def has_continuation(grid, others):
    """Whether another lattice continues this grid, as a part that was split off.

    Its corners then coincide with the next corners of this grid, extrapolated.
    """
    rings = grid.points
    for _ in range(N_RINGS_BEYOND):
        rings = np.pad(rings, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
        for _ in range(2):
            guess = predicted(rings)
            rings = np.where(np.isfinite(rings), rings, guess)
    step = np.linalg.norm(np.gradient(rings, axis=(0, 1)), axis=3).min(axis=0)
    beyond = np.ones(rings.shape[:2], bool)
    inner = slice(N_RINGS_BEYOND, -N_RINGS_BEYOND)
    beyond[inner, inner] = False
    beyond &= np.isfinite(rings[..., 0]) & np.isfinite(step)
    positions, reach = rings[beyond], step[beyond]
    for other in others:
        points = other.points[other.known]
        distance = np.linalg.norm(points[:, None] - positions[None], axis=2) / reach
        nearest, distance = distance.argmin(axis=1), distance.min(axis=1)
        near = distance < 1
        on = np.unique(nearest[distance < ON_LATTICE_TOL_STEPS])
        if (
            len(on) >= MIN_N_SIDE_CORNERS
            and len(on) > MIN_ON_LATTICE_FRACTION * near.sum()
        ):
            return True
    return False
