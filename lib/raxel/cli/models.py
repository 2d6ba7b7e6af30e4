"""The models of `raxel calibrate --model`, and how each is fitted.

A fit takes views, (width, height) and the unit of their points, and returns a Fitted.
"""

import math
from functools import partial
from typing import NamedTuple

import numpy as np

from raxel.calibration import (
    calibrate_cgsp,
    calibrate_generic,
    calibrate_lens,
    calibrate_spline,
)
from raxel.calibration.parametric.lens_bundle import imaged_points
from raxel.calibration.parametric.lens_formula import BoardTest, calibrate_pinhole
from raxel.calibration.views.correspondence import displaced
from raxel.cameras.core.base import Camera
from raxel.evaluation.board_corners import without_wrong_corners
from raxel.evaluation.diagnoses import known
from raxel.evaluation.misfit import MAX_SCATTER_RATIO

SEED = 0


class Fitted(NamedTuple):
    """camera; details: a dict for the result, with `left_out`: [{file, reason}]; board:
    BoardTest of the board's shape, None where it was not tested; corners: nominal
    positions and displacements of the corners, None where the fit took none; lens:
    derivatives of pixels by parameters, and their covariance, as `split_half` takes
    them, or None."""

    camera: Camera
    details: dict
    board: BoardTest | None = None
    corners: tuple | None = None
    lens: tuple | None = None

    @property
    def shape(self):
        """The BoardShape that the fit took, None for a board as specified."""
        taken = self.board.taken if self.board and self.board.used else None
        return displaced(taken, *self.corners) if self.corners else taken

    @property
    def unused(self):
        """Names of the views that did not go into the fit."""
        return {entry["file"] for entry in self.details["left_out"]}


def zhang(views, size, unit):
    """A pinhole with two radial terms."""
    found = calibrate_pinhole(views, *size)
    details = {"left_out": []} | _terms(found)
    return Fitted(found.camera, details, found.board, lens=_errors(found))


def lens(law, views, size, unit, pupil="by test"):
    """A model of a fisheye or mirror, with a pupil shift if the data support one."""
    found = calibrate_lens(views, *size, law, pupil=pupil)
    details = {
        "left_out": [],
        **_terms(found),
        "wrong_points": [
            {"file": w.name, "corner": w.corner, "distance_px": w.distance_px}
            for w in found.wrong
        ],
        "pupil": found.pupil and _pupil_fields(found.pupil),
    }
    return Fitted(found.camera, details, found.board, lens=_errors(found))


def _errors(found):
    """(derivatives of pixels at points by the parameters, covariance), or None."""
    if found.terms is None:
        return None
    formula, values, covariance = found.terms

    def slopes(points):
        return imaged_points(formula, values, points).by_values

    return slopes, covariance


def _terms(found):
    """Parameters with standard deviations, and how much larger these are than for
    independent errors of all corners."""
    if found.covariance is None:
        return {}
    sd = np.sqrt(np.diag(found.covariance))
    terms = zip(found.formula.names, found.values, sd, strict=True)
    return {
        "terms": {n: {"value": float(v), "sd": float(s)} for n, v, s in terms},
        "sd_over_independent": found.error_factor,
    }


def _pupil_fields(pupil):
    return {
        name: value if isinstance(value, str) else known(value)
        for name, value in pupil._asdict().items()
    } | {"moves": pupil.moves, "against": pupil.against or None}


def spline(views, size, unit, pupil="by test"):
    """Smooth rays: a parametric model and a B-spline ray field on it."""
    rng = np.random.default_rng(SEED)
    found = calibrate_spline(views, *size, rng=rng, units=unit, pupil=pupil)
    details = {
        **_used(views, found),
        "trend": found.trend,
        "pupil": found.pupil and _pupil_fields(found.pupil),
        "share_of_pixels_under_boards": found.share_covered,
    }
    return Fitted(found.camera, details, found.board)


def table(calibrated, views, size, unit):
    """A ray for each pixel that a board covers, by CGSP or the standard method."""
    found = calibrated(views, *size, rng=np.random.default_rng(SEED), units=unit)
    modes = [found.interpolation[index] for index in found.used]
    details = {
        **_used(views, found),
        "share_of_pixels_with_ray": found.share_with_ray,
        "adjusted_rms_deg": found.rms_deg,
        "interpolation": {m: modes.count(m) for m in ("homographic", "smooth")},
    }
    return Fitted(found.camera, details)


def _used(views, found):
    """Which views went into the fit, and why others did not."""
    return {
        "used": [views[index].name for index in found.used],
        "left_out": [
            {"file": views[index].name, "reason": reason}
            for index, reason in sorted(found.left_out.items())
        ],
    }


def _without_wrong(fit):
    """A fit that weights all corners equally, repeated without outliers."""

    def fitted(views, size, unit):
        found = fit(views, size, unit)
        if any(view.every_pixel for view in views):
            return found
        right = without_wrong_corners(found.camera, views, found.shape)
        return fit(right.views, size, unit) if right.wrong else found

    return fitted


# The simplest first: of models that are as good, `auto` takes that.
FITS = {
    "zhang": _without_wrong(zhang),
    "kannala-brandt": partial(lens, "kannala-brandt"),
    "unified": partial(lens, "unified"),
    "spline": spline,
    "cgsp": _without_wrong(partial(table, calibrate_cgsp)),
    "generic": _without_wrong(partial(table, calibrate_generic)),
}
# Models with an entrance pupil.
PUPILS = "kannala-brandt", "unified", "spline"
# Of --central: the other models are central in any case.
CENTRAL_FITS = FITS | {name: partial(FITS[name], pupil="fixed") for name in PUPILS}
TABLES = ("cgsp", "generic")
# What `auto` compares, the fastest first, and the largest RMS residual, in units of the
# corner scatter, at which the best so far needs no further models. Where tables fit
# better than a smooth field, rays are discontinuous: residuals are then far larger.
STAGES = (
    (("zhang", "kannala-brandt", "unified"), 1.25),
    (("spline",), MAX_SCATTER_RATIO),
    (TABLES, math.inf),
)
MIN_N_VIEWS = dict.fromkeys(FITS, 2) | dict.fromkeys((*TABLES, "auto"), 3)
# Code of the warning where a model does not fit.
MISFITS = dict.fromkeys(("zhang", "kannala-brandt", "unified"), "parametric-misfit")
MISFITS |= dict.fromkeys(("spline", *TABLES), "central-misfit")
MISFITS["auto"] = "all-models-misfit"
