"""Results of this page read: values of the prose, figures, tables."""

import numpy as np
from scipy.special import expit

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
# Click orders by direction, the first corner by rising size of its square.
ORDERS = {
    "clockwise": tuple(f"clockwise_{rank}" for rank in range(4)),
    "anticlockwise": tuple(f"reverse_{rank}" for rank in range(4)),
}
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


def numbers_of(result, *path, poses=WHOLE):
    """Return a number of every image of one range of poses, (..., n)."""
    return result.select(poses=poses).column(*path)


def levels_run(result):
    """Return the light levels of the contrast study as run, brightest first."""
    return [v for v in LIGHT_LEVELS if v in result.conditions[0]["levels"]]


def in_light(result, method, poses=WHOLE, spots=SPOTTED):
    """Return the successes (levels, n) of a method in every light."""
    clean = () if spots == SPOTTED else ("spotless",)
    levels = [level_name(level) for level in levels_run(result)]
    return numbers_of(result, levels, *clean, method, poses=poses)


def shadow_effects(result, method, poses=WHOLE):
    """Return success without minus with the shadow, as an Estimate."""
    return paired_gain(*numbers_of(result, ("plain", "shadow"), method, poses=poses))


def all_orders(result, poses=WHOLE):
    """Return success (2, 4, n): direction, first corner by rising square, image."""
    return np.array([numbers_of(result, of, poses=poses) for of in ORDERS.values()])


def differing(orders):
    """Return for each image (n,) 1 where the eight orders do not all end alike."""
    flat = orders.reshape(-1, orders.shape[-1])
    return (flat.min(axis=0) != flat.max(axis=0)).astype(float)


def merging_of(results, poses=WHOLE):
    """Return size ratio and merge failure, each (n,), of the fisheye images."""
    names = ("size_ratio", "merge_failed")
    both = [results[e] for e in ("exp_c3_shadow", "exp_c3_merge_images")]
    return np.hstack([numbers_of(one, names, poses=poses) for one in both])


def logistic_fit(x, y):
    """Return slope, its standard error and offset of log odds of y (n,) over x (n,).

    Maximum likelihood by Newton's method; nan where all y are alike or x separates
    them, so that the slope is unbounded.
    """
    y = np.asarray(y, float)
    if y.min() == y.max():
        return (np.nan,) * 3
    scale = x.std()
    design = np.column_stack([np.ones(len(x)), (x - x.mean()) / scale])
    weights = np.zeros(2)
    for _ in range(50):
        p = 1 / (1 + np.exp(-design @ weights))
        information = design.T @ (design * (p * (1 - p))[:, None])
        if np.linalg.eigvalsh(information)[0] < SEPARATED:
            return (np.nan,) * 3
        step = np.linalg.solve(information, design.T @ (y - p))
        weights += step
        if np.abs(step).max() < 1e-10:
            break
    error = np.sqrt(np.linalg.inv(information)[1, 1])
    slope = float(weights[1] / scale)
    return slope, float(error / scale), float(weights[0] - slope * x.mean())


def logistic_curve(x, y, at):
    """Return the probability (m,) at `at` (m,) by the logistic fit of y over x (n,).

    It is the mean of y where there is no such fit.
    """
    slope, _, offset = logistic_fit(x, y)
    if not np.isfinite(slope):
        return np.full(len(at), np.mean(y))
    return expit(offset + slope * at)


@numbers("fig_3_14", needs=("fig_3_14_parts",), evidence="rendered")
def numbers_fig_3_14(results):
    """Return sizes of the parts in the plotted image; the others in words."""
    result = results["fig_3_14_parts"]
    found = {}
    for short, camera in (("hype", "hyperboloidal"), ("fish", "fisheye")):
        for name_of, method in (("celect", CELECT), ("opencv", OPENCV)):
            counts, wide, high = result.column(
                method, ("count", "columns", "rows"), camera=camera
            )
            others = ", ".join(f"{n:.0f}" for n in counts)
            for name, sizes in (("cols", wide), ("rows", high)):
                sizes = np.nan_to_num(sizes)
                found[f"fig3_14_{short}_{name_of}_{name}"] = Value(
                    float(sizes[0]),
                    interval=(float(sizes.min()), float(sizes.max())),
                    unit="corners",
                    reason="in the image drawn; the range is over "
                    f"{len(counts)} images, whose parts have {others} "
                    "corners",
                )
    return found


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    needs = ("exp_c3_shadow", "exp_c3_merge_images")
    results = {name: open_results(name) for name in needs}
    ratio, failed = merging_of(results)
    thirds = np.array_split(failed[np.argsort(ratio)], min(3, len(ratio)))
    loss = 100 * np.array(shadow_effects(results["exp_c3_shadow"], OPENCV)[:3])
    orders = proportion(differing(all_orders(open_results("exp_c3_trace_direction"))))
    parts = open_results("fig_3_14_parts")
    quoted = {f"part.{camera}": ratio_of_parts(parts, camera) for camera in CAMERAS} | {
        "shadow.whole.opencv": "{:.1f} ({:.1f} to {:.1f})".format(*loss),
        "orders.differ": rounded(
            100 * orders.value, (100 * orders.low, 100 * orders.high)
        ),
        "merge.even": 100 * thirds[0].mean(),
        "merge.uneven": 100 * thirds[-1].mean(),
    }
    for name, number in quoted.items():
        value(name, number)


def ratio_of_parts(result, camera):
    """Return the median ratio of CELECT's corners to OpenCV's."""
    ours, theirs = result.column((CELECT, OPENCV), "count", camera=camera)
    return float(np.median(ours / np.maximum(theirs, 1)))


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
    for of_camera, camera, letter in zip(panels, CAMERAS, "ab", strict=True):
        image, lattice = (
            result.arrays(name, camera=camera)[0] for name in ("picture", "lattice")
        )
        for panel, method in zip(of_camera, (CELECT, OPENCV), strict=True):
            corners, size = None, "no part"
            if result.column(method, "count", camera=camera)[0] > 0:
                corners = result.arrays(method, "corners", camera=camera)[0]
                size = "{1} × {0}".format(*sorted(corners.shape[:2]))
                inside.append(_shares_corners(corners, lattice))
                rows += [
                    (camera, METHODS[method], index, *corner)
                    for index, corner in enumerate(corners.reshape(-1, 2))
                ]
            _draw_part(panel, image, lattice, corners)
            if corners is not None and method == OPENCV:
                _draw_paint(panel, result, camera)
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


def _draw_part(panel, image, lattice, corners):
    low = lattice.reshape(-1, 2).min(axis=0) - MARGIN_PX
    high = lattice.reshape(-1, 2).max(axis=0) + MARGIN_PX
    panel.imshow(image, cmap="gray", vmin=0, vmax=255)
    if corners is not None:
        panel.plot(*corners.transpose(2, 1, 0), "-", color=GREEN, lw=0.7, marker="")
        panel.plot(*corners.transpose(2, 0, 1), "-", color=YELLOW, lw=0.7, marker="")
        panel.plot(*corners.reshape(-1, 2).T, "o", color=RED, ms=1.8, linestyle="")
    panel.set(
        xlim=(max(low[0], -0.5), min(high[0], image.shape[1] - 0.5)),
        ylim=(min(high[1], image.shape[0] - 0.5), max(low[1], -0.5)),
        xlabel="u (px)",
        ylabel="v (px)",
    )
    panel.grid(visible=False)


def _draw_paint(panel, result, camera):
    """Draw the painted image over the original."""
    bordered, (u, v) = (
        result.arrays(OPENCV, name, camera=camera)[0] for name in ("painted", "first")
    )
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
    from matplotlib.ticker import FixedFormatter, FixedLocator

    panel.xaxis.set_major_locator(FixedLocator(places))
    panel.xaxis.set_major_formatter(FixedFormatter(names))


def _draw_light(panel, result, rows):
    levels = levels_run(result)
    for index, (method, label) in enumerate(METHODS.items()):
        # Offset from each other, so that every interval is visible.
        x = np.array(levels) * OFFSET ** (index - 2)
        _draw(panel, "a", x, in_light(result, method), look_of(label), label, rows)
    grey = numbers_of(result, [level_name(v) for v in levels], "contrast_grey")
    for level, contrast in zip(levels, np.median(grey, axis=1), strict=True):
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
        trials = numbers_of(result, ("plain", "shadow"), method)
        x = np.array([0, 1]) + 0.06 * (index - 2)
        _draw(panel, "b", x, trials, look_of(label), label, rows)
    _name_ticks(panel, [0, 1], ["no shadow", "shadow"])
    panel.set(
        xlim=(-0.4, 1.4), ylim=(-3, 103), title="(b) soft shadow", ylabel="Success (%)"
    )


def _draw_orders(panel, result, rows):
    for index, (label, names) in enumerate(ORDERS.items()):
        x = np.arange(1, 5) + 0.08 * (index - 0.5)
        trials = numbers_of(result, names)
        _draw(panel, "c", x, trials, series(index + 5), label, rows)
    squares = ["smallest\nsquare", "second", "third", "largest\nsquare"]
    _name_ticks(panel, [1, 2, 3, 4], squares)
    panel.set(ylim=(0, 103), title="(c) first corner clicked", ylabel="Success (%)")
    panel.legend(loc="upper right")


def _draw_merging(panel, results, rows):
    ratio, failed = merging_of(results)
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
