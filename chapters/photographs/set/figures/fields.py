"""Figures of an image set: residual vectors and held-out errors."""

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedFormatter, FixedLocator, FuncFormatter, NullLocator

from chapters.photographs.set.figures.pictures import NO_RAY, tinted
from chapters.shared.photographs.notes import EMPTY_IN, note
from chapters.shared.photographs.reading import (
    ALL_NAMES,
    BOARDS,
    MODELS,
    NAMES,
    Study,
    column,
    paired,
)
from repro.judge.statistics import median_interval
from repro.page.method_looks import look_of
from repro.page.style import INK, WIDTH_IN
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

ARROWS = 1500
ARROW_SHARE = 0.05  # drawn length of the 95th percentile, as a share of the image width
MAX_ARROW = 3.0  # times that; longer ones are truncated
LOST = "#8a7a70"
QUANTITIES = (("rms_px", "RMS residual (px)"), ("mean_deg", "Mean angle (deg)"))


@figure(
    "ext_residuals", needs=("photograph_study",), evidence="photograph", per_set=BOARDS
)
def ext_residuals(results):
    """Draw residual vectors of held-out corners, both models on one scale."""
    study = Study(results["photograph_study"])
    rows = study.held_out
    fields = {model: _field(rows, model) for model in MODELS}
    scale = _arrow_scale(fields, study.settings["width_px"])
    shape = study.settings["height_px"] / study.settings["width_px"]
    height = WIDTH_IN / 2 * shape + 1.55 if scale else EMPTY_IN
    drawn, axes = new_figure(1, 2, height_in=height, sharey=True)
    coverage = study.array("general.coverage", part="fit")
    for place, model in zip(axes, MODELS, strict=True):
        _prepare(place, study, coverage if model == "general" else None)
        place.set_title(NAMES[model])
        if np.isfinite(fields[model][:, 2]).any():
            colours = _arrows(place, fields[model], scale)
        else:
            note(place, study.why_nothing_kept_out(model))
    if scale:
        _colour_bar(drawn, axes, colours, scale)
        drawn.legend(
            handles=_residual_legend(coverage is not None),
            loc="outside lower center",
            ncols=2,
        )
    return Drawing(drawn, _residual_data(rows), _residual_caption(scale))


def _residual_caption(scale):
    if scale is None:
        return "Residual vectors: no held-out corner."
    return (
        "Residual vectors of held-out corners, detected minus predicted. Arrows are "
        f"magnified {scale['magnified']:.2g} times, on the same scale for both models. "
        f"Residuals above {scale['cut']:.2g} px are truncated."
    )


def _field(rows, model):
    """Return corners and residuals (N, 4) of one model over all images."""
    at = [
        np.column_stack([row.image.corners, row.own[model].residuals_px])
        for row in rows
        if model in row.own
    ]
    return np.concatenate(at) if at else np.empty((0, 4))


def _colour_bar(drawn, axes, colours, scale):
    bar = drawn.colorbar(
        colours, ax=axes, location="bottom", shrink=0.6, aspect=35, extend="both"
    )
    bar.set_label("Residual (px)")
    _plain_ticks(bar.ax, scale["norm"].vmin, scale["norm"].vmax)


def _arrow_scale(fields, width_px):
    """Return magnification, truncation length (px) and colour range of arrows."""
    lengths = np.concatenate([np.hypot(*f[:, 2:].T) for f in fields.values()])
    lengths = lengths[np.isfinite(lengths)]
    if not len(lengths):
        return None
    long = max(np.percentile(lengths, 95), 1e-6)
    low = max(np.percentile(lengths, 5), long / 1000)
    return {
        "magnified": ARROW_SHARE * width_px / long,
        "cut": MAX_ARROW * long,
        "key": _round_number(long),
        "norm": LogNorm(min(low, long / 2), long),
    }


def _round_number(x):
    """Return the largest of 1, 2, 5 times a power of ten not above ``x``."""
    power = 10.0 ** np.floor(np.log10(x))
    return max(step * power for step in (1, 2, 5) if step * power <= x * 1.0001)


def _prepare(axes, study, coverage):
    """Prepare the image's frame, grey-brown where the general camera has no ray."""
    width, height = study.settings["width_px"], study.settings["height_px"]
    frame = (-0.5, width - 0.5, height - 0.5, -0.5)
    if coverage is not None:
        axes.imshow(tinted(coverage), extent=frame)
    axes.set(xlim=frame[:2], ylim=frame[2:], aspect="equal", xlabel="u (px)")
    axes.grid(False)
    if axes.get_subplotspec().is_first_col():
        axes.set_ylabel("v (px)")


def _arrows(axes, field, scale):
    lost = ~np.isfinite(field[:, 2])
    axes.plot(*field[lost, :2].T, "x", color=LOST, markersize=2.5, mew=0.6)
    seen = field[~lost]
    seen = seen[:: int(np.ceil(len(seen) / ARROWS))]
    length = np.hypot(seen[:, 2], seen[:, 3])
    drawn = (
        seen[:, 2:] * np.minimum(1, scale["cut"] / np.maximum(length, 1e-12))[:, None]
    )
    colours = axes.quiver(
        *seen[:, :2].T,
        *drawn.T,
        length,
        norm=scale["norm"],
        cmap="cividis_r",
        angles="xy",
        scale_units="xy",
        scale=1 / scale["magnified"],
        width=0.004,
        headwidth=3.5,
        headlength=4,
        headaxislength=3.5,
    )
    axes.quiverkey(
        colours,
        0.84,
        1.05,
        scale["key"],
        f"{scale['key']:g} px",
        labelpos="E",
        labelsep=0.05,
        color=INK,
        fontproperties={"size": 9},
    )
    return colours


def _residual_legend(table):
    handles = [
        Line2D([], [], color=LOST, marker="x", linestyle="", label="corner without ray")
    ]
    if table:
        handles.append(Patch(color=NO_RAY, label="pixel without ray"))
    return handles


def _residual_data(rows):
    names = ("model", "image", "corner", "u_px", "v_px", "du_px", "dv_px")
    found = [
        (name, row.image.name, k, *at, *off)
        for row in rows
        for model, name in ALL_NAMES.items()
        if model in row.own
        for k, (at, off) in enumerate(
            zip(row.image.corners, row.own[model].residuals_px, strict=True)
        )
    ]
    return columns(names, found)


@figure(
    "ext_cross_validation",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=BOARDS,
)
def ext_cross_validation(results):
    """Draw the error of every model in every held-out image, in px and degrees."""
    study = Study(results["photograph_study"])
    rows = study.held_out
    kind = "same" if len(paired(rows, "rms_px")[0]) else "own"
    known = any(np.isfinite(column(rows, kind, m, "rms_px")).any() for m in MODELS)
    height = max(2.4, min(1.4 + 0.2 * len(rows), 11)) if known else EMPTY_IN
    drawn, axes = new_figure(1, 2, height_in=height, sharey=True)
    if not known:
        for place, model in zip(axes, MODELS, strict=True):
            place.set_title(NAMES[model])
            note(place, study.why_nothing_kept_out(model))
        caption = "Errors in held-out images: none."
        return Drawing(drawn, _error_data(rows), caption)
    for place, (quantity, label) in zip(axes, QUANTITIES, strict=True):
        _errors_of(place, rows, kind, quantity)
        place.set_xlabel(label)
    # An escaped dollar is literal; two bare ones would enclose a formula.
    names = [row.image.name.replace("$", r"\$") for row in rows]
    axes[0].yaxis.set_major_locator(FixedLocator(range(len(rows))))
    axes[0].yaxis.set_major_formatter(FixedFormatter(names))
    axes[0].tick_params(axis="y", labelsize=8 if len(rows) < 40 else 5)
    axes[0].set_ylim(len(rows) - 0.4, -0.6)
    handles, _ = axes[0].get_legend_handles_labels()
    drawn.legend(handles=handles, loc="outside lower center", ncols=3)
    return Drawing(drawn, _error_data(rows), _error_caption(rows, kind))


def _error_caption(rows, kind):
    where = {
        "same": "shared corners, with a ray of Zhang and of the general camera",
        "own": "all corners with a ray of the model",
    }
    caption = (
        f"Error in each held-out image, on {where[kind]}. Only the board's pose is "
        "fitted. Lines and bands: medians over images with their 95 % intervals."
    )
    errors = [column(rows, kind, model, "rms_px") for model in MODELS]
    blank = int(np.sum(~np.isfinite(errors).any(axis=0)))
    if blank:
        caption += f" No mark: too few such corners ({blank} of {len(rows)} images)."
    return caption


def _errors_of(axes, rows, kind, quantity):
    """Draw one panel: a mark per image and model, medians with intervals."""
    errors = {model: column(rows, kind, model, quantity) for model in ALL_NAMES}
    at = np.arange(len(rows))
    every = np.array(list(errors.values()))
    pair = every[: len(MODELS)]
    axes.hlines(at, pair.min(axis=0), pair.max(axis=0), color="#b8bec5", linewidth=1)
    for model, values in errors.items():
        good = np.isfinite(values)
        if not good.any():
            continue
        look = look_of(ALL_NAMES[model])
        line = look.pop("linestyle")
        axes.plot(values[good], at[good], linestyle="", label=ALL_NAMES[model], **look)
        middle = median_interval(values[good])
        axes.axvline(middle.value, color=look["color"], linestyle=line, linewidth=1.2)
        axes.axvspan(middle.low, middle.high, color=look["color"], alpha=0.13, lw=0)
    axes.set_xscale("log")
    good = every[np.isfinite(every)]
    axes.set_xlim(good.min() / 1.2, good.max() * 1.2)
    _plain_ticks(axes, *axes.get_xlim())


def _plain_ticks(axes, low, high):
    """Few ticks at round numbers of a logarithmic axis, written plainly."""
    decades = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)))
    for steps in ((1,), (1, 3), (1, 2, 5), (1, 1.5, 2, 3, 4, 5, 7)):
        ticks = np.ravel(np.outer(decades, steps))
        ticks = ticks[(ticks >= low) & (ticks <= high)]
        if len(ticks) >= 3:
            break
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:.6g}"))
    axes.xaxis.set_minor_locator(NullLocator())


def _error_data(rows):
    return {"image": [row.image.name for row in rows]} | {
        f"{model}.{kind}.{quantity}": column(rows, kind, model, quantity).tolist()
        for kind in ("own", "same")
        for model in ALL_NAMES
        for quantity in ("corners", "rms_px", "mean_deg")
    }
