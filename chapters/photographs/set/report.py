"""Results of this page read: values of the prose, figures, tables."""

import textwrap
from collections import Counter

import numpy as np
from matplotlib.colors import LogNorm, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedFormatter, FixedLocator, FuncFormatter, NullLocator

from chapters.shared.images.notes import EMPTY_IN, note
from chapters.shared.images.reading import (
    ALL_NAMES,
    BOARDS,
    EVERY,
    MODELS,
    NAMES,
    PEER,
    Study,
    column,
    decided,
    paired,
    pooled_rms,
    share_with_ray,
)
from chapters.shared.images.reading import counted as counted_words
from raxel.evaluation.comparison import MISSED_PX
from repro.page import INK, WIDTH_IN, literal, look_of, new_figure
from repro.run import (
    Drawing,
    Measured,
    Table,
    cell,
    figure,
    in_columns,
    median_interval,
    table,
    wins,
)
from repro.run import columns as as_csv

# Sentences of an image set's page, complete for every outcome of the study.


def about(study):
    """Return camera, image size, board, and the unit of lengths."""
    s = study.settings
    camera = literal(s["camera"])
    text = f"The camera: {camera}. " if camera else ""
    text += f"Its images are {s['width_px']} × {s['height_px']} px. "
    counted = s["columns"] and s["rows"]
    size = f"{s['columns']} × {s['rows']}" if counted else "an unknown number of"
    text += f"The chessboard has {size} interior corners"
    if s["pitch_mm"] is None:
        return text + (". Its pitch is unknown, so lengths are in units of the pitch.")
    return text + f" at a pitch of {s['pitch_mm']:g} mm."


def found(study):
    """Return the number of detected boards, and why others were rejected."""
    count = len(study.images)
    text = (
        f"The detector {study.settings['detector']} finds the board in "
        f"{len(study.found)} of {_images(count)}."
    )
    reasons = Counter(i.reason for i in study.images if not i.found)
    if reasons:
        text += f" Reasons for the others: {_counted(reasons)}."
    evaluated = sum(image.use == "evaluate" for image in study.images)
    if evaluated:
        text += f" Used for evaluation only: {_images(evaluated)}."
    return text


def zhang(study):
    """Return the camera of Zhang's method, or why there is none."""
    why = study.refusal("zhang")
    if why:
        return f"Zhang's method gives no camera ({literal(why)})."
    n = {
        name: study.fit(f"zhang.{name}")
        for name in ("fx_px", "fy_px", "u0_px", "v0_px", "k1", "k2", "rms_px")
    }
    return (
        f"Zhang's method gives focal lengths of {n['fx_px']:.1f} and "
        f"{n['fy_px']:.1f} px, the principal point ({n['u0_px']:.1f}, "
        f"{n['v0_px']:.1f}) px, and radial terms of {n['k1']:.3f} and "
        f"{n['k2']:.3f}. The residual of its fit is {n['rms_px']:.3g} px RMS."
    )


def general(study):
    """Return the camera of the generic method, or why there is none."""
    why = study.refusal("general")
    if why:
        return f"The generic method gives no general camera ({literal(why)})."
    boards = len(study.in_sample)
    used = int(study.fit("general.boards"))
    text = (
        f"The generic method uses {used} of {boards} boards and gives a ray to "
        f"{study.fit('general.rays'):,.0f} pixels, "
        f"{100 * study.fit('general.share_with_ray'):.0f} % of the image."
    )
    reasons = Counter(study.left_out.values())
    if reasons:
        text += f" Reasons for excluded boards: {_counted(reasons)}."
    return text


def peer(study):
    """Return the held-out error of OpenCV's fisheye model, or why there is none."""
    name = "OpenCV's fisheye model"
    why = study.refusal(PEER)
    if why:
        return f"{name} gives no camera ({literal(why)})."
    if not np.isfinite(study.fit(f"{PEER}.image_with_ray")):
        return f"{name} was not fitted."
    rows = study.held_out
    parts, refused = len(study.folds), len(study.fold_refusals(PEER))
    text = f"{name} gives a camera in {parts - refused} of {parts} parts."
    errors = [column(rows, "same", model, "rms_px") for model in (PEER, *NAMES)]
    known = np.isfinite(errors).all(axis=0)
    if not known.any():
        return text
    names = ("this model", "Zhang's model", "the general camera")
    medians = [
        f"{np.median(error[known]):.2g} px with {model}"
        for error, model in zip(errors, names, strict=True)
    ]
    return f"{text} The median held-out error is {', '.join(medians)}."


def kept_out(study):
    """Return the number of held-out images and of parts, with failures."""
    rows = [row for row in study.held_out if row.own]
    if not rows:
        whys = {literal(study.why_nothing_kept_out(m)) for m in NAMES}
        return (
            "No image is held out of a successful calibration "
            f"({'; '.join(sorted(whys))})."
        )
    count, parts = len(rows), len(study.folds)
    text = (
        f"{_images(count).capitalize()} are judged by cameras calibrated without "
        f"them. The set has {parts} parts, and each is held out once."
    )
    for model, name in (("zhang", "Zhang's"), ("general", "the generic")):
        reasons = Counter(study.fold_refusals(model))
        if reasons:
            text += (
                f" With {reasons.total()} of the parts held out, {name} method gives "
                f"no camera: {_counted(reasons)}."
            )
    return text


def coverage(study):
    """Return the share of held-out corners with a ray, by model."""
    rows = study.held_out
    if not any(row.own for row in rows):
        return "Neither model has a ray for a held-out corner."
    shares = {m: 100 * share_with_ray(rows, m) for m in NAMES}
    text = (
        f"Zhang's camera has rays for {shares['zhang']:.0f} % of the held-out "
        f"corners, the general camera for {shares['general']:.0f} %"
    )
    image = study.fit("general.share_with_ray")
    if image == image:
        text += f" and for {100 * image:.0f} % of the image"
    return f"{text}."


def comparison(study):
    """Return which model predicts better, by the rule that the page states."""
    zhangs, generals = paired(study.held_out, "rms_px")
    if not len(zhangs):
        return (
            "The two models cannot be compared: no held-out image has corners with "
            "a ray of both."
        )
    for_general = wins([(generals, zhangs)])[0]
    for_zhang = wins([(zhangs, generals)])[0]
    ratio = for_general.ratio
    better = int(np.sum(generals < zhangs))
    text = (
        f"The general camera has the smaller error in {better} of "
        f"{_images(len(zhangs))}. The ratio of the median errors, Zhang "
        f"over general camera, is {ratio.value:.3g} ({ratio.low:.3g} to "
        f"{ratio.high:.3g}). "
    )
    if decided(for_general):
        return text + "**The general camera predicts these corners better.**"
    if decided(for_zhang):
        return text + "**Zhang's model predicts these corners better.**"
    return text + "**These images do not decide between the two.**"


def angles(study):
    """Return the median angular errors over held-out images."""
    pairs = dict(zip(NAMES, paired(study.held_out, "mean_deg"), strict=True))
    if len(pairs["zhang"]):
        where = "on shared corners"
    else:
        where = "on all corners with a ray"
        rows = study.held_out
        pairs = {m: column(rows, "own", m, "mean_deg") for m in NAMES}
    parts = []
    for model, values in pairs.items():
        values = values[np.isfinite(values)]
        if len(values):
            e = median_interval(values)
            parts.append(
                f"{NAMES[model]} {e.value:.2g}° ({e.low:.2g}° to {e.high:.2g}°)"
            )
    if not parts:
        return "There is no angular error to report."
    return (
        f"Median angles at the rays over held-out images, {where}: {', '.join(parts)}."
    )


def straightness(study):
    """Return the remaining distortion of the board in the corrected view."""
    names = {
        "taken": "as taken",
        "zhang": "through Zhang's model",
        "general": "through the general camera",
    }
    left = {
        name: study.fit(f"undistorted.{key}.distortion_px")
        for key, name in names.items()
    }
    parts = [f"{name} {value:.3g} px" for name, value in left.items() if value == value]
    if len(parts) < 2:
        return "There is no undistorted board to measure."
    if study.refusal("general"):
        shared = "its corners"
    else:
        shared = "its corners that have a ray"
    return (
        "Deviation of the board from a perspective image of a flat lattice, RMS over "
        f"{shared} after the best homography: {', '.join(parts)}."
    )


def exercise(study):
    """Return which camera the exercises use."""
    if study.refusal("zhang"):
        return "This set has no Zhang camera, so the exercises use an invented one."
    return "The exercises use the Zhang camera of this set."


def _images(count):
    return "1 image" if count == 1 else f"{count} images"


def _counted(reasons):
    return "; ".join(
        literal(reason) + (f" ({count} times)" if count > 1 else "")
        for reason, count in reasons.most_common()
    )


# Figures of an image set: contact sheet and undistorted views.


NO_RAY = "#e4d9d2"
PATH = "#e69f00"
START = "#d55e00"


def tinted(mask):
    """Return RGBA (h, w, 4) that covers pixels without a ray (mask 255: ray)."""
    tint = np.ones((*mask.shape, 4))
    tint[..., :3] = to_rgb(NO_RAY)
    tint[..., 3] = 1 - mask / 255
    return tint


@figure(
    "ext_corners", needs=("photograph_study",), evidence="photograph", per_set=BOARDS
)
def ext_corners(results):
    """Draw every image with its corners; rejected ones pale, with the reason."""
    study = Study(results["photograph_study"])
    images = study.images
    across = min(max(int(np.ceil(np.sqrt(1.4 * len(images)))), 3), 10)
    rows = max(1, int(np.ceil(len(images) / across)))
    shape = study.settings["height_px"] / study.settings["width_px"]
    height = rows * (WIDTH_IN / across * shape + 0.17) + 0.4
    drawn, grid = new_figure(rows, across, height_in=height, squeeze=False)
    drawn.get_layout_engine().set(w_pad=0.03, h_pad=0.02, wspace=0, hspace=0)
    for axes in grid.ravel():
        axes.set_axis_off()
    size = 7.5 if across <= 5 else 5.5
    # A letter is about 0.6 of the font size wide, with 72 points per inch.
    characters = int(0.9 * WIDTH_IN / across * 72 / (0.6 * size))
    for axes, image in zip(grid.ravel(), images, strict=False):
        _one_photograph(axes, image, study.settings["width_px"], size, characters)
    drawn.legend(handles=_corner_legend(study), loc="outside lower center", ncols=4)
    return Drawing(
        drawn,
        _corner_data(study.found),
        "Images of the set with the detected corners, connected row by row: "
        f"{len(study.found)} of {len(images)} images.",
    )


def _one_photograph(axes, image, width_px, size, characters):
    height, width = image.thumbnail.shape
    axes.imshow(
        image.thumbnail,
        cmap="gray",
        vmin=0,
        vmax=255,
        alpha=1.0 if image.found else 0.3,
        interpolation="none",
    )
    use = "" if image.use == "calibrate" else " (evaluation)"
    axes.set_title(
        image.name + use, fontsize=size, fontweight="normal", pad=2, parse_math=False
    )
    if not image.found:
        axes.text(
            width / 2,
            height / 2,
            textwrap.fill(image.reason, characters),
            ha="center",
            va="center",
            fontsize=size,
            parse_math=False,
            bbox={"facecolor": "white", "alpha": 0.7, "edgecolor": "none"},
        )
        return
    scale = width / width_px
    lattice = (image.corners + 0.5) * scale - 0.5
    lattice = lattice.reshape(-1, image.columns, 2)
    # A gap after each row separates its line from the next.
    rows = np.pad(lattice, ((0, 0), (0, 1), (0, 0)), constant_values=np.nan).reshape(
        -1, 2
    )
    axes.plot(*rows.T, ".-", color=PATH, linewidth=0.8, markersize=2)
    axes.plot(*lattice[:, 0].T, "o", color=START, markersize=2.4)
    axes.plot(*lattice[0, 0], "s", color="white", mec=START, mew=1.2, markersize=5)


def _corner_legend(study):
    handles = [
        Line2D([], [], color=PATH, marker=".", linewidth=1, label="row of corners"),
        Line2D([], [], color=START, marker="o", linestyle="", label="row starts"),
        Line2D(
            [], [], color="white", mec=START, marker="s", linestyle="",
            label="first corner",
        ),
    ]  # fmt: skip
    if len(study.found) < len(study.images):
        handles.append(Patch(color="#d9d9d9", label="pale: no board detected"))
    return handles


def _corner_data(images):
    rows = [
        (image.name, k, *divmod(k, image.columns), *corner)
        for image in images
        for k, corner in enumerate(image.corners.tolist())
    ]
    return as_csv(("image", "corner", "row", "column", "u_px", "v_px"), rows)


@figure(
    "ext_undistorted",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=BOARDS,
)
def ext_undistorted(results):
    """Draw one image as taken, and undistorted by either model."""
    study = Study(results["photograph_study"])
    view = study.number("undistorted.view", part="fit")
    if not np.isfinite(view):
        drawn, axes = new_figure(height_in=EMPTY_IN)
        note(axes, study.refusal("zhang"))
        return Drawing(drawn, {}, "Undistorted image: no camera.")
    shape = study.settings["height_px"] / study.settings["width_px"]
    drawn, axes = new_figure(1, 3, height_in=WIDTH_IN / 3 * shape + 0.75)
    image = study.image(int(view))
    original = study.array("undistorted.original", part="fit")
    corners = study.array("undistorted.corners", part="fit")
    scale = original.shape[1] / study.settings["width_px"]
    _picture(axes[0], original, None)
    _frame_lines(axes[0], (corners + 0.5) * scale - 0.5, image.columns)
    axes[0].set_title("As taken")
    rows = _numbered("as taken", corners)
    for place, model in zip(axes[1:], MODELS, strict=True):
        place.set_title(NAMES[model])
        picture = study.array(f"undistorted.{model}.picture", part="fit")
        if picture is None:
            _picture(place, np.full_like(original, 255), None)
            reason = study.text(f"undistorted.{model}.reason", part="fit")
            note(place, study.refusal(model) or reason, 26)
            continue
        _picture(place, picture, study.array(f"undistorted.{model}.mask", part="fit"))
        seen = study.array(f"undistorted.{model}.corners", part="fit")
        _frame_lines(place, seen, image.columns)
        rows += _numbered(NAMES[model], seen)
    drawn.legend(
        handles=[
            Patch(color=NO_RAY, label="no ray, or outside the image"),
            Line2D(
                [], [], color=START, linewidth=1, label="chords of the board's outline"
            ),
        ],
        loc="outside lower center",
        ncols=2,
    )
    towards = study.text("undistorted.towards", part="fit")
    centre = "mid-image" if towards == "mid-image" else "the middle of the board"
    zoom = study.number("undistorted.zoom", part="fit")
    return Drawing(
        drawn,
        as_csv(("panel", "corner", "x_px", "y_px"), rows),
        f"{literal(image.name)}, as taken and undistorted, in a view towards {centre} "
        f"at {100 * zoom:.0f} % of the original scale there. Straight edges of the "
        "scene must be straight.",
    )


def _picture(axes, picture, mask):
    axes.set_axis_off()
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="none")
    if mask is not None:
        axes.imshow(tinted(mask), interpolation="none")


def _frame_lines(axes, corners, columns):
    """Draw straight chords between the outermost corners of the board."""
    outer = corners[[0, columns - 1, len(corners) - 1, len(corners) - columns, 0]]
    height, width = axes.images[0].get_array().shape[:2]
    axes.plot(*outer.T, "-", color=START, linewidth=0.8)
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))


def _numbered(panel, corners):
    """Return rows of a panel's corners for the figure's data."""
    return [(panel, k, *corner) for k, corner in enumerate(corners.tolist())]


# Figures of an image set: residual vectors and held-out errors.


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
    return as_csv(names, found)


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


# Tables of an image set's page.


SHARED = "shared corners"
# Two focal lengths, principal point, and two or four radial terms.
CAMERA_PARAMETERS = {"zhang": 6, PEER: 8}

EVERY_CORNER = (
    "Model",
    "Held-out: RMS (px)",
    "Median (px)",
    "Corners with a ray (%)",
    "Parts without a camera",
    "Terms",
    "Entrance pupil",
)


@table("ext_models", needs=("photograph_study",), evidence="photograph", per_set=BOARDS)
def ext_models(results):
    """Tabulate size, fitted and held-out errors, and coverage of every model."""
    study = Study(results["photograph_study"])
    rows = [
        ("zhang", "own", "all corners"),
        (PEER, "own", "all corners"),
        ("zhang", "same", SHARED),
        (PEER, "same", SHARED),
        ("general", "same", SHARED),
    ]
    refused = [
        f"{name}: {literal(study.refusal(model))}."
        for model, name in ALL_NAMES.items()
        if study.refusal(model)
    ]
    caption = (
        "Errors and coverage of the models on the same images. Shared corners: "
        "corners with a ray of both Zhang and the general camera. Fitted: all images "
        "for calibration, poses fitted again. Held-out: medians over images with 95 % "
        "intervals."
    )
    return Table(
        in_columns(_model_row(study, *row) for row in rows),
        " ".join([caption, *refused]),
    )


def _model_row(study, model, kind, scored_on):
    parameters = CAMERA_PARAMETERS.get(model, 2 * study.fit("general.rays"))
    errors, degrees, corners = (
        column(study.held_out, kind, model, quantity)
        for quantity in ("rms_px", "mean_deg", "corners")
    )
    all_corners = sum(row.corners for row in study.held_out)
    return {
        "Model": ALL_NAMES[model],
        "Scored on": scored_on,
        "Parameters": None if study.refusal(model) else _whole(parameters),
        "Fitted: RMS (px)": cell(pooled_rms(study.in_sample, kind, model)),
        "Held-out: RMS (px)": _median(errors),
        "Held-out: angle (deg)": _median(degrees),
        "Images": int(np.isfinite(errors).sum()),
        "Corners scored (%)": cell(100 * np.nansum(corners) / all_corners)
        if all_corners
        else None,
        "Image with a ray (%)": cell(100 * study.fit(f"{model}.image_with_ray")),
    }


@table(
    "ext_every_corner",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=BOARDS,
)
def ext_every_corner(results):
    """Tabulate every model on every held-out corner, smallest error first."""
    study = Study(results["photograph_study"])
    rows = [
        (
            name,
            found["rms_px"],
            found["median_px"],
            100 * found["share"],
            found["parts"],
            _whole(study.fit(f"{model}.terms")),
            _pupil(study, model),
        )
        for model, name in EVERY.items()
        if (found := counted_words(study, model)) is not None
    ]
    rows.sort(key=lambda row: row[1])
    return Table(
        as_csv(EVERY_CORNER, rows),
        "Errors of all models on every corner of the held-out images. A corner "
        f"without a ray counts as {MISSED_PX:g} px. The parametric models "
        "(Kannala-Brandt, unified sphere) select their terms from the fitted images. "
        "The entrance-pupil shift is decided by a test and by held-out boards within "
        "these images, jointly for both models.",
    )


def _pupil(study, model):
    """Return the outcome of the test for an entrance-pupil shift."""
    moves = study.fit(f"{model}.pupil.moves")
    if not np.isfinite(moves):
        return ""
    p_value = study.fit(f"{model}.pupil.p_value")
    level = "p < 0.0001" if p_value < 1e-4 else f"p = {p_value:.2g}"
    outcome = "moves" if moves else "fixed"
    if study.fit(f"{model}.pupil.undecided") == 1:
        outcome = "undecided, taken as fixed"
    return f"{outcome} ({level})"


def _median(values):
    values = values[np.isfinite(values)]
    return Measured(*median_interval(values)[:3]) if len(values) else None


def _whole(number):
    return int(number) if np.isfinite(number) else None
