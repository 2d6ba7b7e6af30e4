"""Results of this page read: values of the prose, figures, tables, judgements."""

from itertools import pairwise

import numpy as np

from chapters.ch03_planar_grids.s2_1_interpolation_bias.experiment import (
    FOCAL_MM,
    FOUR,
    MIDDLE_MM,
    RADIAL,
    SIDE_MM,
)
from repro.page import look_of, new_figure, plot_interval, series, value
from repro.run import (
    FAILS,
    HOLDS,
    Check,
    Drawing,
    Reading,
    Value,
    all_of,
    claim,
    columns,
    figure,
    loglog_slope,
    median_interval,
    numbers,
    trend,
)

# Results of section 3.2.1: errors, slopes, the ridge, quoted numbers.


# Choices of the four corners, the primary one first.
CHOICES = tuple(FOUR)
PRIMARY = CHOICES[0]
MAGNIFIED = 300  # scale of the vectors of Fig. 3.6
STATED_MM = 20
BIN_EDGES_MM = np.linspace(0, MIDDLE_MM * np.sqrt(2), 5)


def trials_of_vectors(result, choice):
    """(points, errors) of every trial, both (n, 2) mm, without points that failed."""
    both = zip(result.arrays("points"), result.arrays(choice), strict=True)
    finite = ((points, errors, np.isfinite(errors[:, 0])) for points, errors in both)
    return [(points[ok], errors[ok]) for points, errors, ok in finite]


def radii(points):
    """Distance (n,) mm from the image centre."""
    return np.linalg.norm(points - MIDDLE_MM, axis=1)


def radial_shares(result, choice):
    """Radial share of the squared errors (trials,)."""
    shares = []
    for points, errors in trials_of_vectors(result, choice):
        out = (points - MIDDLE_MM) / radii(points)[:, None]
        along = np.sum(out * errors, axis=1)
        shares.append(np.sum(along**2) / np.sum(errors**2))
    return np.array(shares)


def swept(result, choice, key="pitch_mm"):
    """Levels (n,) of a sweep, and RMS errors (n, trials) mm at each level."""
    of_level = result.by(key)
    errors = [trials.column(choice, "rms_mm") for trials in of_level.values()]
    return np.array(list(of_level), float), np.array(errors)


def formula_mm(pitch_mm):
    """RMS of the bias over the grid with k1 alone, in mm."""
    strength = abs(RADIAL[0]) / FOCAL_MM**2
    return strength * np.square(pitch_mm) * np.sqrt(11 / 90) * SIDE_MM / np.sqrt(6)


def name_values(open_results):
    """Name the numbers that the page quotes."""
    vectors = open_results("fig_3_6_vectors")
    pitches = open_results("fig_3_7_pitches")
    ridge = open_results("exp_c3_interp_discontinuous")
    levels, errors = swept(pitches, PRIMARY)
    enclosing = pitches.column(CHOICES[1], "rms_mm", pitch_mm=STATED_MM)
    quoted = {
        "radial.nearest": 100 * np.median(radial_shares(vectors, PRIMARY)),
        "slope": loglog_slope(levels, np.median(errors, axis=1)),
        "at_20": np.median(enclosing),
        "formula_20": formula_mm(STATED_MM),
        "break.unknown.gross": 100 * np.median(ridge.column("unknown", "gross")),
        "break.trusted": 100 * np.median(ridge.column("trusted")),
    }
    for name, number in quoted.items():
        value(name, number)


# Figs. 3.6 and 3.7, and the errors at a ridge of two mirrors.


SHOWN_MM = (1e-2, 1e3)
RIDGE_NAMES = {
    "unknown": "interpolation, ridge unknown",
    "7 x 7": "decoding, 7 × 7 filter",
    "none": "decoding, no filter",
}


@figure("fig_3_6", needs=("fig_3_6_vectors",), evidence="synthetic")
def fig_3_6(results):
    """Error vectors of 500 points, for both choices of corners."""
    result = results["fig_3_6_vectors"]
    pitch = result.conditions[0]["pitch_mm"]
    drawn, axes = new_figure(1, 2, height_in=3.9, sharex=True, sharey=True)
    ticks = np.arange(0, SIDE_MM + 1, 60)
    rows, drawn_points = [], result.arrays("points")[0]
    for panel, choice, letter in zip(axes, CHOICES, "ab", strict=True):
        points, errors = trials_of_vectors(result, choice)[0]
        rows += [(choice, *p, *e) for p, e in zip(points, errors, strict=True)]
        _arrows(panel, points, errors, series(0)["color"])
        panel.set(
            title=f"({letter}) {choice}",
            aspect="equal",
            xlabel="x (mm)",
            xticks=ticks,
            yticks=ticks,
        )
    nearest, enclosing = (result.arrays(choice)[0] for choice in CHOICES)
    # Larger than the effect of rounding on the choice of corners.
    other = np.abs(nearest - enclosing).max(axis=1) > 1e-9
    _arrows(axes[0], drawn_points[other], nearest[other], series(1)["color"])
    axes[0].invert_yaxis()
    axes[0].set_ylabel("y (mm)")
    shown = [sum(row[0] == choice for row in rows) for choice in CHOICES]
    count = len(drawn_points)
    names = ("corners", "x_mm", "y_mm", "error_x_mm", "error_y_mm")
    return Drawing(
        drawn,
        columns(names, rows),
        f"Interpolation errors of {count} random points on a grid with a pitch of "
        f"{pitch} mm. Vectors point from the true (dot) to the interpolated point, "
        f"magnified {MAGNIFIED} times, with y downwards as in images. (a) The four "
        "nearest corners, no three collinear on the grid, as in the thesis. "
        "Orange: these are not the corners of the enclosing square. (b) The "
        "corners of the enclosing square.",
        Check(
            shown[0] == count and 0.95 * count <= shown[1] <= count,
            f"{shown[0]} and {shown[1]} of {count} points are drawn; outside "
            "the outermost corners a point can be in no square of the image",
        ),
    )


def _arrows(panel, points, errors, colour):
    """Draw points (n, 2) and their errors (n, 2), magnified."""
    ends = points + MAGNIFIED * errors
    lines = np.stack([points, ends, np.full_like(ends, np.nan)], 1)
    panel.plot(*lines.reshape(-1, 2).T, "-", color=colour, lw=0.9)
    panel.plot(*points.T, ".", color=colour, ms=2.5)


@figure("fig_3_7", needs=("fig_3_7_pitches",), evidence="synthetic")
def fig_3_7(results):
    """RMS over the pitch for both choices of corners, and the formula."""
    result = results["fig_3_7_pitches"]
    drawn, axes = new_figure(1, 2, height_in=3.3)
    rows = []
    for k, choice in enumerate(CHOICES):
        pitch, errors = swept(result, choice)
        found = np.array([median_interval(trials)[:3] for trials in errors])
        for panel in axes:
            plot_interval(panel, pitch, *found.T, look=series(k), label=choice)
        rows += [(choice, p, *ends) for p, ends in zip(pitch, found, strict=True)]
    fine = np.linspace(pitch[0], pitch[-1], 60)
    for panel in axes:
        panel.plot(fine, formula_mm(fine), ":", color="#1b1f24", label="formula")
        panel.set(xlabel="Grid pitch (mm)", ylabel="RMS error (mm)")
    axes[0].legend()
    axes[0].set(title="Linear axes")
    axes[1].set(xscale="log", yscale="log", title="Logarithmic axes")
    shown = [p for p in pitch if p in (5, 10, 20, 30, 60)]
    axes[1].set_xticks(shown, [f"{p:g}" for p in shown])
    axes[1].minorticks_off()
    names = ("corners", "pitch_mm", "rms_mm", "low", "high")
    return Drawing(
        drawn,
        columns(names, rows),
        "RMS error of interpolated points over the pitch of the grid: medians of "
        f"{result.trials_per_condition} trials with 500 points each. Bands: 95 % "
        "intervals, hardly wider than the lines. Dotted: second-order formula of "
        "the Model, with $k_1$ alone.",
    )


@figure("ext_two_facets", needs=("exp_c3_interp_discontinuous",), evidence="rendered")
def ext_two_facets(results):
    """RMS error over the distance from the ridge."""
    result = results["exp_c3_interp_discontinuous"]
    drawn, axes = new_figure(height_in=3.2)
    rows, places = [], np.concatenate(result.arrays("from_ridge_px"))
    place = np.unique(places)
    for name, label in RIDGE_NAMES.items():
        sizes = np.concatenate(result.arrays(name, "by_column_mm"))
        size = np.array([np.median(sizes[places == p]) for p in place])
        # Rounding errors would be drawn as a line down to the axis.
        drawn_size = np.where(size < SHOWN_MM[0], np.nan, size)
        masked = np.flatnonzero(np.diff(place) > 1) + 1
        gaps = (np.insert(a, masked, np.nan) for a in (place, drawn_size))
        look = series(0) if name == "unknown" else look_of(label)
        axes.semilogy(*gaps, label=label, **look)
        rows += [(label, *row) for row in zip(place, size, strict=True)]
    axes.set(
        xlabel="Distance from the ridge (px)", ylabel="RMS error (mm)", ylim=SHOWN_MM
    )
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    return Drawing(
        drawn,
        columns(("method", "from_ridge_px", "rms_mm"), rows),
        "RMS error over the distance from the ridge of two mirrors, for "
        "interpolation and decoding. RMS over the trusted pixels of a column, "
        f"medians of {result.trials_per_condition} trials. Interpolation fails "
        "where corners of the other mirror are among the nearest four, decoding "
        "only where blur or its filter mixes both sides. Where the blue curve "
        "ends, all corners belong to the pixel's own mirror and the error is "
        "rounding.",
    )


# The claims of section 3.2.1.


MIN_RANK, MIN_RADIAL = 0.4, 0.6
PITCH_SLOPE, DISTORTION_SLOPE = (1.5, 2.5), (0.8, 1.2)
EXACT_MM = 1e-9
MIN_GAIN = 10.0


def at_least(estimate, bound):
    """Whether an estimate reaches a bound."""
    return estimate.above(np.nextafter(bound, -np.inf))


@claim(
    "c3_interp_radial_growth",
    needs=("fig_3_6_vectors",),
    evidence="synthetic",
    readings=("four_corners",),
)
def judge_radial_growth(results, options):
    """Spearman(radius, |error|) >= 0.4, and means that rise over four bins."""
    from scipy.stats import spearmanr

    ranks, means = [], []
    for points, errors in trials_of_vectors(
        results["fig_3_6_vectors"], options["four_corners"]
    ):
        radius, size = radii(points), np.linalg.norm(errors, axis=1)
        ranks.append(spearmanr(radius, size).statistic)
        place = np.digitize(radius, BIN_EDGES_MM[1:-1])
        means.append([size[place == k].mean() for k in range(len(BIN_EDGES_MM) - 1)])
    rank = median_interval(ranks)
    rises = [median_interval(d).above(0) for d in np.diff(means, axis=1).T]
    listed = ", ".join(f"{m:.4f}" for m in np.median(means, axis=0))
    return Reading.of(
        all_of([at_least(rank, MIN_RANK), *rises]),
        rank,
        reason=f"Spearman; mean errors in the four bins, inner to outer, {listed} mm",
    )


@claim("c3_interp_radial_dir", needs=("fig_3_6_vectors",), evidence="synthetic")
def judge_radial_direction(results):
    """Radial with the nearest four, and more so with the enclosing cell."""
    shares = [radial_shares(results["fig_3_6_vectors"], name) for name in CHOICES]
    nearest, enclosing = (median_interval(s) for s in shares)
    more = median_interval(shares[1] - shares[0])
    return Reading.of(
        all_of([at_least(nearest, MIN_RADIAL), more.above(0)]),
        nearest,
        reason="share of the energy with the nearest four; with the "
        f"enclosing cell {enclosing.value:.4f}",
    )


@claim(
    "c3_interp_pitch",
    needs=("fig_3_7_pitches",),
    evidence="synthetic",
    readings=("four_corners",),
)
def judge_pitch(results, options):
    """The RMS rises with every pitch; log-log slope in [1.5, 2.5]."""
    pitch, trials = swept(results["fig_3_7_pitches"], options["four_corners"])
    levels = [median_interval(t) for t in trials]
    rises = [
        HOLDS if after.low > before.high else FAILS
        for before, after in pairwise(levels)
    ]
    slope = trend(pitch, trials, loglog_slope)
    return Reading.of(
        all_of([*rises, slope.within(*PITCH_SLOPE)]),
        slope,
        reason=f"log-log slope; RMS from {levels[0].value:.4f} mm at "
        f"{pitch[0]:g} mm to {levels[-1].value:.4f} mm at {pitch[-1]:g} mm",
    )


@claim(
    "c3_interp_cause",
    needs=("fig_3_6_distortion",),
    evidence="synthetic",
    readings=("four_corners",),
)
def judge_cause(results, options):
    """Exact without distortion, and nearly in proportion to it."""
    name = options["four_corners"]
    share, trials = swept(results["fig_3_6_distortion"], name, "share")
    straight = trials[share == 0].max()
    slope = trend(share[share > 0], trials[share > 0], loglog_slope)
    exact = HOLDS if straight < EXACT_MM else FAILS
    return Reading.of(
        all_of([exact, slope.within(*DISTORTION_SLOPE)]),
        slope,
        reason="log-log slope over the share of the distortion; "
        f"without any, at most {straight:.0e} mm",
    )


@claim(
    "c3_interp_discontinuous",
    needs=("exp_c3_interp_discontinuous",),
    evidence="rendered",
    readings=("facets", "phase_smoothing"),
)
def judge_discontinuous(results, options):
    """Interpolation errs ten times as much as decoding near the ridge."""
    result = results["exp_c3_interp_discontinuous"]
    taken = options["facets"], options["phase_smoothing"]
    sizes = result.column(taken, "rms_mm")
    gain = median_interval(sizes[0] / sizes[1])
    trusted = 100 * np.median(result.column("trusted"))
    wrong, decoded = np.median(sizes, axis=1)
    return Reading.of(
        gain.above(MIN_GAIN),
        gain,
        "1",
        f"ratio of RMS errors; interpolation {wrong:.3g} mm, "
        f"decoding {decoded:.3g} mm, on the {trusted:.1f} % of the pixels "
        "near the ridge that the decoder trusts",
    )


@numbers("fig_3_6", needs=("fig_3_6_vectors",), evidence="synthetic")
def settings_of_vectors(results):
    """Settings of Fig. 3.6; the image is as large as the grid (E-3.07)."""
    ran = results["fig_3_6_vectors"]
    return {
        "fig3_6_f": Value(FOCAL_MM, unit="mm"),
        "fig3_6_pp_x": Value(MIDDLE_MM, unit="mm"),
        "fig3_6_pp_y": Value(MIDDLE_MM, unit="mm"),
        "fig3_6_k1": Value(RADIAL[0]),
        "fig3_6_k2": Value(RADIAL[1]),
        "fig3_6_pts": Value(len(ran.arrays("points")[0])),
        "fig3_6_grid": Value(SIDE_MM, unit="mm"),
        "fig3_6_pitch": Value(ran.conditions[0]["pitch_mm"], unit="mm"),
        "fig3_6_scale": Value(MAGNIFIED),
    }
