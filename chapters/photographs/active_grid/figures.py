"""What the pixels of an active grid's views see, drawn."""

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullLocator

from chapters.photographs.active_grid.results import MOST_SHOWN, STUDY, GridStudy
from chapters.shared.photographs.notes import note
from raxel.features.active_grid import REASONS
from repro.page.style import WIDTH_IN
from repro.page.style import figure as new_figure
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

NEEDS = ("active_grid_study",)
KINDS = ("active_grid",)
NOWHERE = "#dcd5cc"
# By the decoder's codes; first those that have a place.
COLOURS = (
    *("#4477aa", "#88ccee", "#3b3b3b", "#cc3311"),
    *("#aa3377", "#ee7733", "#ccbb44", "#bbbbbb", "#228833"),
)


def _rows(study, columns):
    """A figure of one row for each of the views that are shown, their names beside."""
    views = range(min(len(study.names), MOST_SHOWN))
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
    more = f" The first {MOST_SHOWN} of {count} views are shown."
    return more if count > MOST_SHOWN else ""


@figure("ext_grid_places", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_grid_places(results):
    """Where on the monitor each pixel looks, view by view."""
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
        "Where on the monitor each pixel looks, beside the photograph; lines "
        f"every sixteenth of the monitor; pale: no place.{_not_all(study)}",
    )


def _numbers(study):
    """The table beside the pictures: view, share decoded, median sigma."""
    unit = study.settings["unit"]
    spreads = {f"median_sigma_{a}_{unit}": f"spread.{a}.median" for a in "xy"}
    return _of_views(study, {"decoded_share": "share.decoded"} | spreads)


def _of_views(study, names):
    """Numbers of every view for a figure's data; names: column -> name of a number."""
    found = {c: study.views.column(name).tolist() for c, name in names.items()}
    return {"view": study.names} | found


@figure("ext_grid_mask", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_grid_mask(results):
    """Why pixels have a place or none, view by view."""
    study = GridStudy(results[STUDY])
    count = min(len(study.names), MOST_SHOWN)
    columns = min(count, 3)
    rows = -(-count // columns)
    shape = study.settings["height_px"] / study.settings["width_px"]
    height = rows * (WIDTH_IN / max(columns, 2) * shape + 0.3) + 0.7
    drawn, axes = new_figure(rows, columns, height_in=height, squeeze=False)
    colours = ListedColormap(COLOURS)
    norm = BoundaryNorm(np.arange(-0.5, len(COLOURS)), len(COLOURS))
    present = set()
    for place in axes.ravel():
        place.set_axis_off()
    for k, place in zip(range(count), axes.ravel(), strict=False):
        status = study.array("status", k)
        place.imshow(status, cmap=colours, norm=norm, interpolation="none")
        name = study.names[k]
        place.set_title(name, fontsize=8, fontweight="normal", parse_math=False)
        present |= set(np.unique(status).tolist())
    handles = [
        Patch(color=COLOURS[code], label=REASONS[code]) for code in sorted(present)
    ]
    drawn.legend(handles=handles, loc="outside lower center", ncols=3)
    return Drawing(
        drawn,
        _of_views(study, {why: f"share.{why}" for why in REASONS.values()}),
        "What became of each pixel: places are kept only where the code can be "
        f"read, light is enough, and a neighbour agrees.{_not_all(study)}",
    )


@figure("ext_grid_sigma", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_grid_sigma(results):
    """The standard deviation of each pixel's place, view by view."""
    study = GridStudy(results[STUDY])
    drawn, axes, views = _rows(study, 2)
    sigmas = {view: study.array("sigma", view) for view in views}
    known = [s[np.isfinite(s)] for s in sigmas.values() if s is not None]
    known = np.concatenate(known) if known else np.array([1.0])
    low, high = np.quantile(known, (0.02, 0.98))
    low, high = max(low / 1.2, 1e-9), high * 1.2
    for column, axis in enumerate(study.axes):
        for view, sigma in sigmas.items():
            place = axes[view, column]
            if sigma is None:
                note(place, study.reasons[view])
                continue
            place.set_facecolor(NOWHERE)
            along = sigma[..., "xy".index(axis)]
            shown = place.imshow(along, norm=LogNorm(low, high), cmap="cividis")
            if view == 0:
                place.set_title(f"along {axis}", fontsize=9)
    for place in axes[:, len(study.axes) :].ravel():
        place.set_axis_off()
    if set(views) & set(study.used):
        bar = drawn.colorbar(shown, ax=axes, location="bottom", aspect=40)
        bar.locator, bar.minorlocator = MaxNLocator(6), NullLocator()
        bar.formatter = FuncFormatter(lambda value, _: f"{value:.3g}")
        bar.set_label(f"Standard deviation of the place ({study.settings['unit']})")
    why = "from the noise of the pictures and the contrast of the pixel"
    if not study.has_sines:
        why = "without sines as good as a cell is wide"
    return Drawing(
        drawn,
        _numbers(study),
        f"How sure each place is, {why}; pale: no place.{_not_all(study)}",
    )
