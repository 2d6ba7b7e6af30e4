"""Results of this page read: values of the prose, figures, tables, judgements."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.experiment import MAGNIFIED, METHODS
from chapters.shared.central import (
    BENCH,
    FISH,
    OMNI,
    OPTIONS,
    judged_by_seed,
    over_the_sweep,
)
from chapters.shared.methods import LINEAR_NAMES
from repro.page import look_of, new_figure, value
from repro.run import (
    Case,
    Drawing,
    Estimate,
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

# Results of section 4.3.2b in one interpretation, and the numbers of the text.


BOARDS, LINES = "fig_4_9_boards", "fig_4_7_lines"
NAMES = {method: LINEAR_NAMES[stage] for method, stage in METHODS.items()}
READINGS = {
    "decoding_noise": OPTIONS,
    "standard_method": {"as printed": "printed", "well conditioned": "conditioned"},
}


class Corrected(Case):
    """Trials of one experiment in one interpretation, at one noise level."""

    def __init__(self, result, options=None, noise=BENCH):
        super().__init__(READINGS, options)
        self.result, self.noise = result, noise

    def of(self, camera, name):
        """Return a value of each trial of a camera, (trials,)."""
        return self.result.select(camera=camera).column(f"{self.noise}.{name}")

    def both(self, camera, name):
        """Return a value of the standard method and of CGSP, (2, trials)."""
        methods = self["standard_method"], "cgsp"
        return np.array([self.of(camera, f"{m}.{name}") for m in methods])

    def ratio(self, camera, name):
        """Return standard over CGSP, (trials,); a failed standard run is the worst."""
        standard, cgsp = self.both(camera, name)
        return with_worst(standard) / cgsp


def name_values(open_results):
    """Name the numbers that the text quotes: medians of the trials with a value."""
    boards, lines = open_results(BOARDS), open_results(LINES)

    def median(result, noise, camera, name):
        return np.nanmedian(Corrected(result, noise=noise).of(camera, name))

    cameras = {"omni": OMNI, "fish": FISH}
    for short, camera in cameras.items():
        for method in ("printed", "cgsp"):
            mean = median(boards, "laboratory", camera, f"{method}.mean_mm")
            value(f"lab.{short}.{method}.mean", mean)
        worst = median(lines, BENCH, camera, "cgsp.worst_share")
        value(f"{short}.cgsp.worst", 100 * worst)


# Figs 4.7 to 4.9: a corrected room, and residuals of a chessboard.


KEY_MM = 0.2  # of the arrow that shows the scale
MAX_GREY = 30.0  # limit of the colours of a difference
PANELS = (
    ("(a) omnidirectional, standard", OMNI, "printed"),
    ("(b) omnidirectional, CGSP", OMNI, "cgsp"),
    ("(c) fisheye, standard", FISH, "printed"),
    ("(d) fisheye, CGSP", FISH, "cgsp"),
)
FIGURES_METHODS = {"printed": "standard, as printed", "cgsp": "CGSP"}
ROWS = (("frame", "original"), ("printed", "standard"), ("cgsp", "CGSP"))
FRAMES = 2
LETTERS = ("ab", "cd", "ef", "gh")  # row by row


def _images(results, camera, height_in):
    """Draw original frames, standard, CGSP and their difference: four rows of two."""
    result = results["fig_4_7_pictures"]
    drawn, axes = new_figure(len(ROWS) + 1, FRAMES, height_in=height_in)
    rows = []
    for number, (name, words) in enumerate(ROWS):
        for frame, panel in enumerate(axes[number]):
            letter = LETTERS[number][frame]
            panel.set_title(f"({letter}) {words}, frame {frame + 1}")
            panel.set_axis_off()
            found = result.arrays(f"{name}_{frame}", camera=camera)
            if found:
                panel.imshow(found[0], cmap="gray", vmin=0, vmax=255)
                rows.append((letter, float(found[0].mean()), None))
    for frame, panel in enumerate(axes[-1]):
        letter = LETTERS[-1][frame]
        panel.set_axis_off()
        printed, cgsp = (
            result.arrays(f"{name}_{frame}", camera=camera)
            for name in ("printed", "cgsp")
        )
        if printed and cgsp:
            off = difference(printed[0], cgsp[0])
            shown = panel.imshow(off, cmap="RdBu", vmin=-MAX_GREY, vmax=MAX_GREY)
            rms = float(np.sqrt(np.nanmean(off**2)))
            panel.set_title(f"({letter}) CGSP − standard, RMS {rms:.1f}")
            rows.append((letter, None, rms))
    if axes[-1, 0].images:
        bar = drawn.colorbar(
            shown, ax=axes[-1], location="bottom", shrink=0.5, aspect=40, extend="both"
        )
        bar.set_label("Difference (grey levels)")
    return drawn, columns(("panel", "mean_grey", "rms_difference_grey"), rows)


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
    for panel, (title, camera, method) in zip(axes.flat, PANELS, strict=True):
        found = result.select(camera=camera).arrays(f"{BENCH}.{method}.field")
        panel.set(title=title, aspect="equal")
        if not found:
            continue
        x, y, dx, dy = found[0][:, :4].T
        colour = look_of(FIGURES_METHODS[method])["color"]
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


NOISES = {"thesis-matched": BENCH, "low-noise": "laboratory"}
COLUMNS = {
    "Omnidirectional, mean (mm)": (OMNI, "mean"),
    "Omnidirectional, SD (mm)": (OMNI, "sd"),
    "Fisheye, mean (mm)": (FISH, "mean"),
    "Fisheye, SD (mm)": (FISH, "sd"),
}
# Cameras, and methods of the thesis, in the ids of the registry.
PRINTED_CAMERAS = {OMNI: "omni", FISH: "fish"}
PRINTED_METHODS = {"printed": "std", "cgsp": "cgsp"}


@table("table_4_4", needs=("fig_4_9_boards",), evidence="rendered")
def table_4_4(results):
    """Tabulate residual statistics of both cameras by method."""
    rows = list(product(NOISES.items(), NAMES))
    cells = {
        title: [
            _cell(Corrected(results[BOARDS], noise=noise).of(camera, f"{m}.{name}_mm"))
            for (_, noise), m in rows
        ]
        for title, (camera, name) in COLUMNS.items()
    }
    printed = {
        title: [
            f"t4_4_{PRINTED_CAMERAS[camera]}_{PRINTED_METHODS[m]}_{name}"
            if m in PRINTED_METHODS and noise == BENCH
            else None
            for (_, noise), m in rows
        ]
        for title, (camera, name) in COLUMNS.items()
    }
    return Table(
        {
            "Noise level": [words for (words, _), _ in rows],
            "Method": [NAMES[m] for _, m in rows],
            **cells,
        },
        "Residuals of chessboards after distortion correction: median, smallest and "
        "largest value of the rendered runs. The rays are intersected with the plane "
        "most nearly perpendicular to them, and a homography maps the points to the "
        "metric grid. The noise level is that of the decoded calibration grids.",
        printed=printed,
    )


def _cell(found):
    return Measured.of_seeds(found) if np.isfinite(found).all() else None


# The claims of 4.3.2 about corrected pictures, and the numbers of Table 4.4.
#
# Most are judged trial by trial: a predicate takes the `Corrected` trials of a reading
# and returns whether it is true (trials,), what was measured (trials,), its unit, and
# words.


STRAIGHT, MIN_GAIN = 0.01, 1.05
LINES_ALONE = ("fig_4_7_lines",)
BOARDS_ALONE = ("fig_4_9_boards",)
STANDARD = ("decoding_noise", "standard_method")
REMOVED = 0.2
MIN_RATIO, EQUAL = 1.3, (0.85, 1.25)
MAX_BIAS, SEAM, SKEW = 0.25, 1.5, 0.3


def _lines(results, options, noise=BENCH):
    return Corrected(results[LINES], options, noise)


def _boards(results, options, noise=BENCH):
    return Corrected(results[BOARDS], options, noise)


@claim("c4_lines_straight", needs=LINES_ALONE, evidence="rendered", readings=STANDARD)
def judge_lines_straight(results, options):
    """Worst edge within 1 % for both methods; CGSP ahead, omnidirectional."""

    def shares_at(noise):
        lines = Corrected(results[LINES], options, noise)
        methods = lines["standard_method"], "cgsp"
        return {
            (camera, method): lines.of(camera, f"{method}.worst_share")
            for camera, method in product((OMNI, FISH), methods)
        }

    def found_at(noise):
        shares = shares_at(noise)
        worst = {key: median_interval(found) for key, found in shares.items()}
        standard, cgsp = (with_worst(s) for (c, _), s in shares.items() if c == OMNI)
        return worst, wins([(cgsp, standard)])[0]

    def reading_at(noise):
        worst, ahead = found_at(noise)
        at = max(worst, key=lambda key: worst[key].value)
        return Reading.of(
            all_of([*(e.below(STRAIGHT) for e in worst.values()), ahead.decision]),
            Estimate(*(100 * end for end in worst[at][:3])),
            "%",
            f"largest deviation of an edge from its line, of its length: {at[0]}, "
            f"{at[1]}; standard / CGSP of the omnidirectional camera "
            f"{ahead.ratio.value:.3f} ({ahead.ratio.low:.3f} to "
            f"{ahead.ratio.high:.3f})",
        )

    def straight_and_ahead(noise):
        worst, ahead = found_at(noise)
        straight = all(found.value < STRAIGHT for found in worst.values())
        return straight and ahead.ratio.value >= MIN_GAIN

    return over_the_sweep(Case(READINGS, options), reading_at, straight_and_ahead)


@claim("c4_unwrap_fov", needs=LINES_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_lines)
def less_view(lines):
    """Less vertical view with the standard method, and its depth is why."""
    own, cgsp = lines.both(OMNI, "vertical_deg")
    same, _ = lines.both(OMNI, "equal_depth_deg")
    less = cgsp - own
    left = np.abs(cgsp - same) / np.abs(less)
    return (
        (less > 0) & (left <= REMOVED),
        less,
        "deg",
        "CGSP's vertical view less the standard one's; with equal depth "
        f"{100 * np.nanmedian(left):.0f} % of the difference is left",
    )


@claim("c4_t44_omni", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_boards)
def larger_residuals(boards):
    """Mean and SD of the standard residuals at least 1.3 times CGSP's."""
    mean, spread = (boards.ratio(OMNI, name) for name in ("mean_mm", "sd_mm"))
    return (
        (mean >= MIN_RATIO) & (spread >= MIN_RATIO),
        mean,
        "",
        f"ratio of the means; of the SDs {np.median(spread):.3f}",
    )


@claim("c4_t44_fish", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_boards)
def equal_residuals(boards):
    """The means of the fisheye are nearly equal."""
    mean = boards.ratio(FISH, "mean_mm")
    return (mean >= EQUAL[0]) & (mean <= EQUAL[1]), mean, "", "ratio of the means"


@claim("c4_no_radial_bias", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_boards)
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


@claim("c4_seams", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_boards)
def seams(boards):
    """Standard residuals are larger beside seams, CGSP's less so."""
    own, cgsp = boards.both(OMNI, "seam_ratio")
    return (
        (own > SEAM) & (cgsp < own),
        own,
        "",
        "mean residual beside seams over that elsewhere; CGSP "
        f"{np.nanmedian(cgsp):.2f}",
    )


@claim("c4_skew_amplifies", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_boards)
def skew(boards):
    """Residuals of the fisheye rise with the angle to the plane's normal."""
    least = boards.both(FISH, "skew_spearman").min(axis=0)
    return (
        least >= SKEW,
        least,
        "",
        "rank correlation of angle and residual, the smaller of both methods",
    )


@numbers("table_4_4", needs=BOARDS_ALONE, evidence="rendered")
def numbers_of_table_4_4(results):
    """Mean and SD of the residuals, the standard method as printed."""
    boards = Corrected(results[BOARDS])
    return {
        f"t4_4_{short}_{name}_{statistic}": Value.of_seeds(
            boards.of(camera, f"{method}.{statistic}_mm"), "mm"
        )
        for short, camera in (("omni", OMNI), ("fish", FISH))
        for name, method in (("std", "printed"), ("cgsp", "cgsp"))
        for statistic in ("mean", "sd")
    }


@numbers("fig_4_9", needs=BOARDS_ALONE, evidence="rendered")
def numbers_of_fig_4_9(results):
    """How much longer than they are the vectors are drawn."""
    drawn = results[BOARDS].settings["magnified"]
    return {"fig4_9_scale": Value(drawn, unit="x")}
