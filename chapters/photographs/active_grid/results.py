"""What a study of an active grid says, whatever happened."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from raxel.features.active_grid import REASONS
from repro.page.wording import literal

STUDY = "active_grid_study"
MODELS = {"zhang": "Zhang", "general": "General camera"}
MOST_SHOWN = 6


@dataclass(frozen=True)
class GridPictures:
    """One view; pictures are (h, w), location and sigma (h, w, 2) or None."""

    name: str
    reason: str
    picture: np.ndarray
    status: np.ndarray
    location: np.ndarray | None
    sigma: np.ndarray | None


class GridStudy:
    """The result of `active_grid_study` for one image set."""

    def __init__(self, result) -> None:
        self.result = result
        self.settings = result.settings

    def number(self, name, view):
        """One number of a view; nan where there is none."""
        return float(self.result.column(name, part="view", view=view)[0])

    def text(self, name, view):
        """One text of a view; empty where there is none."""
        return self.result.texts(name, part="view", view=view)[0] or ""

    def _array(self, name, view):
        found = self.result.arrays(name, part="view", view=view)
        return found[0] if found else None

    @property
    def names(self):
        """The views' names, in their order."""
        return self.settings["views"]

    @property
    def used(self):
        """The numbers of the views that could be decoded."""
        return [k for k in range(len(self.names)) if not self.text("reason", k)]

    def view(self, index):
        """What is to be drawn of a view."""
        return GridPictures(
            self.names[index],
            self.text("reason", index),
            *(
                self._array(name, index)
                for name in ("picture", "status", "location", "sigma")
            ),
        )

    @property
    def extent(self):
        """Width and height of the lit area in the unit of locations."""
        return self.settings["monitor_mm"] or self.settings["monitor_px"]

    @property
    def axes(self):
        """The axes that any view has patterns of: 'xy', 'x' or 'y'."""
        names = [name for p in self.settings["patterns"] for name in p]
        return "".join(a for a in "xy" if any(n[0] == a for n in names))

    @property
    def has_sines(self):
        """Whether any view shows sines."""
        shown = self.settings["patterns"]
        return any("phase" in name for one in shown for name in one)

    def calibrated(self, name):
        """A number of the calibration; nan where there is none."""
        return float(self.result.column(name, part="camera")[0])

    def refusal(self, model=""):
        """Why there is no calibration, or not one of this model."""
        name = f"{model}.reason" if model else "reason"
        return self.result.texts(name, part="camera")[0] or ""


def study_of(results):
    """The GridStudy of what a producer was given."""
    return GridStudy(results[STUDY])


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
        reasons = literal(study.text("reason", 0))
        return f"None of {count} {views} could be decoded: {reasons}."
    shares = [100 * study.number("share.decoded", k) for k in used]
    lit = [100 * study.number("decoded_of_lit", k) for k in used]
    return (
        f"{len(used)} of {count} {views} could be decoded: "
        f"{_range(shares)} % of all pixels have a place on the monitor, which is "
        f"{_range(lit)} % of those that receive its light."
    )


def left_out(study):
    """Why pixels have no place, the commonest reasons first."""
    used = study.used
    if not used:
        return "No pixel has a place."
    reasons = {
        why: np.mean([study.number(f"share.{why}", k) for k in used])
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
        values = [study.number(f"spread.{axis}.median", k) for k in study.used]
        values = [value for value in values if np.isfinite(value)]
        if values:
            unit = study.settings["unit"]
            parts.append(f"{np.median(values):.2g} {unit} along {axis}")
    if not parts:
        return "No standard deviation is known."
    how = "" if study.has_sines else "; without sines it is that of a cell's width"
    return f"The median standard deviation of a place is {' and '.join(parts)}{how}."


def doubted(study):
    """What the pictures say against themselves."""
    told = [
        literal(study.text(name, k))
        for k in range(len(study.names))
        for name in ("reason", "warnings")
        if study.text(name, k)
    ]
    if not told:
        return (
            "The pictures do not contradict each other: order, polarity, light "
            "and rest were checked."
        )
    return f"What was found wrong: {'; '.join(told)}."


def mirrored(study):
    """Whether the grid is seen as in a mirror."""
    ways = {study.text("mirrored", k) for k in study.used} - {""}
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
            rms = study.calibrated(f"{model}.rms_px")
            deg = study.calibrated(f"{model}.mean_deg")
            parts.append(f"{name}: {rms:.3g} px RMS, {deg:.2g}° on average")
    count = int(study.calibrated("views"))
    return (
        f"{count} views calibrate a camera. Errors in views that were kept out: "
        f"{'; '.join(parts)}."
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
    if k is None:
        return 2.0
    floor, slope = (study.number(f"noise.{name}", k) for name in ("floor", "slope"))
    return float(np.round(np.sqrt(floor + 100 * slope), 3))


def _range(values):
    low, high = round(min(values), 1), round(max(values), 1)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"
