"""The image sets of a build beside each other, by how strongly they distort."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, isfinite, log2

import numpy as np
from matplotlib.ticker import FuncFormatter

from chapters.shared.photographs.pictures import EMPTY_IN, note
from chapters.shared.photographs.reading import (
    NAMES,
    Study,
    paired,
    share_with_ray,
)
from chapters.shared.photographs.sentences import because, decided
from repro.judge.statistics import (
    SIGNIFICANCE,
    Estimate,
    median_interval,
    wins,
)
from repro.page.style import INK, plot_interval
from repro.page.style import figure as new_figure
from repro.run.outcomes import Drawing, Table

NONE = "–"
QUANTITIES = {
    "rms_px": "Residual, kept out (px)",
    "corrected_px": "Left after correction (px)",
}
# One-sided signed ranks over n pairs reach p = 1 / 2^n at best.
FEWEST_DECIDING = ceil(log2(1 / SIGNIFICANCE))
APART = (
    0.006  # half of that of the two models' marks, as a share of the axis
)
NAME_APART = 0.055  # of the names above the figure


@dataclass(frozen=True)
class Compared:
    """One image set: its distortion, both models' errors, and what came of it.

    errors: quantity -> {model: median over photographs kept out, with its interval},
    empty where no photograph has both. photographs: number of pairs behind rms_px.
    """

    name: str
    study: Study
    level: float
    widest_deg: float
    errors: dict[str, dict[str, Estimate]]
    photographs: int
    outcome: str
    share: float

    @property
    def comparable(self) -> bool:
        """Whether the set has a level, and an error of both models."""
        return isfinite(self.level) and bool(self.errors["rms_px"])


def compared_sets(results):
    """The sets of ``results`` (set name -> Result), least distorted first.

    Sets without a level stand last. A set with the very photographs of an earlier one
    is left out, because it would count twice (see `twins`).
    """
    again = twins(results)
    sets = [
        _compared(name, Study(result))
        for name, result in results.items()
        if name not in again
    ]
    return sorted(
        sets, key=lambda s: (not isfinite(s.level), s.level, s.name)
    )


def twins(results):
    """{set: earlier set} for sets in which the very same corners were found."""
    first, again = {}, {}
    for name, result in results.items():
        found = [image.corners.tobytes() for image in Study(result).found]
        key = tuple(sorted(found))
        if key and key in first:
            again[name] = first[key]
        else:
            first[key] = name
    return again


def _compared(name, study):
    rows = study.held_out
    errors = {quantity: _medians(rows, quantity) for quantity in QUANTITIES}
    pairs = paired(rows, "rms_px")
    return Compared(
        name,
        study,
        study.fit("general.distortion.level"),
        study.fit("general.distortion.widest_deg"),
        errors,
        len(pairs[0]),
        outcome_of(study, *pairs),
        share_with_ray(rows, "general") if rows else np.nan,
    )


def _medians(rows, quantity):
    pairs = paired(rows, quantity)
    if not len(pairs[0]):
        return {}
    return {
        model: median_interval(values)
        for model, values in zip(NAMES, pairs, strict=True)
    }


def outcome_of(study, zhangs, generals):
    """Who predicts better, by the rule of the set's own page; or why nobody knows."""
    if not len(zhangs):
        whys = [study.why_nothing_kept_out(model) for model in NAMES]
        return f"not compared: {because(whys[1] or whys[0])}"
    if len(zhangs) < FEWEST_DECIDING:
        return f"too few photographs ({len(zhangs)})"
    if decided(wins([(generals, zhangs)])[0]):
        return NAMES["general"]
    return (
        NAMES["zhang"]
        if decided(wins([(zhangs, generals)])[0])
        else "undecided"
    )


def sets_table(results):
    """Every set of the build: level, angle, boards, errors, coverage, outcome."""
    sets = compared_sets(results)
    made = [_row(one) for one in sets]
    return Table(
        {name: [row[name] for row in made] for name in _row(None)},
        "Image sets of this build, least distorted first. Residuals are medians "
        "over photographs kept out of the calibration, with 95 % intervals, on "
        "corners that both models have a ray for. Corrected: what is left in the "
        "distortion-free view after a homography, as in Table 2.2."
        + _said_of_twins(results),
    )


def _row(one):
    """Cells of one set; of none, for the names of the columns."""
    zhang, general = (
        {q: _told(one, q, model) for q in QUANTITIES} for model in NAMES
    )
    images = one.study.images if one else []
    found = one.study.found if one else []
    return {
        "Set": one.name if one else "",
        "Level (1)": _number(one.level if one else np.nan, 3),
        "Widest angle (deg)": _number(one.widest_deg if one else np.nan, 3),
        "Boards found": f"{len(found)} of {len(images)}"
        if images
        else NONE,
        "Zhang (px)": zhang["rms_px"],
        "General (px)": general["rms_px"],
        "Zhang, corrected (px)": zhang["corrected_px"],
        "General, corrected (px)": general["corrected_px"],
        "Corners with a ray (%)": _number(
            100 * one.share if one else np.nan, 3
        ),
        "Better": one.outcome if one else "",
    }


def _told(one, quantity, model):
    if one is None or not one.errors[quantity]:
        return NONE
    e = one.errors[quantity][model]
    return f"{e.value:.2g} ({e.low:.2g} to {e.high:.2g})"


def _number(x, digits):
    return f"{x:.{digits}g}" if isfinite(x) else NONE


def _said_of_twins(results):
    return "".join(
        f" {later} is left out: its photographs are those of {first}."
        for later, first in twins(results).items()
    )


def sets_figure(results):
    """Both errors of both models against the distortion level, a name per set."""
    sets = [one for one in compared_sets(results) if one.comparable]
    data = _figure_data(sets)
    if not sets:
        drawn, axes = new_figure(height_in=EMPTY_IN)
        note(
            axes, "No image set of this build compares the two models.", 60
        )
        return Drawing(drawn, data, _figure_caption(sets))
    drawn, axes = new_figure(2, 1, height_in=5.6, sharex=True, sharey=True)
    for place, (quantity, label) in zip(
        axes, QUANTITIES.items(), strict=True
    ):
        _panel(place, sets, quantity)
        place.set_ylabel(label)
        place.set_yscale("log")
        place.yaxis.set_major_formatter(
            FuncFormatter(lambda y, _: f"{y:g}")
        )
        place.grid(False, axis="x")
    span = max(1.0, *(one.level for one in sets))
    axes[1].set_xlim(-0.04 * span, 1.06 * span)
    axes[1].set_xlabel("Distortion level (1)")
    _write_names(axes[0], sets)
    handles, _ = axes[0].get_legend_handles_labels()
    drawn.legend(handles=handles, loc="outside lower center", ncols=2)
    return Drawing(drawn, data, _figure_caption(sets))


def _panel(axes, sets, quantity):
    """One error of both models, marks side by side."""
    shown = [one for one in sets if one.errors[quantity]]
    span = max(1.0, *(one.level for one in sets))
    for one in sets:
        axes.axvline(one.level, color="#8b929a", linewidth=0.8, zorder=0)
    for index, (model, name) in enumerate(NAMES.items()):
        at = [one.level + (2 * index - 1) * APART * span for one in shown]
        found = np.array(
            [one.errors[quantity][model][:3] for one in shown]
        ).reshape(-1, 3)
        plot_interval(
            axes, np.array(at), *found.T, index=index, label=name, bars=True
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
        "Errors of both models against the distortion level of the lens, one "
        "vertical line per image set. Above: distance of corners kept out from "
        "their prediction. Below: what is left of them in the distortion-free "
        "view after a homography, as in Table 2.2. Medians over photographs with "
        "95 % intervals."
    )


def _figure_data(sets):
    data = {
        "set": [one.name for one in sets],
        "level": [one.level for one in sets],
        "photographs": [one.photographs for one in sets],
    }
    for quantity in QUANTITIES:
        for model in NAMES:
            for part in ("value", "low", "high"):
                data[f"{model}.{quantity}.{part}"] = [
                    getattr(one.errors[quantity][model], part)
                    if one.errors[quantity]
                    else ""
                    for one in sets
                ]
    return data
