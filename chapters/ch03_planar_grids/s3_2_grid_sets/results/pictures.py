"""The rendered pictures of 3.3.2: which a reading counts, and what was found."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import (
    MEASURES,
    METHODS,
    SPOTLESS,
    SPOTLESS_SEED,
    TRUTH,
)
from chapters.shared.grid_detectors import CELECT, OPENCV, OPENCV_SB
from chapters.shared.grid_rigs import HARD, WHOLE

# Set -> the experiment that ran it.
EXPERIMENTS = {
    "spherical": "table_3_4_grids",
    "hyperboloidal": "table_3_5_grids",
    "fisheye": "table_3_6_grids",
    "flexible-mirror": "table_3_7_grids",
}
# The four of them: what the claims of all sixty pictures need.
GRIDS = ("table_3_4_grids", "table_3_5_grids", "table_3_6_grids", "table_3_7_grids")
TITLES = {
    "spherical": "Spherical",
    "hyperboloidal": "Hyperboloidal",
    "fisheye": "Fisheye",
    "flexible-mirror": "Flexible Mirror",
}
DETECTORS_OF_TODAY = (OPENCV, OPENCV_SB)
SPOTTED, CLEAN = "600 spots", "no spots"
# The window that a table shows; the accuracy claims are judged with both.
WINDOW = "half window"


class Which(NamedTuple):
    """Which pictures count: the range of their poses, and the ball's spots."""

    poses: str = WHOLE
    spots: str = SPOTTED

    def asked(self):
        """The options of the ledger's questions that these pictures answer."""
        return {"pose_range": self.poses, "spots": self.spots}


PRIMARY = Which()
ALL_WHICH = [Which(p, s) for p in (WHOLE, HARD) for s in (SPOTTED, CLEAN)]


def pictures_of(result, which=PRIMARY, seed=None):
    """Conditions of an experiment that count, of one seed or of all."""
    return [
        c
        for c in result.conditions
        if c["poses"] == which.poses
        and seed in (None, c["seed"])
        and (which.spots == SPOTTED or c["seed"] == SPOTLESS_SEED)
    ]


def seeds_of(result, which=PRIMARY):
    """Seeds of the pictures that count, in order."""
    return list(dict.fromkeys(c["seed"] for c in pictures_of(result, which)))


def any_of(results, which=PRIMARY):
    """The seeds, which all four experiments share."""
    return seeds_of(next(iter(results.values())), which)


def prefix_of(result, which):
    """Before the name of a value: only the ball has pictures without spots."""
    spherical = result.settings["set"] == "spherical"
    return "spotless." if spherical and which.spots == CLEAN else ""


def numbers_of(result, name, which=PRIMARY, seed=None):
    """A number of each picture that counts: (n,)."""
    name = prefix_of(result, which) + name
    return np.array(
        [result.column(name, **c)[0] for c in pictures_of(result, which, seed)]
    )


def right(result, method, which=PRIMARY, seed=None):
    """Whether each picture's grid was found and in order: (n,) bool."""
    return numbers_of(result, f"{method}.success", which, seed) == 1


def pooled(results, of_result):
    """One array over the four sets and both ranges of poses."""
    return np.concatenate(
        [
            of_result(result, Which(poses))
            for result in results.values()
            for poses in (WHOLE, HARD)
        ]
    )


def all_right(results, method, which, seed):
    """`right` of a seed's pictures of all sets, in the order of the sets."""
    return np.concatenate(
        [right(results[name], method, which, seed) for name in EXPERIMENTS.values()]
    )


def of_each_seed(results, detector, which):
    """Which of a seed's pictures CELECT and a detector get right, seed by seed.

    Yields (seed, (n,) bool, (n,) bool), the pictures of all four sets.
    """
    for seed in any_of(results, which):
        yield (
            seed,
            all_right(results, CELECT, which, seed),
            all_right(results, detector, which, seed),
        )


@cache
def _errors_of_pictures(result, name):
    """Image, seed and poses -> errors (methods, 7, corners) of a picture."""
    return {
        tuple(c.values()): found
        for c in result.conditions
        for found in result.arrays(name, **c)
    }


def errors(result, method, when, reference, which=PRIMARY, seed=None, window=WINDOW):
    """Errors in px of the corners of the right grids: one array (n,) per grid.

    when: 'before' or 'after' localisation; reference: one of REFERENCES;
    window: of the localiser, where it has a say.
    """
    prefix = prefix_of(result, which)
    methods = SPOTLESS if prefix else METHODS
    told = when == "before" and reference == TRUTH
    row = MEASURES.index((when, reference, None if told else window))
    stored = _errors_of_pictures(result, f"{prefix}errors")
    return [
        stored[tuple(c.values())][methods.index(method), row]
        for c, good in zip(
            pictures_of(result, which, seed),
            right(result, method, which, seed),
            strict=True,
        )
        if good
    ]


def texts(result, name, which=PRIMARY, seed=None):
    """One text of each picture, None where it has none."""
    name = prefix_of(result, which) + name
    return [result.texts(name, **c)[0] for c in pictures_of(result, which, seed)]


def causes(results, which, seed, set_name=None):
    """Why CELECT failed, one text per failed picture of a seed."""
    names = EXPERIMENTS if set_name is None else [set_name]
    found = []
    for name in names:
        result = results[EXPERIMENTS[name]]
        lost = ~right(result, CELECT, which, seed)
        told = texts(result, f"{CELECT}.cause", which, seed)
        found += [cause for cause, bad in zip(told, lost, strict=True) if bad]
    return found


def cleared(result, blemish, seed):
    """How many failures of CELECT a clean mirror would have spared."""
    name = f"{CELECT}.right_without_{blemish}"
    return int((numbers_of(result, name, PRIMARY, seed) == 1).sum())


def opened_all(open_results):
    """The four results by the names of their experiments."""
    return {name: open_results(name) for name in EXPERIMENTS.values()}


def title_of(set_name):
    """Name of a set in the thesis."""
    return TITLES[set_name]


def spread(values):
    """(mean, (least, greatest)) of one value per seed."""
    return float(np.mean(values)), (float(np.min(values)), float(np.max(values)))
