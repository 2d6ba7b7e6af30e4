"""Where a board ends: is a side row a row of corners, or the edge of the paper?

Along a row of corners, dark and bright swap on both sides of the row. At the end of a
board, the edges between the outermost squares meet the edge of these squares or of the
paper, and the area beyond does not alternate: paper, table or cloth. A chance pattern
may imitate a few corners, but the whole area beyond the row does not alternate in step
with the board.
"""

from typing import NamedTuple

import numpy as np

from raxel.features.chessboard.corners import SQUARE_SAMPLES, asymmetry, sampled
from raxel.features.chessboard.grids import (
    CHANCE_SIGMAS,
    MAX_ASYMMETRY,
    MAX_N_STRAYS,
    MAX_STRAY_FRACTION,
    MIN_N_SIDE_CORNERS,
    MIN_ROW_FRACTION,
    Grid,
    is_nearly_complete,
    patches_of,
    predicted,
    without,
)
from raxel.features.chessboard.sides import (
    MAX_LOG_STEP_CHANGE_END,
    grey_at,
    lengths_outward,
    side_named,
    sides_of,
)

# Half way between a row of a board, 1, and the edge of the paper, 0.
ROW_THRESHOLD = 0.5
# Smallest fraction of the outermost squares that is visible where a board ends.
MIN_INNER_FRACTION = 2 / 3


class Side(NamedTuple):
    """A side row of a grid: contrast of its outer squares relative to the board's.

    name: (axis, whether its end); cells: of the row, (rows, columns) bool; change: 1
    for a row of a board, 0 for the edge of the paper, NaN outside the image; sd of
    change; n_symmetric: number of its corners with squares of the same tones on both
    sides; inner_fraction: fraction of its corners with squares on the inner side.
    """

    name: tuple
    cells: np.ndarray
    change: float
    sd: float
    n_symmetric: int
    inner_fraction: float

    def is_edge(self, known_size):
        """Whether the row is certainly not a row of corners; see `trim_paper_edges`."""
        length = np.count_nonzero(self.cells)
        max_symmetric = (
            min(MAX_N_STRAYS, MAX_STRAY_FRACTION * length) if known_size else 0
        )
        may_be_row = (
            self.change >= ROW_THRESHOLD or self.change + CHANCE_SIGMAS * self.sd >= 1
        )
        return self.n_symmetric <= max_symmetric and not may_be_row

    @property
    def is_row(self):
        """Whether the row is certainly a row of corners."""
        changes = (
            self.change > ROW_THRESHOLD and self.change - CHANCE_SIGMAS * self.sd > 0
        )
        return changes or self.n_symmetric > MAX_STRAY_FRACTION * np.count_nonzero(
            self.cells
        )


def trim_paper_edges(grid, level, known_size):
    """The grid without side rows that are the edge of the paper or a chance pattern.

    A row is removed where it has no symmetric corner, and where its outer squares
    together do not alternate as the board's. For a known size a few corners may be
    symmetric by chance, since only a board of this size is returned then. The corners
    of a row that an occluder leaves visible are symmetric; where a shadow ends in a row
    its squares alternate as the board's. The board must be complete up to the first
    removed row, since an occluder of the board's end occludes squares as well.
    """
    trimmed, first = grid, {}
    while edges := [
        side for side in examine_sides(trimmed, level) if side.is_edge(known_size)
    ]:
        edge = min(edges, key=lambda side: side.n_symmetric)
        first[edge.name] = edge.inner_fraction
        trimmed = without(trimmed, edge.cells)
        if trimmed.count < MIN_N_SIDE_CORNERS**2:
            return grid
    return trimmed if min(first.values(), default=1.0) >= MIN_INNER_FRACTION else grid


def uncertain_side(grid, level):
    """The side row that may be the edge of the paper (`side_named`), or ''."""
    for side in examine_sides(grid, level):
        if not side.is_row:
            row = grid.points[side.cells & grid.known]
            return side_named(row, grid.points[grid.known])
    return ""


def examine_sides(grid, level):
    """The Sides of a grid that is a board also without them, measured in a Level.

    level: `saddles.Level`.
    """
    known = grid.known
    if min(known.shape) < MIN_N_SIDE_CORNERS:
        return []
    points = np.where(known[..., None], grid.points, predicted(grid.points))
    patches, i, j = patches_of(points)
    even = known[i, j] & (asymmetry(patches, level) <= MAX_ASYMMETRY)
    sides = []
    for axis, at in enumerate((i, j)):
        if known.shape[axis] <= MIN_N_SIDE_CORNERS:
            continue
        steps, inside = steps_across(patches, level, axis)
        steps = steps * np.where((i + j) % 2 == 0, 1.0, -1.0)[:, None]
        for end, outer in ((0, 0), (known.shape[axis] - 1, 1)):
            row = at == end
            beyond, within = steps[:, outer], steps[:, 1 - outer]
            usual = [_mean(within[(np.abs(at - end) == k) & inside]) for k in range(2)]
            usual = max(usual, key=abs)
            change, sd = np.nan, np.nan
            # Across a row of corners dark and bright swap.
            outer_steps = -beyond[row & inside]
            if len(outer_steps) >= MIN_N_SIDE_CORNERS and usual:
                change = outer_steps.mean() / usual
                sd = outer_steps.std(ddof=1) / np.sqrt(len(outer_steps)) / abs(usual)
            equal = np.abs(beyond + within) <= MAX_ASYMMETRY * np.abs(within)
            inner_steps = within[row & inside] / usual if usual else np.zeros(1)
            inner_fraction = (
                np.mean(inner_steps > ROW_THRESHOLD) if len(inner_steps) else 0.0
            )
            cells = np.zeros_like(known)
            cells[(slice(None),) * axis + (end,)] = True
            n_symmetric = np.count_nonzero(row & even & equal)
            name = axis, bool(end)
            sides.append(Side(name, cells, change, sd, n_symmetric, inner_fraction))
    return sides


def _mean(values):
    return values.mean() if len(values) else 0.0


def steps_across(patches, level, axis):
    """Contrast (N, 2) along a row between neighbours, on both its sides; inside (N,).

    Relative to their mean, since light falloff scales dark and bright alike. inside:
    corners whose squares are inside the image.
    """
    along, across = np.meshgrid(SQUARE_SAMPLES, SQUARE_SAMPLES)
    along, across = along.ravel(), across.ravel()
    signs = ((-1, -1), (1, -1), (-1, 1), (1, 1))
    a = np.concatenate([x * along for x, _ in signs])
    b = np.concatenate([y * across for _, y in signs])
    s, t = (a, b) if axis == 0 else (b, a)
    pixels = patches.at(s, t)
    height, width = level.grey.shape
    upper = level.scale * np.array([width - 1, height - 1])
    inside = np.all((pixels >= 0) & (pixels <= upper), axis=(1, 2))
    grey = sampled(level, pixels).reshape(-1, 2, 2, along.size).mean(axis=3)
    step = grey[..., 1] - grey[..., 0]
    return step / np.maximum(grey.mean(axis=2), 1.0), inside


# A board of known size in a lattice that continues over its surroundings. Tiles or
# checked cloth continue the lattice of a board that is cut along its squares. The
# contrast of dark and bright, relative to their mean, distinguishes the two, since
# light scales both alike: it changes abruptly where the board ends. So may the spacing
# of corners, or few corners are found there.


# A relative contrast change above this fraction is of another object. Paint, ink and
# oblique light change it by less from row to row of one board.
TONE_CHANGE_TOL = 0.2
# Rings of corners by which a lattice is extrapolated, to determine which corners the
# image would show.
N_EXTRAPOLATED_RINGS = 3


def board_within(grid, sizes, level):
    """The part of a grid that is a board of one of `sizes`, (rows, columns), or None.

    level: `saddles.Level`. Two thirds of each of its rows are known. Beyond each of its
    sides the grid ends, is nearly empty, or has another contrast or spacing. None as
    well where several parts qualify, and for a complete grid, which is another board.
    """
    if is_nearly_complete(grid):
        return None
    known, found = grid.known, []
    regions = [
        (slice(i, i + high), slice(j, j + wide))
        for high, wide in set(sizes)
        for i in range(len(known) - high + 1)
        for j in range(known.shape[1] - wide + 1)
    ]
    steps = _steps(grid, level) if regions else None
    shown = _inside_image(grid.points, level) if regions else None
    for region in regions:
        part = Grid(*(a[region] for a in grid))
        if is_nearly_complete(part) and _ends_at_all_sides(
            grid.points, shown, steps, region
        ):
            found.append(part)
    return found[0] if len(found) == 1 else None


def _steps(grid, level):
    """Contrasts (rows, columns, 2) on both sides of lines, along rows and columns.

    On a whole board those behind a line have one sign, and those before it the other.
    """
    points = np.where(grid.known[..., None], grid.points, predicted(grid.points))
    patches, i, j = patches_of(points)
    both = []
    for axis in (0, 1):
        steps, inside = steps_across(patches, level, axis)
        steps = steps * np.where((i + j) % 2 == 0, 1.0, -1.0)[:, None]
        all_steps = np.full((*grid.known.shape, 2), np.nan)
        all_steps[i, j] = np.where(inside[:, None], steps, np.nan)
        both.append(all_steps)
    return both


def _inside_image(points, level):
    """Which corners of a lattice (rows, columns, 2) are inside the image.

    As far as they can be extrapolated. Corners outside do not indicate where a board
    ends.
    """
    for _ in range(N_EXTRAPOLATED_RINGS):
        points = np.where(np.isfinite(points), points, predicted(points))
    height, width = level.grey.shape
    upper = level.scale * np.array([width - 2, height - 2])
    return ~((points <= level.scale) | (points >= upper)).any(axis=2)


def _ends_at_all_sides(points, shown, steps, region):
    """Whether a part of a lattice, two slices, ends at all of its sides.

    points: (rows, columns, 2); shown: see `_inside_image`; steps: see `_steps`.
    """
    for axis, of_axis in enumerate(steps):
        along = region[1 - axis]
        lines, corners, visible = (
            a.swapaxes(0, axis)[:, along] for a in (of_axis, points, shown)
        )
        first, last = region[axis].start, region[axis].stop - 1
        for beyond, inward, outer in ((first - 1, 1, 0), (last + 1, -1, 1)):
            if not 0 <= beyond < len(lines):
                continue
            known = np.isfinite(corners[beyond, visible[beyond], 0])
            few = len(known) >= MIN_N_SIDE_CORNERS and known.mean() < MIN_ROW_FRACTION
            next_ones = corners[[beyond + k * inward for k in range(3)]]
            own_steps = lines[first : last + 1, :, 1 - outer]
            tones = -lines[beyond, :, outer]
            if not (few or _other_pitch(next_ones) or _other_tones(tones, own_steps)):
                return False
    return True


def _other_pitch(lines):
    """Whether the first of three lines of corners (3, n, 2) has another spacing."""
    lengths = np.log(np.linalg.norm(np.diff(lines, axis=0), axis=2))
    change = np.subtract(*lengths)
    change = change[np.isfinite(change)]
    return (
        len(change) >= MIN_N_SIDE_CORNERS
        and abs(np.median(change)) > MAX_LOG_STEP_CHANGE_END
    )


def _other_tones(beyond, inside):
    """Whether contrasts (n,) beyond a side differ from those of a board (rows, n).

    The latter may vary from row to row: with the paint of its squares, or in glare.
    """
    beyond = beyond[np.isfinite(beyond)]
    of_rows = np.array(
        [row[np.isfinite(row)].mean() for row in inside if np.isfinite(row).any()]
    )
    if (
        len(beyond) < MIN_N_SIDE_CORNERS
        or len(of_rows) < MIN_N_SIDE_CORNERS
        or not of_rows.mean()
    ):
        return False
    usual = of_rows.mean()
    sd = beyond.std(ddof=1) / np.sqrt(len(beyond))
    chance = np.hypot(sd, of_rows.std(ddof=1)) / abs(usual)
    return abs(beyond.mean() / usual - 1) > max(TONE_CHANGE_TOL, CHANCE_SIGMAS * chance)


# Does a side of a board end at an occluder or in a shadow? The edge of a sheet, a book
# or a table is straight and extends beyond both ends of the side, with the same tone
# behind it. The squares in a shadow are darker by one factor, dark and bright alike.


# Positions beyond the end of a side, in squares, and number of positions behind each of
# its squares. Offsets from its edge, in squares, at which tones are measured.
EXTENSION_SQUARES = np.array([0.2, 0.45, 0.7, 0.95])
N_SAMPLES_PER_SQUARE = 5
NEAR_OFFSET_SQUARES, FAR_OFFSET_SQUARES = 0.25, 0.5
# Lengths of outer squares that deviate more from their median are not used.
LENGTH_TOL_SQUARES = 0.25
# Relative to the contrast of the squares: largest deviation within one tone; smallest
# contrast of an edge, also as a multiple of the deviations on either side of it. White
# paper on white paper has a contrast of 0.03.
UNIFORM_TONE_TOL, MIN_EDGE_STEP, MIN_EDGE_SHARPNESS = 0.1, 0.025, 4.0
# Smallest number of positions beyond the ends, and smallest fraction of them with an
# edge: the occluder may have the tone of its background in places.
MIN_N_POSITIONS, MIN_SHARP_FRACTION = 3, 0.5
# Positions of the four squares around a corner, (s, t).
SQUARE_OFFSETS = tuple(0.3 * np.array(k) for k in ((1, -1, -1, 1), (1, 1, -1, -1)))


def occluded_side(grid, image):
    """The side that ends at a straight edge extending beyond it (`side_named`), or ''.

    image: (height, width) uint8.
    """
    patches, _, _ = patches_of(grid.points)
    tones = grey_at(image, patches.at(*SQUARE_OFFSETS).astype(np.float32))
    scale = max(np.subtract(*np.percentile(tones, (90, 10))), 1.0)
    for on_side, outward in sides_of(grid):
        side = patches.of(on_side)
        length = lengths_outward(grid, image, on_side, outward)
        if _extends_beyond(image, side, outward, length, scale):
            return side_named(side.p, grid.points[grid.known])
    return ""


def _extends_beyond(image, side, outward, length, scale):
    """Whether the edge at `length` outward of a side's corners extends beyond the side.

    Straight in the image, or curved as the side is: a lens bends near and far alike,
    but does not bend lines through its centre.
    """
    usual = np.abs(length - np.median(length)) < LENGTH_TOL_SQUARES
    if np.count_nonzero(usual) < MIN_N_SIDE_CORNERS:
        return False
    axis = 0 if outward[0] else 1
    out = outward[axis] * (side.u, side.v)[axis]
    bent = (side.uu, side.vv)[axis]
    edge = side.p + length[:, None] * out + (length**2)[:, None] * bent
    steps = np.linalg.norm(np.diff(edge, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    ends = (
        -steps[0] * (1 + EXTENSION_SQUARES),
        along[-1] + steps[-1] * (1 + EXTENSION_SQUARES),
    )
    last = np.array(image.shape[::-1]) - 2

    def runs_on(curve):
        def grey(at, offset):
            sideways = np.column_stack(
                [np.interp(at, along, out[:, k]) for k in (0, 1)]
            )
            pixels = np.vander(at, len(curve)) @ curve + offset * sideways
            inside = np.all((pixels >= 1) & (pixels <= last), axis=1)
            values = grey_at(image, pixels[None].astype(np.float32))[0] / scale
            return np.where(inside, values, np.nan)

        behind = grey(
            np.linspace(along[0], along[-1], N_SAMPLES_PER_SQUARE * len(along)),
            NEAR_OFFSET_SQUARES,
        )
        return _is_edge(behind, np.concatenate(ends), grey)

    degrees = (1, 2) if np.count_nonzero(usual) > MIN_N_SIDE_CORNERS else (1,)
    return any(runs_on(np.polyfit(along[usual], edge[usual], k)) for k in degrees)


def _is_edge(behind, beyond, grey):
    """Whether the tone `behind` a side (N,) continues with an edge beyond its ends.

    beyond: positions there; grey(positions, offset): grey level at an offset from the
    edge.
    """
    behind = behind[np.isfinite(behind)]
    if not len(behind) or behind.std() > UNIFORM_TONE_TOL:
        return False
    tones = np.array(
        [
            grey(beyond, offset)
            for offset in (
                FAR_OFFSET_SQUARES,
                NEAR_OFFSET_SQUARES,
                -NEAR_OFFSET_SQUARES,
                -FAR_OFFSET_SQUARES,
            )
        ]
    )
    far, near, inner_near, inner_far = tones[:, np.isfinite(tones).all(axis=0)]
    if (
        len(near) < MIN_N_POSITIONS
        or np.abs(near - np.median(behind)).max() > UNIFORM_TONE_TOL
    ):
        return False
    step, outer, inner = (
        np.abs(a) for a in (near - inner_near, far - near, inner_near - inner_far)
    )
    of_one_tone = np.abs([far, near] - np.median(behind)).max()
    min_step = max(MIN_EDGE_STEP, MIN_EDGE_SHARPNESS * behind.std())
    sharp = step > np.maximum(MIN_EDGE_SHARPNESS * np.maximum(outer, inner), min_step)
    # An object of one tone ends at once, also on a background of varying tone.
    ends = step > np.maximum(inner, max(MIN_EDGE_SHARPNESS * of_one_tone, min_step))
    return np.mean(sharp | ends) >= MIN_SHARP_FRACTION


def side_before_shadow(grid, level):
    """The side with squares in a shadow behind it (`side_named`), or ''.

    level: `saddles.Level`. Tests the contrast of the squares of the next row.
    """
    lattice = np.pad(grid.points, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
    lattice = np.where(np.isfinite(lattice), lattice, predicted(lattice))
    patches, i, j = patches_of(lattice)
    high, wide = lattice.shape[:2]
    for axis, at, across, count, n_across in (
        (0, i, j, high, wide),
        (1, j, i, wide, high),
    ):
        steps, inside = steps_across(patches, level, axis)
        steps = steps * np.where((i + j) % 2 == 0, 1.0, -1.0)[:, None]
        for end, outer in ((0, 0), (count - 1, 1)):
            row = (at == end) & (across > 0) & (across < n_across - 1) & inside
            if np.count_nonzero(row) < MIN_N_SIDE_CORNERS:
                continue
            usual = np.median(steps[row, 1 - outer])
            share = -steps[row, outer] / usual if usual else np.zeros(1)
            sd = share.std(ddof=1) / np.sqrt(len(share))
            if share.mean() - CHANCE_SIGMAS * sd > ROW_THRESHOLD:
                return side_named(patches.p[row], grid.points[grid.known])
    return ""
