"""Both errors of every model against the distortion of the lens, set by set."""

import numpy as np
from matplotlib.ticker import FuncFormatter

from chapters.shared.photographs.compared import QUANTITIES, compared_sets
from chapters.shared.photographs.notes import EMPTY_IN, note
from chapters.shared.photographs.reading import ALL_NAMES
from repro.page.method_looks import look_of
from repro.page.style import INK, plot_interval
from repro.page.style import figure as new_figure
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

# Half the distance of neighbouring marks, as a share of the axis.
APART = 0.006
NAME_APART = 0.055  # of the names above the figure


@figure(
    "ext_real_by_distortion_figure", needs=("photograph_study",), evidence="photograph"
)
def ext_real_by_distortion_figure(results):
    """Both errors of every model against the distortion level, by set."""
    study = results["photograph_study"]
    sets = [one for one in compared_sets(study) if one.comparable]
    data = _figure_data(sets)
    if not sets:
        drawn, axes = new_figure(height_in=EMPTY_IN)
        note(axes, "No image set of this build compares the two models.", 60)
        return Drawing(drawn, data, _figure_caption(sets))
    drawn, axes = new_figure(2, 1, height_in=5.6, sharex=True, sharey=True)
    for place, (quantity, label) in zip(axes, QUANTITIES.items(), strict=True):
        _panel(place, sets, quantity)
        place.set(ylabel=label, yscale="log")
        plain = FuncFormatter(lambda y, _: f"{y:.3g}")
        place.yaxis.set_major_formatter(plain)
        if max(place.get_ylim()) < 10 * min(place.get_ylim()):
            place.yaxis.set_minor_formatter(plain)
        place.grid(False, axis="x")
    span = max(1.0, *(one.level for one in sets))
    axes[1].set(xlim=(-0.04 * span, 1.06 * span), xlabel="Distortion level (1)")
    _write_names(axes[0], sets)
    handles, _ = axes[0].get_legend_handles_labels()
    drawn.legend(handles=handles, loc="outside lower center", ncols=3)
    return Drawing(drawn, data, _figure_caption(sets))


def _panel(axes, sets, quantity):
    """One error of every model, marks side by side."""
    shown = [one for one in sets if one.errors[quantity]]
    span = max(1.0, *(one.level for one in sets))
    for one in sets:
        axes.axvline(one.level, color="#8b929a", linewidth=0.8, zorder=0)
    for index, (model, name) in enumerate(ALL_NAMES.items()):
        known = [one for one in shown if model in one.errors[quantity]]
        at = [one.level + 2 * (index - 1) * APART * span for one in known]
        found = np.array([one.errors[quantity][model][:3] for one in known]).reshape(
            -1, 3
        )
        plot_interval(
            axes, np.array(at), *found.T, look=look_of(name), label=name, bars=True
        )
    for line in axes.get_lines():
        line.set_linestyle(
            "none" if line.get_marker() not in ("None", "", None) else "-"
        )


def _write_names(axes, sets):
    """Names above the upper panel, moved apart where levels nearly agree."""
    low, high = axes.get_xlim()
    last = -np.inf
    for one in sets:
        place = max((one.level - low) / (high - low), last + NAME_APART)
        last = place
        axes.annotate(
            one.name,
            xy=((one.level - low) / (high - low), 1.0),
            xytext=(place, 1.05),
            xycoords="axes fraction",
            textcoords="axes fraction",
            rotation=25,
            ha="left",
            va="bottom",
            fontsize=8.5,
            color=INK,
        )


def _figure_caption(sets):
    if not sets:
        return "Errors by distortion level: no set of this build has any."
    return (
        "Errors of the models against the distortion level of the lens, one "
        "vertical line per image set. Above: distance of corners kept out from "
        "their prediction. Below: what is left of them in the distortion-free "
        "view after a homography, as in Table 2.2. Medians over photographs with "
        "95 % intervals."
    )


def _figure_data(sets):
    return {
        "set": [one.name for one in sets],
        "level": [one.level for one in sets],
        "photographs": [one.photographs for one in sets],
    } | {
        f"{model}.{quantity}.{part}": [
            getattr(one.errors[quantity].get(model), part, "") for one in sets
        ]
        for quantity in QUANTITIES
        for model in ALL_NAMES
        for part in ("value", "low", "high")
    }
