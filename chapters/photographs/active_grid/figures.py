"""Figure of an active grid's page: decoded screen positions."""

import numpy as np

from chapters.photographs.active_grid.results import MAX_SHOWN, STUDY, GridStudy
from chapters.shared.photographs.notes import note
from repro.page.style import WIDTH_IN
from repro.page.style import figure as new_figure
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

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
        picture = study.array("picture", view)
        axes[view, 0].imshow(picture, cmap="gray", vmin=0, vmax=255)
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
