"""Steps of a vector that is told up to its length, and kept at length 1."""

import numpy as np


def tangents(p):
    """Unit vectors (n, n - 1), in columns, across p (n,) and each other."""
    return np.linalg.svd(p[None])[2][1:].T


def stepped(p, step):
    """p (n,) after a step (n - 1,) along its `tangents`, at length 1."""
    moved = p + tangents(p) @ step
    return moved / np.linalg.norm(moved)
