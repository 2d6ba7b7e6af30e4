"""Interpretations of sections 2.5.1 and 2.5.2: ambiguous text as the trials name it."""

from __future__ import annotations

import numpy as np

from chapters.shared.general.zoom_rigs import FACADE_ZOOM, ZOOMS
from chapters.shared.methods import LINEAR, SCALES, SCORINGS
from repro.run import Case, Reading, wins

# Question of settings.yaml -> {option: name in the trials}, the primary one first.
SYNTHETIC_NAMES = {
    "noise": {"px": "px", "mm": "mm"},
    "scoring": dict(
        zip(("fresh noise", "same noise", "no noise"), SCORINGS, strict=True)
    ),
    "extent": {"unbounded": "unbounded", "finite": "finite"},
    "standard_method": {linear: method for method, linear in LINEAR.items()},
    "residual_scale": dict(
        zip(("corrected view", "source image"), SCALES, strict=True)
    ),
}
# For the sweeps alone: no figure of section 2.5.2, which shares the others, has means.
STATISTIC = {"statistic_of_trials": {"median": "median", "mean": "mean"}}


class SweepCase(Case):
    """Trials of a sweep of section 2.5.1 in one interpretation."""

    def __init__(self, result, options: dict[str, str] | None = None) -> None:
        super().__init__(SYNTHETIC_NAMES | STATISTIC, options)
        self.result = result
        self.statistic = self["statistic_of_trials"]

    def column(self, *path, **condition) -> np.ndarray:
        """Return the trials of a value without a method, such as the point noise."""
        ambiguous = {"domain": self["noise"], "extent": self["extent"]}
        return self.result.column(*path, **ambiguous | condition)

    def trials(self, method: str, quantity, *law, **condition) -> np.ndarray:
        """Return the trials (..., trials) of a method's residuals.

        method: `generic`, `parametric`, or `exact` for exact rays, which are always
        scored on fresh noise. quantity: one value or several. law: the laws, in the
        sweep that has several in every trial.
        """
        name = self["standard_method"] if method == "generic" else method
        scored = () if method == "exact" else (self["scoring"],)
        path = (*law, name, *scored, self["residual_scale"], quantity)
        return self.column(*path, **condition)

    def over_exact(self, quantity, method="generic", **condition) -> np.ndarray:
        """Return a method's trials as multiples of those of exact rays."""
        exact = self.trials("exact", quantity, **condition)
        return self.trials(method, quantity, **condition) / exact


VARIED = ("corner_noise", "interpolation")
NOISE_PX = {"none": 0.0, "0.06 px": 0.06, "0.45 px": 0.45}
# Question of settings.yaml -> {option: name in the trials}, the primary one first.
ZOOM_NAMES = SYNTHETIC_NAMES | {
    "residual_image": {
        "calibration images": "calibration",
        "held-out images": "held_out",
    },
    "residual_statistic": {"RMS": "rms_px", "mean": "mean_px"},
    "step_frame": {"grid": "grid", "camera": "camera"},
    "corner_noise": {option: option for option in NOISE_PX},
    "interpolation": {"homographic": "homographic", "smooth": "smooth"},
}
OF_SEEDS = ("table_2_2_redrawn", "table_2_2_readings", "fig_2_7_smooth")
OTHERS = (("none", "smooth"), ("0.06 px", "homographic"), ("0.45 px", "homographic"))


def condition_of(zoom, corner_noise, interpolation):
    """Return a condition of the runs with other corner noise or interpolation."""
    taken = zip(VARIED, (corner_noise, interpolation), strict=True)
    return {"zoom": zoom} | dict(taken)


# What c2_periphery depends on: a paired comparison requires more runs.
IN_PAIRS = [condition_of(FACADE_ZOOM, "none", "smooth")]
VARIANTS = [
    condition
    for zoom in ZOOMS
    for other in OTHERS
    if (condition := condition_of(zoom, *other)) not in IN_PAIRS
]


class ZoomCase(Case):
    """Simulated runs of section 2.5.2 in one interpretation.

    results: experiment -> Result, of those in OF_SEEDS that the options require.
    """

    def __init__(self, results, options=None):
        super().__init__(ZOOM_NAMES, options)
        self.results = results

    def column(self, method, zoom, *path):
        """Return the values (..., runs) of a method, NaN if it is missing.

        method: `generic` is that of the interpretation. It may also be the first key
        of a value without a method.
        """
        method = self["standard_method"] if method == "generic" else method
        redrawn, variants, paired = OF_SEEDS
        other = tuple(self[question] for question in VARIED)
        if other not in OTHERS:
            return self.results[redrawn].column(method, *path, zoom=zoom)
        condition = condition_of(zoom, *other)
        name = paired if condition in IN_PAIRS else variants
        return self.results[name].column(method, *path, **condition)

    def residual(self, method, zoom, statistic=None):
        """Return the residual (px) of every run, NaN where the method failed."""
        path = self["residual_image"], self["residual_scale"]
        return self.column(method, zoom, *path, statistic or self["residual_statistic"])


def generic_wins(generic, parametric, quantity):
    """Return the Reading of wins(generic < parametric), paired by run.

    generic, parametric: (runs,), NaN where the method returned nothing, which
    counts as the worst.
    """
    won = wins([(generic, parametric)])[0]
    return Reading.of(
        won.decision,
        won.ratio,
        reason=f"parametric over generic {quantity}; Wilcoxon p {won.p:.1g}; of "
        f"{len(generic)} simulated runs {np.isnan(parametric).sum()} failed with the "
        f"parametric method and {np.isnan(generic).sum()} with the generic one",
    )
