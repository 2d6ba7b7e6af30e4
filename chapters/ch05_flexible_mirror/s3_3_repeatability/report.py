"""Results of this page read: values of the prose, figures, tables."""

from types import SimpleNamespace

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.experiment import (
    ARMS,
    KEPT,
    LOOP,
    OUT,
    update_seconds,
)
from chapters.shared.mirror import STAGES_MM, BenchRuns, mirror_rig, reached
from raxel.calibration import MAX_SWING_DEG
from raxel.geometry import intersect_rays_plane, on_plane, transform
from raxel.show import Polyline, Scene, Segments, Surface, framed, frustum
from raxel.show import board as board_mesh
from repro.page import INK, new_figure, series
from repro.page import value as name_value
from repro.page.film import pictured
from repro.page.space import draw_scene, scene_frames
from repro.run import (
    Check,
    Drawing,
    Film,
    Panel,
    Table,
    Value,
    columns,
    figure,
    median_and_range,
    numbers,
    ratio_of,
    table,
)

# The runs out and back: result, error level and step.


RUNS, SWEPT_RUNS = "table_5_5_runs", "table_5_5_swept"
JUDGED = ("table_5_5_runs", "table_5_5_swept")
METRIC, FILM = "exp_c5_metric_fit_helps", "ext_mirror_film_pictures"
STEPS = tuple(range(1, len(LOOP)))
STEP_NAMES = tuple(f"step{step}" for step in STEPS)
THERE, BACK = STEPS[:OUT], STEPS[OUT:]
# Steps out, each with the step back that reverses it.
EQUIVALENT = tuple(zip(THERE, reversed(BACK), strict=True))
STEP_MM = STAGES_MM[1] - STAGES_MM[0]
WHOLE_MM = STAGES_MM[-1] - STAGES_MM[0]
SCALE = 10  # of the vectors of Fig. 5.13
PANELS = {
    "start": "(a) stage 0, before",
    "step3": "(b) stage 3, three steps",
    "step6": "(c) stage 0, six steps",
    "single": "(d) stage 0, three and one",
}


class LoopRuns(BenchRuns):
    """The loop out and back, and the single step back.

    Places of a run are "start", "step1" to "step6", and "single".
    """

    EXPERIMENTS = (RUNS, SWEPT_RUNS)
    SWINGS = STEP_NAMES

    def goes_on(self, place):
        """Extends that of all runs; the single step starts after the third step."""
        if place != "single":
            return super().goes_on(place)
        swings = self.result.column(self.bench, place, "swing_deg") >= MAX_SWING_DEG
        swings &= self["swinging_ends"]
        return super().goes_on(STEP_NAMES[OUT - 1]) & ~swings

    @property
    def completed(self):
        """Which runs (runs,) completed all six steps."""
        return np.isfinite(self.at_place(STEP_NAMES[-1], "back_mm"))

    def at(self, name, steps=STEPS):
        """A value (steps, runs) of several steps."""
        return np.array([self.at_place(STEP_NAMES[step - 1], name) for step in steps])

    def vectors(self, place):
        """Indices (n,) of the runs that reached a place, and the errors of the board's
        corners, n times (N, 2) mm, NaN where one was not visible."""
        reached = np.isfinite(self.result.column(self.bench, place, "back_mm"))
        return np.flatnonzero(reached), self.result.arrays(self.bench, place, "own")

    @property
    def board_mm(self):
        """Corners (N, 2) of the board."""
        return self.result.arrays(self.bench, "board_mm")[0]


# Quantities of each run out and back, and the bounds of the claims.


def disagreement(runs):
    """Largest difference of equivalent steps, %, (runs,)."""
    out, back = runs.at("deflection_mm")[np.subtract(EQUIVALENT, 1).T]
    both = np.array([out, back])
    return (100 * (both.max(axis=0) / both.min(axis=0) - 1)).max(axis=0)


def loop_error(runs):
    """All steps out less all steps back, mm, (runs,), without sign."""
    found = runs.at("deflection_mm")
    return np.abs(found[:OUT].sum(axis=0) - found[OUT:].sum(axis=0))


def single_difference(runs):
    """Difference of the single step from the three back, %, (runs,), without sign."""
    staged = runs.at("deflection_mm", BACK).sum(axis=0)
    return 100 * np.abs(runs.at_place("single", "deflection_mm") / staged - 1)


def height_errors(runs):
    """Error of the load's height after each step, mm, (steps, runs), signed.

    The height is the estimate of stage 0 with all steps added.
    """
    signs = np.where(np.isin(STEPS, THERE), 1.0, -1.0)[:, None]
    found = np.cumsum(signs * runs.at("deflection_mm"), axis=0)
    true = np.array([STAGES_MM[LOOP[step]] for step in STEPS])
    return found - true[:, None]


# The numbers that the page quotes: medians over completed runs.


def name_values(open_results):
    """Name the numbers of the prose."""
    runs = LoopRuns({RUNS: open_results(RUNS)})
    last = STEP_NAMES[-1]
    more = runs.at_place("single", "back_mm") / runs.at_place(last, "back_mm")
    quoted = {
        "single.worse": 100 * float(np.mean(more[np.isfinite(more)] > 1)),
        "angle.start": quoted_median(runs.at_place("start", "angle_deg")),
        "angle.end": quoted_median(runs.at_place(last, "angle_deg")),
        "film.update_ms": 1000 * update_seconds(),
    }
    third = open_results(METRIC).column(ARMS, STEP_NAMES[OUT - 1], "back_mm")
    for arm, found in zip(ARMS, third, strict=True):
        quoted[f"metric.{arm}.third"] = quoted_median(found)
    for name, number in quoted.items():
        name_value(name, number)


def quoted_median(found):
    """Median of the runs (runs,) that have a value, nan without any."""
    return median_and_range(found).value


# The film of the bending mirror, and its still.


TRUE, FOUND, CORNER = INK, series(1)["color"], "#00b3ff"
LATER = {"color": "#c8ccd2", "lw": 1.2, "marker": ""}
# Images of the film: inches and dots per inch; pixels of the scene in space.
FRAME_IN, FRAME_DPI, SPACE_PX = (4.2, 3.0), 92, (480, 344)
SILVER, SIGHT_COLOUR, RAY, EDGE = "#9fb4c7", "#aeb6c0", "#0072b2", "#d55e00"
# View from above, behind the mirror.
SIGHT, UP, BODY_MM, ASPECT = (-0.55, 0.75, -0.4), (0.0, -1.0, 0.0), 45.0, 1.4
IN_FRAMES = (
    "true_mm", "found_mm", "angle_deg", "used", "picture", "corners", "mirror",
    "directions", "profile", "T_camera_board",
)  # fmt: skip
# Points across and along the sheet whose rays are drawn.
ACROSS, ALONG = (0, 4, 8), (1, 11, 21, 31)


def frames_of(result):
    """The film's only trial, a row for each of n frames.

    true_mm, found_mm, angle_deg, error_um (n,); used (n,) corners; picture (n, h, w)
    uint8; corners (n, N, 2) px of the whole image; mirror, directions (n, a, b, 3);
    profile (n, b, 2) mm; T_camera_board (4, 4); peak: number of the frame with the
    largest deflection.
    """
    frames = SimpleNamespace(**{name: result.arrays(name)[0] for name in IN_FRAMES})
    frames.error_um = 1000 * (frames.found_mm - frames.true_mm)
    frames.peak = int(np.argmax(frames.true_mm))
    return frames


def scenes_of(rig, frames):
    """The Scene of each frame, all from one viewpoint."""
    T = frames.T_camera_board
    fixed = [frustum(rig.viewer, BODY_MM, label=""), *board_mesh(rig.board, T)]
    moving = [
        moving_parts(mirror, directions, T)
        for mirror, directions in zip(frames.mirror, frames.directions, strict=True)
    ]
    whole = [*fixed, *moving[0], *moving[frames.peak]]
    view = framed(whole, SIGHT, UP, aspect=ASPECT)
    return [
        Scene([*fixed, *parts], view.view_from, view.look_at, UP, "", ASPECT)
        for parts in moving
    ]


def moving_parts(mirror, directions, T_camera_board):
    """Mirror (a, b, 3) with scene rays (a, b, 3), and their outline on the board."""
    rays = mirror.reshape(-1, 3), directions.reshape(-1, 3)
    met = on_plane(intersect_rays_plane(*rays, T_camera_board).points)
    met = transform(T_camera_board, met).reshape(mirror.shape)
    some = np.ix_(ACROSS, ALONG)
    starts, ends = mirror[some].reshape(-1, 3), met[some].reshape(-1, 3)
    rim = [met[0], met[1:, -1], met[-1, -2::-1], met[-2::-1, 0]]
    return [
        Surface(mirror, SILVER, 0.8, ""),
        Segments(np.zeros_like(starts), starts, SIGHT_COLOUR, "", 1.0),
        Segments(starts, ends, RAY, "", 1.4),
        Polyline(np.concatenate(rim), EDGE, "", 3.0),
    ]


@figure("ext_mirror_film", needs=("ext_mirror_film_pictures",), evidence="rendered",
        scene=True)  # fmt: skip
def film_figure(results):
    """A still of the film at its largest deflection, and the film."""
    frames = frames_of(results[FILM])
    scenes = scenes_of(mirror_rig("A", small=True), frames)
    still = frames.peak
    drawn, axes = new_figure(2, 2, height_in=6.0)
    draw_image(axes[0, 1], frames, still)
    draw_profile(axes[1, 0], frames, still)
    draw_error(axes[1, 1], frames, still)
    for panel, letter in zip(axes.flat, "abcd", strict=True):
        panel.set_title(f"({letter})")
    draw_scene(axes[0, 0], scenes[still])
    numbers_of_frames = (
        range(len(frames.used)), frames.true_mm, frames.found_mm, frames.angle_deg,
        frames.used,
    )  # fmt: skip
    return Drawing(
        drawn,
        columns(
            ("frame", "true_mm", "found_mm", "angle_deg", "corners"),
            list(zip(*numbers_of_frames, strict=True)),
        ),
        "A bending mirror and the calibration that follows it, image by image: the "
        f"frame at {frames.true_mm[still]:g} mm. (a) Camera, estimated mirror, rays "
        "(grey, then blue), and the part of the board's plane that the mirror shows "
        "(orange). (b) Camera image with the tracked corners. (c) Profile of the "
        "mirror's middle line, true and estimated. (d) Error of the deflection over "
        "the film.",
        scene=film_of(frames, scenes),
    )


def film_of(frames, scenes):
    """The Film of all frames."""
    count = range(len(scenes))
    panels = [
        Panel("In space", "Camera, bending mirror, rays and board; an orange outline "
              "on the board, what the mirror shows of it, widens and narrows.",
              scene_frames(scenes, SPACE_PX))
    ]  # fmt: skip
    panels += [
        Panel(title, words, [_alone(draw, frames, k) for k in count])
        for draw, title, words in (
            (draw_image, "Camera image", "A board in the mirror, its corners "
             "marked where they were tracked."),
            (draw_profile, "Profile of the mirror", "Height of the mirror's middle "
             "line over the flat sheet, true and estimated."),
            (draw_error, "Error of the deflection", "Estimated minus true deflection "
             "over the film, up to the frame that is shown."),
        )
    ]  # fmt: skip
    labels = [
        f"Frame {k + 1} of {len(count)}: deflection {frames.true_mm[k]:.2f} mm, "
        # Without a minus before zero.
        f"estimated {round(float(frames.found_mm[k]), 2) + 0:.2f} mm; "
        f"{int(frames.used[k])} corners, ray error {frames.angle_deg[k]:.3f} degrees"
        for k in count
    ]
    return Film(panels, labels)


def _alone(draw, frames, k):
    drawn, axes = new_figure(height_in=FRAME_IN[1])
    drawn.set_size_inches(*FRAME_IN)
    draw(axes, frames, k)
    return pictured(drawn, FRAME_DPI)


def draw_image(axes, frames, k):
    """Draw the camera's image with the corners of frame k."""
    axes.imshow(frames.picture[k], cmap="gray", vmin=0, vmax=255)
    # Pixel centres at whole numbers, in the stored image as in the camera's.
    places = KEPT * (frames.corners[k] + 0.5) - 0.5
    axes.plot(*places.T, "o", mfc="none", mec=CORNER, ms=4, mew=1.0)
    axes.set_axis_off()


def draw_profile(axes, frames, k):
    """Draw the height of the middle line, true and estimated, in frame k."""
    sheet = mirror_rig("A", small=True).camera(float(frames.true_mm[k])).mirror
    flat = np.linspace(0, sheet.end, 81)
    axes.plot(
        flat, sheet.height(flat, 0 * flat)[0], color=TRUE, marker="", label="true"
    )
    axes.plot(*frames.profile[k].T, ".", color=FOUND, ms=5, label="estimated")
    top = 1.15 * np.nanmax(frames.profile[..., 1])
    axes.set(xlim=(0, 1.03 * sheet.end), ylim=(-0.05 * top, top))
    axes.set(xlabel="Position along the flat sheet (mm)", ylabel="Height (mm)")
    axes.legend(loc="upper left")


def draw_error(axes, frames, k):
    """Draw the error of the deflection up to frame k; later frames are pale."""
    time = np.arange(len(frames.true_mm)) + 1
    axes.axhline(0, color=TRUE, lw=0.8, marker="")
    axes.plot(time, frames.error_um, **LATER)
    axes.plot(time[: k + 1], frames.error_um[: k + 1], ".-", color=FOUND, lw=1.4)
    axes.plot(time[k], frames.error_um[k], "o", color=FOUND, ms=7)
    axes.set(xlabel="Frame", ylabel="Deflection error (µm)")


# Fig. 5.13: back-projection errors along the loop.


MARGIN_MM = 10.0
ROUNDING = 1e-9


@figure("fig_5_13", needs=("table_5_5_runs",), evidence="rendered")
def fig_5_13(results):
    """Vectors from the corners of a board to where their rays meet it, times ten."""
    runs = LoopRuns(results)
    drawn, axes = new_figure(2, 2, height_in=4.4, sharex=True, sharey=True)
    first = np.flatnonzero(np.isfinite(runs.at_place("single", "back_mm")))[0]
    rows, gaps, ends = [], [], []
    for panel, (place, title) in zip(axes.flat, PANELS.items(), strict=True):
        reached, errors = runs.vectors(place)
        errors = errors[np.flatnonzero(reached == first)[0]]
        known = np.isfinite(errors).all(axis=1)
        corners, off = runs.board_mm[known], errors[known]
        panel.plot(*corners.T, ls="", marker=".", ms=2.5, color=INK)
        panel.quiver(
            *corners.T, *(SCALE * off).T, angles="xy", scale_units="xy", scale=1,
            color=series(0)["color"], width=0.004,
        )  # fmt: skip
        mean = np.linalg.norm(off, axis=1).mean()
        panel.set_title(f"{title}: {mean:.2f} mm", fontsize=9.5)
        panel.set_aspect("equal")
        ends += [*corners, *(corners + SCALE * off)]
        gaps.append(abs(mean - runs.at_place(place, "back_mm")[first]))
        rows += [(place, *four) for four in np.column_stack([corners, off])]
    low, high = np.min(ends, axis=0) - MARGIN_MM, np.max(ends, axis=0) + MARGIN_MM
    axes[0, 0].set(xlim=(low[0], high[0]), ylim=(high[1], low[1]))
    for panel in axes[-1]:
        panel.set_xlabel("Board x (mm)")
    for panel in axes[:, 0]:
        panel.set_ylabel("Board y (mm)")
    return Drawing(
        drawn,
        columns(("panel", "x_mm", "y_mm", "off_x_mm", "off_y_mm"), rows),
        "Back-projection errors on a board at 400 mm in the pose fitted by the "
        f"calibrated camera, scaled by {SCALE}: the first completed run at the second "
        "solved level. Mean lengths above the panels.",
        Check(
            bool(max(gaps) < ROUNDING),
            f"the drawn vectors have the mean lengths of the trial, to {max(gaps):.0e} "
            "mm",
        ),
    )


# Table 5.5 with its numbers and those of Fig. 5.13, and the sensitivity table.


SET = "the steps of the rig are these: put in, not found"
# Names of states of the loop in the registry's ids -> names in the results.
PLACES = {"stage0_primary": "start", "stage3": "step3", "stage0_after6": "step6"}
COLUMNS = {
    "linear": "linear_mm",
    "final": "deflection_mm",
    "res_mean": "residual_mm",
    "res_sd": "residual_sd_mm",
}


def _median(found, unit):
    """Median of the runs that have a value, with the number of others, as a Value."""
    known = found[np.isfinite(found)]
    lost = len(found) - len(known)
    reason = f"{lost} of {len(found)} runs were rejected before" if lost else ""
    return Value.median(known if len(known) else found, unit, reason)


@numbers("table_5_5", needs=("table_5_5_runs",), evidence="rendered")
def numbers_table_5_5(results):
    """Cells of the table, and the text's numbers: medians over runs."""
    runs = LoopRuns(results)
    found = {}
    for step, place in zip(STEPS, STEP_NAMES, strict=True):
        found[f"t5_5_step{step}_actual"] = Value(STEP_MM, unit="mm", put_in=SET)
        for column, name in COLUMNS.items():
            found[f"t5_5_step{step}_{column}"] = _median(
                runs.at_place(place, name), "mm"
            )
    # The registry has shorter ids for the single step.
    for end, name in zip(("lin", "fin", "res_mean", "res_sd"), COLUMNS.values(),
                         strict=True):  # fmt: skip
        found[f"s5_rep_single_{end}"] = _median(runs.at_place("single", name), "mm")
    loop = loop_error(runs)
    return found | {
        "s5_rep_agree": _median(disagreement(runs), "%"),
        "s5_rep_hyst_mm": _median(loop, "mm"),
        "s5_rep_hyst_pct": _median(100 * loop / WHOLE_MM, "%"),
        "s5_rep_staged": _median(runs.at("deflection_mm", BACK).sum(axis=0), "mm"),
        "s5_rep_single_pct": _median(single_difference(runs), "%"),
    }


@numbers("fig_5_13", needs=("table_5_5_runs",), evidence="rendered")
def numbers_fig_5_13(results):
    """Back-projection errors in the fitted pose: medians over runs."""
    runs = LoopRuns(results)
    found = {
        f"s5_rep_{name}_{statistic}": _median(runs.at_place(place, column), "mm")
        for name, place in (
            *((f"bp_{name}", place) for name, place in PLACES.items()),
            ("single_bp", "single"),
        )
        for statistic, column in (("mean", "back_mm"), ("sd", "back_sd_mm"))
    }
    after, before = runs.at("back_mm", (STEPS[-1], STEPS[0]))
    done = np.isfinite(after + before)
    increase = Value(np.nan, unit="%")
    if done.any():
        ratio = ratio_of("median", after[done], before[done], paired=True)
        more, low, high = (100 * (number - 1) for number in ratio[:3])
        increase = Value(more, (low, high), "%")
    return found | {
        "s5_rep_bp_increase": increase,
        "fig5_13_scale": Value(SCALE, unit="x"),
    }


@table("table_5_5", needs=("table_5_5_runs",), evidence="rendered")
def table_5_5(results):
    """Steps by stage: deflections, residuals, and errors against the truth."""
    runs = LoopRuns(results)
    measures = [runs.at(name) for name in COLUMNS.values()]
    measures.append(np.abs(height_errors(runs)))
    measures += [runs.at(name) for name in ("angle_deg", "back_true_mm")]
    rows = [
        (LOOP[step], STEP_MM, *(reached(found[step - 1]) for found in measures))
        for step in STEPS
    ]
    names = (
        "Stage",
        "Actual (mm)",
        "Linear estimate (mm)",
        "Final estimate (mm)",
        "Residual, mean (mm)",
        "Residual, SD (mm)",
        "Error of the height at the load (mm)",
        "Angle to true rays (°)",
        "Back-projection, true pose (mm)",
    )
    printed = dict(zip(names[1:6], ("actual", *COLUMNS), strict=True))
    return Table(
        columns(names, rows),
        "Deflections and errors of three steps of 5 mm out and three back, second "
        f"solved level: medians over the {runs.completed.sum()} of {runs.seeds} "
        "completed runs, with 95 % intervals. The three columns on the right require "
        "the truth, which the thesis did not have: absolute error of the height, as "
        "the sum of all steps; mean angle of the rays to the true ones; and "
        "back-projection error on a board at 400 mm in its true pose.",
        printed={
            name: [f"t5_5_step{step}_{column}" for step in STEPS]
            for name, column in printed.items()
        },
    )
