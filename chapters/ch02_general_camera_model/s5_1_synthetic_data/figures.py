"""The figures of section 2.5.1: curves of three methods along two sweeps."""

from __future__ import annotations

from itertools import product

import numpy as np

from chapters.ch02_general_camera_model.s5_1_synthetic_data.results import (
    PRIMARY,
)
from chapters.ch02_general_camera_model.s5_1_synthetic_data.trials import (
    DOMAINS,
    EXTENTS,
    LEVELS,
)
from chapters.shared.methods import METHODS, NAMES
from chapters.shared.three_planes import FOVS_DEG
from repro.page.style import figure as new_figure
from repro.page.style import plot_interval
from repro.run.experiment import figure
from repro.run.outcomes import Drawing
from repro.run.results import summary

NOISE = ("fig_2_3_noise", "noise", LEVELS, "Noise SD (px)")
FOV = ("fig_2_3_fov", "fov_deg", FOVS_DEG, "Field of view (deg)")


class Curves:
    """A figure in the making, and the data of every curve drawn into it."""

    def __init__(self, results, rows, columns, **layout):
        self.results = results
        self.drawn, self.axes = new_figure(rows, columns, **layout)
        self.data = {name: [] for name in COLUMNS}

    def draw(self, axes, sweep, value, condition):
        """Three methods along one sweep; ``value`` is named within a method.

        Medians over trials with 95 % intervals; failed trials count as the
        worst that was seen.
        """
        experiment, x_name, xs, x_label = sweep
        result = self.results[experiment]
        for index, method in enumerate(METHODS):
            name = f"{method}.{value}"
            found = curve(result, name, x_name, xs, condition)
            plot_interval(
                axes, np.array(xs), *found, index=index, label=NAMES[method]
            )
            for row in zip(xs, *found, strict=True):
                cells = (x_name, value, method, *condition.values(), *row)
                for column, cell in zip(self.data, cells, strict=True):
                    self.data[column].append(cell)
        axes.set_yscale("log")
        axes.set_xlabel(x_label)
        if x_name == "noise":
            axes.set_xscale("log")
        else:
            axes.set_xticks(range(30, 151, 30))

    def finished(self, caption):
        """The drawing, with one legend for all panels."""
        self.drawn.legend(
            *self.axes.flat[0].get_legend_handles_labels(),
            loc="outside lower center",
            ncols=3,
        )
        return Drawing(self.drawn, self.data, caption)


COLUMNS = (
    "sweep", "value", "method", "noise_domain", "extent",
    "x", "median", "low", "high",
)  # fmt: skip


def curve(result, name, x_name, xs, condition):
    """Median over trials and its 95 % interval along a sweep: (3, n)."""
    found = []
    for x in xs:
        trials = result.column(name, **{x_name: x}, **condition)
        row = summary(worst_for_failed(trials))
        found.append((row["median"], *row["median_interval"]))
    return np.array(found).T


def worst_for_failed(trials):
    """Trials with the failed ones (nan) set to the worst that was seen."""
    worst = np.nanmax(trials) if np.isfinite(trials).any() else np.nan
    return np.where(np.isnan(trials), worst, trials)


@figure(
    "fig_2_3",
    needs=("fig_2_3_noise", "fig_2_3_fov"),
    evidence="synthetic",
)
def fig_2_3(results):
    """Mean and SD of the residual in the primary reading, both sweeps."""
    curves = Curves(results, 2, 2, height_in=6.4, sharex="col")
    for panels, sweep in zip(curves.axes.T, (NOISE, FOV), strict=True):
        for panel, quantity in zip(panels, ("mean", "sd"), strict=True):
            value = f"noisy.corrected.{quantity}_px"
            curves.draw(panel, sweep, value, PRIMARY)
        panels[0].set_ylabel("Mean residual (px)")
        panels[1].set_ylabel("SD of residual (px)")
    curves.axes[0, 0].set_title("(a) rising noise")
    curves.axes[0, 1].set_title("(b) rising field of view")
    for panel in curves.axes[0]:
        panel.set_xlabel("")
    return curves.finished(
        "Distortion residuals of the parametric and the generic method (a) "
        "under rising noise and (b) under rising field of view, in the "
        "primary reading. Top: mean, bottom: standard deviation. Medians "
        "over trials with 95 % intervals; note the logarithmic axes."
    )


@figure(
    "ext_fig_2_3_readings", needs=("fig_2_3_fov",), evidence="synthetic"
)
def ext_fig_2_3_readings(results):
    """Fig. 2.3(b) in twelve readings."""
    curves = Curves(results, 3, 4, height_in=7.2, sharex=True, sharey=True)
    rows = {
        "noisy.corrected": "noisy data,\ncorrected view (px)",
        "clean.corrected": "clean data,\ncorrected view (px)",
        "clean.source": "clean data,\nsource image (px)",
    }
    cases = list(product(DOMAINS, EXTENTS))
    for panels, (scored, label) in zip(
        curves.axes, rows.items(), strict=True
    ):
        for panel, (domain, extent) in zip(panels, cases, strict=True):
            condition = {"domain": domain, "extent": extent}
            curves.draw(panel, FOV, f"{scored}.mean_px", condition)
            panel.set_xticks((30, 90, 150))
            panel.set_xlabel("")
        panels[0].set_ylabel(f"Mean residual,\n{label}")
    for panel, (domain, extent) in zip(curves.axes[0], cases, strict=True):
        panel.set_title(f"noise in {domain},\n{extent}")
    for panel in curves.axes[-1]:
        panel.set_xlabel("Field of view (deg)")
    return curves.finished(
        "The field-of-view sweep in twelve readings of the text. Columns: "
        "noise in the image or on the grids, unbounded planes or grids of "
        "±600 mm. Rows: scored on noisy or on clean data, in pixels of the "
        "corrected view or of the source image. Medians over trials with "
        "95 % intervals."
    )


@figure(
    "ext_fig_2_3_rays",
    needs=("fig_2_3_noise", "fig_2_3_fov"),
    evidence="synthetic",
)
def ext_fig_2_3_rays(results):
    """What the residual cannot see: the error of the rays themselves."""
    curves = Curves(results, 1, 2, height_in=3.6, sharey=True)
    for panel, sweep in zip(curves.axes, (NOISE, FOV), strict=True):
        curves.draw(panel, sweep, "ray_deg", PRIMARY)
    curves.axes[0].set_ylabel("Median ray error (deg)")
    curves.axes[0].set_title("rising noise")
    curves.axes[1].set_title("rising field of view")
    return curves.finished(
        "The error that a distortion residual does not show: the angle "
        "between calibrated and true rays, after the best rotation, in the "
        "primary reading. Medians over trials with 95 % intervals."
    )
