"""All lattices of chessboard corners in an image."""

from typing import NamedTuple

import numpy as np

from raxel.features.chessboard.compiled import nearest
from raxel.features.chessboard.ends import board_within, trim_paper_edges
from raxel.features.chessboard.grids import (
    cut_to,
    grid_of,
    is_nearly_complete,
    refine_grid,
    trimmed,
)
from raxel.features.chessboard.links import as_grid, lattices_of, links_of
from raxel.features.chessboard.saddles import (
    Nodes,
    levels_of,
    merge_nodes,
    nodes_of,
    noise_sd,
    saddles_of,
    sharp_level,
)

MIN_N_NODES = 7
MAX_N_LATTICES = 8
SAME_CORNER_PX = 2.5


class SearchResult(NamedTuple):
    """What an image contains: lattices and corners.

    grids: the lattice with most corners first; nodes: all corners of four squares
    (`saddles.Nodes`); levels: the image at its scales; is_part: which grids are parts
    of lattices that extend beyond the board.
    """

    grids: list
    nodes: Nodes
    levels: list
    is_part: tuple = ()


def search_image(image, size=None):
    """All lattices in an image (height, width), uint8 or float32: `SearchResult`.

    size: (columns, rows) of the board, None where unknown.
    """
    grey = image.astype(np.float32)
    noise = noise_sd(grey)
    levels = levels_of(grey, noise)
    parts = [
        nodes_of(level, saddles_of(level), number)
        for number, level in enumerate(levels)
    ]
    nodes = merge_nodes(parts, levels)
    if not len(nodes.points):
        return SearchResult([], nodes, levels)
    links = links_of(nodes, levels)
    grids = grids_of(nodes, links, levels)
    grids = [
        trim_paper_edges(grid, levels[0], known_size=size is not None) for grid in grids
    ]
    grids = [trimmed(grid) for grid in grids]
    is_part = [False] * len(grids)
    if size:
        sizes = size[::-1], size
        grids = [cut_to(grid, sizes) for grid in grids]
        parts = [
            None if grid.known.shape in sizes else board_within(grid, sizes, levels[0])
            for grid in grids
        ]
        is_part = [part is not None for part in parts]
        grids = [part or grid for part, grid in zip(parts, grids, strict=True)]
    whole = [is_nearly_complete(grid, size is not None) for grid in grids]
    if any(whole):
        sharp = levels[0], sharp_level(grey, noise)
        grids = [
            refine_grid(grid, sharp) if whole_one else grid
            for grid, whole_one in zip(grids, whole, strict=True)
        ]
    order = sorted(range(len(grids)), key=lambda k: -grids[k].count)
    is_part = tuple(is_part[k] for k in order)
    return SearchResult([grids[k] for k in order], nodes, levels, is_part)


def grids_of(nodes, links, levels):
    """The grids grown from lattices of linked nodes, the largest lattice first.

    The loop terminates for any input. Each pass takes a lattice from the queue and
    returns only lattices of those of its nodes that the grid did not use, if the grid
    used at least one. A node belongs to one lattice at most, so each pass reduces the
    number of nodes in the queue.
    """
    queue, grids = lattices_of(nodes, links)[:MAX_N_LATTICES], []
    taken = np.zeros(len(nodes.points), bool)
    # The position of a corner found in a coarse copy is known to a pixel of that copy.
    reach = SAME_CORNER_PX * np.array([level.scale for level in levels])
    while queue:
        lattice = queue.pop(0)
        lattice_nodes = np.array(list(lattice.values()))
        if (grids and len(lattice_nodes) < MIN_N_NODES) or taken[
            lattice_nodes
        ].mean() > 0.5:
            continue
        grid = grid_of(as_grid(lattice, nodes.points), nodes.points[~taken], levels[0])
        if grid is None:
            continue
        grids.append(grid)
        _, distance = nearest(nodes.points, grid.points[grid.known])
        taken |= distance < reach[nodes.level]
        unused = lattice_nodes[~taken[lattice_nodes]]
        if MIN_N_NODES <= len(unused) < len(lattice_nodes):
            queue += lattices_of(nodes, _links_among(links, unused))
    return grids


def _links_among(links, selected):
    """The links between these nodes only."""
    chosen = np.zeros(len(links) + 1, bool)
    chosen[selected] = True
    keep = chosen[:-1, None] & chosen[links[..., 0]]
    return np.where(keep[..., None], links, -1)
