"""The models of `raxel calibrate --model`: how each is fitted, and what it tells.

A fit takes views, (width, height) and the unit of their points, and returns a Fitted.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.generic.cgsp import calibrate_cgsp
from raxel.calibration.generic.standard import calibrate_generic
from raxel.calibration.parametric.lens_formula import (
    UNDECIDED,
    BoardTest,
    calibrate_lens,
    calibrate_pinhole,
)
from raxel.calibration.smooth.boards import calibrate_spline
from raxel.cameras.core.base import Camera
from raxel.cli.described import WHAT_BENDS
from raxel.cli.scores import known
from raxel.evaluation.board_corners import without_wrong_corners

SEED = 0


class Fitted(NamedTuple):
    """camera; details: a dict for the result, with `left_out`: [{file, reason}]; board:
    BoardTest of what was found of the board's shape, None where nobody asked."""

    camera: Camera
    details: dict
    board: BoardTest | None = None

    @property
    def shape(self):
        """The BoardShape that the fit took, None for a board that is as stated."""
        return self.board.taken if self.board and self.board.used else None


def zhang(views, size, unit):
    """A pinhole with two radial terms."""
    found = calibrate_pinhole(views, *size)
    return Fitted(found.camera, {"left_out": []} | _terms(found), found.board)


def kannala_brandt(views, size, unit):
    """Kannala and Brandt's formula, decentred; its pupil moves if the views say so."""
    return _lens(views, size, "kannala-brandt")


def unified(views, size, unit):
    """The unified sphere, decentred; its pupil moves if the views say so."""
    return _lens(views, size, "unified")


def _lens(views, size, law):
    found = calibrate_lens(views, *size, law)
    wrong = [
        {"file": w.name, "corner": w.corner, "distance_px": w.distance_px}
        for w in found.wrong
    ]
    details = {
        "left_out": [],
        **_terms(found),
        "wrong_points": wrong,
        "pupil": _told(found.pupil),
    }
    return Fitted(found.camera, details, found.board)


def _terms(found):
    """Parameters with standard deviations, and how much larger these are than if all
    corners erred for themselves."""
    if found.covariance is None:
        return {}
    sd = np.sqrt(np.diag(found.covariance))
    terms = zip(found.formula.names, found.values, sd, strict=True)
    return {
        "terms": {n: {"value": float(v), "sd": float(s)} for n, v, s in terms},
        "sd_over_independent": found.error_factor,
    }


def _told(pupil):
    told = {
        name: value if isinstance(value, str) else known(value)
        for name, value in pupil._asdict().items()
    }
    return told | {"moves": pupil.moves, "against": pupil.against or None}


def spline(views, size, unit):
    """Smooth rays: a lens formula, and a field of splines on it; its pupil as there."""
    rng = np.random.default_rng(SEED)
    found = calibrate_spline(views, *size, rng=rng, units=unit)
    details = {
        "used": [views[index].name for index in found.used],
        "left_out": _left_out(views, found),
        "trend": found.trend,
        "pupil": found.pupil and _told(found.pupil),
        "share_of_pixels_under_boards": found.share_covered,
    }
    return Fitted(found.camera, details, found.board)


def cgsp(views, size, unit):
    """A ray for each pixel that a board covers, by CGSP."""
    return _table(calibrate_cgsp, views, size, unit)


def generic(views, size, unit):
    """A ray for each pixel that a board covers, by the standard generic method."""
    return _table(calibrate_generic, views, size, unit)


def _table(calibrated, views, size, unit):
    found = calibrated(views, *size, rng=np.random.default_rng(SEED), units=unit)
    ways = [found.interpolation[index] for index in found.used]
    details = {
        "used": [views[index].name for index in found.used],
        "left_out": _left_out(views, found),
        "share_of_pixels_with_ray": found.share_with_ray,
        "adjusted_rms_deg": found.rms_deg,
        "interpolation": {way: ways.count(way) for way in ("homographic", "smooth")},
    }
    return Fitted(found.camera, details)


def _left_out(views, found):
    return [
        {"file": views[index].name, "reason": reason}
        for index, reason in sorted(found.left_out.items())
    ]


def _without_wrong(fit):
    """A fit that takes all corners alike, done again without those that stand alone."""

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
    "kannala-brandt": kannala_brandt,
    "unified": unified,
    "spline": spline,
    "cgsp": _without_wrong(cgsp),
    "generic": _without_wrong(generic),
}
FEWEST_VIEWS = {
    "zhang": 2,
    "kannala-brandt": 2,
    "unified": 2,
    "spline": 2,
    "cgsp": 3,
    "generic": 3,
    "auto": 3,
}
TABLES = ("cgsp", "generic")
# (what a misfit says of a model, what to do about it)
BENDS = "possible: " + WHAT_BENDS
FORMULA = (
    "this lens formula does not fit",
    "try --model auto, or look at what bends: " + WHAT_BENDS,
)
DOES_NOT_FIT = {
    "zhang": (
        "a pinhole with two radial terms does not fit",
        "try --model auto, or look at what bends: " + WHAT_BENDS,
    ),
    "kannala-brandt": FORMULA,
    "unified": FORMULA,
    "spline": ("no central camera fits", BENDS),
    "cgsp": ("no central camera fits", BENDS),
    "generic": ("no central camera fits", BENDS),
    "auto": (
        "no model that could be tried fits",
        "more views that share areas of the image let CGSP and the generic method try; "
        "else " + BENDS,
    ),
}


def lines(details, unit):
    """What people are told of a fit beside the camera's numbers."""
    if "terms" in details:
        fx, fy, cx, cy = (details["terms"][n]["sd"] for n in ("fx", "fy", "cx", "cy"))
        yield (
            f"standard deviations: focal lengths {fx:.2g} and {fy:.2g} px, principal "
            f"point ({cx:.2g}, {cy:.2g}) px; all in all "
            f"{details['sd_over_independent']:.2g} times what they were if each corner "
            "erred for itself"
        )
    pupil = details.get("pupil")
    if pupil and pupil["central_px"] is not None:
        yield _pupil_line(pupil, unit)


def _pupil_line(pupil, unit):
    errors = (
        f"without that, {pupil['central_px']:.3g} px RMS on boards kept out, with it "
        f"{pupil['moving_px']:.3g} px"
    )
    by = f"{pupil['shift']:.3g} +- {pupil['shift_sd']:.2g} {unit}"
    if pupil["moves"]:
        return f"the entrance pupil moves by {by} over the field of view: {errors}"
    if pupil["verdict"] == UNDECIDED:
        why = f"which chance makes with p = {pupil['chance']:.2g}"
        if pupil["against"]:
            why = f"but {pupil['against']}, which fits better, says otherwise"
        return (
            f"whether the entrance pupil moves is undecided, and it is taken to stand "
            f"still: if it does, by {by} over the field of view; {errors}, {why}"
        )
    return (
        "the entrance pupil is taken to stand still: one that moves fits better "
        f"(p = {pupil['p_value']:.2g}), but not boards kept out "
        f"({pupil['moving_px']:.3g} px RMS, {pupil['central_px']:.3g} px without)"
    )
