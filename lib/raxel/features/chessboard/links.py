"""Links between corners along edges, and lattices grown from the links."""

from __future__ import annotations

import heapq
from collections.abc import Container, Sequence
from typing import NamedTuple

import numpy as np

from raxel.features.chessboard.saddles import paint_discs, pixels_of

# The four edges of every corner are followed to the next corner, without a model or a
# prediction: one step along the edge, then across to the strongest gradient. Along an
# edge the same side is bright. Where the edge passes a corner the sides swap, so that a
# trace detects a corner even if it is no node.


# Distance in px of the level from its corner at which a trace starts, and radius around
# a corner at which it ends.
TRACE_START_PX, CAPTURE_RADIUS_PX = 3.0, 2.6
MAX_ARRIVAL_ANGLE_RAD = np.radians(38)
# Slope across an edge (grey levels over 2 ACROSS) as a share of the ring's contrast.
SLOPE_CONTRAST_RATIO = 0.12


class Atlas(NamedTuple):
    """All levels in one image: grey levels and known corners (index + 1, 0 elsewhere).

    left, top, width, height, scale: (levels,) position, size and scale of each.
    """

    grey: np.ndarray
    known: np.ndarray
    left: np.ndarray
    top: np.ndarray
    width: np.ndarray
    height: np.ndarray
    scale: np.ndarray


def atlas_of(levels, points):
    """The Atlas of the levels with corners `points` (N, 2) of the image."""
    sizes = np.array([level.grey.shape for level in levels])
    height, width = sizes.T
    top = np.concatenate([[0, 0], np.cumsum(height[1:-1])])[: len(levels)]
    left = np.where(np.arange(len(levels)) == 0, 0, width[0])
    shape = (top + height).max(), (left + width).max()
    grey, known = np.zeros(shape, np.float32), np.zeros(shape, np.int32)
    numbers = np.arange(1, len(points) + 1)
    for level, x, y, w, h in zip(levels, left, top, width, height, strict=True):
        region = slice(y, y + h), slice(x, x + w)
        grey[region] = level.grey
        pixels = pixels_of(points / level.scale, (h, w))
        paint_discs(known[region], pixels, numbers, CAPTURE_RADIUS_PX)
    scale = np.array([level.scale for level in levels], np.float32)
    left, top = left.astype(np.float32), top.astype(np.float32)
    sizes = width.astype(np.float32), height.astype(np.float32)
    return Atlas(grey, known, left, top, *sizes, scale)


class Arms(NamedTuple):
    """Edges to follow: from points (N, 2) px at angles (N,).

    signs (N,), contrast (N,) and level (N,) as of `saddles.Nodes`; own (N,): index of
    the corner that each edge leaves.
    """

    points: np.ndarray
    angles: np.ndarray
    signs: np.ndarray
    contrast: np.ndarray
    level: np.ndarray
    own: np.ndarray


def links_of(nodes, levels):
    """Index (N, 4, 2) of the (node, arm) at the other end of each arm; -1 for none."""
    arms = Arms(
        np.repeat(nodes.points, 4, axis=0),
        nodes.angles.ravel(),
        nodes.signs.ravel(),
        np.repeat(nodes.contrast, 4),
        np.repeat(nodes.level, 4),
        np.repeat(np.arange(len(nodes.points)), 4),
    )
    ends, heading = _trace_arms(arms, atlas_of(levels, nodes.points))
    return _confirmed_links(nodes, ends.reshape(-1, 4), heading.reshape(-1, 4))


def _trace_arms(arms, atlas):
    """(corner reached (N,) or -1, heading there (N,)) of Arms in the Atlas."""
    from raxel.features.chessboard.compiled import followed

    d = np.stack([np.cos(arms.angles), np.sin(arms.angles)], axis=1).astype(np.float32)
    start = arms.points / atlas.scale[arms.level][:, None] + TRACE_START_PX * d
    usual = SLOPE_CONTRAST_RATIO * arms.contrast
    single = (a.astype(np.float32) for a in (start, d, arms.signs, usual))
    end, d = followed(atlas, *single, arms.level, arms.own)
    return end, np.where(end < 0, arms.angles, np.arctan2(d[:, 1], d[:, 0]))


def _confirmed_links(nodes, ends, heading):
    """Links that both ends confirm, with the arm by which each arrives."""
    links = np.full((*ends.shape, 2), -1)
    i, k = np.nonzero(ends >= 0)
    if not len(i):
        return links
    j = ends[i, k]
    back = heading[i, k] + np.pi
    angle_error = (nodes.angles[j] - back[:, None] + np.pi) % (2 * np.pi) - np.pi
    wrong = nodes.signs[j] != -nodes.signs[i, k][:, None]
    angle_error = np.abs(angle_error) + 10.0 * wrong
    m = angle_error.argmin(axis=1)
    confirmed = (angle_error.min(axis=1) < MAX_ARRIVAL_ANGLE_RAD) & (ends[j, m] == i)
    links[i[confirmed], k[confirmed]] = np.stack([j[confirmed], m[confirmed]], axis=1)
    agreed = links[links[..., 0], links[..., 1]]
    number = np.arange(len(ends))[:, None]
    same = (agreed[..., 0] == number) & (agreed[..., 1] == np.arange(4))
    links[~same | (links[..., 0] < 0)] = -1
    return links


LATTICE_STEPS = ((1, 0), (0, 1), (-1, 0), (0, -1))
MIN_LENGTH_RATIO = 0.4
MIN_COSINE = 0.75
MIN_N_LATTICE_NODES = 4


def lattices_of(nodes, links):
    """Lattices as dicts (x, y) -> node, the one with the most corners first.

    links: (N, 4, 2) as `trace.links_of` gives them. A corner is in one lattice at most.
    """
    points = nodes.points
    free = (links[..., 0] >= 0).sum(axis=1)
    order = np.lexsort((-nodes.contrast, -free))
    table = links.tolist()
    used, lattices = set(), []
    for seed in order.tolist():
        if free[seed] < 2:
            break
        if seed in used:
            continue
        lattice = grow_lattice(seed, points, nodes.contrast, table, used)
        if len(lattice) >= MIN_N_LATTICE_NODES:
            used.update(lattice.values())
            lattices.append(lattice)
    return sorted(lattices, key=len, reverse=True)


def grow_lattice(
    seed: int,
    points: np.ndarray,
    contrast: np.ndarray,
    links: Sequence[Sequence[Sequence[int]]],
    used: Container[int],
) -> dict[tuple[int, int], int]:
    """Return the lattice around a node.

    Parameters
    ----------
    seed : int
        Index of the node from which the lattice grows.
    points : np.ndarray
        (N, 2) px (u, v) of the nodes.
    contrast : np.ndarray
        (N,) contrast of the nodes.
    links : Sequence[Sequence[Sequence[int]]]
        (N, 4, 2) int: for each of the four edges of a node the other node, -1 for none,
        and the edge at which the link arrives there.
    used : Container[int]
        Nodes of other lattices, which are not taken.

    Returns
    -------
    dict[tuple[int, int], int]
        (x, y) -> node.
    """
    placed, rotation, cells = {}, {}, {}  # type: ignore[var-annotated]
    queue = [(0.0, 0, seed, 0, (0, 0), -1)]
    count = 0
    while queue:
        _, _, node, turn, cell, origin = heapq.heappop(queue)
        if node in placed or cell in cells or node in used:
            continue
        if origin >= 0 and not _fits_lattice(
            node, turn, cell, points, links, cells, placed
        ):
            continue
        placed[node], rotation[node], cells[cell] = cell, turn, node
        for k in range(4):
            other, m = links[node][k]
            if other < 0 or other in placed:
                continue
            towards = (k + turn) % 4
            step = LATTICE_STEPS[towards]
            there = cell[0] + step[0], cell[1] + step[1]
            count += 1
            cost = _cost(node, other, towards, cell, points, contrast, cells)
            item = (cost, count, other, (k + turn + 2 - m) % 4, there, node)
            heapq.heappush(queue, item)
    return cells


def _cost(node, other, towards, cell, points, contrast, cells):
    """Cost of a link: small for equal lengths and equal contrasts."""
    step = LATTICE_STEPS[towards]
    behind = cells.get((cell[0] - step[0], cell[1] - step[1]))
    unequal = abs(np.log(contrast[node] / contrast[other]))
    if behind is None:
        return unequal + 0.5
    a = points[other] - points[node]
    b = points[node] - points[behind]
    return unequal + abs(np.log(np.hypot(*a) / np.hypot(*b)))


def _fits_lattice(node, turn, cell, points, links, cells, placed):
    """Whether a node fits into this cell, by its neighbours and links."""
    x, y = cell
    for k in range(4):
        other = links[node][k][0]
        step = LATTICE_STEPS[(k + turn) % 4]
        if other in placed and placed[other] != (x + step[0], y + step[1]):
            return False
        neighbour = cells.get((x + step[0], y + step[1]))
        if neighbour is None:
            continue
        along = points[neighbour] - points[node]
        for other_pair in _reference_pairs(cells, (x, y), step):
            if not _similar_vectors(
                along, points[other_pair[1]] - points[other_pair[0]]
            ):
                return False
    return True


def _reference_pairs(cells, cell, step):
    """Placed pairs parallel to the link from `cell` by `step`, and the one along it."""
    (x, y), (dx, dy) = cell, step
    first = cells.get((x + dx, y + dy)), cells.get((x + 2 * dx, y + 2 * dy))
    left = cells.get((x + dy, y + dx)), cells.get((x + dx + dy, y + dy + dx))
    right = cells.get((x - dy, y - dx)), cells.get((x + dx - dy, y + dy - dx))
    return [pair for pair in (first, left, right) if None not in pair]


def _similar_vectors(a, b):
    """Whether two vectors have similar lengths and directions."""
    m, n = np.hypot(*a), np.hypot(*b)
    ratio = m / n if m < n else n / m
    return ratio > MIN_LENGTH_RATIO and (a @ b) > MIN_COSINE * m * n


def as_grid(lattice, points):
    """Corners (rows, columns, 2), NaN where missing, of a lattice's dict."""
    cells = np.array(list(lattice))
    low = cells.min(axis=0)
    columns, rows = cells.max(axis=0) - low + 1
    grid = np.full((rows, columns, 2), np.nan)
    x, y = (cells - low).T
    grid[y, x] = points[list(lattice.values())]
    return grid
