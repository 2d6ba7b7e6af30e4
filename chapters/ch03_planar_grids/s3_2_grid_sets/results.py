"""What the four experiments of 3.3.2 found, seed by seed."""

from __future__ import annotations

import numpy as np

from chapters.shared.grid_scoring import TRUTH
from chapters.shared.grid_trials import (
    CELECT,
    OPENCV,
    OPENCV_SB,
)
from chapters.shared.grid_views import TITLES

# Set -> the experiment that ran it.
EXPERIMENTS = {
    "spherical": "table_3_4_grids",
    "hyperboloidal": "table_3_5_grids",
    "fisheye": "table_3_6_grids",
    "flexible-mirror": "table_3_7_grids",
}
DETECTORS_OF_TODAY = (OPENCV, OPENCV_SB)


def seeds_of(result):
    """Seeds of an experiment, in order."""
    return list(dict.fromkeys(c["seed"] for c in result.conditions))


def pictures_of(result, seed=None):
    """Conditions of an experiment, of one seed or of all."""
    return [c for c in result.conditions if seed in (None, c["seed"])]


def right(result, method, seed=None):
    """Whether each picture's grid was found and in order: (n,) bool."""
    name = f"{method}.success"
    return np.array(
        [
            bool(result.column(name, **c)[0])
            for c in pictures_of(result, seed)
        ]
    )


def all_right(results, method, seed):
    """`right` of a seed's pictures of all sets, in the order of the sets."""
    return np.concatenate(
        [
            right(results[name], method, seed)
            for name in EXPERIMENTS.values()
        ]
    )


def errors(result, method, when, reference, seed=None):
    """Errors (N,) in px of all corners of the right grids.

    when: 'before' or 'after' localisation; reference: one of REFERENCES.
    """
    against = "truth" if reference == TRUTH else "reference"
    found = [np.empty(0)]
    for condition in pictures_of(result, seed):
        found += result.arrays(f"{method}.{when}_{against}", **condition)
    return np.concatenate(found)


def texts(result, name, seed=None):
    """One text of each picture, None where it has none."""
    return [result.texts(name, **c)[0] for c in pictures_of(result, seed)]


def causes(results, seed, set_name=None):
    """Why CELECT failed, one text per failed picture of a seed."""
    names = EXPERIMENTS if set_name is None else [set_name]
    found = []
    for name in names:
        result = results[EXPERIMENTS[name]]
        lost = ~right(result, CELECT, seed)
        told = texts(result, f"{CELECT}.cause", seed)
        found += [
            cause for cause, bad in zip(told, lost, strict=True) if bad
        ]
    return found


def cleared(result, blemish, seed):
    """How many failures of CELECT a clean mirror would have spared."""
    name = f"{CELECT}.right_without_{blemish}"
    return sum(
        result.column(name, **c)[0] == 1 for c in pictures_of(result, seed)
    )


def opened_all(open_results):
    """The four results by the names of their experiments."""
    return {name: open_results(name) for name in EXPERIMENTS.values()}


def title_of(set_name):
    """Name of a set in the thesis."""
    return TITLES[set_name]
