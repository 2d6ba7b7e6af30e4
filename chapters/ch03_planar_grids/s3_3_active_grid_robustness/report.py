"""Results of this page read: values of the prose, figures, tables, judgements."""

from itertools import product

import numpy as np
from scipy.stats import spearmanr

from chapters.ch03_planar_grids.s3_3_active_grid_robustness.experiment import (
    ACTIVE,
    AS_TAKEN,
    DEFAULT_LEVEL,
    DEFAULT_MM,
    EXPOSURES,
    METHODS,
    ONE_WINDOW,
    OVER,
    TRUE,
    WITHIN,
)
from repro.page import look_of, new_figure, value
from repro.run import (
    Drawing,
    Reading,
    Value,
    claim,
    columns,
    figure,
    median_and_range,
    numbers,
    with_worst,
)

# Results of the sweeps of 3.3.3, and the numbers that the prose quotes.


SWEPT = ("fig_3_15_sweeps",)
SWEEPS = ("distance", "orientation", "blur", "noise")
BY_GRID, BY_TRUTH = "a second grid", "the true corners"
# Question of the registry -> its primary option, named alike in the trials.
PRIMARY = {
    "corner_window": ONE_WINDOW,
    "second_grid_pictures": AS_TAKEN,
    "exposure": WITHIN,
    "corner_measure": BY_GRID,
}
# Methods, and true corners as if a method had found them.
WITH_TRUE = (*METHODS, TRUE)


def levels_of(result, sweep):
    """Return the levels of a sweep in rising order, including the default one."""
    default = {DEFAULT_LEVEL[sweep]} if sweep in DEFAULT_LEVEL else set()
    return sorted({*result.levels("level", sweep=sweep), *default})


def at(result, sweep, level, *path):
    """Return values (..., sets) of a level."""
    if DEFAULT_LEVEL.get(sweep) == level:
        sweep, level = "default", DEFAULT_MM
    return result.select(sweep=sweep, level=level).column(*path)


def points_of(result):
    """Return every (sweep, level) once; the sweeps share the default."""
    return list(dict.fromkeys((c["sweep"], c["level"]) for c in result.conditions))


def residuals(result, sweep, level, methods, taken=PRIMARY):
    """Return RMS residuals (..., sets) in mm; infinite where the method failed.

    methods: one, or several, which make an axis; taken: option by question. Compared
    with the true corners: RMS errors in px.
    """
    measured = taken["second_grid_pictures"]
    if taken["corner_measure"] == BY_TRUTH:
        measured = "off_px"
    path = taken["exposure"], taken["corner_window"], measured, methods
    return with_worst(at(result, sweep, level, *path))


def wins(result, points, taken=PRIMARY):
    """Return where (points, sets) the active grid beats or ties both others.

    Residuals are a tie if they differ by no more than the range of the floor over
    the sets. Compared with the true corners there is no floor, and no tie.
    """
    won = []
    for sweep, level in points:
        *theirs, ours, floor = residuals(result, sweep, level, WITH_TRUE, taken)
        tie = np.ptp(floor)
        won.append(np.isfinite(ours) & (ours <= np.minimum(*theirs) + tie))
    return np.array(won)


def points_along(result, sweep):
    """Return (sweep, level) of every level of a sweep, including the default one."""
    return [(sweep, level) for level in levels_of(result, sweep)]


@numbers("fig_3_15", needs=SWEPT, evidence="rendered")
def numbers_fig_3_15(results):
    """Return the settings of the sweeps as they were run."""
    ran = results["fig_3_15_sweeps"].settings
    return {
        "fig3_15_corners": Value(ran["corners"][0], unit="count"),
        "fig3_15_size": Value(ran["grid_mm"], unit="mm"),
        "fig3_15_dist": Value(ran["distance_mm"], unit="mm"),
        "fig3_15_ori": Value(ran["orientation_deg"], unit="deg"),
    }


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    result = open_results("fig_3_15_sweeps")
    share = wins(result, points_of(result)).mean(axis=0)
    noise = points_along(result, "noise")
    beaten = np.median(wins(result, noise), axis=1) < 1
    by_truth = PRIMARY | {"corner_measure": BY_TRUTH}
    derivative, _, active = np.median(
        residuals(result, "distance", DEFAULT_MM, METHODS, by_truth), axis=1
    )
    quoted = {
        "won": 100 * np.median(share),
        "won.least": 100 * share.min(),
        "floor": np.median(residuals(result, "distance", DEFAULT_MM, TRUE)),
        "first_lost_noise": noise[beaten.argmax()][1] if beaten.any() else "none",
        "off.active": active,
        "off.derivative": derivative,
    }
    for name, number in quoted.items():
        value(name, number)


# Fig. 3.15, and the errors by the true corners.


AXES = {
    "distance": "Camera-grid distance (mm)",
    "orientation": "Grid orientation (deg)",
    "blur": "Gaussian blur, SD (px)",
    "noise": "Gaussian noise, SD (grey levels)",
}


def _along(panel, result, sweep, method, taken, look, label):
    """Draw median and range of residuals over sets along a sweep; return the data."""
    levels = levels_of(result, sweep)
    found = np.array([residuals(result, sweep, x, method, taken) for x in levels])
    found[~np.isfinite(found)] = np.nan
    low, middle, high = (
        statistic(found, axis=1) for statistic in (np.min, np.median, np.max)
    )
    panel.plot(levels, middle, label=label, **look)
    band = {"color": look["color"], "alpha": 0.18, "linewidth": 0}
    panel.fill_between(levels, low, high, **band)
    return list(zip(levels, middle, low, high, strict=True))


@figure("fig_3_15", needs=SWEPT, evidence="rendered")
def fig_3_15(results):
    """Draw the residuals of three methods along four sweeps."""
    result = results["fig_3_15_sweeps"]
    drawn, panels = new_figure(2, 2, height_in=6.4)
    rows = []
    for panel, sweep in zip(panels.flat, SWEEPS, strict=True):
        for method in WITH_TRUE:
            look = look_of(method)
            found = _along(panel, result, sweep, method, PRIMARY, look, method)
            rows += [(sweep, level, method, *rest) for level, *rest in found]
        panel.set(xlabel=AXES[sweep], ylabel="RMS residual (mm)", ylim=(0, None))
    _legend(drawn, panels[0, 0], 4)
    return Drawing(
        drawn,
        columns(("sweep", "level", "method", "rms_mm", "low_mm", "high_mm"), rows),
        "RMS residual of the chessboard's corners after a homography from the "
        "second active grid, in mm on the chessboard: median and range over "
        f"{_sets(result)}. Dotted: true corners, whose residual is the second "
        "grid's own error (floor). Exposure below a full well, window of 15 px.",
    )


@figure("ext_active_errors", needs=SWEPT, evidence="rendered")
def ext_active_errors(results):
    """Draw the errors by the true corners along the sweeps, with both exposures."""
    result = results["fig_3_15_sweeps"]
    drawn, panels = new_figure(2, 2, height_in=6.6, sharey=True)
    rows = []
    for panel, sweep in zip(panels.flat, SWEEPS, strict=True):
        for exposure, method in product(EXPOSURES, METHODS):
            line = "-" if exposure == WITHIN else "--"
            look = look_of(method) | {"linestyle": line}
            label = f"{method}{', overexposed' * (exposure == OVER)}"
            taken = PRIMARY | {"corner_measure": BY_TRUTH, "exposure": exposure}
            found = _along(panel, result, sweep, method, taken, look, label)
            rows += [(sweep, level, exposure, method, *rest) for level, *rest in found]
        panel.set(xlabel=AXES[sweep], ylabel="RMS error (px)", yscale="log")
    _legend(drawn, panels[0, 0], 3)
    return Drawing(
        drawn,
        columns(
            (
                "sweep", "level", "exposure", "method",
                "rms_px", "low_px", "high_px",
            ),
            rows,
        ),
        "RMS distance (px) of the localised corners from the true ones: median "
        f"and range over {_sets(result)}. Dashed: overexposed by a fifth above "
        "a full well.",
    )  # fmt: skip


def _legend(drawn, panel, columns_in_it):
    """Draw one legend above all panels."""
    handles, labels = panel.get_legend_handles_labels()
    drawn.legend(
        handles, labels, loc="outside upper center", ncols=columns_in_it,
        fontsize=8,
    )  # fmt: skip


def _sets(result):
    count = len(result.levels("set"))
    return "one set of images" if count == 1 else f"{count} sets of images"


# Claims of section 3.3.3, decided by the share of the sets that support them.


MIN_CONDITIONS, MIN_LEVELS = 0.8, 0.7
MAX_BLUR_RATIO = 1.5
MAX_RANK, MIN_FALL = -0.9, 0.01
# Options of the viewing angle -> their names in the trials.
DECODABLE = {"with the rim": "share", "without the rim": "without_rim"}
GAMMAS = {"gamma 2.2": 2.2, "linear": 1.0}
ALL = ("corner_window", "second_grid_pictures", "exposure", "corner_measure")
OF_FIRST = ("corner_window", "exposure", "corner_measure")


def of_share(results, options, sweep=None):
    """Return the Reading that no method leaves less in a share of the conditions.

    It must hold in nearly all sets: over the levels of a sweep, or over all
    conditions. Ties count.
    """
    result, taken = results["fig_3_15_sweeps"], PRIMARY | options
    points = points_along(result, sweep) if sweep else points_of(result)
    required = MIN_LEVELS if sweep else MIN_CONDITIONS
    won = wins(result, points, taken)
    share = won.mean(axis=0)
    beaten = [
        f"{sweep} {level:g}"
        for (sweep, level), sets in zip(points, won, strict=True)
        if not sets.all()
    ]
    return Reading.of_seeds(
        share >= required,
        median_and_range(share),
        "1",
        f"median and range over {len(share)} sets, of {len(points)} conditions each; "
        f"holds in {int(np.sum(share >= required))}; beaten in some set "
        f"at: {', '.join(beaten) or 'none'}; corners left out: "
        f"{left_out(result, points, taken)}",
    )


def left_out(result, points, taken):
    """Return the number of corners that each method missed, as text."""
    path = taken["exposure"], taken["corner_window"], "lost", METHODS
    counts = np.sum([at(result, *point, *path).sum(axis=1) for point in points], axis=0)
    corners = np.prod(result.settings["corners"]) * len(result.levels("set"))
    by_method = [f"{m} {n:.0f}" for m, n in zip(METHODS, counts, strict=True)]
    return f"{', '.join(by_method)} of {corners * len(points)}"


@claim("c3_active_best", needs=SWEPT, evidence="rendered", readings=ALL)
def judge_active_best(results, options):
    """In four fifths of the conditions no method leaves less."""
    return of_share(results, options)


@claim("c3_active_distance", needs=SWEPT, evidence="rendered", readings=OF_FIRST)
def judge_active_distance(results, options):
    """At seven tenths of the distances no method leaves less."""
    return of_share(results, options, "distance")


@claim("c3_active_orientation", needs=SWEPT, evidence="rendered", readings=OF_FIRST)
def judge_active_orientation(results, options):
    """At seven tenths of the orientations no method leaves less."""
    return of_share(results, options, "orientation")


@claim("c3_active_noise", needs=SWEPT, evidence="rendered", readings=ALL)
def judge_active_noise(results, options):
    """At seven tenths of the levels of noise no method leaves less."""
    return of_share(results, options, "noise")


@claim("c3_active_blur", needs=SWEPT, evidence="rendered", readings=ALL)
def judge_active_blur(results, options):
    """Strongest blur over none: no larger than others' or a tie, and at most 1.5."""
    result, taken = results["fig_3_15_sweeps"], PRIMARY | options
    weakest, *_, strongest = levels_of(result, "blur")
    sharp, blurred = (
        residuals(result, "blur", level, WITH_TRUE, taken)
        for level in (weakest, strongest)
    )
    *theirs, ours = ratios = blurred[:-1] / sharp[:-1]
    tie = np.ptp(blurred[-1]) / sharp[METHODS.index(ACTIVE)]
    holds = (ours <= np.minimum(*theirs) + tie) & (ours <= MAX_BLUR_RATIO)
    medians = ", ".join(
        f"{m} {ratio:.3f}"
        for m, ratio in zip(METHODS, np.median(ratios, axis=1), strict=True)
    )
    return Reading.of_seeds(
        holds,
        median_and_range(ours),
        "1",
        f"median ratios over {len(ours)} sets: {medians}; a tie is up to "
        f"{np.median(tie):.3f}; holds in {int(holds.sum())}",
    )


@claim(
    "c3_active_viewing_angle",
    needs=("exp_c3_active_viewing_angle",),
    evidence="rendered",
    readings=("decodable", "camera_file"),
)
def judge_active_viewing_angle(results, options):
    """The decoded share of the visible area falls as the monitor rotates."""
    result = results["exp_c3_active_viewing_angle"]
    turns = sorted(result.levels("turn_deg"))
    name, gamma = DECODABLE[options["decodable"]], GAMMAS[options["camera_file"]]

    def shares(turn, falloff=2):
        shown = {"falloff_exponent": falloff, "camera_gamma": gamma}
        return result.select(turn_deg=turn, **shown).column(name)

    found = np.array([shares(turn) for turn in turns])
    fall = np.round(found[0] - found[-1], 9)
    holds = [
        drop > MIN_FALL and spearmanr(turns, along)[0] <= MAX_RANK
        for drop, along in zip(fall, found.T, strict=True)
    ]
    reason = f"fall of the share from 0 to {turns[-1]} deg, median and range over "
    reason += f"{len(fall)} simulated runs; holds in {sum(holds)}"
    if gamma > 1:
        plain = found[0] - shares(turns[-1], falloff=0)
        reason += f"; a monitor without fall-off loses {np.median(plain):.3f}"
    return Reading.of_seeds(holds, median_and_range(fall), "1", reason)
