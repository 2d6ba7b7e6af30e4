"""Rendered images of 3.3.2: selection by interpretation, and detection results."""

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
from chapters.shared.grid_rigs import WHOLE
from repro.judge.statistics import Estimate

# Set -> the experiment that ran it.
EXPERIMENTS = {
    "spherical": "table_3_4_grids",
    "hyperboloidal": "table_3_5_grids",
    "fisheye": "table_3_6_grids",
    "flexible-mirror": "table_3_7_grids",
}
# All four: what the claims on sixty images need.
GRIDS = ("table_3_4_grids", "table_3_5_grids", "table_3_6_grids", "table_3_7_grids")
# Smallest distances of their corners, and the experiments of the claim on these.
SPACING = "exp_c3_same_after_loc"
GRIDS_AND_SPACING = (
    "table_3_4_grids",
    "table_3_5_grids",
    "table_3_6_grids",
    "table_3_7_grids",
    "exp_c3_same_after_loc",
)
# Smallest distance of neighbouring corners (px) in the interpretations.
MIN_SPACING_PX = {"9 px or more": 9.0, "15 px or more": 15.0}
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
    """Selection of images: the range of their poses, and the ball's spots."""

    poses: str = WHOLE
    spots: str = SPOTTED

    @classmethod
    def of(cls, options):
        """Return the selection of one interpretation."""
        return cls(options["pose_range"], options["spots"])


PRIMARY = Which()


def pictures_of(result, which=PRIMARY, seed=None):
    """Return the selected images of an experiment, of one run or of all."""
    if which.spots == CLEAN:
        seed = SPOTLESS_SEED
    of_seed = {} if seed is None else {"seed": seed}
    return result.select(poses=which.poses, **of_seed)


def seeds_of(results, which=PRIMARY):
    """Return the runs of the selected images, which all four experiments share."""
    return pictures_of(next(iter(results.values())), which).levels("seed")


def prefix_of(result, which):
    """Return the prefix of a value's name: only the ball has images without spots."""
    spherical = result.settings["set"] == "spherical"
    return "spotless." if spherical and which.spots == CLEAN else ""


def numbers_of(result, name, which=PRIMARY, seed=None):
    """Return a number of each selected image, (n,)."""
    return pictures_of(result, which, seed).column(prefix_of(result, which) + name)


def right(result, method, which=PRIMARY, seed=None):
    """Return whether each image's grid was found and in order, (n,) bool."""
    return numbers_of(result, f"{method}.success", which, seed) == 1


def all_right(results, method, which, seed):
    """Return `right` of a run's images of all sets, in the order of the sets."""
    return np.concatenate(
        [right(results[name], method, which, seed) for name in EXPERIMENTS.values()]
    )


def of_each_seed(results, detector, which):
    """Yield which images CELECT and a detector extract correctly, run by run.

    Each item is (seed, (n,) bool, (n,) bool), over the images of all four sets.
    """
    for seed in seeds_of(results, which):
        ours, theirs = (
            all_right(results, method, which, seed) for method in (CELECT, detector)
        )
        yield seed, ours, theirs


@cache
def _errors_of_pictures(result, name):
    """Return {(image, seed, poses): errors (methods, 7, corners)}."""
    return {
        tuple(c.values()): found
        for c in result.conditions
        for found in result.arrays(name, **c)
    }


def errors(result, method, when, reference, which=PRIMARY, seed=None, window=WINDOW):
    """Return errors (px) of the corners of correct grids, one array (n,) per grid.

    when: 'before' or 'after' localisation; reference: one of REFERENCES;
    window: of the localiser, where it applies.
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
    """Return those `errors` of grids with neighbouring corners at least this far apart.

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
    """Return one text of each image, None where it has none."""
    return pictures_of(result, which, seed).texts(prefix_of(result, which) + name)


def causes(results, which, seed, set_name=None):
    """Return the causes of CELECT's failures, one text per failed image of a run."""
    names = EXPERIMENTS if set_name is None else [set_name]
    found = []
    for name in names:
        result = results[EXPERIMENTS[name]]
        lost = ~right(result, CELECT, which, seed)
        stated = texts(result, f"{CELECT}.cause", which, seed)
        found += [cause for cause, bad in zip(stated, lost, strict=True) if bad]
    return found


def cleared(result, blemish, seed):
    """Return how many failures of CELECT succeed with a clean mirror."""
    name = f"{CELECT}.right_without_{blemish}"
    return int((numbers_of(result, name, PRIMARY, seed) == 1).sum())


def opened_all(open_results):
    """Return the four results by the names of their experiments."""
    return {name: open_results(name) for name in EXPERIMENTS.values()}


def spread(values):
    """Return the mean of one value per run, with the range of the runs."""
    return Estimate(*(float(of(values)) for of in (np.mean, np.min, np.max)))
