"""Pictures of the grids of section 3.3.2, one at a time, and of Fig. 3.14.

A set's picture depends on its number and a seed alone: pose, light, glare and
noise are its own, the flaws of the mirror are the seed's. No detector has a say.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from raxel.geometry import transform
from raxel.lab import load_rig
from raxel.lab.board_photograph import grey_of, photograph_board

ROOT = Path(__file__).resolve().parents[2]
IMAGES = 15
# Rigs of a set, each with how many of its images it takes (E-3.14).
SETS = {
    "spherical": (("spherical", 15),),
    "hyperboloidal": (("hyperboloidal", 15),),
    "fisheye": (("fisheye-9x7", 7), ("fisheye-12x9", 8)),
    "flexible-mirror": (("flexible-mirror", 15),),
    "large-hyperboloidal": (("large-hyperboloidal", 1),),
    "large-fisheye": (("large-fisheye", 1),),
}
TITLES = {
    "spherical": "Spherical",
    "hyperboloidal": "Hyperboloidal",
    "fisheye": "Fisheye",
    "flexible-mirror": "Flexible Mirror",
}
# Streams of random numbers of a seed.
POSE, PICTURE, SPECIMEN = 0, 1, 2


class GridView(NamedTuple):
    """A picture of a grid and where its corners truly are.

    image: (H, W) uint8; corners: (rows * columns, 2) px, row by row, so that
    columns and rows turn clockwise in the picture, also behind a mirror;
    outer_corners: (4, 2), clockwise in the picture, the first (row 0, column 0);
    colour: the same picture as the camera saved it, (H, W, 3) where coloured;
    pitch_mm: of the grid.
    """

    image: np.ndarray
    corners: np.ndarray
    columns: int
    rows: int
    outer_corners: np.ndarray
    colour: np.ndarray
    pitch_mm: float


@lru_cache(maxsize=8)
def rig_named(name):
    """The rig of one file of data/rigs."""
    return load_rig(ROOT / "data" / "rigs" / f"{name}.yaml")


def rig_of(set_name, image):
    """The rig that took an image, 0 to 14, of a set."""
    for name, count in SETS[set_name]:
        if image < count:
            return rig_named(name)
        image -= count
    raise ValueError(f"{set_name} has no image {image}")


def grid_view(set_name, image, seed):
    """Image number `image` (from 0) of a set, rendered from a seed: GridView.

    set_name: key of SETS; seed: whole number, 0 or more.
    """
    rig = rig_of(set_name, image)
    number = list(SETS).index(set_name)
    streams = [
        np.random.default_rng([seed, number, kind, image])
        for kind in (POSE, PICTURE)
    ]
    specimen = np.random.default_rng([seed, number, SPECIMEN])
    pose = rig.draw_poses(streams[0], 1)[0]
    picture = photograph_board(rig, pose, streams[1], specimen)
    points = np.pad(rig.target.points(), ((0, 0), (0, 1)))
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


def clockwise(lattice):
    """The lattice (rows, columns, 2), its columns reversed where mirrored."""
    (ax, ay), (bx, by) = np.diff(outer(lattice)[[3, 0, 1]], axis=0)
    return lattice if ax * by > ay * bx else lattice[:, ::-1]


def outer(lattice):
    """Corners (4, 2) of a lattice (rows, columns, 2), around it by its rows."""
    return np.array(
        [lattice[0, 0], lattice[0, -1], lattice[-1, -1], lattice[-1, 0]]
    )
