"""Figures of section 2.5.1: residuals of the methods along two sweeps."""

from __future__ import annotations

from typing import NamedTuple

from chapters.ch02_general_camera_model.s5_1_synthetic_data.results import (
    PRIMARY,
    trials_of,
)
from chapters.ch02_general_camera_model.s5_1_synthetic_data.trials import LEVELS
from chapters.shared.methods import METHODS, NAMES
from chapters.shared.three_planes import FOVS_DEG
from repro.judge.statistics import median_interval
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import plot_estimates
from repro.run.columns import columns as columns_of
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

NOISE = ("fig_2_3_noise", "noise", LEVELS, "Noise SD (px)")
FOV = ("fig_2_3_fov", "fov_deg", FOVS_DEG, "Field of view (deg)")
FISHEYE = ("fig_2_3_fisheye", *FOV[1:])


class Curve(NamedTuple):
    """A curve to draw: a method, one of its values, and its label."""

    method: str
    value: str
    label: str
    look: dict


def line(method, value):
    """Return a method's curve in its own style, under its own name."""
    return Curve(method, value, NAMES[method], look_of(NAMES[method]))


class Curves:
    """A figure under construction, with the data of every curve drawn."""

    def __init__(self, results, rows, columns, **layout):
        self.results = results
        self.drawn, self.axes = new_figure(rows, columns, **layout)
        self.rows = []

    def draw(self, axes, sweep, lines, condition=PRIMARY):
        """Draw curves along one sweep: medians over trials, 95 % intervals.

        A failed trial counts as the worst trial.
        """
        experiment, x_name, xs, x_label = sweep
        result = self.results[experiment]
        for one in lines:
            found = [
                median_interval(
                    trials_of(result, one.method, one.value, **{x_name: x}, **condition)
                )
                for x in xs
            ]
            self.rows += plot_estimates(
                axes, xs, found, (x_name, one.value, one.method, *condition.values()),
                look=one.look, label=one.label,
            )  # fmt: skip
        axes.set(yscale="log", xlabel=x_label)
        if x_name == "noise":
            axes.set_xscale("log")
        else:
            axes.set_xticks(range(30, 151, 30))

    def finished(self, caption, columns):
        """Return the drawing, with one legend for all panels."""
        shown = {}
        for axes in self.axes.flat:
            handles, labels = axes.get_legend_handles_labels()
            shown |= dict(zip(labels, handles, strict=True))
        self.drawn.legend(
            shown.values(), shown.keys(), loc="outside lower center", ncols=columns
        )
        return Drawing(self.drawn, columns_of(COLUMNS, self.rows), caption)


COLUMNS = (
    "sweep", "value", "method", "noise_domain", "extent",
    "x", "median", "low", "high",
)  # fmt: skip


@figure("fig_2_3", needs=("fig_2_3_noise", "fig_2_3_fov"), evidence="synthetic")
def fig_2_3(results):
    """Draw mean and SD of the residual in the primary interpretation, both sweeps."""
    curves = Curves(results, 2, 2, height_in=6.4, sharex="col")
    for panels, sweep in zip(curves.axes.T, (NOISE, FOV), strict=True):
        for panel, quantity in zip(panels, ("mean", "sd"), strict=True):
            value = f"fresh.corrected.{quantity}_px"
            curves.draw(panel, sweep, [line(m, value) for m in ("exact", *METHODS)])
        panels[0].set_ylabel("Mean residual (px)")
        panels[1].set_ylabel("SD of residual (px)")
    curves.axes[0, 0].set_title("(a) noise")
    curves.axes[0, 1].set_title("(b) field of view")
    for panel in curves.axes[0]:
        panel.set_xlabel("")
    return curves.finished(
        "Distortion residuals of the parametric and the generic method as a "
        "function of (a) noise and (b) field of view, scored on fresh noise "
        "(primary interpretation). Top: mean, bottom: standard deviation. "
        "*Exact rays* are those of the simulated camera: their residual is "
        "the noise of the scored points. Medians over trials with 95 % "
        "intervals, on logarithmic axes.",
        columns=2,
    )


@figure(
    "ext_fig_2_3_fisheye",
    needs=("fig_2_3_fov", "fig_2_3_fisheye"),
    evidence="synthetic",
)
def ext_fig_2_3_fisheye(results):
    """Draw Fig. 2.3(b) together with OpenCV's fisheye model: residual and rays."""
    curves = Curves(results, 1, 2, height_in=3.8)
    residual, rays = curves.axes
    for panel, value in ((residual, "over_exact"), (rays, "ray_deg")):
        curves.draw(panel, FOV, [line(m, value) for m in METHODS[:2]])
        curves.draw(panel, FISHEYE, [line("opencv_fisheye", value)])
    residual.set(ylabel="Mean residual (multiple of exact rays)", title="residual")
    rays.set(ylabel="Median ray error (deg)", title="rays")
    return curves.finished(
        "Residual and ray error in the sweep of Fig. 2.3(b), with OpenCV's "
        "fisheye model, which the thesis did not have. Left: the mean "
        "residual on fresh noise as a multiple of that of exact rays on the "
        "same points, which removes the stretch of the corrected view. "
        "Right: the angle between calibrated and true rays, after the best "
        "rotation. Medians over trials with 95 % intervals.",
        columns=3,
    )
