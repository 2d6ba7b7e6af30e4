"""Plücker matrices and vectors of random lines, (2.11) and (2.12)."""

import numpy as np

from raxel.geometry import pluecker_matrix, pluecker_vector
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

LINES = 100
EXTENT_M = 1.0  # points and distances are of order one
MIN_SEPARATION = 0.05

LINE_TRIALS = {"quick": 2, "full": 10}

LINE_SETTINGS = {
    "lines_per_trial": 100,
    "points": "within 1 m of a point of the line, at least 5 cm apart, "
    "each at a homogeneous scale of its own",
    "lines": "through a point within a cube of 2 m about the origin, or "
    "through the origin",
}


def two_pairs_trial(condition, rng):
    """Compare (2.11) from two pairs of points of each of 100 lines."""
    origins, directions = draw_lines(rng)
    first, second = (
        normalised(pluecker_matrix(*homogeneous_pair(o, directions, rng)))
        for o in (origins, origins)
    )
    return {
        "difference": np.abs(first - second).max(),
        "asymmetry": np.abs(first + np.swapaxes(first, 1, 2)).max(),
    }


def origin_trial(condition, rng):
    """Compute moments of (2.12): 100 lines through the origin, 100 others."""
    origins, directions = draw_lines(rng)
    ratio = {}
    for name, place in (("through", 0.0), ("beside", origins)):
        pair = homogeneous_pair(place, directions, rng)
        vectors = pluecker_vector(pluecker_matrix(*pair))
        ratio[name] = np.linalg.norm(vectors[:, 3:], axis=1)
        ratio[name] /= np.linalg.norm(vectors, axis=1)
    return {
        "through_origin": ratio["through"].max(),
        "beside_origin": ratio["beside"].min(),
        "least_distance_m": np.linalg.norm(np.cross(origins, directions), axis=1).min(),
    }


def draw_lines(rng):
    """Return points (100, 3) and unit directions of random lines."""
    origins = rng.uniform(-EXTENT_M, EXTENT_M, (LINES, 3))
    directions = rng.normal(size=(LINES, 3))
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def homogeneous_pair(origins, directions, rng):
    """Yield two distinct points (N, 4) on each line, each with its own scale."""
    places = rng.uniform(-EXTENT_M, EXTENT_M, (2, len(directions)))
    close = np.abs(places[0] - places[1]) < MIN_SEPARATION * EXTENT_M
    places[1, close] = places[0, close] + EXTENT_M
    for place in places:
        point = origins + place[:, None] * directions
        scale = rng.uniform(0.2, 5.0, (len(point), 1))
        yield scale * np.column_stack([point, np.ones(len(point))])


def normalised(matrices):
    """Return matrices of unit norm with positive largest entry."""
    flat = matrices.reshape(len(matrices), -1)
    flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    largest = np.argmax(np.abs(np.triu(matrices)).reshape(flat.shape), 1)
    sign = np.sign(flat[np.arange(len(flat)), largest])
    return (sign[:, None] * flat).reshape(matrices.shape)


@experiment("exp_c2_pluecker_invariant", artefact="sec_2_3")
def lines_by_two_pairs(effort):
    """Plücker matrices of random lines, each from two pairs of points."""
    return Plan(two_pairs_trial, [{}], LINE_TRIALS[effort], LINE_SETTINGS)


@experiment("exp_c2_pluecker_origin", artefact="sec_2_3")
def lines_through_origin(effort):
    """Plücker vectors of lines through the origin and of others."""
    return Plan(origin_trial, [{}], LINE_TRIALS[effort], LINE_SETTINGS)
