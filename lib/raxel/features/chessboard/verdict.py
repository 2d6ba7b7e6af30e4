"""Is a grid of corners the whole board, and nothing but the board?"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from raxel.features.chessboard.corners import QUADRANT, sampled
from raxel.features.chessboard.grids import (
    AXES,
    LEAST_SIDE,
    MOST_CHANCE,
    MOST_SD,
    ONE_MISSING_OF,
    Grid,
    holed,
    nearly_complete,
    patches_of,
    predicted,
    shifted,
)
from raxel.features.chessboard.sides import (
    SHARE_OF_EDGES,
    SURE_SHARE_OF_EDGES,
    line_named,
    runs_on_beyond,
    side_named,
    unequal_pitch,
)
from raxel.features.detector import as_8_bit
from raxel.features.lattice import lattice_fault, spacing

# Are the fields between a lattice's corners squares: of one tone, with straight
# edges? Seen in the lattice's own coordinates the border between two squares of a
# chessboard is the line from corner to corner, however a lens bends it. The border of
# a disc is an arc: it bulges out of every disc, so out of the fields of one tone,
# where a bend of the lens goes the same way on both sides of a line. At the corners'
# own grey the border between squares stays where it is, however they are blurred and
# whatever the response of the camera. Only where ink or light leaves a gap at the
# corners is their grey that of the gap; the border then stays at the middle between
# dark and bright.


# Of a lattice, for something to be said of its fields.
MIN_SQUARES_SEEN = 0.5
# Places along an edge at which its border is looked for, in squares: near its ends and
# in its middle; and places across it.
PLACES = np.array([0.2, 0.5, 0.8])
ACROSS = np.linspace(-0.35, 0.35, 29)
# How far the arc through the four corners of a square bulges between these places.
ARC = float(np.sqrt(0.5) - np.sqrt(0.5 - (PLACES[1] - PLACES[0]) ** 2))
# Half of it lies between a square and a disc.
MOST_BULGE = ARC / 2
# The part of a field that is looked at, and of it what may be of the other tone: a hole
# of a third of its side can be seen.
FILLED, FILLED_SAMPLES = (0.2, 0.8), 9
MOST_OTHER = 1 / 9


def shape_fault(grid, level):
    """Why the fields of a grid are no squares, or ''. level: `saddles.Level`.

    Nothing is said of a lattice of which less than half is seen.
    """
    known = grid.known
    if min(known.shape) < LEAST_SIDE or known.mean() < MIN_SQUARES_SEEN:
        return ""
    if abs(bulge_of(grid, level)) > MOST_BULGE:
        return (
            "its fields are round, not square: this looks like a grid of circles; show "
            "a chessboard"
        )
    if other_tone(grid, level) > MOST_OTHER:
        return (
            "its fields are not filled evenly: there is something in the dark or the "
            "bright ones; a chessboard has plain squares, a ChArUco board "
            "(target.kind: charuco) markers in the bright ones"
        )
    return ""


def bulge_of(grid, level):
    """How far borders bulge out of dark fields (below 0: bright ones) between their
    ends and their middle, in squares.

    The mean of all edges between neighbours; 0 where none tells. At the grey of the
    corners, if it differs from edge to edge by less than squares differ from discs:
    where that is the grey of the fields, noise crosses it anywhere. Then at the middle.
    """
    edges = np.concatenate([_edges(axis, grid, level) for axis in (0, 1)], axis=1)
    at_corners, in_middle = (row[np.isfinite(row)] for row in edges)
    if len(at_corners) and at_corners.std() < MOST_BULGE:
        return at_corners.mean()
    return in_middle.mean() if len(in_middle) else 0.0


def _edges(axis, grid, level):
    """Bulges (2, N) of the edges along columns (axis 0) or rows (1): at the grey of the
    corners, and at the middle of dark and bright."""
    patches, i, j = patches_of(grid.points)
    number = np.full(grid.known.shape, -1)
    number[i, j] = np.arange(len(i))
    number = number if axis == 1 else number.T
    first, last = number[:, :-1].ravel(), number[:, 1:].ravel()
    both = (first >= 0) & (last >= 0)
    first, last = patches.of(first[both]), patches.of(last[both])
    along, across = np.meshgrid(PLACES, ACROSS, indexing="ij")
    a, b = along.ravel(), across.ravel()
    here = first.at(a, b) if axis == 1 else first.at(b, a)
    there = last.at(a - 1, b) if axis == 1 else last.at(b, a - 1)
    pixels = (1 - a[:, None]) * here + a[:, None] * there
    grey = sampled(level, pixels).reshape(-1, *along.shape)
    corners = sampled(level, np.stack([first.p, last.p], axis=1)).mean(axis=1)
    sides = grey[..., [0, -1]]
    brighter = np.sign((sides[..., 1] - sides[..., 0]).mean(axis=1))
    greys = corners, sides.mean(axis=(1, 2))
    return np.array([_arch(grey, at) * brighter for at in greys])


def _arch(grey, border_grey):
    """How far across the middle of edges (N, PLACES, ACROSS) the border at a grey (N,)
    lies from where it lies at their ends, (N,); NaN where there is no such border."""
    above = grey > border_grey[:, None, None]
    change = above[..., 1:] != above[..., :-1]
    nearest = np.where(change, np.abs(ACROSS[1:] + ACROSS[:-1]), np.inf)
    k = nearest.argmin(axis=-1)[..., None]
    low, high = (np.take_along_axis(grey, k + n, axis=-1)[..., 0] for n in (0, 1))
    rise = np.where(high != low, high - low, 1.0)
    share = (border_grey[:, None] - low) / rise
    border = ACROSS[k[..., 0]] + share * (ACROSS[1] - ACROSS[0])
    border = np.where(change.any(axis=-1), border, np.nan)
    return border[:, 1] - (border[:, 0] + border[:, 2]) / 2


def other_tone(grid, level):
    """The share of fields that is of the other tone: of the dark or of the bright ones,
    whichever is more, the median field.

    Which fields are bright is told at the corners. The tone of a field is that of its
    brightest tenth, or darkest: most of it may be covered.
    """
    grey = _fields(grid, level)
    odd = np.add.outer(*map(np.arange, grid.known.shape)) % 2 == 1
    even_bright = np.nansum(np.where(odd, -grid.sign, grid.sign)) > 0
    bright = odd[:-1, :-1] != even_bright
    low, high = np.percentile(grey, (10, 90), axis=2)
    tone = np.where(bright, high, low)
    beside = _mean([shifted(tone, *d) for d in AXES])
    above = grey > ((tone + beside) / 2)[..., None]
    other = (above != bright[..., None]).mean(axis=2)
    told = np.isfinite(tone + beside)
    each = [other[told & (bright == one)] for one in (True, False)]
    return max((np.median(some) for some in each if len(some)), default=0.0)


def _fields(grid, level):
    """Grey (rows - 1, columns - 1, N) of the inner part of fields, NaN where a corner
    is missing."""
    p = grid.points
    ring = p[:-1, :-1], p[:-1, 1:], p[1:, :-1], p[1:, 1:]
    k = np.linspace(*FILLED, FILLED_SAMPLES)
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
    """The mean of those that are known, NaN where none is."""
    stack = np.stack(arrays)
    known = np.isfinite(stack)
    count = np.where(known.any(axis=0), known.sum(axis=0), np.nan)
    return np.where(known, stack, 0).sum(axis=0) / count


# Of a board whose corners are seen, so many must be sure.
LEAST_SURE = 2 / 3
# Share of the edges' strength that may point past a corner. On rendered boards blur had
# moved corners by more than a pixel where it was higher, at narrow outer squares.
MOST_MISFIT = 0.375
# Nearer corners than this, in px, are moved by any blur of a lens.
LEAST_SPACING = 7.5
LEAST_SEEN = 0.34
RIM_PX = 2.0
# Places that a refusal names.
MOST_PLACES = 3
# A hand or a sheet leaves one or two sides of a board ragged, and no others outside.
RAGGED_SIDES = 2
# A lattice cut off lies on the next rings of the grid: so many, so near (in steps).
BEYOND_RINGS, ON_LATTICE, SHARE_ON = 3, 0.25, 0.6


class Judged(NamedTuple):
    """A grid of corners seen, those of them that are sure, and why it is no board, or
    ''."""

    seen: Grid
    sure: Grid
    fault: str


def judged(grid, image, told, part=False):
    """Whether a grid is a board that could be returned: `Judged`.

    told: whether its size is given. If so it may lack corners, as `nearly_complete`
    says; if not, every corner of its sides must be seen: a side that is broken does not
    say that the board ends there. part: whether it is the part of a lattice that was
    told from the rest (`windows`), where more squares do stand beyond its sides.
    """
    sure = holed(grid, unsure(grid))
    fault = _lack(grid, sure, image, told) or _misplaced(sure, image)
    fault = fault or ("" if part else _runs_on(grid, image, told))
    return Judged(grid, sure, fault)


def unsure(grid):
    """Which corners (rows, columns) are too uncertain, or no crossing of edges."""
    return grid.known & ~((grid.sd <= MOST_SD) & (grid.misfit <= MOST_MISFIT))


def _lack(grid, sure, image, told):
    """Why too many corners are missing or unsure, or ''."""
    rows, columns = sorted(grid.known.shape)
    if min(rows, columns) < LEAST_SIDE:
        return (
            f"a lattice of {columns} x {rows} corners is too small to be sure of; a "
            f"board has {LEAST_SIDE} x {LEAST_SIDE} or more"
        )
    known = grid.known
    sides_hold = known[[0, -1]].all() and known[:, [0, -1]].all()
    seen = nearly_complete(grid) and (told or sides_hold)
    if seen and sure.count >= LEAST_SURE * known.size:
        return ""
    if seen or grid.complete:
        return f"{_unsure_ones(grid, unsure(grid))}; two thirds of all must be sure"
    if lies_on_pattern(grid, image):
        return _of_pattern(grid, told)
    what = (
        f"{grid.count} of {columns * rows} corners of a lattice of {columns} x {rows} "
        f"are seen{_places(predicted(grid.points)[~grid.known], 'missing near')}"
    )
    what += f"; {_lacking_line(grid)}"
    if unsure(grid).any():
        what += f"; {_unsure_ones(grid, unsure(grid))}"
    return what if told else f"{what}; give columns and rows"


def lies_on_pattern(grid, image):
    """Whether squares go on about a board: sides are ragged or outside the image.

    Of squares at all: chance corners of letters or codes make no nine side by side.
    """
    known = grid.known
    if min(known.shape) < LEAST_SIDE:
        return False
    if not sliding_window_view(known, (LEAST_SIDE,) * 2).all(axis=(2, 3)).any():
        return False
    sides = known[0], known[-1], known[:, 0], known[:, -1]
    ragged = sum(side.mean() < MOST_CHANCE for side in sides)
    if nearly_complete(grid) or ragged < RAGGED_SIDES:
        return False
    return ragged > RAGGED_SIDES or len(open_sides(grid, image)) >= RAGGED_SIDES


def _of_pattern(grid, told):
    """What to do about squares that go on about a board."""
    part = "no part of this size differs from the rest" if told else "no end is seen"
    give = "" if told else "give columns and rows, or "
    return (
        f"squares go on about the board, as of tiles or checked cloth ({grid.count} "
        f"corners), and {part}; {give}show it with a white margin or on plain ground"
    )


def _lacking_line(grid):
    """Which row or column lacks too much, and what the rule is."""
    lines = [(axis, k) for axis in (0, 1) for k in range(grid.known.shape[axis])]
    seen = {line: grid.known.take(line[1], axis=line[0]) for line in lines}
    axis, k = min(lines, key=lambda line: seen[line].mean())
    if ONE_MISSING_OF * (~seen[axis, k]).sum() > len(seen[axis, k]):
        rule = "a third of a row or column may be missing at most"
    else:
        ends = [line for line in lines if line[1] in (0, grid.known.shape[line[0]] - 1)]
        axis, k = min(ends, key=lambda line: seen[line].mean())
        rule = "where the size is not given every side must be whole"
    lack = np.count_nonzero(~seen[axis, k])
    verb = "are" if lack > 1 else "is"
    return (
        f"{lack} of {len(seen[axis, k])} corners of {line_named(grid, axis, k)} {verb} "
        f"missing, and {rule}"
    )


def _unsure_ones(grid, which):
    """What is wrong with corners that cannot be used."""
    count = np.count_nonzero(which)
    of = f"{count} of {grid.count} corners" if count > 1 else "a corner"
    crossing = which & ~(grid.misfit <= MOST_MISFIT)
    worst = np.where(which & np.isfinite(grid.sd), grid.sd, 0).max()
    if crossing.sum() > count / 2:
        what = "not clear: their edges do not meet in one point"
    elif worst > MOST_SD:
        what = f"uncertain by up to {worst:.2f} px, where {MOST_SD:.2f} px is the most"
    else:
        what = (
            "not to be placed: something covers a part, the edge of a shadow or of a "
            "reflection crosses it, or blur has mixed its edges"
        )
    verb = "are" if count > 1 else "is"
    return f"{of} {verb} {what}{_places(grid.points[which], 'near')}"


def _places(points, word):
    """Where in the image: ' (near (u, v), ...)', the first few that are known."""
    points = points[np.isfinite(points[:, 0])]
    if not len(points):
        return ""
    shown = [f"({u:.0f}, {v:.0f})" for u, v in points[:MOST_PLACES]]
    more = len(points) - len(shown)
    return f" ({word} {', '.join(shown)}{f' and {more} more' if more else ''})"


def _misplaced(grid, image):
    """What is wrong with the corners of a grid that lacks little, or ''."""
    corners, size = grid.points.reshape(-1, 2), grid.known.shape[::-1]
    least = spacing(corners, *size).min()
    if least < LEAST_SPACING:
        return (
            f"corners lie {np.floor(10 * least) / 10:.1f} px apart; below "
            f"{LEAST_SPACING:g} px they cannot be placed well: come nearer, or use "
            "larger squares"
        )
    return lattice_fault(corners, *size, image) or unequal_pitch(grid)


def _runs_on(grid, image, told):
    """The side beyond which a grid's squares go on, in words, or ''."""
    share = SURE_SHARE_OF_EDGES if told else SHARE_OF_EDGES
    side = runs_on_beyond(grid, as_8_bit(image), share)
    if not side:
        return ""
    return (
        f"more squares stand beyond its {side}, of the board or of what lies behind; a "
        "white margin about the board would tell them apart"
    )


def open_side(grid, image):
    """Which side of a grid may go on beyond the image (`side_named`), or ''."""
    return next((name for _, name in open_sides(grid, image)), "")


def open_sides(grid, image):
    """[(axis, `side_named`)] of the sides of a grid that may go on beyond the image.

    axis: 0 where rows may follow, 1 where columns. A board has ended where the next
    corners would lie inside the image and are none, with as much of the fields behind
    them as a corner is told by (QUADRANT); of each side a third (LEAST_SEEN) of these
    must lie inside.
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
        points = following + QUADRANT[0] * (following - last)
        points = points[np.isfinite(points[:, 0])]
        inside = np.all(
            (points > RIM_PX) & (points < np.array([width, height]) - 1 - RIM_PX),
            axis=1,
        )
        if len(points) and inside.mean() < LEAST_SEEN:
            found.append((axis, side_named(points, grid.points[grid.known])))
    return found


def continues(grid, others):
    """Whether another lattice carries this grid on, as a part of it cut off.

    Its corners then lie where this grid, run on, has its next ones.
    """
    rings = grid.points
    for _ in range(BEYOND_RINGS):
        rings = np.pad(rings, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
        for _ in range(2):
            guess = predicted(rings)
            rings = np.where(np.isfinite(rings), rings, guess)
    step = np.linalg.norm(np.gradient(rings, axis=(0, 1)), axis=3).min(axis=0)
    beyond = np.ones(rings.shape[:2], bool)
    inner = slice(BEYOND_RINGS, -BEYOND_RINGS)
    beyond[inner, inner] = False
    beyond &= np.isfinite(rings[..., 0]) & np.isfinite(step)
    places, reach = rings[beyond], step[beyond]
    for other in others:
        points = other.points[other.known]
        off = np.linalg.norm(points[:, None] - places[None], axis=2) / reach
        place, off = off.argmin(axis=1), off.min(axis=1)
        near = off < 1
        on = np.unique(place[off < ON_LATTICE])
        if len(on) >= LEAST_SIDE and len(on) > SHARE_ON * near.sum():
            return True
    return False
