"""Results of this page read: values of the prose, figures, tables."""

import numpy as np
from matplotlib.ticker import FixedFormatter, FixedLocator

from chapters.ch03_planar_grids.s3_2_conditions.experiment import (
    LIGHT_LEVELS,
    level_name,
)
from chapters.shared.grids import CELECT, CLICKLESS, LINEAR, OPENCV, OPENCV_SB, WHOLE
from repro.page import (
    legend_below,
    look_of,
    new_figure,
    plot_interval,
    rounded,
    series,
    value,
)
from repro.run import (
    Check,
    Drawing,
    Value,
    columns,
    figure,
    numbers,
    paired_gain,
    proportion,
)

# Results of the conditions of section 3.3.2, and the numbers that are quoted.


CAMERAS = ("hyperboloidal", "fisheye")
WAYS = ("clockwise", "reverse")
METHODS = {
    CELECT: "CELECT",
    LINEAR: "CELECT, tone curve undone",
    OPENCV: "findChessboardCorners",
    OPENCV_SB: "findChessboardCornersSB",
    CLICKLESS: "without clicks (ours)",
}
SPOTTED, CLEAN = ("600 spots", "no spots")
# Information below which a slope is unbounded.
SEPARATED = 1e-6


def numbers_of(result, name, poses=WHOLE):
    """Return a number of every image of one range of poses, (n,)."""
    return result.select(poses=poses).column(name)


def levels_run(result):
    """Return the light levels of the contrast study as run, brightest first."""
    return [v for v in LIGHT_LEVELS if v in result.conditions[0]["levels"]]


def in_light(result, level, method, poses=WHOLE, spots=SPOTTED):
    """Return the successes (n,) of a method in one light."""
    clean = "" if spots == SPOTTED else "spotless."
    return numbers_of(result, f"{level_name(level)}.{clean}{method}", poses)


def shadow_effects(result, method, poses=WHOLE):
    """Return success without minus with the shadow, as an Estimate."""
    return paired_gain(
        numbers_of(result, f"plain.{method}", poses),
        numbers_of(result, f"shadow.{method}", poses),
    )


def all_orders(result, tone="", poses=WHOLE):
    """Return success (2, 4, n): direction, first corner by rising square, image.

    tone: 'linear_' for the images with their tone curve undone.
    """
    return np.array(
        [
            [numbers_of(result, f"{tone}{way}_{rank}", poses) for rank in range(4)]
            for way in WAYS
        ]
    )


def differing(orders):
    """Return for each image (n,) 1 where the eight orders do not all end alike."""
    flat = orders.reshape(-1, orders.shape[-1])
    return (flat.min(axis=0) != flat.max(axis=0)).astype(float)


def merging_of(results, tone="", poses=WHOLE):
    """Return size ratio, merge failure and success, each (n,), of the fisheye images.

    tone: 'linear.' for the images with their tone curve undone.
    """
    both = [results[e] for e in ("exp_c3_shadow", "exp_c3_merge_images")]
    return [
        np.concatenate([numbers_of(r, tone + name, poses) for r in both])
        for name in ("size_ratio", "merge_failed", "success")
    ]


def logistic_slope(x, y):
    """Return the slope of log odds of y (n,) bool over x (n,), and its standard error.

    Maximum likelihood by Newton's method; (nan, nan) where all y are alike or x
    separates them, so that the slope is unbounded.
    """
    y = np.asarray(y, float)
    if y.min() == y.max():
        return np.nan, np.nan
    scale = x.std()
    design = np.column_stack([np.ones(len(x)), (x - x.mean()) / scale])
    weights = np.zeros(2)
    for _ in range(50):
        p = 1 / (1 + np.exp(-design @ weights))
        information = design.T @ (design * (p * (1 - p))[:, None])
        if np.linalg.eigvalsh(information)[0] < SEPARATED:
            return np.nan, np.nan
        step = np.linalg.solve(information, design.T @ (y - p))
        weights += step
        if np.abs(step).max() < 1e-10:
            break
    error = np.sqrt(np.linalg.inv(information)[1, 1])
    return float(weights[1] / scale), float(error / scale)


def logistic_curve(x, y, at):
    """Return the probability (m,) at `at` (m,) by the logistic fit of y over x (n,).

    It is the mean of y where there is no such fit.
    """
    slope, _ = logistic_slope(x, y)
    y = np.asarray(y, float)
    if not np.isfinite(slope):
        return np.full(len(at), y.mean())
    offset = _offset(slope, x, y)
    return 1 / (1 + np.exp(-(offset + slope * at)))


def _offset(slope, x, y):
    """Return the constant of the fit of a known slope, matching the mean of y."""
    from scipy.optimize import brentq

    def excess(offset):
        return (1 / (1 + np.exp(-(offset + slope * x)))).mean() - y.mean()

    far = 50 + np.abs(slope * x).max()
    return brentq(excess, -far, far)


@numbers("fig_3_14", needs=("fig_3_14_parts",), evidence="rendered")
def numbers_fig_3_14(results):
    """Return sizes of the parts in the plotted image; the others in words."""
    result = results["fig_3_14_parts"]
    found = {}
    for short, camera in (("hype", "hyperboloidal"), ("fish", "fisheye")):
        for name_of, method in (("celect", CELECT), ("opencv", OPENCV)):
            counts = result.column(f"{method}.count", camera=camera)
            others = ", ".join(f"{n:.0f}" for n in counts)
            for axis, name in (("columns", "cols"), ("rows", "rows")):
                sizes = np.nan_to_num(result.column(f"{method}.{axis}", camera=camera))
                found[f"fig3_14_{short}_{name_of}_{name}"] = Value(
                    float(sizes[0]),
                    interval=(float(sizes.min()), float(sizes.max())),
                    unit="corners",
                    reason="in the picture drawn; the range is over "
                    f"{len(counts)} pictures, whose parts have {others} "
                    "corners",
                )
    return found


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    shadow = open_results("exp_c3_shadow")
    more = open_results("exp_c3_merge_images")
    both = {"exp_c3_shadow": shadow, "exp_c3_merge_images": more}
    orders = all_orders(open_results("exp_c3_trace_direction"))
    quoted = {
        **of_parts(open_results("fig_3_14_parts")),
        "shadow.whole.opencv": in_points(shadow_effects(shadow, OPENCV)),
        "orders.differ": of_hundred(proportion(differing(orders))),
        **of_merging(both),
    }
    for name, number in quoted.items():
        value(name, number)


def of_merging(results):
    """Return the merge failures (%) of the thirds with most even and uneven squares."""
    ratio, failed, _ = merging_of(results)
    thirds = np.array_split(failed[np.argsort(ratio)], min(3, len(ratio)))
    return {
        "merge.even": 100 * thirds[0].mean(),
        "merge.uneven": 100 * thirds[-1].mean(),
    }


def in_points(found):
    """Return an Estimate of a share in percentage points, with its interval."""
    points, low, high = (f"{100 * share:.1f}" for share in found[:3])
    return f"{points} ({low} to {high})"


def of_hundred(found):
    """Return an Estimate of a share in percent, with its interval, as text."""
    return rounded(100 * found.value, (100 * found.low, 100 * found.high))


def of_parts(result):
    """Return the median ratio of CELECT's corners to OpenCV's, by camera."""

    def ratio(camera):
        ours, theirs = (
            result.column(f"{method}.count", camera=camera)
            for method in (CELECT, OPENCV)
        )
        return float(np.median(ours / np.maximum(theirs, 1)))

    return {f"part.{camera}": ratio(camera) for camera in CAMERAS}


# Fig. 3.14, and the conditions of section 3.3.2.


MARGIN_PX = 30
RED, YELLOW, GREEN = "#e6201f", "#ffd60a", "#1fb25a"
BINS = 6
OFFSET = 1.06


@figure("fig_3_14", needs=("fig_3_14_parts",), evidence="rendered")
def fig_3_14(results):
    """Draw the parts that CELECT and OpenCV extract from one image per camera."""
    result = results["fig_3_14_parts"]
    drawn, panels = new_figure(2, 2, height_in=6.6)
    rows, inside = [], []
    for of_camera, camera in zip(panels, CAMERAS, strict=True):
        for panel, method in zip(of_camera, (CELECT, OPENCV), strict=True):
            found = result.arrays(f"{method}.corners", camera=camera)
            picture = result.arrays("picture", camera=camera)[0]
            lattice = result.arrays("lattice", camera=camera)[0]
            here = result.column(f"{method}.count", camera=camera)[0] > 0
            corners = found[0] if here else None
            _draw_part(panel, picture, lattice, corners)
            if here and method == OPENCV:
                _draw_paint(panel, result, camera)
            size = "none"
            if here:
                long, short = sorted(corners.shape[:2], reverse=True)
                size = f"{long} × {short}"
                inside.append(_shares_corners(corners, lattice))
                rows += [
                    (camera, METHODS[method], index, *corner)
                    for index, corner in enumerate(corners.reshape(-1, 2))
                ]
            letter = "ab"[CAMERAS.index(camera)]
            name = METHODS[method] if method == CELECT else "OpenCV"
            panel.set_title(f"({letter}) {camera}, {name}: {size}")
    return Drawing(
        drawn,
        columns(("panel", "method", "corner", "u_px", "v_px"), rows),
        "Extracted parts of large grids without a border. Left: the largest part "
        "that CELECT extracts from the unmodified image. Right: the largest part "
        "that OpenCV's findChessboardCorners returns when everything around it is "
        "painted white. Red: corners. Yellow and green: their order.",
        check=Check(
            bool(inside) and all(inside), "every drawn corner is a corner of the grid"
        ),
    )


def _draw_part(panel, picture, lattice, corners):
    low = lattice.reshape(-1, 2).min(axis=0) - MARGIN_PX
    high = lattice.reshape(-1, 2).max(axis=0) + MARGIN_PX
    panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
    if corners is not None:
        panel.plot(*corners.transpose(2, 1, 0), "-", color=GREEN, lw=0.7, marker="")
        panel.plot(*corners.transpose(2, 0, 1), "-", color=YELLOW, lw=0.7, marker="")
        panel.plot(*corners.reshape(-1, 2).T, "o", color=RED, ms=1.8, linestyle="")
    panel.set(
        xlim=(max(low[0], -0.5), min(high[0], picture.shape[1] - 0.5)),
        ylim=(min(high[1], picture.shape[0] - 0.5), max(low[1], -0.5)),
        xlabel="u (px)",
        ylabel="v (px)",
    )
    panel.grid(visible=False)


def _draw_paint(panel, result, camera):
    """Draw the painted image over the original."""
    bordered = result.arrays(f"{OPENCV}.painted", camera=camera)[0]
    u, v = result.arrays(f"{OPENCV}.first", camera=camera)[0]
    height, width = bordered.shape
    extent = (u - 0.5, u + width - 0.5, v + height - 0.5, v - 0.5)
    limits = {"xlim": panel.get_xlim(), "ylim": panel.get_ylim()}
    panel.set_facecolor("white")
    panel.images[0].set_visible(False)
    panel.imshow(bordered, cmap="gray", vmin=0, vmax=255, extent=extent)
    panel.set(**limits)


def _shares_corners(corners, lattice):
    apart = np.abs(corners[:, :, None, None] - lattice).sum(axis=-1)
    return bool((apart.min(axis=(2, 3)) == 0).all())


@figure(
    "ext_conditions",
    needs=(
        "exp_c3_low_contrast",
        "exp_c3_shadow",
        "exp_c3_trace_direction",
        "exp_c3_merge_images",
    ),
    evidence="rendered",
)
def ext_conditions(results):
    """Draw success by light, shadow, click order and size variation."""
    drawn, panels = new_figure(2, 2, height_in=6.6)
    rows = []
    _draw_light(panels[0, 0], results["exp_c3_low_contrast"], rows)
    _draw_shadow(panels[0, 1], results["exp_c3_shadow"], rows)
    _draw_orders(panels[1, 0], results["exp_c3_trace_direction"], rows)
    _draw_merging(panels[1, 1], results, rows)
    legend_below(drawn, panels[0, 0], ncols=2)
    return Drawing(
        drawn,
        columns(("panel", "series", "x", "y", "low", "high"), rows),
        "Share of boards returned complete and in order, with 95 % intervals, whole "
        "range of poses. (a) Mirror ball, by light on the board. (b) Fisheye, "
        "without and with a soft shadow that takes 30 % of the light. (c) CELECT, "
        "with the first click on each outer corner, by size of its square, in both "
        "directions. (d) Share of fisheye images with a merge failure of CELECT, by "
        "the largest ratio of steps along one contour, in groups of equal size, "
        "with a logistic fit.",
    )


def _draw(panel, letter, x, trials, look, label, rows):
    """Draw shares of trials with their intervals, and add their data to rows."""
    shares = np.array([proportion(t)[:3] for t in trials])
    at = np.asarray(x, float)
    plot_interval(panel, at, *100 * shares.T, look=look, label=label, bars=True)
    rows += [(letter, label, x, *share) for x, share in zip(x, shares, strict=True)]


def _name_ticks(panel, places, names):
    panel.xaxis.set_major_locator(FixedLocator(places))
    panel.xaxis.set_major_formatter(FixedFormatter(names))


def _draw_light(panel, result, rows):
    levels = levels_run(result)
    for index, (method, label) in enumerate(METHODS.items()):
        trials = [in_light(result, v, method) for v in levels]
        # Offset from each other, so that every interval is visible.
        x = np.array(levels) * OFFSET ** (index - 2)
        _draw(panel, "a", x, trials, look_of(label), label, rows)
    grey = [
        np.median(numbers_of(result, f"{level_name(v)}.contrast_grey")) for v in levels
    ]
    for level, contrast in zip(levels, grey, strict=True):
        panel.annotate(f"{contrast:.0f}", (level, 104), ha="center", fontsize=7.5)
    panel.set_xscale("log")
    panel.set_xticks(levels, [f"{v:g}" for v in levels], rotation=45)
    panel.minorticks_off()
    panel.set(
        ylim=(-3, 112),
        title="(a) light (above: contrast, grey levels)",
        xlabel="Light on the board (share of full light)",
        ylabel="Success (%)",
    )


def _draw_shadow(panel, result, rows):
    for index, (method, label) in enumerate(METHODS.items()):
        trials = [
            numbers_of(result, f"{name}.{method}") for name in ("plain", "shadow")
        ]
        x = np.array([0, 1]) + 0.06 * (index - 2)
        _draw(panel, "b", x, trials, look_of(label), label, rows)
    _name_ticks(panel, [0, 1], ["no shadow", "shadow"])
    panel.set(
        xlim=(-0.4, 1.4), ylim=(-3, 103), title="(b) soft shadow", ylabel="Success (%)"
    )


def _draw_orders(panel, result, rows):
    orders = all_orders(result)
    for index, way in enumerate(WAYS):
        x = np.arange(1, 5) + 0.08 * (index - 0.5)
        label = "clockwise" if way == "clockwise" else "anticlockwise"
        _draw(panel, "c", x, orders[index], series(index + 5), label, rows)
    squares = ["smallest\nsquare", "second", "third", "largest\nsquare"]
    _name_ticks(panel, [1, 2, 3, 4], squares)
    panel.set(ylim=(0, 103), title="(c) first corner clicked", ylabel="Success (%)")
    panel.legend(loc="upper right")


def _draw_merging(panel, results, rows):
    ratio, failed, _ = merging_of(results)
    groups = np.array_split(np.argsort(ratio), min(BINS, len(ratio)))
    x = [float(np.median(ratio[g])) for g in groups]
    _draw(panel, "d", x, [failed[g] for g in groups], series(0), "merge failure", rows)
    along = np.linspace(ratio.min(), ratio.max(), 60)
    curve = logistic_curve(ratio, failed, along)
    look = series(1) | {"marker": ""}
    panel.plot(along, 100 * curve, label="logistic fit", **look)
    panel.set(
        ylim=(-3, 103),
        title="(d) size variation",
        xlabel="Longest step over shortest (ratio)",
        ylabel="Images with a merge failure (%)",
    )
    panel.legend(loc="lower right")
