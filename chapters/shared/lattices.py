"""Lattices of corners in a picture: which way round they go, and their outer corners.

A lattice is (rows, columns, 2) px; clockwise is as one sees it in the picture.
"""

import numpy as np


def clockwise(lattice):
    """The lattice (rows, columns, 2), its columns reversed where mirrored."""
    (ax, ay), (bx, by) = np.diff(outer(lattice)[[3, 0, 1]], axis=0)
    return lattice if ax * by > ay * bx else lattice[:, ::-1]


def outer(lattice):
    """Corners (4, 2) of a lattice (rows, columns, 2), around it by its rows."""
    return np.array([lattice[0, 0], lattice[0, -1], lattice[-1, -1], lattice[-1, 0]])


def steps_between(lattice):
    """Lengths (n,) px of the steps between neighbours of a lattice, nan as they are."""
    steps = (np.diff(lattice, axis=axis) for axis in (0, 1))
    return np.concatenate([np.linalg.norm(s, axis=2).ravel() for s in steps])


def corner_areas(lattice):
    """Area (4,) in px² of the squares at the four outer corners, as `outer`."""
    rows, columns = lattice.shape[:2]
    areas = []
    for r, c in ((0, 0), (0, columns - 2), (rows - 2, columns - 2), (rows - 2, 0)):
        (a, b), (d, e) = lattice[r : r + 2, c : c + 2]
        (x, y), (p, q) = e - a, d - b
        areas.append(abs(x * q - y * p) / 2)
    return np.array(areas)
