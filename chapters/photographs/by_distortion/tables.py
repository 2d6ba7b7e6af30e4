"""Every image set of the build in a table."""

import numpy as np

from chapters.shared.photographs.compared import QUANTITIES, compared_sets, twins
from chapters.shared.photographs.reading import ALL_NAMES, EVERY, counted
from raxel.evaluation.comparison import MISSED_PX
from repro.run.columns import cell
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
        "ray: of the general camera." + _twins_named(study),
        texts=("Set", "Better"),
    )


def _row(one):
    """Cells of one set; of none, for the names of the columns."""
    images = one.study.images if one else []
    found = one.study.found if one else []
    residuals, corrected = (
        {model: _measured(one, q, model) for model in ALL_NAMES} for q in QUANTITIES
    )
    return {
        "Set": one.name if one else "",
        "Level (1)": cell(one.level if one else np.nan),
        "Widest angle (deg)": cell(one.widest_deg if one else np.nan),
        "Photographs": len(images),
        "Boards found": len(found),
        **{f"{ALL_NAMES[m]} (px)": x for m, x in residuals.items()},
        "OpenCV fisheye answers in": one.of_peer if one else 0,
        "of": one.photographs if one else 0,
        **{f"{ALL_NAMES[m]}, corrected (px)": x for m, x in corrected.items()},
        "Corners with a ray (%)": cell(100 * one.share if one else np.nan),
        "Picture with a ray (%)": cell(100 * one.image_share if one else np.nan),
        "Better": one.outcome if one else "",
    }


def _measured(one, quantity, model):
    if one is None or model not in one.errors[quantity]:
        return None
    return Measured(*one.errors[quantity][model][:3])


def _twins_named(results):
    return "".join(
        f" {later} is left out: its photographs are those of {first}."
        for later, first in twins(results).items()
    )


@table("ext_real_every_corner", needs=("photograph_study",), evidence="photograph")
def ext_real_every_corner(results):
    """Every set of the build and every model, on every corner kept out."""
    made = [_counted_row(one) for one in compared_sets(results["photograph_study"])]
    return Table(
        {name: [row[name] for row in made] for name in _counted_row(None)},
        "Image sets of this build and all models: RMS distance in px of "
        "every corner of the photographs kept out, and their median. A "
        "corner for which a model has no ray, or no camera, counts as "
        f"{MISSED_PX:g} px.",
        texts=("Set", "Least RMS"),
    )


def _counted_row(one):
    """Cells of one set; of none, for the names of the columns."""
    found = {model: one and counted(one.study, model) for model in EVERY}
    known = {model: errors for model, errors in found.items() if errors}
    least = min(known, key=lambda m: known[m]["rms_px"], default=None)
    return {
        "Set": one.name if one else "",
        **{
            f"{EVERY[model]}{words}": errors and errors[quantity]
            for model, errors in found.items()
            for quantity, words in (
                ("rms_px", ", RMS (px)"),
                ("median_px", ", median (px)"),
            )
        },
        "Least RMS": EVERY.get(least, ""),
    }
