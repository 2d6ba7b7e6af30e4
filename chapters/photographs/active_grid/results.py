"""What a study of an active grid says, whatever happened."""

from __future__ import annotations

import numpy as np

from raxel.features.active_grid import REASONS
from repro.page.wording import literal

STUDY = "active_grid_study"
MODELS = {"zhang": "Zhang", "general": "General camera"}
MOST_SHOWN = 6


class GridStudy:
    """The result of `active_grid_study` for one image set.

    views, camera: the trials of all views, and that of the calibration; reasons: why
    a view could not be decoded, empty where it could; used: numbers of those that
    could; extent: width and height of the lit area in the unit of locations; axes: of
    which any view has patterns, 'xy', 'x' or 'y'.
    """

    def __init__(self, result) -> None:
        self.result = result
        self.settings = result.settings
        self.views = result.select(part="view")
        self.camera = result.one(part="camera")
        self.names = self.settings["views"]
        self.reasons = self.views.texts("reason")
        self.used = [k for k, reason in enumerate(self.reasons) if not reason]
        self.extent = self.settings["monitor_mm"] or self.settings["monitor_px"]
        shown = [name for view in self.settings["patterns"] for name in view]
        self.axes = "".join(a for a in "xy" if any(name[0] == a for name in shown))
        self.has_sines = any("phase" in name for name in shown)

    def array(self, name, view):
        """One array of a view; None where there is none."""
        found = self.result.arrays(name, part="view", view=view)
        return found[0] if found else None

    def refusal(self, model=""):
        """Why there is no calibration, or not one of this model."""
        name = f"{model}.reason" if model else "reason"
        return self.camera.texts(name)[0] or ""


def about(study):
    """What was photographed, with what, and in which unit locations come out."""
    s = study.settings
    camera = literal(s["camera"])
    text = f"The camera: {camera}. " if camera else ""
    wide, high = s["monitor_px"]
    text += (
        f"Its pictures are {s['width_px']} × {s['height_px']} px. The monitor "
        f"has {wide} × {high} px"
    )
    if s["monitor_mm"]:
        wide, high = s["monitor_mm"]
        return f"{text} on {wide:g} × {high:g} mm."
    return f"{text}; its size in mm is not known, so places come out in its px."


def shown(study):
    """Which patterns were photographed."""
    counts = study.settings["patterns"]
    first = counts[0]
    text = ", ".join(
        f"{n} {'pictures of Gray code' if name[2:] == 'gray' else 'steps of a sine'} "
        f"along {name[0]}"
        for name, n in first.items()
    )
    if any(other != first for other in counts):
        return f"The first view shows {text}; others differ."
    each = "Every view shows" if len(counts) > 1 else "The view shows"
    return f"{each} {text}."


def found(study):
    """How many views were decoded, and how much of them."""
    count, used = len(study.names), study.used
    views = "view" if count == 1 else "views"
    if not used:
        why = literal(study.reasons[0])
        return f"None of {count} {views} could be decoded: {why}."
    shares = 100 * study.views.column("share.decoded")[used]
    lit = 100 * study.views.column("decoded_of_lit")[used]
    return (
        f"{len(used)} of {count} {views} could be decoded: "
        f"{_range(shares)} % of all pixels have a place on the monitor, which is "
        f"{_range(lit)} % of those that receive its light."
    )


def left_out(study):
    """Why pixels have no place, the commonest reasons first."""
    if not study.used:
        return "No pixel has a place."
    reasons = {
        why: np.mean(study.views.column(f"share.{why}")[study.used])
        for code, why in REASONS.items()
        if code
    }
    lost = sorted(reasons, key=reasons.get, reverse=True)
    told = [
        f"{why} ({100 * reasons[why]:.1f} %)" for why in lost if reasons[why] > 0.0005
    ]
    if not told:
        return "Nearly every pixel has a place."
    return f"Pixels without a place, by reason: {', '.join(told)}."


def precision(study):
    """The median standard deviation of a place, for each axis."""
    parts = []
    for axis in study.axes:
        values = study.views.column(f"spread.{axis}.median")[study.used]
        values = values[np.isfinite(values)]
        if len(values):
            unit = study.settings["unit"]
            parts.append(f"{np.median(values):.2g} {unit} along {axis}")
    if not parts:
        return "No standard deviation is known."
    how = "" if study.has_sines else "; without sines it is that of a cell's width"
    return f"The median standard deviation of a place is {' and '.join(parts)}{how}."


def doubted(study):
    """What the pictures say against themselves."""
    of_views = zip(study.reasons, study.views.texts("warnings"), strict=True)
    told = [literal(text) for both in of_views for text in both if text]
    if not told:
        return (
            "The pictures do not contradict each other: order, polarity, light "
            "and rest were checked."
        )
    return f"What was found wrong: {'; '.join(told)}."


def mirrored(study):
    """Whether the grid is seen as in a mirror."""
    seen = study.views.texts("mirrored")
    ways = {seen[k] for k in study.used} - {""}
    if ways == {"True"}:
        return "The grid is seen as in a mirror: right where the camera looks into one."
    if ways == {"True", "False"}:
        return (
            "Some views show the grid as in a mirror and others do not; one "
            "camera cannot do both."
        )
    return ""


def camera(study):
    """What a calibration from these views says, or why there is none."""
    why = study.refusal()
    if why:
        return f"There is no calibration: {literal(why)}."
    parts = []
    for model, name in MODELS.items():
        refused = study.refusal(model)
        if refused:
            parts.append(f"{name}: {literal(refused)}")
        else:
            rms = study.camera.column(f"{model}.rms_px")[0]
            deg = study.camera.column(f"{model}.mean_deg")[0]
            parts.append(f"{name}: {rms:.3g} px RMS, {deg:.2g}° on average")
    return (
        f"{study.camera.column('views')[0]:.0f} views calibrate a camera. Errors in "
        f"views that were kept out: {'; '.join(parts)}."
    )


def exercise(study):
    """Where the numbers of the exercise come from."""
    if _modulated(study) is None:
        return "Its numbers are made up: the set has no view with sines."
    return f"Its noise is that of {literal(study.names[_modulated(study)])}."


def _modulated(study):
    """The first decoded view with sines, or None."""
    for k in study.used:
        if any("phase" in name for name in study.settings["patterns"][k]):
            return k
    return None


def noise_of(study):
    """Standard deviation of a grey value of 100 in the exercise's view."""
    k = _modulated(study)
    return 2.0 if k is None else float(np.round(noises(study)[k], 3))


def noises(study):
    """Standard deviation of a grey value of 100 in every view, (views,)."""
    floor, slope = (study.views.column(f"noise.{name}") for name in ("floor", "slope"))
    return np.sqrt(floor + 100 * slope)


def _range(values):
    low, high = round(min(values), 1), round(max(values), 1)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"
