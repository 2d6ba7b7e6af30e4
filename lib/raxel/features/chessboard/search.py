"""All lattices of four-field corners in an image."""

from typing import NamedTuple

import numpy as np

from raxel.features.chessboard.ends import ended, window_of
from raxel.features.chessboard.grids import (
    cut_to,
    grid_of,
    nearly_complete,
    settled,
    trimmed,
)
from raxel.features.chessboard.links import as_grid, lattices_of, links_of
from raxel.features.chessboard.saddles import (
    Nodes,
    joined,
    levels_of,
    nodes_of,
    noise_sd,
    saddles_of,
    sharp_level,
)

LEAST_NODES = 7
MOST_LATTICES = 8
SAME_PX = 2.5


class Seen(NamedTuple):
    """What an image shows: grids, the one with most corners first; nodes: all corners
    of four fields (`ring.Nodes`); levels: the image at its scales; parted: which grids
    are parts of lattices that run on beyond the board."""

    grids: list
    nodes: Nodes
    levels: list
    parted: tuple = ()


def seen_in(image, size=None):
    """All lattices in an image (height, width), uint8 or float32: `Seen`.

    size: (columns, rows) of the board that is looked for, None where unknown.
    """
    grey = image.astype(np.float32)
    noise = noise_sd(grey)
    levels = levels_of(grey, noise)
    parts = [
        nodes_of(level, saddles_of(level), number)
        for number, level in enumerate(levels)
    ]
    nodes = joined(parts, levels)
    if not len(nodes.points):
        return Seen([], nodes, levels)
    links = links_of(nodes, levels)
    grids = grids_of(nodes, links, levels)
    grids = [ended(grid, levels[0], told=size is not None) for grid in grids]
    grids = [trimmed(grid) for grid in grids]
    parted = [False] * len(grids)
    if size:
        sizes = size[::-1], size
        grids = [cut_to(grid, sizes) for grid in grids]
        parts = [
            None if grid.known.shape in sizes else window_of(grid, sizes, levels[0])
            for grid in grids
        ]
        parted = [part is not None for part in parts]
        grids = [part or grid for part, grid in zip(parts, grids, strict=True)]
    whole = [nearly_complete(grid) for grid in grids]
    if any(whole):
        sharp = levels[0], sharp_level(grey, noise)
        grids = [
            settled(grid, sharp) if some else grid
            for grid, some in zip(grids, whole, strict=True)
        ]
    order = sorted(range(len(grids)), key=lambda k: -grids[k].count)
    parted = tuple(parted[k] for k in order)
    return Seen([grids[k] for k in order], nodes, levels, parted)


def grids_of(nodes, links, levels):
    """The grids that grow from the lattices of linked nodes, the largest lattice first.

    It ends for any input: each pass takes a lattice off the queue and puts back only
    lattices of those of its nodes that the grid left, if it left fewer than all. A node
    is in one lattice at most, so the nodes in the queue become fewer with every pass.
    """
    queue, grids = lattices_of(nodes, links)[:MOST_LATTICES], []
    taken = np.zeros(len(nodes.points), bool)
    # A corner seen in a coarse copy is known to a pixel of that copy.
    reach = SAME_PX * np.array([level.scale for level in levels])
    while queue:
        lattice = queue.pop(0)
        of = np.array(list(lattice.values()))
        if (grids and len(of) < LEAST_NODES) or taken[of].mean() > 0.5:
            continue
        grid = grid_of(as_grid(lattice, nodes.points), nodes.points[~taken], levels[0])
        if grid is None:
            continue
        grids.append(grid)
        taken |= _near(nodes.points, grid.points[grid.known], reach[nodes.level])
        left = of[~taken[of]]
        if LEAST_NODES <= len(left) < len(of):
            queue += lattices_of(nodes, _links_among(links, left))
    return grids


def _near(points, others, reach):
    """Which points (N, 2) lie within reach (N,) px of one of the others (M, 2)."""
    from raxel.features.chessboard.compiled import nearest

    return nearest(points, others)[1] < reach


def _links_among(links, some):
    """The links between these nodes only."""
    chosen = np.zeros(len(links) + 1, bool)
    chosen[some] = True
    keep = chosen[:-1, None] & chosen[links[..., 0]]
    return np.where(keep[..., None], links, -1)
