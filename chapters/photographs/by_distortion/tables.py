"""Every image set of the build in a table."""

from __future__ import annotations

from math import isfinite

import numpy as np

from chapters.shared.photographs.compared import (
    QUANTITIES,
    compared_sets,
    twins,
)
from chapters.shared.photographs.reading import ALL_NAMES
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


@table(
    "ext_real_by_distortion",
    needs=("photograph_study", "ext_calibration_record"),
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
        "corners that Zhang and the general camera both have a ray for; these two "
        "are compared. OpenCV fisheye stands beside them, in as many of the "
        "photographs as it has a camera for. Corrected: what is left in the "
        "distortion-free view after a homography, as in Table 2.2. With a "
        "ray: of the general camera." + _said_of_twins(study),
        texts=("Set", "Better"),
    )


def _row(one):
    """Cells of one set; of none, for the names of the columns."""
    images = one.study.images if one else []
    found = one.study.found if one else []
    residuals, corrected = (
        {model: _measured(one, q, model) for model in ALL_NAMES}
        for q in QUANTITIES
    )
    return {
        "Set": one.name if one else "",
        "Level (1)": _number(one.level if one else np.nan),
        "Widest angle (deg)": _number(one.widest_deg if one else np.nan),
        "Photographs": len(images),
        "Boards found": len(found),
        **{f"{ALL_NAMES[m]} (px)": x for m, x in residuals.items()},
        "OpenCV fisheye answers in": one.of_peer if one else 0,
        "of": one.photographs if one else 0,
        **{
            f"{ALL_NAMES[m]}, corrected (px)": x
            for m, x in corrected.items()
        },
        "Corners with a ray (%)": _number(
            100 * one.share if one else np.nan
        ),
        "Picture with a ray (%)": _number(
            100 * one.image_share if one else np.nan
        ),
        "Better": one.outcome if one else "",
    }


def _measured(one, quantity, model):
    if one is None or model not in one.errors[quantity]:
        return None
    return Measured(*one.errors[quantity][model][:3])


def _number(x):
    return float(x) if isfinite(x) else None


def _said_of_twins(results):
    return "".join(
        f" {later} is left out: its photographs are those of {first}."
        for later, first in twins(results).items()
    )
