"""Results of this page read: values of the prose, figures, tables."""

from collections import Counter

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.ticker import FixedFormatter, FixedLocator, LogLocator, NullFormatter

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
    counted,
    decided,
    paired,
    pooled_rms,
    share_with_ray,
)
from raxel.evaluation import MISSED_PX
from repro.page import WIDTH_IN, legend_below, literal, look_of, new_figure
from repro.run import (
    Drawing,
    Measured,
    Table,
    cell,
    columns,
    figure,
    in_columns,
    median_interval,
    table,
    wins,
)

STUDY = "photograph_study"
NEEDS = ("photograph_study",)

# Sentences of an image set's page, complete for every outcome of the study.


def about(study):
    """Return camera, image size, board, and the unit of lengths."""
    s = study.settings
    camera = literal(s["camera"])
    text = f"The camera: {camera}. " if camera else ""
    text += f"Its images are {s['width_px']} × {s['height_px']} px. "
    known = s["columns"] and s["rows"]
    size = f"{s['columns']} × {s['rows']}" if known else "an unknown number of"
    text += f"The chessboard has {size} interior corners"
    if s["pitch_mm"] is None:
        return f"{text}. Its pitch is unknown, so lengths are in units of the pitch."
    return text + f" at a pitch of {s['pitch_mm']:g} mm."


def found(study):
    """Return the number of detected boards, and why others were rejected."""
    count = len(study.images)
    text = (
        f"The detector {study.settings['detector']} finds the board in "
        f"{len(study.found)} of {_images(count)}."
    )
    reasons = _with_counts(i.reason for i in study.images if not i.found)
    if reasons:
        text += f" Reasons for the others: {reasons}."
    return text


def zhang(study):
    """Return the camera of Zhang's method, or why it is missing."""
    why = study.failure("zhang")
    if why:
        return f"Zhang's method gives no camera ({literal(why)})."
    names = ("fx_px", "fy_px", "u0_px", "v0_px", "k1", "k2", "rms_px")
    fx, fy, u0, v0, k1, k2, rms = (study.fit("zhang", name) for name in names)
    return (
        f"Zhang's method gives focal lengths of {fx:.1f} and {fy:.1f} px, the "
        f"principal point ({u0:.1f}, {v0:.1f}) px, and radial terms of {k1:.3f} and "
        f"{k2:.3f}. The residual of its fit is {rms:.3g} px RMS."
    )


def general(study):
    """Return the camera of the generic method, or why it is missing."""
    why = study.failure("general")
    if why:
        return f"The generic method gives no general camera ({literal(why)})."
    boards = len(study.in_sample)
    used = int(study.fit("general.boards"))
    text = (
        f"The generic method uses {used} of {boards} boards and gives a ray to "
        f"{study.fit('general.rays'):,.0f} pixels, "
        f"{100 * study.fit('general.share_with_ray'):.0f} % of the image."
    )
    if study.left_out:
        reasons = _with_counts(study.left_out.values())
        text += f" Reasons for excluded boards: {reasons}."
    return text


def peer(study):
    """Return the held-out error of OpenCV's fisheye model, or why it is missing."""
    name = "OpenCV's fisheye model"
    why = study.failure(PEER)
    if why:
        return f"{name} gives no camera ({literal(why)})."
    rows = study.held_out
    parts, failures = len(study.folds), len(study.fold_failures(PEER))
    text = f"{name} gives a camera in {parts - failures} of {parts} parts."
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


def held_out(study):
    """Return the number of held-out images and of parts, or why they are missing."""
    count = sum(bool(row.own) for row in study.held_out)
    if not count:
        whys = sorted({literal(study.why_nothing_held_out(m)) for m in NAMES})
        return f"No image is held out of a successful calibration ({'; '.join(whys)})."
    return (
        f"{_images(count).capitalize()} are judged by cameras calibrated without "
        f"them. The set has {len(study.folds)} parts, and each is held out once."
    )


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
    share = f" and for {100 * image:.0f} % of the image" if np.isfinite(image) else ""
    return f"{text}{share}."


def comparison(study):
    """Return which model predicts better, by the rule that the page states."""
    zhangs, generals = paired(study.held_out, "rms_px")
    if not len(zhangs):
        return "The models cannot be compared: no held-out image has shared corners."
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


def exercise(study):
    """Return which camera the exercises use."""
    if study.failure("zhang"):
        return "This set has no Zhang camera, so the exercises use an invented one."
    return "The exercises use the Zhang camera of this set."


def _images(count):
    return "1 image" if count == 1 else f"{count} images"


def _with_counts(reasons):
    return "; ".join(
        literal(reason) + (f" ({count} times)" if count > 1 else "")
        for reason, count in Counter(reasons).most_common()
    )


# Figures of an image set: contact sheet and undistorted views.


NO_RAY = "#e4d9d2"
ARROW = "#0072b2"
PATH = "#e69f00"
START = "#d55e00"


def tinted(mask):
    """Return RGBA (h, w, 4) that covers pixels without a ray (mask 255: ray)."""
    tint = np.ones((*mask.shape, 4))
    tint[..., :3] = to_rgb(NO_RAY)
    tint[..., 3] = 1 - mask / 255
    return tint


@figure("ext_corners", needs=NEEDS, evidence="photograph", per_set=BOARDS)
def ext_corners(results):
    """Draw every image with its corners; rejected ones pale, with the reason."""
    study = Study(results[STUDY])
    images = study.images
    across = min(max(int(np.ceil(np.sqrt(1.4 * len(images)))), 3), 10)
    rows = max(1, int(np.ceil(len(images) / across)))
    height = rows * (WIDTH_IN / across * _shape(study) + 0.17) + 0.4
    drawn, grid = new_figure(rows, across, height_in=height, squeeze=False)
    drawn.get_layout_engine().set(w_pad=0.03, h_pad=0.02, wspace=0, hspace=0)
    for axes in grid.ravel():
        axes.set_axis_off()
    size = 7.5 if across <= 5 else 5.5
    # A letter is about 0.6 of the font size wide, with 72 points per inch.
    characters = int(0.9 * WIDTH_IN / across * 72 / (0.6 * size))
    for axes, image in zip(grid.ravel(), images, strict=False):
        _draw_corners(axes, image, study.settings["width_px"], size, characters)
    legend_below(drawn, max(grid.ravel(), key=lambda axes: len(axes.lines)), ncols=3)
    return Drawing(
        drawn,
        _corner_data(study.found),
        "Images of the set with the detected corners, connected row by row: "
        f"{len(study.found)} of {len(images)} images.",
    )


def _draw_corners(axes, image, width_px, size, characters):
    look = {"cmap": "gray", "vmin": 0, "vmax": 255, "interpolation": "none"}
    axes.imshow(image.thumbnail, alpha=1.0 if image.found else 0.3, **look)
    use = "" if image.use == "calibrate" else " (evaluation)"
    font = {"fontsize": size, "fontweight": "normal", "parse_math": False}
    axes.set_title(image.name + use, pad=2, **font)
    if not image.found:
        note(axes, image.reason, characters, size)
        return
    lattice = (image.corners + 0.5) * image.thumbnail.shape[1] / width_px - 0.5
    lattice = lattice.reshape(-1, image.columns, 2)
    # A gap after each row separates its line from the next.
    rows = np.pad(lattice, ((0, 0), (0, 1), (0, 0)), constant_values=np.nan)
    line = {"color": PATH, "linewidth": 0.8, "markersize": 2}
    axes.plot(*rows.reshape(-1, 2).T, ".-", **line, label="row of corners")
    starts = {"color": START, "markersize": 2.4}
    axes.plot(*lattice[:, 0].T, "o", **starts, label="row starts")
    first = {"color": "white", "mec": START, "mew": 1.2, "markersize": 5}
    axes.plot(*lattice[0, 0], "s", **first, label="first corner")


def _corner_data(images):
    rows = [
        (image.name, k, *divmod(k, image.columns), *corner)
        for image in images
        for k, corner in enumerate(image.corners.tolist())
    ]
    return columns(("image", "corner", "row", "column", "u_px", "v_px"), rows)


@figure("ext_undistorted", needs=NEEDS, evidence="photograph", per_set=BOARDS)
def ext_undistorted(results):
    """Draw one image as taken, and undistorted by either model."""
    study = Study(results[STUDY])
    view = study.fit("undistorted.view")
    if not np.isfinite(view):
        drawn, axes = new_figure(height_in=EMPTY_IN)
        note(axes, study.failure("zhang"))
        return Drawing(drawn, {}, "Undistorted image: no camera.")
    drawn, axes = new_figure(1, 3, height_in=WIDTH_IN / 3 * _shape(study) + 0.75)
    image = study.image(int(view))
    original = study.array("undistorted.original", part="fit")
    corners = study.array("undistorted.corners", part="fit")
    scale = original.shape[1] / study.settings["width_px"]
    _show_image(axes[0], original)
    _frame_lines(axes[0], (corners + 0.5) * scale - 0.5, image.columns)
    axes[0].set_title("As taken" + _distortion(study, "taken"))
    rows = _numbered("as taken", corners)
    for place, model in zip(axes[1:], MODELS, strict=True):
        place.set_title(NAMES[model] + _distortion(study, model))
        view, mask, lattice = (
            study.array("undistorted", model, name, part="fit")
            for name in ("picture", "mask", "corners")
        )
        if view is None:
            _show_image(place, np.full_like(original, 255))
            reason = study.text("undistorted", model, "reason", part="fit")
            note(place, study.failure(model) or reason, 26)
            continue
        _show_image(place, view, mask)
        _frame_lines(place, lattice, image.columns)
        rows += _numbered(NAMES[model], lattice)
    towards = study.text("undistorted.towards", part="fit")
    centre = "mid-image" if towards == "mid-image" else "the middle of the board"
    zoom = study.fit("undistorted.zoom")
    return Drawing(
        drawn,
        columns(("panel", "corner", "x_px", "y_px"), rows),
        f"{literal(image.name)}, as taken and undistorted, in a view towards {centre} "
        f"at {100 * zoom:.0f} % of the original scale there. Straight edges of the "
        "scene must be straight. Lines: chords of the board's outline. Tinted: no ray, "
        "or outside the image.",
    )


def _shape(study):
    """Return the height of the images over their width."""
    return study.settings["height_px"] / study.settings["width_px"]


def _show_image(axes, image, mask=None):
    axes.set_axis_off()
    axes.imshow(image, cmap="gray", vmin=0, vmax=255, interpolation="none")
    if mask is not None:
        axes.imshow(tinted(mask), interpolation="none")


def _frame_lines(axes, corners, across):
    """Draw straight chords between the outermost corners of the board."""
    outer = corners[[0, across - 1, len(corners) - 1, len(corners) - across, 0]]
    height, width = axes.images[0].get_array().shape[:2]
    axes.plot(*outer.T, "-", color=START, linewidth=0.8)
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))


def _distortion(study, view):
    left = study.fit("undistorted", view, "distortion_px")
    return f": {left:.3g} px" if np.isfinite(left) else ""


def _numbered(panel, corners):
    """Return rows of a panel's corners for the figure's data."""
    return [(panel, k, *corner) for k, corner in enumerate(corners.tolist())]


# Figures of an image set: residual vectors and held-out errors.


MAX_ARROWS = 1500
ARROW_SHARE = 0.05  # drawn length of the 95th percentile, as a share of the image width
MAX_ARROW = 3.0  # times that; longer ones are truncated
LOST = "#8a7a70"
SCORED = {"own": "all corners", "same": "shared corners"}
QUANTITIES = (("rms_px", "RMS residual (px)"), ("mean_deg", "Mean angle (deg)"))


@figure("ext_residuals", needs=NEEDS, evidence="photograph", per_set=BOARDS)
def ext_residuals(results):
    """Draw residual vectors of held-out corners, both models on one scale."""
    study = Study(results[STUDY])
    rows = study.held_out
    fields = {model: _field(rows, model) for model in MODELS}
    lengths = np.concatenate([np.hypot(*f[:, 2:].T) for f in fields.values()])
    known = np.isfinite(lengths).any()
    long = max(np.nanpercentile(lengths, 95), 1e-6) if known else np.nan
    width, height = study.settings["width_px"], study.settings["height_px"]
    magnified = ARROW_SHARE * width / long
    frame = (-0.5, width - 0.5, height - 0.5, -0.5)
    height_in = WIDTH_IN / 2 * height / width + 1.2 if known else EMPTY_IN
    drawn, axes = new_figure(1, 2, height_in=height_in, sharey=True)
    coverage = study.array("general.coverage", part="fit")
    for place, model in zip(axes, MODELS, strict=True):
        if model == "general" and coverage is not None:
            place.imshow(tinted(coverage), extent=frame)
        place.set(xlim=frame[:2], ylim=frame[2:], aspect="equal", xlabel="u (px)")
        place.set_title(NAMES[model])
        place.grid(False)
        if np.isfinite(fields[model][:, 2]).any():
            _arrows(place, fields[model], long, magnified)
        else:
            note(place, study.why_nothing_held_out(model))
    axes[0].set_ylabel("v (px)")
    caption = (
        "Residual vectors of held-out corners, detected minus predicted. Arrows are "
        f"magnified {magnified:.2g} times, on the same scale for both models. "
        f"Residuals above {MAX_ARROW * long:.2g} px are truncated. Crosses: corners "
        "without a ray. Tinted: pixels without a ray."
    )
    if not known:
        caption = "Residual vectors: no held-out corner."
    return Drawing(drawn, _residual_data(rows), caption)


def _field(rows, model):
    """Return corners and residuals (N, 4) of one model over all images."""
    at = [
        np.column_stack([row.image.corners, row.own[model].residuals_px])
        for row in rows
        if model in row.own
    ]
    return np.concatenate(at) if at else np.empty((0, 4))


def _arrows(axes, field, long, magnified):
    """Draw residuals, those above MAX_ARROW times `long` truncated to it."""
    lost = ~np.isfinite(field[:, 2])
    axes.plot(*field[lost, :2].T, "x", color=LOST, markersize=2.5, mew=0.6)
    some = field[~lost]
    some = some[:: int(np.ceil(len(some) / MAX_ARROWS))]
    length = np.hypot(*some[:, 2:].T)
    truncated = np.minimum(1, MAX_ARROW * long / np.maximum(length, 1e-12))
    arrows = axes.quiver(
        *some[:, :2].T, *(some[:, 2:].T * truncated), color=ARROW, width=0.004,
        angles="xy", scale_units="xy", scale=1 / magnified,
    )  # fmt: skip
    key = float(f"{long:.1g}")
    axes.quiverkey(arrows, 0.84, 1.05, key, f"{key:g} px", labelpos="E", labelsep=0.05)


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


@figure("ext_cross_validation", needs=NEEDS, evidence="photograph", per_set=BOARDS)
def ext_cross_validation(results):
    """Draw the error of every model in every held-out image, in px and degrees."""
    study = Study(results[STUDY])
    rows = study.held_out
    kind = "same" if len(paired(rows, "rms_px")[0]) else "own"
    known = np.isfinite([column(rows, kind, m, "rms_px") for m in MODELS]).any()
    height = max(2.4, min(1.4 + 0.2 * len(rows), 11)) if known else EMPTY_IN
    drawn, axes = new_figure(1, 2, height_in=height, sharey=True)
    if not known:
        for place, model in zip(axes, MODELS, strict=True):
            place.set_title(NAMES[model])
            note(place, study.why_nothing_held_out(model))
        return Drawing(drawn, _error_data(rows), "Errors in held-out images: none.")
    for place, (quantity, label) in zip(axes, QUANTITIES, strict=True):
        _errors_of(place, rows, kind, quantity)
        place.set_xlabel(label)
    # An escaped dollar is literal; two bare ones would enclose a formula.
    names = [row.image.name.replace("$", r"\$") for row in rows]
    axes[0].yaxis.set_major_locator(FixedLocator(range(len(rows))))
    axes[0].yaxis.set_major_formatter(FixedFormatter(names))
    axes[0].tick_params(axis="y", labelsize=8 if len(rows) < 40 else 5)
    axes[0].set_ylim(len(rows) - 0.4, -0.6)
    legend_below(drawn, axes[0], ncols=3)
    return Drawing(
        drawn,
        _error_data(rows),
        f"Error in each held-out image, on {SCORED[kind]}. Only the board's pose is "
        "fitted. Lines and bands: medians over images with their 95 % intervals. No "
        "mark: too few such corners.",
    )


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
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())


def _error_data(rows):
    return {"image": [row.image.name for row in rows]} | {
        f"{model}.{kind}.{quantity}": column(rows, kind, model, quantity).tolist()
        for kind in ("own", "same")
        for model in ALL_NAMES
        for quantity in ("corners", "rms_px", "mean_deg")
    }


# Tables of an image set's page.


# Two focal lengths, principal point, and two or four radial terms.
CAMERA_PARAMETERS = {"zhang": 6, PEER: 8}


@table("ext_models", needs=NEEDS, evidence="photograph", per_set=BOARDS)
def ext_models(results):
    """Tabulate size, fitted and held-out errors, and coverage of every model."""
    study = Study(results[STUDY])
    rows = [("zhang", "own"), (PEER, "own")]
    rows += [(model, "same") for model in ("zhang", PEER, "general")]
    failures = [
        f"{name}: {literal(study.failure(model))}."
        for model, name in ALL_NAMES.items()
        if study.failure(model)
    ]
    caption = (
        "Errors and coverage of the models on the same images. Shared corners: "
        "corners with a ray of both Zhang and the general camera. Fitted: all images "
        "for calibration, poses fitted again. Held-out: medians over images with 95 % "
        "intervals."
    )
    return Table(
        in_columns(_model_row(study, *row) for row in rows),
        " ".join([caption, *failures]),
    )


def _model_row(study, model, kind):
    parameters = CAMERA_PARAMETERS.get(model, 2 * study.fit("general.rays"))
    errors, degrees, corners = (
        column(study.held_out, kind, model, quantity)
        for quantity in ("rms_px", "mean_deg", "corners")
    )
    all_corners = sum(row.corners for row in study.held_out)
    return {
        "Model": ALL_NAMES[model],
        "Scored on": SCORED[kind],
        "Parameters": None if study.failure(model) else _whole(parameters),
        "Fitted: RMS (px)": cell(pooled_rms(study.in_sample, kind, model)),
        "Held-out: RMS (px)": _median(errors),
        "Held-out: angle (deg)": _median(degrees),
        "Images": int(np.isfinite(errors).sum()),
        "Corners scored (%)": cell(100 * np.nansum(corners) / all_corners)
        if all_corners
        else None,
        "Image with a ray (%)": cell(100 * study.fit(model, "image_with_ray")),
    }


@table("ext_every_corner", needs=NEEDS, evidence="photograph", per_set=BOARDS)
def ext_every_corner(results):
    """Tabulate every model on every held-out corner, smallest error first."""
    study = Study(results[STUDY])
    rows = [
        (
            name,
            found["rms_px"],
            found["median_px"],
            100 * found["share"],
            found["parts"],
            _whole(study.fit(model, "terms")),
            _pupil(study, model),
        )
        for model, name in EVERY.items()
        if (found := counted(study, model)) is not None
    ]
    rows.sort(key=lambda row: row[1])
    names = (
        "Model", "Held-out: RMS (px)", "Median (px)", "Corners with a ray (%)",
        "Parts without a camera", "Terms", "Entrance pupil",
    )  # fmt: skip
    return Table(
        columns(names, rows),
        "Errors of all models on every corner of the held-out images. A corner "
        f"without a ray counts as {MISSED_PX:g} px. The parametric models "
        "(Kannala-Brandt, unified sphere) select their terms from the fitted images. "
        "The entrance-pupil shift is decided by a test and by held-out boards within "
        "these images, jointly for both models.",
    )


def _pupil(study, model):
    """Return the outcome of the test for an entrance-pupil shift."""
    names = ("moves", "p_value", "undecided")
    moves, p_value, undecided = (study.fit(model, "pupil", name) for name in names)
    if not np.isfinite(moves):
        return ""
    level = "p < 0.0001" if p_value < 1e-4 else f"p = {p_value:.2g}"
    outcome = "moves" if moves else "fixed"
    if undecided == 1:
        outcome = "undecided, taken as fixed"
    return f"{outcome} ({level})"


def _median(values):
    values = values[np.isfinite(values)]
    return Measured(*median_interval(values)[:3]) if len(values) else None


def _whole(number):
    return int(number) if np.isfinite(number) else None
