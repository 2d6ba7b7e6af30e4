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
from chapters.shared.grid_detectors import CELECT
from chapters.shared.grid_rigs import HARD, WHOLE
from repro.judge.statistics import Estimate

# Set -> the experiment that ran it.
EXPERIMENTS = {
    "spherical": "table_3_4_grids",
    "hyperboloidal": "table_3_5_grids",
    "fisheye": "table_3_6_grids",
    "flexible-mirror": "table_3_7_grids",
}
# The four of them: what the claims of all sixty pictures need.
GRIDS = ("table_3_4_grids", "table_3_5_grids", "table_3_6_grids", "table_3_7_grids")
# Least distances of their corners, and all that the claim needs that asks for these.
SPACING = "exp_c3_same_after_loc"
GRIDS_AND_SPACING = (
    "table_3_4_grids",
    "table_3_5_grids",
    "table_3_6_grids",
    "table_3_7_grids",
    "exp_c3_same_after_loc",
)
# Least distance of neighbouring corners (px) in the readings of the ledger.
LEAST_SPACING_PX = {"9 px or more": 9.0, "15 px or more": 15.0}
TITLES = {
    "spherical": "Spherical",
    "hyperboloidal": "Hyperboloidal",
    "fisheye": "Fisheye",
    "flexible-mirror": "Flexible Mirror",
}
SPOTTED, CLEAN = "600 spots", "no spots"
# The window that a table shows; the accuracy claims are judged with both.
WINDOW = "half window"


class Which(NamedTuple):
    """Which pictures count: the range of their poses, and the ball's spots."""

    poses: str = WHOLE
    spots: str = SPOTTED

    @classmethod
    def of(cls, options):
        """The pictures of one reading of the ledger's questions."""
        return cls(options["pose_range"], options["spots"])


PRIMARY = Which()


def pictures_of(result, which=PRIMARY, seed=None):
    """The pictures of an experiment that count, of one seed or of all."""
    if which.spots == CLEAN:
        seed = SPOTLESS_SEED
    of_seed = {} if seed is None else {"seed": seed}
    return result.select(poses=which.poses, **of_seed)


def seeds_of(results, which=PRIMARY):
    """Seeds of the pictures that count, which all four experiments share."""
    return pictures_of(next(iter(results.values())), which).levels("seed")


def prefix_of(result, which):
    """Before the name of a value: only the ball has pictures without spots."""
    spherical = result.settings["set"] == "spherical"
    return "spotless." if spherical and which.spots == CLEAN else ""


def numbers_of(result, name, which=PRIMARY, seed=None):
    """A number of each picture that counts: (n,)."""
    return pictures_of(result, which, seed).column(prefix_of(result, which) + name)


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
    for seed in seeds_of(results, which):
        ours, theirs = (
            all_right(results, method, which, seed) for method in (CELECT, detector)
        )
        yield seed, ours, theirs


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
    as_detected = when == "before" and reference == TRUTH
    row = MEASURES.index((when, reference, None if as_detected else window))
    stored = _errors_of_pictures(result, f"{prefix}errors")
    return [
        stored[tuple(c.values())][methods.index(method), row]
        for c, good in zip(
            pictures_of(result, which, seed).conditions,
            right(result, method, which, seed),
            strict=True,
        )
        if good
    ]


def apart(found, result, spacing, least_px, method, which=PRIMARY, seed=None):
    """Of `errors` found, those of grids without neighbouring corners nearer than this.

    spacing: Result of SPACING.
    """
    pictures = pictures_of(result, which, seed).conditions
    good = right(result, method, which, seed)
    steps = [
        spacing.column("least_px", **picture)[0]
        for picture, is_right in zip(pictures, good, strict=True)
        if is_right
    ]
    return [one for one, step in zip(found, steps, strict=True) if step >= least_px]


def texts(result, name, which=PRIMARY, seed=None):
    """One text of each picture, None where it has none."""
    return pictures_of(result, which, seed).texts(prefix_of(result, which) + name)


def causes(results, which, seed, set_name=None):
    """Why CELECT failed, one text per failed picture of a seed."""
    names = EXPERIMENTS if set_name is None else [set_name]
    found = []
    for name in names:
        result = results[EXPERIMENTS[name]]
        lost = ~right(result, CELECT, which, seed)
        stated = texts(result, f"{CELECT}.cause", which, seed)
        found += [cause for cause, bad in zip(stated, lost, strict=True) if bad]
    return found


def cleared(result, blemish, seed):
    """How many failures of CELECT a clean mirror would have spared."""
    name = f"{CELECT}.right_without_{blemish}"
    return int((numbers_of(result, name, PRIMARY, seed) == 1).sum())


def opened_all(open_results):
    """The four results by the names of their experiments."""
    return {name: open_results(name) for name in EXPERIMENTS.values()}


def spread(values):
    """Mean of one value per seed, with their range: Estimate."""
    return Estimate(*(float(of(values)) for of in (np.mean, np.min, np.max)))
