"""Comparison of the image sets of a build."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chapters.shared.photographs.reading import (
    MODELS,
    NAMES,
    PEER,
    Study,
    column,
    paired,
    share_with_ray,
)
from repro.judge.statistics import Estimate, median_interval


@dataclass(frozen=True)
class Compared:
    """One image set and the errors of the models on it.

    errors: {model: median over held-out images, px, with its interval}, empty where no
    image has both Zhang's and the general camera; with OpenCV's fisheye model where it
    has any. share: held-out corners with a ray of the general camera; image_share:
    pixels with such a ray, NaN where there is no such camera.
    """

    name: str
    errors: dict[str, Estimate]
    share: float
    image_share: float


def compared_sets(results):
    """Return the sets of ``results`` (set name -> Result), by name.

    A set with the same images as an earlier one is excluded, because it would count
    twice (see `twins`).
    """
    again = twins(results)
    sets = [
        _compared(name, Study(result))
        for name, result in results.items()
        if name not in again
    ]
    return sorted(sets, key=lambda s: s.name)


def twins(results):
    """Return {set: earlier set} for sets with identical corners."""
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
    return Compared(
        name,
        _medians(rows),
        share_with_ray(rows, "general") if rows else np.nan,
        study.fit("general.image_with_ray"),
    )


def _medians(rows):
    pairs = paired(rows, "rms_px")
    if not len(pairs[0]):
        return {}
    found = dict(zip(NAMES, pairs, strict=True))
    every = np.array([column(rows, "same", m, "rms_px") for m in (*MODELS, PEER)])
    peers = every[-1, np.isfinite(every).all(axis=0)]
    if len(peers):
        found[PEER] = peers
    return {model: median_interval(values) for model, values in found.items()}
