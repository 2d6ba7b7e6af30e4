"""The image sets of a build beside each other, least distorted first."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, isfinite, log2

import numpy as np

from chapters.shared.photographs.reading import (
    MODELS,
    NAMES,
    PEER,
    Study,
    because,
    column,
    decided,
    paired,
    share_with_ray,
)
from repro.judge.statistics import SIGNIFICANCE, Estimate, median_interval, wins

QUANTITIES = {
    "rms_px": "Residual, kept out (px)",
    "corrected_px": "Left after correction (px)",
}
# One-sided signed ranks over n pairs reach p = 1 / 2^n at best.
FEWEST_DECIDING = ceil(log2(1 / SIGNIFICANCE))


@dataclass(frozen=True)
class Compared:
    """One image set: its distortion, the models' errors, and what came of it.

    errors: quantity -> {model: median over photographs kept out, with its interval},
    empty where no photograph has both; with OpenCV's fisheye model where it has any.
    photographs: number of pairs behind rms_px; of_peer: in how many of them OpenCV's
    fisheye model has an error. share: corners kept out that the general camera has a
    ray for; image_share: pixels of the image, NaN where there is no such camera.
    """

    name: str
    study: Study
    level: float
    widest_deg: float
    errors: dict[str, dict[str, Estimate]]
    photographs: int
    of_peer: int
    outcome: str
    share: float
    image_share: float

    @property
    def comparable(self) -> bool:
        """Whether the set has a level, and an error of both models."""
        return isfinite(self.level) and bool(self.errors["rms_px"])


def compared_sets(results):
    """The sets of ``results`` (set name -> Result), least distorted first.

    Sets without a level stand last. A set with the very photographs of an earlier one
    is left out, because it would count twice (see `twins`).
    """
    again = twins(results)
    sets = [
        _compared(name, Study(result))
        for name, result in results.items()
        if name not in again
    ]
    return sorted(sets, key=lambda s: (not isfinite(s.level), s.level, s.name))


def twins(results):
    """{set: earlier set} for sets in which the very same corners were found."""
    first, again = {}, {}
    for name, result in results.items():
        found = [image.corners.tobytes() for image in Study(result).found]
        key = tuple(sorted(found))
        if key and key in first:
            again[name] = first[key]
        else:
            first[key] = name
    return again


def _compared(name, study):
    rows = study.held_out
    errors = {quantity: _medians(rows, quantity) for quantity in QUANTITIES}
    pairs = paired(rows, "rms_px")
    return Compared(
        name,
        study,
        study.fit("general.distortion.level"),
        study.fit("general.distortion.widest_deg"),
        errors,
        len(pairs[0]),
        len(_of_peer(rows, "rms_px")),
        outcome_of(study, *pairs),
        share_with_ray(rows, "general") if rows else np.nan,
        study.fit("general.image_with_ray"),
    )


def _medians(rows, quantity):
    pairs = paired(rows, quantity)
    if not len(pairs[0]):
        return {}
    found = dict(zip(NAMES, pairs, strict=True))
    peers = _of_peer(rows, quantity)
    if len(peers):
        found[PEER] = peers
    return {model: median_interval(values) for model, values in found.items()}


def _of_peer(rows, quantity):
    """Errors of OpenCV's fisheye model in photographs that both others answer for."""
    every = np.array([column(rows, "same", m, quantity) for m in (*MODELS, PEER)])
    return every[-1, np.isfinite(every).all(axis=0)]


def outcome_of(study, zhangs, generals):
    """Who predicts better, by the rule of the set's own page; or why nobody knows."""
    if not len(zhangs):
        whys = [study.why_nothing_kept_out(model) for model in NAMES]
        return f"not compared: {because(whys[1] or whys[0])}"
    if len(zhangs) < FEWEST_DECIDING:
        return f"too few photographs ({len(zhangs)})"
    if decided(wins([(generals, zhangs)])[0]):
        return NAMES["general"]
    return NAMES["zhang"] if decided(wins([(zhangs, generals)])[0]) else "undecided"
