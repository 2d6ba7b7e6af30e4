"""The readings of section 2.5.1: what its text leaves open, as the trials call it."""

from __future__ import annotations

import numpy as np

from chapters.shared.general.zoom_rigs import FACADE_ZOOM, ZOOMS
from chapters.shared.methods import LINEAR, SCALES, SCORINGS
from repro.run import Case, Reading, wins

# Question of the ledger -> {option: name in the trials}, the primary one first.
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
# Asked of the sweeps alone: no figure of section 2.5.2, which shares them, has means.
STATISTIC = {"statistic_of_trials": {"median": "median", "mean": "mean"}}


class SweepCase:
    """Trials of one reading."""

    def __init__(self, result, options: dict[str, str] | None = None) -> None:
        self.result = result
        self.taken = Case(SYNTHETIC_NAMES | STATISTIC, options)
        self.statistic = self.taken["statistic_of_trials"]

    def generic(self, quantity: str, law: str | None = None, **condition) -> np.ndarray:
        """Trials of the generic method, (trials,).

        law: which one, in the sweep that holds several in every trial.
        """
        method = self.taken["standard_method"]
        return self._column(f"{law}.{method}" if law else method, quantity, condition)

    def parametric(self, quantity: str, **condition) -> np.ndarray:
        """Trials of the parametric method, (trials,)."""
        return self._column("parametric", quantity, condition)

    def exact(self, quantity: str, law: str | None = None, **condition) -> np.ndarray:
        """Trials of exact rays, scored on fresh noise in any reading."""
        place = f"exact.{self.taken['residual_scale']}.{quantity}"
        return self.column(f"{law}.{place}" if law else place, **condition)

    def over_exact(self, quantity: str, **condition) -> np.ndarray:
        """The generic method's trials as multiples of those of exact rays."""
        exact = self.exact(quantity, **condition)
        return self.generic(quantity, **condition) / exact

    def column(self, name: str, **condition) -> np.ndarray:
        """Trials of a value without a method, such as the point noise."""
        open_text = {"domain": self.taken["noise"], "extent": self.taken["extent"]}
        return self.result.column(name, **open_text | condition)

    def other(self, **options: str) -> SweepCase:
        """The same reading with other options."""
        return SweepCase(self.result, {**self.taken.options, **options})

    def _column(self, method: str, quantity: str, condition: dict) -> np.ndarray:
        place = f"{method}.{self.taken['scoring']}.{self.taken['residual_scale']}"
        return self.column(f"{place}.{quantity}", **condition)


# The readings of section 2.5.2: what its text leaves open, as the trials call it.


LABORATORY = ("corner_noise", "interpolation")
NOISE_PX = {"none": 0.0, "0.06 px": 0.06, "0.45 px": 0.45}
# Question of the ledger -> {option: name in the trials}, the primary one first.
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
REDRAWN, READ, PAIRED = OF_SEEDS
OTHERS = (("none", "smooth"), ("0.06 px", "homographic"), ("0.45 px", "homographic"))


def condition_of(zoom, corner_noise, interpolation):
    """A condition of READ or PAIRED."""
    taken = zip(LABORATORY, (corner_noise, interpolation), strict=True)
    return {"zoom": zoom} | dict(taken)


# What c2_periphery hangs on; a comparison seed by seed needs more of them.
IN_PAIRS = [condition_of(FACADE_ZOOM, "none", "smooth")]
READINGS = [
    condition
    for zoom in ZOOMS
    for other in OTHERS
    if (condition := condition_of(zoom, *other)) not in IN_PAIRS
]


class ZoomCase:
    """Seeds of one reading; methods are `parametric` and `generic`.

    results: experiment -> Result, of those in OF_SEEDS that the options ask for.
    """

    def __init__(self, results, options=None):
        self.results = results
        self.taken = Case(ZOOM_NAMES, options)

    def method(self, name):
        """The trial's name of a method."""
        return name if name == "parametric" else self.taken["standard_method"]

    @property
    def scale(self):
        """The trial's name of the scale."""
        return self.taken["residual_scale"]

    @property
    def images(self):
        """The trial's name of the pictures that are scored."""
        return self.taken["residual_image"]

    def column(self, place, zoom):
        """Values (seeds,) by their full name, NaN where there is none."""
        other = tuple(self.taken[question] for question in LABORATORY)
        if other not in OTHERS:
            return self.results[REDRAWN].column(place, zoom=zoom)
        condition = condition_of(zoom, *other)
        made = self.results[PAIRED if condition in IN_PAIRS else READ]
        return made.column(place, **condition)

    def residual(self, name, zoom, statistic=None):
        """Residual (px) of every seed, NaN where the method failed."""
        statistic = statistic or self.taken["residual_statistic"]
        place = f"{self.method(name)}.{self.images}.{self.scale}"
        return self.column(f"{place}.{statistic}", zoom)

    def residuals(self, name):
        """Residuals of the seeds at the three zoom settings."""
        return [self.residual(name, zoom) for zoom in ZOOMS]

    def of(self, name, quantity, zoom):
        """Any other value of a method."""
        return self.column(f"{self.method(name)}.{quantity}", zoom)


def generic_wins(generic, parametric, quantity):
    """The Reading of wins(generic < parametric), paired by seed.

    generic, parametric: (seeds,), NaN where the method gave nothing, which
    counts as the worst.
    """
    won = wins([(generic, parametric)])[0]
    failed = [int(np.isnan(t).sum()) for t in (parametric, generic)]
    return Reading.of(
        won.decision,
        won.ratio,
        reason=f"parametric over generic {quantity}; Wilcoxon p {won.p:.1g}; of "
        f"{len(generic)} seeds {failed[0]} failed with the parametric method "
        f"and {failed[1]} with the generic one",
    )
