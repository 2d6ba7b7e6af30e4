"""Results of this page read: values of the prose, figures, tables, judgements."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.experiment import MAGNIFIED, METHODS
from chapters.shared.central import (
    FISH,
    LEVEL_NAMES,
    MATCHED,
    OMNI,
    OPTIONS,
    CentralRuns,
    judged_by_run,
    over_the_sweep,
)
from chapters.shared.methods import LINEAR_NAMES
from repro.page import look_of, new_figure, value
from repro.run import (
    Case,
    Drawing,
    Measured,
    Reading,
    Table,
    Value,
    all_of,
    claim,
    columns,
    figure,
    median_interval,
    numbers,
    table,
    wins,
    with_worst,
)

# The experiments of section 4.3.2b, and the numbers of the text.


BOARDS, LINES = "fig_4_9_boards", "fig_4_7_lines"
NAMES = {method: LINEAR_NAMES[stage] for method, stage in METHODS.items()}
QUESTIONS = {
    "decoding_noise": OPTIONS,
    "standard_method": {"as printed": "printed", "well conditioned": "conditioned"},
}
CAMERAS = {"omni": OMNI, "fish": FISH}
STATISTICS = {"mean": "mean_mm", "sd": "sd_mm"}
PRINTED_METHODS = {"printed": "std", "cgsp": "cgsp"}  # in the ids of the registry


def name_values(open_results):
    """Name the numbers that the text quotes: medians of the trials with a value."""
    boards, lines = open_results(BOARDS), open_results(LINES)
    for short, camera in CAMERAS.items():
        for method in ("printed", "cgsp"):
            means = boards.select(camera=camera).column("laboratory", method, "mean_mm")
            value(f"lab.{short}.{method}.mean", np.nanmedian(means))
        worst = lines.select(camera=camera).column(MATCHED, "cgsp", "worst_share")
        value(f"{short}.cgsp.worst", 100 * np.nanmedian(worst))


# Figs 4.7 to 4.9: a corrected room, and residuals of a chessboard.


KEY_MM = 0.2  # of the arrow that shows the scale
MAX_GREY = 30.0  # limit of the colours of a difference
FRAMES = {
    "original": ("frame_0", "frame_1"),
    "standard": ("printed_0", "printed_1"),
    "CGSP": ("cgsp_0", "cgsp_1"),
}
LETTERS = ("ab", "cd", "ef", "gh")  # row by row


def _images(results, camera, height_in):
    """Draw original frames, standard, CGSP and their difference: four rows of two."""
    result = results["fig_4_7_pictures"].one(camera=camera)
    drawn, axes = new_figure(len(LETTERS), 2, height_in=height_in)
    rows = []
    for frame, column in enumerate(axes.T):
        letters = [pair[frame] for pair in LETTERS]
        shown = {words: result.arrays(keys[frame]) for words, keys in FRAMES.items()}
        for panel, letter, (words, image) in zip(
            column[:-1], letters[:-1], shown.items(), strict=True
        ):
            panel.set_title(f"({letter}) {words}, frame {frame + 1}")
            panel.set_axis_off()
            if image:
                panel.imshow(image[0], cmap="gray", vmin=0, vmax=255)
                rows.append((letter, float(image[0].mean()), None))
        column[-1].set_axis_off()
        if shown["standard"] and shown["CGSP"]:
            off = difference(shown["standard"][0], shown["CGSP"][0])
            colours = column[-1].imshow(off, cmap="RdBu", vmin=-MAX_GREY, vmax=MAX_GREY)
            rms = float(np.sqrt(np.nanmean(off**2)))
            column[-1].set_title(f"({letters[-1]}) CGSP − standard, RMS {rms:.1f}")
            rows.append((letters[-1], None, rms))
    if axes[-1, 0].images:
        bar = drawn.colorbar(
            colours,
            ax=axes[-1],
            location="bottom",
            shrink=0.5,
            aspect=40,
            extend="both",
        )
        bar.set_label("Difference (grey levels)")
    return drawn, columns(("panel", "mean_grey", "rms_difference_grey"), sorted(rows))


def difference(printed, cgsp):
    """Return CGSP minus standard (H, W), grey levels; NaN where either has no ray."""
    both = (printed > 0) & (cgsp > 0)
    return np.where(both, cgsp.astype(float) - printed, np.nan)


@figure("fig_4_7", needs=("fig_4_7_pictures",), evidence="rendered")
def fig_4_7(results):
    """Draw the mirror camera's image of a room, unwrapped by both calibrations."""
    drawn, data = _images(results, OMNI, height_in=7.6)
    return Drawing(
        drawn,
        data,
        "Images of a room by the omnidirectional camera: original, and the calibrated "
        "part unwrapped on a vertical cylinder about the camera centre, by the "
        "standard method as printed and adjusted, and by CGSP, at the thesis-matched "
        "level. Black: pixels without a ray. Last row: grey levels of CGSP minus "
        "standard, where both have a ray.",
    )


@figure("fig_4_8", needs=("fig_4_7_pictures",), evidence="rendered")
def fig_4_8(results):
    """Draw the fisheye's image of a room, corrected to a pinhole view."""
    drawn, data = _images(results, FISH, height_in=9.0)
    return Drawing(
        drawn,
        data,
        "Images of a room by the fisheye: original, and the central 100° corrected to "
        "a pinhole view, by the standard method as printed and adjusted, and by CGSP, "
        "at the thesis-matched level. Black: pixels without a ray. Last row: grey "
        "levels of CGSP minus standard.",
    )


@figure("fig_4_9", needs=("fig_4_9_boards",), evidence="rendered")
def fig_4_9(results):
    """Draw residual vectors of one board by camera and method."""
    result = results[BOARDS]
    drawn, axes = new_figure(2, 2, height_in=5.4, sharex=True, sharey=True)
    rows = []
    panels = product(((OMNI, "omnidirectional"), (FISH, "fisheye")), PRINTED_METHODS)
    for panel, letter, ((camera, words), method) in zip(
        axes.flat, "abcd", panels, strict=True
    ):
        found = result.select(camera=camera).arrays(MATCHED, method, "field")
        name = NAMES[method].partition(",")[0]
        panel.set(title=f"({letter}) {words}, {name}", aspect="equal")
        if not found:
            continue
        x, y, dx, dy = found[0][:, :4].T
        colour = look_of(NAMES[method])["color"]
        panel.plot(x, y, ".", color=colour, markersize=3)
        ends = np.column_stack([x + MAGNIFIED * dx, y + MAGNIFIED * dy])
        panel.update_datalim(ends)
        arrows = panel.quiver(
            x, y, MAGNIFIED * dx, MAGNIFIED * dy, angles="xy",
            scale_units="xy", scale=1, color=colour, width=0.004,
        )  # fmt: skip
        panel.quiverkey(
            arrows, 0.13, 0.07, MAGNIFIED * KEY_MM, f"{KEY_MM:g} mm", labelpos="E"
        )  # fmt: skip
        rows += [(camera, method, *row[:4]) for row in found[0]]
    for panel in axes[-1]:
        panel.set_xlabel("x (mm)")
    for panel in axes[:, 0]:
        panel.set_ylabel("y (mm)")
    return Drawing(
        drawn,
        columns(("camera", "method", "x_mm", "y_mm", "dx_mm", "dy_mm"), rows),
        "Residual vectors of one chessboard after distortion correction and a "
        f"homography to the metric grid, enlarged {MAGNIFIED} times (in the thesis, 15 "
        "times), at the thesis-matched level. The arrow at the lower left is the "
        "scale. Each panel shows the board of the first run with most calibrated "
        "rays.",
    )


# Table 4.4.


@table("table_4_4", needs=("fig_4_9_boards",), evidence="rendered")
def table_4_4(results):
    """Tabulate residual statistics of both cameras by method."""
    rows = list(product(LEVEL_NAMES, NAMES))
    cells, printed = {}, {}
    for (short, camera), (name, key) in product(CAMERAS.items(), STATISTICS.items()):
        words = {"mean": "mean", "sd": "SD"}[name]
        title = f"{camera.capitalize()}, {words} (mm)"
        trials = results[BOARDS].select(camera=camera)
        found = [trials.column(*row, key) for row in rows]
        cells[title] = [
            Measured.of_seeds(one) if np.isfinite(one).all() else None for one in found
        ]
        printed[title] = [
            f"t4_4_{short}_{PRINTED_METHODS[method]}_{name}"
            if noise == MATCHED and method in PRINTED_METHODS
            else None
            for noise, method in rows
        ]
    return Table(
        {
            "Noise level": [LEVEL_NAMES[noise] for noise, _ in rows],
            "Method": [NAMES[method] for _, method in rows],
            **cells,
        },
        "Residuals of chessboards after distortion correction: median, smallest and "
        "largest value of the rendered runs. The rays are intersected with the plane "
        "most nearly perpendicular to them, and a homography maps the points to the "
        "metric grid. The noise level is that of the decoded calibration grids.",
        printed=printed,
    )


# The claims of 4.3.2 about corrected images, and the numbers of Table 4.4.
#
# Most are judged trial by trial: a predicate takes the `CentralRuns` of an
# interpretation. It
# returns whether it is true (trials,), the measured value (trials,), its unit, and a
# reason.


MAX_BEND, MIN_GAIN, MAX_REMAINDER = 0.01, 1.05, 0.2
MIN_RATIO, EQUAL = 1.3, (0.85, 1.25)
MAX_BIAS, MIN_SEAM, MIN_CORRELATION = 0.25, 1.5, 0.3
STANDARD = ("decoding_noise", "standard_method")


@claim(
    "c4_lines_straight",
    needs=("fig_4_7_lines",),
    evidence="rendered",
    readings=STANDARD,
)
def judge_lines_straight(results, options):
    """Worst edge within 1 % for both methods; CGSP ahead, omnidirectional."""
    case = Case(QUESTIONS, options)
    methods = case["standard_method"], "cgsp"
    edges = list(product((OMNI, FISH), methods))

    def found_at(noise):
        runs = CentralRuns([results[LINES]], case, noise)
        shares = [runs.of(camera, one, "worst_share") for camera, one in edges]
        standard, cgsp = map(with_worst, shares[:2])
        return [median_interval(one) for one in shares], wins([(cgsp, standard)])[0]

    def reading_at(noise):
        worst, ahead = found_at(noise)
        at = int(np.argmax([found.value for found in worst]))
        camera, method = edges[at]
        return Reading.of(
            all_of([*(found.below(MAX_BEND) for found in worst), ahead.decision]),
            worst[at].times(100),
            "%",
            f"largest deviation of an edge from its line, of its length: {camera}, "
            f"{method}; standard / CGSP of the omnidirectional camera "
            f"{ahead.ratio.value:.3f} ({ahead.ratio.low:.3f} to "
            f"{ahead.ratio.high:.3f})",
        )

    def straight_and_ahead(noise):
        worst, ahead = found_at(noise)
        straight = all(found.value < MAX_BEND for found in worst)
        return straight and ahead.ratio.value >= MIN_GAIN

    return over_the_sweep(case, reading_at, straight_and_ahead)


@claim(
    "c4_unwrap_fov", needs=("fig_4_7_lines",), evidence="rendered", readings=STANDARD
)
@judged_by_run(QUESTIONS, LINES)
def less_view(lines):
    """Less vertical view with the standard method, and its depth is why."""
    own, cgsp = lines.both(OMNI, "vertical_deg")
    same, _ = lines.both(OMNI, "equal_depth_deg")
    less = cgsp - own
    remainder = np.abs(cgsp - same) / np.abs(less)
    return (
        (less > 0) & (remainder <= MAX_REMAINDER),
        less,
        "deg",
        "CGSP's vertical view less the standard one's; with equal depth "
        f"{100 * np.nanmedian(remainder):.0f} % of the difference is left",
    )


def ratios(boards, camera, *path):
    """Return standard over CGSP, (..., trials); a failed standard is the worst."""
    standard, cgsp = boards.both(camera, *path)
    return with_worst(standard) / cgsp


@claim("c4_t44_omni", needs=("fig_4_9_boards",), evidence="rendered", readings=STANDARD)
@judged_by_run(QUESTIONS, BOARDS)
def larger_residuals(boards):
    """Mean and SD of the standard residuals at least 1.3 times CGSP's."""
    mean, spread = ratios(boards, OMNI, ("mean_mm", "sd_mm"))
    return (
        (mean >= MIN_RATIO) & (spread >= MIN_RATIO),
        mean,
        "",
        f"ratio of the means; of the SDs {np.median(spread):.3f}",
    )


@claim("c4_t44_fish", needs=("fig_4_9_boards",), evidence="rendered", readings=STANDARD)
@judged_by_run(QUESTIONS, BOARDS)
def equal_residuals(boards):
    """The means of the fisheye are nearly equal."""
    mean = ratios(boards, FISH, "mean_mm")
    return (mean >= EQUAL[0]) & (mean <= EQUAL[1]), mean, "", "ratio of the means"


@claim(
    "c4_no_radial_bias",
    needs=("fig_4_9_boards",),
    evidence="rendered",
    readings=STANDARD,
)
@judged_by_run(QUESTIONS, BOARDS)
def no_radial_bias(boards):
    """No quintile of radius has a mean radial residual of a quarter RMS."""
    worse = with_worst(boards.both(OMNI, "radial_bias")).max(axis=0)
    return (
        worse <= MAX_BIAS,
        worse,
        "",
        "largest mean radial residual of a quintile over the RMS, the worse of both "
        "methods",
    )


@claim("c4_seams", needs=("fig_4_9_boards",), evidence="rendered", readings=STANDARD)
@judged_by_run(QUESTIONS, BOARDS)
def seams(boards):
    """Standard residuals are larger near seams, CGSP's less so."""
    own, cgsp = boards.both(OMNI, "seam_ratio")
    return (
        (own > MIN_SEAM) & (cgsp < own),
        own,
        "",
        f"mean residual near seams over that elsewhere; CGSP {np.nanmedian(cgsp):.2f}",
    )


@claim(
    "c4_skew_amplifies",
    needs=("fig_4_9_boards",),
    evidence="rendered",
    readings=STANDARD,
)
@judged_by_run(QUESTIONS, BOARDS)
def skew(boards):
    """Residuals of the fisheye rise with the angle to the plane's normal."""
    smaller = boards.both(FISH, "skew_spearman").min(axis=0)
    return (
        smaller >= MIN_CORRELATION,
        smaller,
        "",
        "rank correlation of angle and residual, the smaller of both methods",
    )


@numbers("table_4_4", needs=("fig_4_9_boards",), evidence="rendered")
def numbers_of_table_4_4(results):
    """Mean and SD of the residuals, the standard method as printed."""
    boards = CentralRuns([results[BOARDS]], Case(QUESTIONS))
    return {
        f"t4_4_{short}_{name}_{statistic}": Value.of_seeds(
            boards.of(camera, method, key), "mm"
        )
        for short, camera in CAMERAS.items()
        for method, name in PRINTED_METHODS.items()
        for statistic, key in STATISTICS.items()
    }


@numbers("fig_4_9", needs=("fig_4_9_boards",), evidence="rendered")
def numbers_of_fig_4_9(results):
    """How much longer than they are the vectors are drawn."""
    return {"fig4_9_scale": Value(results[BOARDS].settings["magnified"], unit="x")}
