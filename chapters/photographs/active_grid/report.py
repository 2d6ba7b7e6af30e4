"""Results of this page read: values of the prose, figures, tables."""

from __future__ import annotations

import numpy as np

from chapters.shared.images.notes import note
from raxel.features.active_grid import REASONS
from repro.page import WIDTH_IN, literal, new_figure
from repro.run import Drawing, Table, cell, figure, table

# Sentences of an active grid's page, complete for every outcome.


STUDY = "active_grid_study"
MODELS = {"zhang": "Zhang", "general": "General camera"}
MAX_SHOWN = 6


class GridStudy:
    """The result of `active_grid_study` for one image set.

    views, camera: trials of all views, and that of the calibration; reasons: why a view
    is not decoded, empty where it is; used: indices of decoded views; extent: width and
    height of the lit area in the unit of locations; axes: those with patterns in any
    view, 'xy', 'x' or 'y'.
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
        """Return one array of a view; None if it is missing."""
        found = self.result.arrays(name, part="view", view=view)
        return found[0] if found else None

    def failure(self, *model):
        """Return why there is no calibration, or none of this model."""
        return self.camera.texts(*model, "reason")[0] or ""


def about(study):
    """Return camera, image size, monitor, and the unit of positions."""
    s = study.settings
    camera = literal(s["camera"])
    text = f"The camera: {camera}. " if camera else ""
    wide, high = s["monitor_px"]
    text += (
        f"Its images are {s['width_px']} × {s['height_px']} px. The monitor "
        f"has {wide} × {high} px"
    )
    if s["monitor_mm"]:
        wide, high = s["monitor_mm"]
        return f"{text} on {wide:g} × {high:g} mm."
    return f"{text}. Its size in mm is unknown, so positions are in its px."


def shown(study):
    """Return which patterns the images show."""
    counts = study.settings["patterns"]
    first = counts[0]
    text = ", ".join(
        f"{n} {'images of Gray code' if name[2:] == 'gray' else 'phase steps'} "
        f"along {name[0]}"
        for name, n in first.items()
    )
    if any(other != first for other in counts):
        return f"The first view shows {text}. Other views differ."
    each = "Every view shows" if len(counts) > 1 else "The view shows"
    return f"{each} {text}."


def found(study):
    """Return the number of decoded views, and their decoded share."""
    count, used = len(study.names), study.used
    views = "view" if count == 1 else "views"
    if not used:
        why = literal(study.reasons[0])
        return f"None of {count} {views} is decoded: {why}."
    shares = 100 * study.views.column("share.decoded")[used]
    lit = 100 * study.views.column("decoded_of_lit")[used]
    return (
        f"Decoded: {len(used)} of {count} {views}, with {_range(shares)} % of all "
        f"pixels, or {_range(lit)} % of those that receive the monitor's light."
    )


def left_out(study):
    """Return why pixels are excluded, the most frequent reasons first."""
    if not study.used:
        return "No pixel is decoded."
    reasons = {
        why: np.mean(study.views.column("share", why)[study.used])
        for code, why in REASONS.items()
        if code
    }
    lost = sorted(reasons, key=reasons.get, reverse=True)
    shares = [
        f"{why} ({100 * reasons[why]:.1f} %)" for why in lost if reasons[why] > 0.0005
    ]
    if not shares:
        return "Nearly every pixel is decoded."
    return f"Excluded pixels, by reason: {', '.join(shares)}."


def precision(study):
    """Return the median predicted standard deviation, for each axis."""
    parts = []
    for axis in study.axes:
        values = study.views.column("spread", axis, "median")[study.used]
        values = values[np.isfinite(values)]
        if len(values):
            unit = study.settings["unit"]
            parts.append(f"{np.median(values):.2g} {unit} along {axis}")
    if not parts:
        return "No standard deviation is predicted."
    how = (
        ""
        if study.has_sines
        else ", which without phase steps is that of a cell's width"
    )
    return f"Median predicted standard deviation: {' and '.join(parts)}{how}."


def doubted(study):
    """Return the consistency warnings of the images."""
    of_views = zip(study.reasons, study.views.texts("warnings"), strict=True)
    warnings = [literal(text) for both in of_views for text in both if text]
    if not warnings:
        return (
            "The images are consistent: order, polarity, light and motion were checked."
        )
    return f"Warnings: {'; '.join(warnings)}."


def mirrored(study):
    """Return whether the grid appears mirrored."""
    of_views = study.views.texts("mirrored")
    ways = {of_views[k] for k in study.used} - {""}
    if ways == {"True"}:
        return "The grid appears mirrored: correct for a camera that views a mirror."
    if ways == {"True", "False"}:
        return (
            "Some views show the grid mirrored and others do not, which contradicts a "
            "single camera."
        )
    return ""


def camera(study):
    """Return the errors of a calibration from these views, or why it is missing."""
    why = study.failure()
    if why:
        return f"There is no calibration: {literal(why)}."
    parts = []
    for model, name in MODELS.items():
        if why := study.failure(model):
            parts.append(f"{name}: {literal(why)}")
        else:
            rms, deg = study.camera.column(model, ("rms_px", "mean_deg"))[:, 0]
            parts.append(f"{name}: {rms:.3g} px RMS, {deg:.2g}° on average")
    return (
        f"Calibration from {study.camera.column('views')[0]:.0f} views. Errors in "
        f"held-out views: {'; '.join(parts)}."
    )


def exercise(study):
    """Return where the numbers of the exercise come from."""
    if _modulated(study) is None:
        return "The value is invented: no decoded view has phase steps."
    return f"It is measured in {literal(study.names[_modulated(study)])}."


def _modulated(study):
    """Return the first decoded view with phase steps, or None."""
    for k in study.used:
        if any("phase" in name for name in study.settings["patterns"][k]):
            return k
    return None


def noise_of(study):
    """Return the standard deviation of a grey value of 100 in the exercise's view."""
    k = _modulated(study)
    return 2.0 if k is None else float(np.round(noises(study)[k], 3))


def noises(study):
    """Return the standard deviation of a grey value of 100 per view, (views,)."""
    floor, slope = study.views.column("noise", ("floor", "slope"))
    return np.sqrt(floor + 100 * slope)


def _range(values):
    low, high = round(min(values), 1), round(max(values), 1)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


# Figure of an active grid's page: decoded screen positions.


NEEDS = ("active_grid_study",)
KINDS = ("active_grid",)
NOWHERE = "#dcd5cc"


def _rows(study, columns):
    """Return a figure with one labelled row per view."""
    views = range(min(len(study.names), MAX_SHOWN))
    shape = study.settings["height_px"] / study.settings["width_px"]
    height = len(views) * (WIDTH_IN / columns * 0.92 * shape + 0.3) + 0.75
    drawn, axes = new_figure(len(views), columns, height_in=height, squeeze=False)
    for place in axes.ravel():
        place.set(xticks=[], yticks=[])
        place.grid(False)
        place.spines[:].set_visible(False)
    for view in views:
        axes[view, 0].set_ylabel(study.names[view], fontsize=8, parse_math=False)
    return drawn, axes, views


def _not_all(study):
    count = len(study.names)
    more = f" Shown: the first {MAX_SHOWN} of {count} views."
    return more if count > MAX_SHOWN else ""


@figure("ext_grid_places", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_grid_places(results):
    """Draw the decoded screen position of each pixel, view by view."""
    study = GridStudy(results[STUDY])
    drawn, axes, views = _rows(study, 1 + len(study.axes))
    for column, axis in enumerate(study.axes, 1):
        k = "xy".index(axis)
        extent = study.extent[k]
        for view in views:
            place = axes[view, column]
            location = study.array("location", view)
            if location is None:
                note(place, study.reasons[view], 30)
                continue
            place.set_facecolor(NOWHERE)
            shown = place.imshow(location[..., k], vmin=0, vmax=extent, cmap="viridis")
            place.contour(
                location[..., k],
                levels=np.linspace(0, extent, 17)[1:-1],
                colors="white",
                linewidths=0.4,
            )
        if set(views) & set(study.used):
            bar = drawn.colorbar(
                shown, ax=axes[:, column], location="bottom", aspect=30
            )
            bar.set_label(f"{axis} on the monitor ({study.settings['unit']})")
    for view in views:
        image = study.array("picture", view)
        axes[view, 0].imshow(image, cmap="gray", vmin=0, vmax=255)
    return Drawing(
        drawn,
        _numbers(study),
        "Decoded screen position of each pixel, next to the image. Lines: every "
        f"sixteenth of the monitor. Pale: not decoded.{_not_all(study)}",
    )


def _numbers(study):
    """Return the data of the figure: view, decoded share, median sigma."""
    unit = study.settings["unit"]
    spreads = {f"median_sigma_{a}_{unit}": f"spread.{a}.median" for a in "xy"}
    names = {"decoded_share": "share.decoded"} | spreads
    found = {c: study.views.column(name).tolist() for c, name in names.items()}
    return {"view": study.names} | found


# Tables of an active grid's page.


@table("ext_grid_views", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_grid_views(results):
    """Tabulate decoded and excluded pixels, noise and standard deviations by view."""
    study = GridStudy(results[STUDY])
    columns = {"View": study.names}
    for why in REASONS.values():
        shares = 100 * study.views.column("share", why)
        if max(shares) > 0:
            columns[f"{why.capitalize()} (%)"] = list(map(cell, shares))
    columns["Noise at grey value 100 (grey values)"] = list(map(cell, noises(study)))
    for axis in study.axes:
        for name, words in (("median", "median"), ("high", "90 % below")):
            found = study.views.column("spread", axis, name)
            title = f"σ {axis}, {words} ({study.settings['unit']})"
            columns[title] = list(map(cell, found))
        columns |= _of_response(study, axis)
    of_views = zip(study.reasons, study.views.texts("warnings"), strict=True)
    remarks = ["; ".join(filter(None, both)) for both in of_views]
    if any(remarks):
        columns["Remark"] = remarks
    return Table(
        columns,
        "Decoded and excluded pixels of every view, noise of a grey value of 100, and "
        "predicted standard deviation σ of a position. Shift by the response: effect "
        "of the nonlinear monitor and camera without correction (RMS). Left of it: "
        "after correction. A remark may reject a view.",
        texts=("View", "Remark"),
    )


def _of_response(study, axis):
    """Return columns of the response along an axis, none where it is not measured."""
    columns = {}
    for name, words in (("shift", "shift by the response"), ("left", "left of it")):
        found = study.views.column("response", axis, name)
        if np.isfinite(found).any():
            title = f"{words.capitalize()} {axis} ({study.settings['unit']})"
            columns[title] = list(map(cell, found))
    return columns


@table("ext_grid_camera", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_grid_camera(results):
    """Tabulate the held-out errors of cameras from these views."""
    study = GridStudy(results[STUDY])
    caption = "Errors in held-out views of cameras from the decoded positions."
    if study.failure():
        caption = f"{caption} None: {literal(study.failure())}."
    columns = {"Model": list(MODELS.values())}
    names = {
        "RMS (px)": "rms_px",
        "Median (px)": "median_px",
        "Mean angle (deg)": "mean_deg",
    }
    for words, name in names.items():
        columns[words] = list(map(cell, study.camera.column(tuple(MODELS), name)[:, 0]))
    return Table(columns, caption)
