"""Every image set of the build in a table."""

from __future__ import annotations

from math import isfinite

import numpy as np

from chapters.shared.photographs.compared import (
    QUANTITIES,
    compared_sets,
    twins,
)
from chapters.shared.photographs.reading import NAMES
from repro.run.experiment import table
from repro.run.outcomes import Table

NONE = "–"


@table(
    "ext_real_by_distortion",
    needs=("photograph_study",),
    evidence="photograph",
)
def ext_real_by_distortion(results):
    """Every set of the build: level, angle, boards, errors, coverage, outcome."""
    study = results["photograph_study"]
    made = [_row(one) for one in compared_sets(study)]
    return Table(
        {name: [row[name] for row in made] for name in _row(None)},
        "Image sets of this build, least distorted first. Residuals are medians "
        "over photographs kept out of the calibration, with 95 % intervals, on "
        "corners that both models have a ray for. Corrected: what is left in the "
        "distortion-free view after a homography, as in Table 2.2."
        + _said_of_twins(study),
        texts=("Set", "Better"),
    )


def _row(one):
    """Cells of one set; of none, for the names of the columns."""
    zhang, general = (
        {q: _told(one, q, model) for q in QUANTITIES} for model in NAMES
    )
    images = one.study.images if one else []
    found = one.study.found if one else []
    return {
        "Set": one.name if one else "",
        "Level (1)": _number(one.level if one else np.nan, 3),
        "Widest angle (deg)": _number(one.widest_deg if one else np.nan, 3),
        "Boards found": f"{len(found)} of {len(images)}"
        if images
        else NONE,
        "Zhang (px)": zhang["rms_px"],
        "General (px)": general["rms_px"],
        "Zhang, corrected (px)": zhang["corrected_px"],
        "General, corrected (px)": general["corrected_px"],
        "Corners with a ray (%)": _number(
            100 * one.share if one else np.nan, 3
        ),
        "Better": one.outcome if one else "",
    }


def _told(one, quantity, model):
    if one is None or not one.errors[quantity]:
        return NONE
    e = one.errors[quantity][model]
    return f"{e.value:.2g} ({e.low:.2g} to {e.high:.2g})"


def _number(x, digits):
    return f"{x:.{digits}g}" if isfinite(x) else NONE


def _said_of_twins(results):
    return "".join(
        f" {later} is left out: its photographs are those of {first}."
        for later, first in twins(results).items()
    )
