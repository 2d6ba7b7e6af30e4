"""Images of the grids of section 3.3.2, one at a time.

An image depends only on its number, a seed and the range of poses. Pose, light, glare
and noise are its own; the flaws of the mirror are the seed's.
"""

from __future__ import annotations

from copy import deepcopy
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chapters.shared.grid_rigs import SETS, rig_of, wiped
from chapters.shared.lattices import clockwise, corner_areas, outer
from raxel.geometry import on_plane, transform
from raxel.lab.board_photograph import grey_of, light_of_board, saved

IMAGES = 15
# Streams of random numbers of a seed.
POSE, PICTURE, SPECIMEN, CLICKS = 0, 1, 2, 3


class GridView(NamedTuple):
    """An image of a grid and its true corners.

    image: (H, W) uint8; corners: (rows * columns, 2) px, row by row, so that
    columns and rows turn clockwise in the image, also behind a mirror;
    outer_corners: (4, 2), clockwise in the image, the first (row 0, column 0);
    colour: the same image as saved by the camera, (H, W, 3) if coloured; pitch_mm:
    of the grid.
    """

    image: np.ndarray
    corners: np.ndarray
    columns: int
    rows: int
    outer_corners: np.ndarray
    colour: np.ndarray
    pitch_mm: float


def stream(set_name, image, seed, kind):
    """Return the numpy Generator of one kind of draw for one image."""
    number = list(SETS).index(set_name)
    return np.random.default_rng([seed, number, kind, image])


@lru_cache(maxsize=1)
def taken(set_name, image, seed, poses):
    """Return (rig, pose, light on its sensor, Generator for the rest) of an image."""
    rig = rig_of(set_name, image, poses)
    pose = rig.draw_poses(stream(set_name, image, seed, POSE), 1)[0]
    draws = stream(set_name, image, seed, PICTURE)
    return rig, pose, light_of_board(rig, pose, draws), draws


def grid_view(set_name, image, seed, poses, without=None):
    """Render image number `image` (from 0) of a set from a seed: GridView.

    set_name: key of SETS; seed: whole number, 0 or more; poses: WHOLE or HARD of
    grid_rigs; without: None, or the blemish, a key of CLEANED, to omit with all
    else equal.
    """
    rig, pose, light, draws = taken(set_name, image, seed, poses)
    rig = wiped(rig, without)
    number = list(SETS).index(set_name)
    specimen = np.random.default_rng([seed, number, SPECIMEN])
    picture = saved(rig, light, deepcopy(draws), specimen)
    points = on_plane(rig.target.points())
    corners = rig.camera.project(transform(pose, points)).pixels
    columns, rows = rig.target.columns, rig.target.rows
    lattice = clockwise(corners.reshape(rows, columns, 2))
    return GridView(
        grey_of(picture),
        lattice.reshape(-1, 2),
        columns,
        rows,
        outer(lattice),
        picture,
        rig.target.pitch_mm,
    )


def from_smallest(lattice):
    """Return the lattice starting at the outer corner with the smallest square.

    lattice: (rows, columns, 2), clockwise in the image, as is the result. Its rows
    and columns are exchanged if it starts along the other side.
    """
    return np.rot90(lattice, int(corner_areas(lattice).argmin()))
