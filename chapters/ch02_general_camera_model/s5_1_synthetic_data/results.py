"""The numbers of section 2.5.1 that its prose and the ledger ask for."""

from __future__ import annotations

from itertools import product

import numpy as np

from chapters.ch02_general_camera_model.s5_1_synthetic_data.trials import (
    DOMAINS,
    EXTENTS,
)
from chapters.shared.methods import METHODS, SCALES, SCORINGS
from repro.judge.statistics import with_worst
from repro.page.reader import value

PRIMARY = {"domain": "px", "extent": "unbounded"}


def median_of(result, name, **condition):
    """Median over trials of one value; failed ones count as the worst seen.

    In the primary reading, but for what ``condition`` says otherwise.
    """
    trials = result.column(name, **(PRIMARY | condition))
    return float(np.median(with_worst(trials, np.nanmax(trials))))


def failures(results, method):
    """Trials in which a method gave nothing, and all trials."""
    failed = total = 0
    for result in results:
        for condition in result.conditions:
            texts = result.texts(f"{method}.failed", **condition)
            failed += sum(text is not None for text in texts)
            total += len(texts)
    return failed, total


def ahead(fov, method, scale, **condition):
    """Where a generic method is ahead of the parametric on clean data, in words."""
    every = sorted({c["fov_deg"] for c in fov.conditions})
    place = f"clean.{scale}.mean_px"
    better = [
        median_of(fov, f"parametric.{place}", fov_deg=at, **condition)
        > median_of(fov, f"{method}.{place}", fov_deg=at, **condition)
        for at in every
    ]
    found = [at for at, yes in zip(every, better, strict=True) if yes]
    if not found:
        return "at no field of view"
    if found == every[every.index(found[0]) :]:
        return f"from {found[0]}° on"
    return "at " + " and ".join(f"{at}°" for at in found) + " only"


def name_values(noise, fov):
    """Name the numbers of the prose, in the primary reading."""
    for method in METHODS[1:]:
        failed, total = failures([noise, fov], method)
        value(f"{method}.failed", failed)
    value("trials", total)
    for at in (30, 60, 120, 150):
        for method in METHODS:
            for scoring in SCORINGS:
                for scale in SCALES:
                    name = f"{method}.{scoring}.{scale}.mean_px"
                    value(f"{name}.{at}", median_of(fov, name, fov_deg=at))
    for method in METHODS:
        name = f"{method}.ray_deg"
        value(f"{name}.90", median_of(fov, name, fov_deg=90))
    for domain, extent, scale in product(DOMAINS, EXTENTS, SCALES):
        for method in METHODS[1:]:
            name = f"ahead.{method}.{domain}.{extent}.{scale}"
            where = {"domain": domain, "extent": extent}
            value(name, ahead(fov, method, scale, **where))
    for extent in EXTENTS:
        for name in ("accepted_share", "widest_angle_deg"):
            found = median_of(fov, name, fov_deg=150, extent=extent)
            value(f"{name}.{extent}.150", found)
    name = "generic_as_printed.noisy.corrected.mean_px"
    at_150, at_120 = (
        median_of(fov, name, fov_deg=at, domain="mm") for at in (150, 120)
    )
    value("rise.mm", at_150 / at_120)
    value("noise_ratio", median_of(fov, "point_noise_ratio", fov_deg=150))
