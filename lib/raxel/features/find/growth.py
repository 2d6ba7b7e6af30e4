"""Linked corners put on lattices: which corner is in which row and column."""

import heapq

import numpy as np

STEPS = ((1, 0), (0, 1), (-1, 0), (0, -1))
LEAST_RATIO = 0.4
LEAST_COSINE = 0.75
LEAST_NODES = 4


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
        lattice = _grown(seed, points, nodes.contrast, table, used)
        if len(lattice) >= LEAST_NODES:
            used.update(lattice.values())
            lattices.append(lattice)
    return sorted(lattices, key=len, reverse=True)


def _grown(seed, points, contrast, links, used):
    """The lattice around a node: dict (x, y) -> node."""
    placed, rotation, cells = {}, {}, {}
    queue = [(0.0, 0, seed, 0, (0, 0), -1)]
    count = 0
    while queue:
        _, _, node, turn, cell, origin = heapq.heappop(queue)
        if node in placed or cell in cells or node in used:
            continue
        if origin >= 0 and not _fits(node, turn, cell, points, links, cells, placed):
            continue
        placed[node], rotation[node], cells[cell] = cell, turn, node
        for k in range(4):
            other, m = links[node][k]
            if other < 0 or other in placed:
                continue
            towards = (k + turn) % 4
            step = STEPS[towards]
            there = cell[0] + step[0], cell[1] + step[1]
            count += 1
            cost = _cost(node, other, towards, cell, points, contrast, cells)
            item = (cost, count, other, (k + turn + 2 - m) % 4, there, node)
            heapq.heappush(queue, item)
    return cells


def _cost(node, other, towards, cell, points, contrast, cells):
    """Small for links as long as the one behind and between equal contrasts."""
    step = STEPS[towards]
    behind = cells.get((cell[0] - step[0], cell[1] - step[1]))
    unequal = abs(np.log(contrast[node] / contrast[other]))
    if behind is None:
        return unequal + 0.5
    a = points[other] - points[node]
    b = points[node] - points[behind]
    return unequal + abs(np.log(np.hypot(*a) / np.hypot(*b)))


def _fits(node, turn, cell, points, links, cells, placed):
    """Whether a node may stand in this cell, judged by its neighbours and links."""
    x, y = cell
    for k in range(4):
        other = links[node][k][0]
        step = STEPS[(k + turn) % 4]
        if other in placed and placed[other] != (x + step[0], y + step[1]):
            return False
        neighbour = cells.get((x + step[0], y + step[1]))
        if neighbour is None:
            continue
        along = points[neighbour] - points[node]
        for other_pair in _compared(cells, (x, y), step):
            if not _alike(along, points[other_pair[1]] - points[other_pair[0]]):
                return False
    return True


def _compared(cells, cell, step):
    """Placed pairs beside and beyond the link from `cell` by `step`."""
    (x, y), (dx, dy) = cell, step
    first = cells.get((x + dx, y + dy)), cells.get((x + 2 * dx, y + 2 * dy))
    left = cells.get((x + dy, y + dx)), cells.get((x + dx + dy, y + dy + dx))
    right = cells.get((x - dy, y - dx)), cells.get((x + dx - dy, y + dy - dx))
    return [pair for pair in (first, left, right) if None not in pair]


def _alike(a, b):
    """Whether two vectors are about as long and about parallel."""
    m, n = np.hypot(*a), np.hypot(*b)
    ratio = m / n if m < n else n / m
    return ratio > LEAST_RATIO and (a @ b) > LEAST_COSINE * m * n


def as_grid(lattice, points):
    """(corners (rows, columns, 2), NaN where none) of a lattice's dict."""
    cells = np.array(list(lattice))
    low = cells.min(axis=0)
    columns, rows = cells.max(axis=0) - low + 1
    grid = np.full((rows, columns, 2), np.nan)
    x, y = (cells - low).T
    grid[y, x] = points[list(lattice.values())]
    return grid
