"""A calibrated camera, and how well it fits its boards, in words and as JSON."""

import numpy as np

from raxel.calibration.views.correspondence import near_copies
from raxel.cli.scores import known
from raxel.evaluation.coverage import board_counts, field_of_view

# A table of fewer of the image's pixels is a small part of a camera.
LEAST_TABLE = 1 / 3
# Fewer are not asked whether they are flat, nor whether halves of them agree.
FEW_BOARDS, ENOUGH_BOARDS = 6, 10
# RMS distance by which single corners scatter that are not where they are said to be.
OTHER_ORDER_PX = 10.0
# Of a lens formula, beside focal lengths, principal point and radial terms.
TERMS = {
    "xi": "xi",
    "tangential": "tangential terms",
    "prism": "prism terms",
    "pupil_shift": "pupil's shift",
}
WHAT_BENDS = (
    "rays that do not meet in one point, a rolling shutter, targets that are not flat, "
    "or pictures of several cameras"
)


def camera_fields(camera, views):
    """The camera as JSON: its kind and size, its numbers, and what it sees."""
    fields = {"kind": camera.kind, "width": camera.width, "height": camera.height}
    fields |= _formula_fields(camera)
    if camera.kind == "general":
        fields |= {"units": camera.units, "centre": camera.origins.tolist()}
        fields["share_of_image_with_ray"] = camera.share_with_ray
    angles = {name: known(angle) for name, angle in field_of_view(camera).items()}
    fields["field_of_view_deg"] = angles
    counts = board_counts(views, camera.width, camera.height)
    fields["share_of_image_under_boards"] = float(np.mean(counts > 0))
    return fields


def _formula_fields(camera):
    """The numbers of a formula; focal lengths are px per radian near the axis."""
    if camera.kind == "ray spline":
        return _formula_fields(camera.trend)
    if camera.kind == "moving pupil":
        shift = camera.pupil_shift.tolist()
        return _formula_fields(camera.lens) | {"pupil_shift": shift}
    if camera.kind == "kannala-brandt":
        focal = camera.k[0] * camera.pixels_per_unit
        terms = {"radial": (camera.k[1:] / camera.k[0]).tolist()}
        centre = camera.principal_point
    elif camera.kind in ("perspective", "unified sphere"):
        xi = getattr(camera, "xi", 0.0)
        focal, centre = np.diag(camera.K)[:2] / (1 + xi), camera.K[:2, 2]
        terms = {"K": camera.K.tolist(), "radial": camera.radial.tolist()}
        if camera.kind == "unified sphere":
            terms["xi"] = xi
    else:
        return {}
    for name in ("tangential", "prism"):
        if np.any(getattr(camera, name, 0)):
            terms[name] = getattr(camera, name).tolist()
    return terms | {"focal_px": focal.tolist(), "principal_point_px": centre.tolist()}


def camera_lines(fields, target):
    """The same for people, in lines; target: what `raxel.sets.model` calls it."""
    if fields["kind"] == "ray spline":
        yield (
            f"smooth rays where {target}s were; beyond them they go on towards the "
            "trend's, and nothing checks them; the numbers are the trend's"
        )
    if "focal_px" in fields:
        f, p = fields["focal_px"], fields["principal_point_px"]
        told = [
            f"{words} {_terms(fields[name])}"
            for name, words in TERMS.items()
            if name in fields
        ]
        yield (
            f"focal lengths {f[0]:.2f} and {f[1]:.2f} px, principal point ({p[0]:.2f}, "
            f"{p[1]:.2f}) px, radial terms {_terms(fields['radial'])}"
            + "".join(f", {text}" for text in told)
        )
    else:
        yield (
            f"a ray for {_percent(fields['share_of_image_with_ray'])} of the image, "
            f"through one centre, the origin; lengths in {fields['units']}"
        )
    angles = fields["field_of_view_deg"]
    across, down, reach = (
        "no" if angles[name] is None else f"{angles[name]:.1f}"
        for name in ("horizontal", "vertical", "from_axis")
    )
    share = _percent(fields["share_of_image_under_boards"])
    yield (
        f"field of view {across} x {down} deg, up to {reach} deg from the axis; "
        f"{target}s cover {share} of the image"
    )


def _terms(values):
    return ", ".join(f"{value:.4g}" for value in np.atleast_1d(values))


def coverage_warnings(fields, target):
    """What to say of a table that holds little of the image."""
    share = fields.get("share_of_image_with_ray", 1.0)
    if share >= LEAST_TABLE:
        return []
    return [
        f"the table has rays for {_percent(share)} of the image only: pixels that no "
        f"{target} covered have none; take pictures with {target}s there"
    ]


def few_warnings(views, target):
    """What to say of a camera that few boards were seen by: [] for active grids."""
    boards = [view for view in views if not view.every_pixel]
    boards = len(set(near_copies(boards)))
    if not 0 < boards < FEW_BOARDS:
        return []
    return [
        f"{boards} {target}s went into the fit: their own residuals hardly tell how "
        f"wrong the camera is elsewhere, and neither whether the {target} is flat nor "
        f"whether halves of them agree was asked; take {ENOUGH_BOARDS} or more, all "
        "over the image and at other tilts"
    ]


def misfit_fields(found):
    """A Misfit as JSON."""
    return {
        "fits": not found.large,
        "rms_px": known(found.rms_px),
        "scatter_px": known(found.scatter_px),
        "stated_sd_px": known(found.sd_px),
        "odd_board": found.odd_board or None,
    }


def misfit_warnings(found, what, cure, words):
    """What to say where residuals are larger than the corners explain; [] else.

    what: the subject of the sentence, such as "no central camera fits"; cure: what may
    be the cause, or what to do; words: of the target.
    """
    if not found.large and not found.odd_board:
        return []
    sure = [
        f"{words} {number:.2g} px"
        for words, number in (
            ("scatter singly by", found.scatter_px),
            ("are sure to", found.sd_px),
        )
        if np.isfinite(number)
    ]
    off = f"off by {found.rms_px:.2f} px (rms)"
    if sure:
        off += f" where {words.point}s {' and '.join(sure)}"
    if found.odd_board:
        return [
            f"{found.odd_board}: does not fit as the other {words.target}s do: with it "
            f"{off}; if its {words.point}s are right, {what} these {words.target}s"
        ]
    if found.scatter_px > OTHER_ORDER_PX:
        cure = (
            f"no finder's {words.point}s scatter so: are columns and rows exchanged, "
            f"or {words.point}s in another order than row by row? If not, {cure}"
        )
    return [f"{what} these {words.target}s: {off}; {cure}"]


def centre_fields(test):
    """A CentralTest as JSON, lengths in the unit of the result; None where there is
    none."""
    if test is None:
        return None
    return {
        "central": test.central,
        "p_value": test.p_value,
        "distance": test.distance_mm,
        "at_least": test.at_least_mm,
        "at_most": test.at_most_mm,
        "noise_over_stated": known(test.noise_ratio),
        "rays": test.rays,
    }


def centre_line(test, unit, target):
    """How far from one point the rays pass, for people."""
    if test is None:
        return (
            "whether the rays meet in one point was not tested: too few pixels see "
            f"three {target}s, or too many of them are far off"
        )
    bounds = f"{test.at_least_mm:.2g} to {test.at_most_mm:.2g} {unit}"
    found = f"pass {test.distance_mm:.2g} {unit} from it (RMS; {bounds}, each bound"
    return (
        f"one centre: {test.rays} rays that see three {target}s or more {found} of "
        f"95 %); if there is one, noise does so with p = {test.p_value:.2g}"
    )


def centre_warnings(test, unit, target):
    """What to say of rays that do not meet in one point."""
    if test is None or test.central:
        return []
    return [
        f"the rays do not meet in one point, and the camera has one all the same: they "
        f"pass {test.distance_mm:.2g} {unit} from it (RMS, at least "
        f"{test.at_least_mm:.2g} {unit}), p = {test.p_value:.2g}; if the {target}s are "
        "flat and stood still, try --model kannala-brandt or unified, whose pupil may "
        "move, and take distances near the camera with care"
    ]


def _percent(share):
    return f"{100 * share:.0f} %"
