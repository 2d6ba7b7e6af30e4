"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.ch04_central_generic.s1_1_synthetic_pinhole.experiment import (
    CAMERAS,
    LENSES,
)
from chapters.shared.central import CENTRE_MM
from raxel.geometry import on_plane
from raxel.show import Labels, Points, Polyline, Segments, Surface, framed
from repro.page import INK, new_figure, plot_estimates, series, value
from repro.page.space import draw_scene
from repro.run import (
    NOT_COMPARABLE,
    Check,
    Drawing,
    Estimate,
    Reading,
    Value,
    all_of,
    bootstrap,
    claim,
    columns,
    figure,
    median_interval,
    numbers,
    with_worst,
)

# Estimates of section 4.1.1, from its results.


SOLVERS = ("CGSP", "CGSP circle")  # Sturm-Maybank and the circles


def name_values(open_results):
    """Name the numbers that the prose quotes."""
    value("residual", largest(open_results("exp_c4_synth_pinhole"), "residual"))
    value("exact_mm", largest(open_results("exp_c4_any_pinhole"), SOLVERS))
    ratios = centre_ratios(open_results("exp_c4_sm_vs_wl"))
    value("ratio_most", max(ratio.value for ratio in ratios))
    for name in ("base_mm", "noise_mm"):
        found = open_results("exp_c4_interp_bias_centre").column(name)
        value(f"board.{name}", median_interval(found).value)


def largest(result, names, cameras=CAMERAS):
    """Return the largest error over the trials with the given cameras.

    A failed trial counts as infinite.
    """
    return max(
        float(with_worst(result.column(names, camera=camera)).max())
        for camera in cameras
    )


def centre_ratios(result):
    """Return the median ratio of the circles' error to Sturm-Maybank's, Estimates."""
    trials = [result.column(SOLVERS, **condition) for condition in result.conditions]
    return [
        median_interval((other / one)[np.isfinite(one) & np.isfinite(other)])
        for one, other in trials
    ]


def straightness(lattice):
    """Return the largest deviation of a lattice's lines from straight, per length.

    lattice: (rows, columns, 2).
    """
    shares = []
    for line in [*lattice, *np.swapaxes(lattice, 0, 1)]:
        along, (x, y) = line[-1] - line[0], (line - line[0]).T
        shares.append(np.abs(along[0] * y - along[1] * x).max() / (along @ along))
    return float(max(shares))


# Fig. 4.1, and the effects of noise and interpolation on the centre.


BLUE, ORANGE, GREEN = (series(k)["color"] for k in range(3))
SIGHT = (0.75, 0.35, -0.45)
HALF_MM = 640.0  # of the base grid, as drawn
SPARSE = (slice(None, None, 3), slice(None, None, 4))


@figure("fig_4_1", needs=("fig_4_1_scene",), evidence="analytic", scene=True)
def fig_4_1(results):
    """The base grid as the image plane of a pinhole camera."""
    found = results["fig_4_1_scene"]
    corners, image, flat = (
        found.arrays(name)[0] for name in ("corners", "picture", "synthetic")
    )
    bent, straight = straightness(image), straightness(flat)
    drawn, axes = new_figure(1, 3, height_in=4.6)
    drawn.set_layout_engine("none")
    axes[0].set_position([0.0, 0.02, 0.6, 0.93])
    axes[1].set_position([0.71, 0.585, 0.27, 0.335])
    axes[2].set_position([0.71, 0.105, 0.27, 0.335])
    axes[0].set_title("a  in space")
    scene = _scene(corners, flat)
    draw_scene(axes[0], scene)
    _lattice(axes[1], image, ORANGE, "b  image of the camera", "px")
    axes[1].invert_yaxis()
    _lattice(axes[2], flat, BLUE, "c  on the base grid", "mm")
    rows = [
        (row, column, *corners[row, column], *image[row, column], *flat[row, column])
        for row, column in np.ndindex(corners.shape[:2])
    ]
    head = ("row", "column", "x_mm", "y_mm", "z_mm", "u_px", "v_px")
    return Drawing(
        drawn,
        columns((*head, "base_x_mm", "base_y_mm"), rows),
        "Rays from a chessboard (orange) through the base grid (blue) to the "
        "centre of a fisheye: the base grid is the image plane of a synthetic "
        f"pinhole camera. In the fisheye image a row is bent by {bent:.0%} of "
        "its length. On the base grid the rows are straight.",
        Check(
            bool(straight < 1e-9 < bent),
            "rows and columns deviate from a straight line by "
            f"{straight:.0e} of their length on the base grid and by {bent:.2f} "
            "in the fisheye image",
        ),
        scene,
    )


def _scene(corners, flat):
    on_base = on_plane(flat)
    rim = on_plane(HALF_MM * np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]]))
    sheet = rim[[0, 1, 3, 2]].reshape(2, 2, 3)
    some = corners[SPARSE].reshape(-1, 3)
    starts = np.broadcast_to(CENTRE_MM, some.shape)
    parts = [
        Surface(corners, ORANGE, 0.35, "board"),
        *_lines(corners, ORANGE, "board"),
        Surface(sheet, BLUE, 0.25, "base grid"),
        Polyline(np.concatenate([rim, rim[:1]]), BLUE, "base grid", 2.5),
        *_lines(on_base, BLUE, "image on the base grid"),
        Points(on_base[SPARSE].reshape(-1, 3), BLUE, "image on the base grid"),
        Segments(starts, some, GREEN, "ray", 1.5),
        Points(CENTRE_MM[None], INK, "centre C", 12.0),
        Labels([CENTRE_MM + [90.0, 0.0, 60.0]], ["C"], INK),
        Labels([rim[1]], ["base grid"], BLUE),
        Labels([corners[0, 0]], ["board"], ORANGE),
    ]
    return framed(
        parts,
        SIGHT,
        up=(0.0, 0.0, 1.0),
        aspect=0.94,
        note="Rays through one point form a pinhole image on a plane, for any lens.",
    )


def _lines(lattice, colour, label):
    broken = np.full((1, 3), np.nan)
    both = [*lattice, *np.swapaxes(lattice, 0, 1)]
    joined = [part for line in both for part in (line, broken)]
    return [Polyline(np.concatenate(joined), colour, label, 1.5)]


def _lattice(panel, points, colour, title, unit):
    for line in [*points, *np.swapaxes(points, 0, 1)]:
        panel.plot(*line.T, color=colour, marker="", ls="-", lw=1.0)
    panel.set_aspect("equal", "datalim")
    panel.set_title(title, fontsize=9.5)
    panel.set_xlabel(f"x ({unit})", labelpad=1)
    panel.set_ylabel(f"y ({unit})", labelpad=1)
    panel.tick_params(labelsize=7.5)


@figure("ext_board_as_base", needs=("ext_board_as_base_sweep",), evidence="synthetic")
def ext_board_as_base(results):
    """Centre error over the pitch of a chessboard that is the base."""
    found = results["ext_board_as_base_sweep"]
    drawn, axes = new_figure(1, 2, height_in=3.4, sharey=True)
    rows = []
    shown = {"base_mm": "chessboard, no noise", "noise_mm": "per-pixel data, 0.1 px"}
    for panel, lens in zip(axes, LENSES, strict=True):
        pitches = found.by("pitch_mm", lens=lens)
        x = list(pitches)
        for index, (name, label) in enumerate(shown.items()):
            medians = [median_interval(one.column(name)) for one in pitches.values()]
            rows += [
                (lens, at, label, *median)
                for at, *median in plot_estimates(
                    panel, x, medians, look=series(index), label=label
                )
            ]
        panel.set(xscale="log", yscale="log", title=lens)
        panel.set_xlabel("Square size (mm)")
        panel.set_xticks(x, [f"{at:g}" for at in x])
        panel.minorticks_off()
    axes[0].set_ylabel("Centre error (mm)")
    axes[0].legend()
    return Drawing(
        drawn,
        columns(("lens", "pitch_mm", "series", "value", "low", "high"), rows),
        "Error of the centre against the square size of a chessboard base grid: "
        "interpolation between corners without noise, compared with 0.1 px of "
        "noise on per-pixel data (medians and 95 % intervals).",
    )


# Tests of the claims of section 4.1.1, as the registry states them.


EXACT_MM = 1e-6


@claim("c4_synth_pinhole", needs=("exp_c4_synth_pinhole",), evidence="analytic")
def judge_images(results):
    """Every pair lies on one homography, for any central camera."""
    result = results["exp_c4_synth_pinhole"]
    worst = largest(result, "residual")
    return Reading.of(
        worst < 1e-9,
        worst,
        reason=f"largest residual of {result.trials_per_condition * len(CAMERAS)} "
        "scenes with four kinds of camera, in normalised coordinates; "
        f"{largest(result, 'residual_mm'):.1g} mm",
    )


@claim("c4_any_pinhole", needs=("exp_c4_any_pinhole",), evidence="analytic")
def judge_centres(results):
    """Both solvers, for the fisheye of 183 deg and the hyperboloid."""
    result = results["exp_c4_any_pinhole"]
    worst = largest(result, SOLVERS, ("equidistance, 183°", "hyperboloid mirror"))
    return Reading.of(
        worst < EXACT_MM,
        worst,
        "mm",
        "largest error of Sturm-Maybank and the circles over "
        f"{result.trials_per_condition} scenes each; with the radial lens "
        f"and rays at random as well {largest(result, SOLVERS):.1g} mm",
    )


@claim("c4_sm_vs_wl", needs=("exp_c4_sm_vs_wl",), evidence="synthetic")
def judge_methods(results):
    """Not comparable without Wang and Liu's paper; reports the ratio to the circles."""
    ratios = centre_ratios(results["exp_c4_sm_vs_wl"])
    values = sorted(ratio.value for ratio in ratios)
    return Reading.of(
        NOT_COMPARABLE,
        Estimate(values[len(values) // 2], values[0], values[-1]),
        "1",
        "the method of Wang and Liu is not "
        "described. Shown: error of the circle construction over that of "
        "Sturm-Maybank, median within trials, and its range over "
        f"{len(ratios)} levels of noise and fields of view",
    )


@claim(
    "c4_interp_bias_centre", needs=("exp_c4_interp_bias_centre",), evidence="synthetic"
)
def judge_interpolation(results):
    """Above 0.1 mm, and above the effect of 0.1 px noise."""
    errors = results["exp_c4_interp_bias_centre"].column(
        ("base_mm", "noise_mm", "all_mm", "gap_mm")
    )
    bias, noise, boards, gap = map(median_interval, errors)
    more = bootstrap(
        lambda x: np.median(x, axis=-1), with_worst(errors[0]) - with_worst(errors[1])
    )
    return Reading.of(
        all_of([bias.above(0.1), more.above(0.0)]),
        bias,
        "mm",
        f"0.1 px of noise with per-pixel data: {noise.value:.2g} "
        f"mm; all three grids interpolated: {boards.value:.2g} mm. The "
        f"points on the base are off by {gap.value:.2g} mm (median)",
    )


@numbers("sec_4_1_1", needs=("sec_4_1_1_grids",), evidence="analytic")
def values_of_grids(results):
    """Smallest number of grids that give the correct centre."""
    errors = results["sec_4_1_1_grids"].by("grids").items()
    enough = [
        grids
        for grids, trials in errors
        if with_worst(trials.column("centre_mm")).max() < EXACT_MM
    ]
    return {"s4_1_2_grids": Value(float(min(enough)))}
