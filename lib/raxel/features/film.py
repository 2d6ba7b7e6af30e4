"""Corners of a chessboard, from one picture of a film to the next.

Between two pictures a board moves little, so no search of the whole picture is needed.
Optical flow says about where each corner went; the flow of all of them together, a
smooth function of the lattice, mends what one of them got wrong. The saddle points of
the grey values say where exactly. A corner counts only if the four squares around it
are dark and bright as they were: its direct neighbours have them the other way round,
so none can take another's place. Corners that come into view are sought where the
lattice, carried on, has them.
Source of the flow: Bouguet 2001, pyramidal Lucas-Kanade, by OpenCV.
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.features.lattice import misfit, spacing
from raxel.features.localise import saddle_point

# Windows of flow and of saddle points, as shares of the distance of corners; px.
FLOW_SHARE, FLOW_PX, LEVELS = 0.9, (11, 61), 3
SADDLE_SHARE, SADDLE_PX, BLUR_SD = 0.4, (7, 25), 1.0
# Of the distance to the next corner: how far one may lie off the smooth flow or the
# lattice's course, and the saddle point off where it was sought.
ASTRAY, OFF_THE_LATTICE = 0.3, 0.25
# Next corners but one have squares that look alike. For one of these to be taken, after
# a true step of half a square, a corner would have to move farther than this.
FARTHEST = 0.7
# Where the squares around a corner are looked at: as far as its window reaches and
# EDGE_PX more, but no farther than this share of a square; how far places that are dark
# or bright as they should must outnumber the others, of all.
PLACES, EDGE_PX, WITHIN = np.array([-1, -0.75, -0.5, -0.3, 0.3, 0.5, 0.75, 1]), 3.0, 0.4
RIGHT = 0.95
FEWEST, ROUNDS = 6, 3
SMOOTHED = 8  # rounds in which flow that is off counts less and less


class FilmCorners(NamedTuple):
    """corners (N, 2) px of the picture after, NaN for those not seen; sd (N,) px, see
    `raxel.features.localise`; lost, regained (N,) bool: seen before and not after, and
    the other way round."""

    corners: np.ndarray
    sd: np.ndarray
    lost: np.ndarray
    regained: np.ndarray


def next_corners(before, after, corners, columns, rows):
    """FilmCorners of the picture after, from the corners of the picture before.

    before, after: (H, W) uint8, grey, of one film; corners: (rows * columns, 2) px of
    the picture before, row by row, NaN for those not seen. They may move by up to half
    a square: a board that moves farther may be taken for itself a square down and one
    aside, which looks alike. Raises InputError for pictures or corners that do not fit
    each other, for fewer than six corners before, and where no two are neighbours.
    """
    before, after, corners = _checked(before, after, corners, columns, rows)
    seen = np.isfinite(corners[:, 0])
    step = _usual_step(corners, columns, rows)
    lattice = np.indices((rows, columns)).reshape(2, -1).T
    sense = (-1.0) ** lattice.sum(axis=1)
    likeness = _likeness(before, corners, columns, rows, sense, step)
    sense = sense * (np.sign(np.nansum(likeness)) or 1.0)
    place = _flown(before, after, corners, lattice, step)
    found, sd = np.full(corners.shape, np.nan), np.full(len(corners), np.nan)
    sought, carried = np.isfinite(place[:, 0]), np.zeros(len(corners), bool)
    for _ in range(ROUNDS):
        if not sought.any():
            break
        found[sought], sd[sought] = _saddles(after, place[sought], step)
        wrong = ~_fits(after, found, columns, rows, sense, step)
        wrong |= np.linalg.norm(found - corners, axis=1) > FARTHEST * step
        found[wrong], sd[wrong] = np.nan, np.nan
        # Those not seen yet, next to ones that are, once each.
        place = carried_on(found, columns, rows)
        sought = np.isnan(found[:, 0]) & np.isfinite(place[:, 0]) & ~carried
        carried |= sought
    now = np.isfinite(found[:, 0])
    return FilmCorners(found, sd, seen & ~now, now & ~seen)


def _usual_step(corners, columns, rows):
    """Median distance in px from a corner to its nearest neighbour, of those that have
    one; InputError where none has."""
    apart = spacing(corners, columns, rows)
    apart = apart[np.isfinite(apart)]
    if not len(apart):
        raise InputError(
            "film: no two corners before are neighbours; give corners found anew"
        )
    return np.median(apart)


def carried_on(corners, columns, rows):
    """Where the lattice puts each corner by those beyond its neighbours: (N, 2) px.

    A parabola through the next three along a row or column, the mean over the sides
    that have three; NaN where none has.
    """
    grid = np.pad(
        corners.reshape(rows, columns, 2),
        ((3, 3), (3, 3), (0, 0)),
        constant_values=np.nan,
    )

    def beside(down, right):
        return grid[3 + down : 3 + down + rows, 3 + right : 3 + right + columns]

    sides = [
        3 * beside(a, b) - 3 * beside(2 * a, 2 * b) + beside(3 * a, 3 * b)
        for a, b in ((0, 1), (0, -1), (1, 0), (-1, 0))
    ]
    known = np.isfinite(sides)
    total = np.where(known, sides, 0.0).sum(axis=0)
    count = known.sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan).reshape(-1, 2)


def _flown(before, after, corners, lattice, step):
    """Where optical flow takes the corners seen, mended by the flow of all."""
    import cv2

    seen = np.flatnonzero(np.isfinite(corners[:, 0]))
    width = _odd(FLOW_SHARE * step, FLOW_PX)
    start = corners[seen].astype(np.float32)
    went, known, _ = cv2.calcOpticalFlowPyrLK(
        before, after, start, None, winSize=(width, width), maxLevel=LEVELS
    )
    motion = np.where(known == 1, went - start, np.nan)
    smooth = _smooth(lattice[seen], motion)
    near = np.linalg.norm(motion - smooth, axis=1) <= ASTRAY * step
    place = np.full(corners.shape, np.nan)
    place[seen] = corners[seen] + np.where(near[:, None], motion, smooth)
    return place


def _smooth(lattice, motion):
    """The quadratic in the lattice's coordinates nearest to motion (n, 2), by the sum
    of distances, at all n; rows of NaN do not count."""
    i, j = (lattice - lattice.mean(axis=0)).T / max(np.ptp(lattice), 1)
    A = np.column_stack([np.ones(len(i)), i, j, i * i, i * j, j * j])
    known = np.isfinite(motion[:, 0])
    weights = known.astype(float)
    motion = np.where(known[:, None], motion, 0.0)
    for _ in range(SMOOTHED):
        root = np.sqrt(weights)[:, None]
        found = A @ np.linalg.lstsq(root * A, root * motion, rcond=None)[0]
        off = np.linalg.norm(motion - found, axis=1)
        weights = known / np.maximum(off, 0.1)
    return found


def _saddles(picture, place, step):
    """(corners (n, 2), sd (n,)) at the saddle points next to places, NaN where there is
    none; only the part of the picture around them is looked at."""
    height, width = picture.shape
    margin = int(step) + SADDLE_PX[1]
    low = np.floor(place.min(axis=0)).astype(int) - margin
    u, v = np.clip(low, 0, [width - 1, height - 1])
    high = np.ceil(place.max(axis=0)).astype(int) + margin
    part = picture[v : max(high[1], v + 1), u : max(high[0], u + 1)]
    window = _saddle_window(step)
    got = saddle_point(part, place - [u, v], window=window, blur_sd=BLUR_SD)
    there = got.converged & np.isfinite(got.sd)
    moved = np.linalg.norm(got.corners - (place - [u, v]), axis=1)
    there &= moved <= ASTRAY * step
    return (
        np.where(there[:, None], got.corners + [u, v], np.nan),
        np.where(there, got.sd, np.nan),
    )


def _fits(picture, corners, columns, rows, sense, step):
    """Which corners (N,) lie on the lattice's course, with the right squares around."""
    off = misfit(corners, columns, rows)[0]
    like = _likeness(picture, corners, columns, rows, sense, step)
    return ~(off > OFF_THE_LATTICE) & (like >= RIGHT)


def _likeness(picture, corners, columns, rows, sense, step):
    """Share (N,) of places around each corner that are bright or dark as `sense` (N,)
    has it, less that of the others: 1 where all are right, -1 where all are wrong, NaN
    where a corner or its neighbours are missing."""
    import cv2

    along, down = _directions(corners.reshape(rows, columns, 2))
    reach = min((_saddle_window(step) // 2 + EDGE_PX) / step, WITHIN)
    a, b = (part.ravel() for part in np.meshgrid(reach * PLACES, reach * PLACES))
    places = corners[:, None] + a[:, None] * along[:, None] + b[:, None] * down[:, None]
    known = np.isfinite(places).all(axis=(1, 2))
    at = np.where(known[:, None, None], places, 0).astype(np.float32)
    grey = cv2.remap(picture, at, None, cv2.INTER_LINEAR).astype(float)
    wanted = np.sign(a * b) * sense[:, None]
    bright = (grey * (wanted > 0)).sum(axis=1) / (wanted > 0).sum(axis=1)
    dark = (grey * (wanted < 0)).sum(axis=1) / (wanted < 0).sum(axis=1)
    level = (bright + dark)[:, None] / 2
    return np.where(known, np.mean(np.sign(grey - level) * wanted, axis=1), np.nan)


def _directions(lattice):
    """Steps (N, 2) of a lattice (rows, columns, 2) along rows and down columns: from
    neighbours on both sides, or on one."""
    found = []
    for axis in (1, 0):
        step = np.diff(lattice, axis=axis)
        pad = [(0, 0)] * 3
        pad[axis] = (1, 1)
        step = np.pad(step, pad, constant_values=np.nan)
        sides = np.stack([np.delete(step, -1, axis), np.delete(step, 0, axis)])
        known = np.isfinite(sides)
        total = np.where(known, sides, 0.0).sum(axis=0)
        count = known.sum(axis=0)
        mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
        found.append(mean.reshape(-1, 2))
    return found


def _saddle_window(step):
    return _odd(SADDLE_SHARE * step, SADDLE_PX)


def _odd(size, ends):
    return 2 * int(np.clip(size, *ends) / 2) + 1


def _checked(before, after, corners, columns, rows):
    before, after = np.ascontiguousarray(before), np.ascontiguousarray(after)
    for name, picture in (("before", before), ("after", after)):
        if picture.ndim != 2 or picture.dtype != np.uint8:
            raise InputError(
                f"film: the picture {name} is {picture.dtype} {picture.shape}; give "
                "grey values (H, W), uint8"
            )
    if before.shape != after.shape:
        raise InputError(
            f"film: pictures of {before.shape} and {after.shape}; give pictures of one "
            "film, alike in size"
        )
    corners = np.array(corners, float)
    if corners.shape != (rows * columns, 2):
        raise InputError(
            f"film: corners {corners.shape} for {columns} columns, {rows} rows; give "
            f"({rows * columns}, 2), NaN where one was not seen"
        )
    count = np.count_nonzero(np.isfinite(corners).all(axis=1))
    if count < FEWEST:
        raise InputError(
            f"film: {count} corners before; give {FEWEST} or more, found anew in a "
            "picture where the board is seen"
        )
    corners[~np.isfinite(corners).all(axis=1)] = np.nan
    return before, after, corners
