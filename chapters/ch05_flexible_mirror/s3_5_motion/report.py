"""Results of this page read: values of the prose, figures, tables."""

from typing import ClassVar

import numpy as np
from scipy.stats import rankdata

from chapters.ch05_flexible_mirror.s3_5_motion.experiment import (
    MARKER_MM,
    MARKS,
    RADIUS_MM,
    STEP_MM,
    STEPS,
    moved_cylinder,
    seen_by,
)
from chapters.shared.mirror import (
    CONTRASTED,
    LABORATORY,
    LEVEL,
    LEVEL_NAMES,
    MEDIANS,
    STAGES_MM,
    SWEPT,
    BenchRuns,
    middle,
    mirror_rig,
    reached,
)
from raxel.geometry import tangent_bases
from raxel.show import Points, Surface, framed
from repro.page import (
    INK,
    legend_below,
    look_of,
    new_figure,
    plot_estimates,
    series,
    value,
)
from repro.page.space import draw_scene
from repro.run import (
    Check,
    Drawing,
    Reading,
    Table,
    Value,
    all_of,
    bootstrap,
    columns,
    figure,
    median_interval,
    numbers,
    table,
)

# Runs of the moving cylinder: result, error level, camera, method and step.


RUNS, SWEPT_RUNS, LONGER = "table_5_7_runs", "table_5_7_swept", "table_5_7_longer"
JUDGED = ("table_5_7_runs", "table_5_7_swept")
# As in the thesis: calibration stage by stage, and step lengths estimated from rays.
CAMERA, WAY = "published", "open"
CAMERAS = ("true", "published")
EACH_STEP = range(1, STEPS + 1)
STEP_NAMES = tuple(f"step{k}" for k in EACH_STEP)
STAGES = range(len(STAGES_MM))
STAGE_NAMES = tuple(f"stage{stage}" for stage in STAGES)
LAST = len(STAGES_MM) - 1


class MotionRuns(BenchRuns):
    """Motions of the cylinder."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)
    ELSEWHERE: ClassVar = {"C": LONGER}

    def column(self, *path):
        """A value (..., runs) that a run has once."""
        return self.result.column(self.bench, *path)

    def of(self, name, camera=CAMERA, way=WAY):
        """A value (runs,) of a camera and a method."""
        return self.column(camera, way, name)

    def steps(self, name, camera=CAMERA, way=WAY):
        """A value (5, runs) after each step, all steps before added up."""
        return self.column(camera, way, STEP_NAMES, name)

    def scales(self, stage):
        """Mean estimated step over the true one, (runs,), at a stage."""
        path = (STAGE_NAMES[stage],) if stage < LAST else (CAMERA, WAY)
        return self.column(*path, "mean_mm") / STEP_MM

    def drawn_camera(self):
        """The published calibration, the true mirror where that has no cylinder."""
        has = np.isfinite(self.of("radius_mm"))
        return CAMERA if has.any() else "true"

    def middling(self, off):
        """Index of the run with a cylinder whose measure off (runs,) is the median."""
        has = np.isfinite(self.of("radius_mm", self.drawn_camera()))
        order = np.argsort(np.where(has, off, np.nan))
        return int(order[(np.count_nonzero(has) - 1) // 2])

    def array(self, name, seed):
        """An array of one run, None where it has none."""
        has = self._has(name)
        if not has[seed]:
            return None
        every = self.result.arrays(self.bench, name)
        return every[np.count_nonzero(has[:seed])]

    def _has(self, name):
        """Which runs (runs,) have an array: those with its number."""
        number = {"path": "mean_mm", "points": "radius_mm", "cylinder": "radius_mm"}
        owner, last = name.rsplit(".", 1)
        if owner == "marks":
            return np.ones(self.seeds, bool)
        return np.isfinite(self.column(owner, number[last]))


# Claims about the moving cylinder, for single runs and for all.
#
# Fixed before the first run, where the registered test is not specific: a translation
# is that of the point closest to all rays, of motions whose mean step is scaled to 25
# mm, as in Table 5.7; the cylinder has the same scale. A marker meets the scaled
# cylinder if its centre is within 3 mm; a mark that is not found misses it. Changed
# later: claims are judged on completed runs, and rejected ones are reported.


MAX_STEP_ERROR, MAX_END_MM = 0.05, 8.0
MAX_SCALED, MAX_UNSCALED = 0.10, 0.20
MAX_N_MISSED = 1
MAX_TREND = -0.8
MAX_SCALE_ERROR = 0.10
# Factor of a length that diverges or vanishes.
MAX_FACTOR = 100.0


def follows(runs, camera=CAMERA):
    """Every magnitude is within 5 %, and the final position within 8 mm."""
    true = STEP_MM * np.array(EACH_STEP)
    off = np.abs(runs.steps("length_mm", camera) / true[:, None] - 1)
    end = runs.steps("off_mm", camera)[-1]
    return (
        np.all(off <= MAX_STEP_ERROR, axis=0) & (end <= MAX_END_MM),
        end,
        "mm",
        f"last shift off; magnitudes off by {middle(100 * off.max(axis=0))} % at most; "
        "with each length given "
        f"{middle(runs.steps('off_mm', camera, 'given')[-1])} mm",
    )


def radius_found(runs):
    """The scaled radius is within 10 %, the unscaled one within 20 %."""
    scaled, own = (runs.of(n) / RADIUS_MM - 1 for n in ("scaled_mm", "radius_mm"))
    return (
        (np.abs(scaled) <= MAX_SCALED) & (np.abs(own) <= MAX_UNSCALED),
        100 * np.abs(scaled),
        "%",
        f"scaled radius off; unscaled {middle(100 * np.abs(own))} %; with each length "
        f"given {middle(runs.of('radius_mm', way='given'))} mm of {RADIUS_MM:g} mm",
    )


def missed(runs, seeds):
    """Estimate of the median number of markers that miss the cylinder, of some runs.

    A run without a cylinder counts as the worst.
    """
    return median_interval(runs.of("missed")[seeds])


def mostly_meet(runs, seeds):
    """Whether all markers but one meet the cylinder in the median of some runs."""
    # Whole numbers: between one that may miss and two.
    return missed(runs, seeds).value < MAX_N_MISSED + 0.5


def markers_meet(runs, seeds):
    """Reading: all markers but one meet the cylinder, median over some runs."""
    found = missed(runs, seeds)
    return Reading.of(
        found.below(MAX_N_MISSED + 0.5),
        found,
        "",
        f"median number of markers that miss; distances of {middle(runs.of('fit_mm'))} "
        "mm on the mean",
    )


def log_scales(runs):
    """Logarithms (4, runs) of mean steps over the true one, at all stages."""
    found = np.array([runs.scales(stage) for stage in STAGES])
    worst = np.where(np.isfinite(found), found, MAX_FACTOR)
    return np.log(np.clip(worst, 1 / MAX_FACTOR, MAX_FACTOR))


def fall(*logs):
    """Spearman's correlation (...) of deflection with the SD of log scales (..., n);
    0 where all scatter alike, as single runs do."""
    sd = np.stack([np.std(one, axis=-1) for one in logs], axis=-1)
    x, y = rankdata(STAGES_MM), rankdata(sd, axis=-1)
    x, y = x - x.mean(), y - y.mean(axis=-1, keepdims=True)
    size = np.linalg.norm(x) * np.linalg.norm(y, axis=-1)
    return (y @ x) / np.where(size > 0, size, 1.0)


def scale_tells(runs, seeds):
    """Reading: scatter of the scale falls with deflection; the scale ends correct.

    The median at the largest deflection is that of the mean steps of some runs.
    """
    logs = log_scales(runs)[:, seeds]
    falls = bootstrap(fall, *logs, paired=True)
    last = median_interval(np.exp(logs[LAST]))
    sds = ", ".join(f"{sd:.2g}" for sd in logs.std(axis=1))
    return Reading.of(
        all_of(
            [
                falls.below(np.nextafter(MAX_TREND, 1)),
                last.within(1 - MAX_SCALE_ERROR, 1 + MAX_SCALE_ERROR),
            ]
        ),
        falls,
        "",
        f"rank correlation of deflection with the SD of log scale, which is {sds} at "
        f"stages 0 to 3; median scale at stage 3 {last.value:.3g} ({last.low:.3g} to "
        f"{last.high:.3g})",
    )


def scaled(runs, level):
    """Which runs (runs,) have a scale: at all stages, in a sweep at the last."""
    stages = (LAST,) if level in SWEPT else STAGES
    return np.isfinite([runs.scales(stage) for stage in stages]).all(axis=0)


def scale_right(runs, seeds):
    """Whether the median scale of some runs at the largest deflection is correct."""
    scale = np.exp(log_scales(runs)[LAST][seeds])
    return bool(abs(np.median(scale) - 1) <= MAX_SCALE_ERROR)


# Numbers quoted on the page: medians over the runs that completed.


LENGTH_MM = STEPS * STEP_MM


def quoted_median(found):
    """Median of the trials that have a value, as words; "no" without any."""
    known = found[np.isfinite(found)]
    return in_words(np.median(known)) if len(known) else "no"


def in_words(number):
    """A number below 10 with two digits, a larger one as a whole number."""
    return f"{number:.2g}" if abs(number) < 10 else f"{number:.0f}"


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {RUNS: open_results(RUNS)}
    value("parallax", in_words(parallax()))
    turn = MotionRuns(results, bench=LEVEL).steps("turn_deg", "true", "given")
    value("true.given.last", quoted_median(turn[-1]))
    runs = MotionRuns(results, bench=LABORATORY)
    value("lab.published.open.off", quoted_median(runs.steps("off_mm")[-1]))
    step_sd = runs.column(STAGE_NAMES[LAST], "told1", "length_percent")
    value(f"lab.told.{LAST}", quoted_median(step_sd))
    length = runs.of("length_mm", way="together") / LENGTH_MM
    value("lab.published.six.share", quoted_median(length))
    sd = runs.of("told_percent", way="together")
    value("lab.published.six.told", quoted_median(sd))


def parallax():
    """How much more the nearest mark moves in one step than the farthest, degrees.

    Seen from the point next to all rays of a smooth mirror at stage 3.
    """
    camera = mirror_rig("A").camera(STAGES_MM[LAST])
    scene = moved_cylinder(camera, np.random.default_rng(0))
    away = np.linalg.norm(scene.points - seen_by(camera, scene.pixels).centre, axis=1)
    return float(np.ptp(np.degrees(STEP_MM / away)))


# Figs 5.20 and 5.21, and the uncertainty of a length from rays.


PATHS = {
    ("published", "open"): "calibrated, lengths open",
    ("published", "given"): "calibrated, lengths given",
    ("true", "given"): "true mirror, lengths given",
}
ROUNDING = 1e-9
AROUND, ALONG = 60, 2
PLACES_MM = STEP_MM * np.array(EACH_STEP)
SIGHT = (0.6, -0.3, -0.75)


@figure("fig_5_20", needs=("table_5_7_runs",), evidence="rendered")
def fig_5_20(results):
    """Path of the cylinder, true and estimated, of the median run."""
    runs = MotionRuns(results)
    drawn_as = runs.drawn_camera()
    seed = runs.middling(runs.steps("off_mm", drawn_as)[-1])
    true = runs.array("marks.path", seed)
    along = true[-1] / np.linalg.norm(true[-1])
    frame = np.column_stack([along, tangent_bases(along[None])[0]])
    drawn, panels = new_figure(1, 2, height_in=3.6)
    paths = {"actual": true} | {
        words: runs.array(f"{camera}.{way}.path", seed)
        for (camera, way), words in PATHS.items()
    }
    paths = {words: path for words, path in paths.items() if path is not None}
    looks = {"actual": {"color": INK, "marker": "s"}}
    looks[PATHS["true", "given"]] = look_of("true mirror")
    rows = []
    for index, (words, path) in enumerate(paths.items()):
        places = path @ frame
        look = looks.get(words, series(index - 1))
        for k, panel in enumerate(panels, 1):
            panel.plot(places[:, 0], places[:, k], label=words, **look)
        rows += [(words, step, *place) for step, place in enumerate(places)]
    for panel, side in zip(
        panels, ("first perpendicular", "second perpendicular"), strict=True
    ):
        panel.set(
            xlabel="Position along the motion (mm)", ylabel=f"Offset, {side} (mm)"
        )
    legend_below(drawn, panels[0], ncols=2)
    last = runs.array(f"{drawn_as}.{WAY}.path", seed)[-1]
    off = np.linalg.norm(last - true[-1])
    of_trial = runs.steps("off_mm", drawn_as)[-1][seed]
    return Drawing(
        drawn,
        columns(
            ("path", "step", "along_mm", "first_offset_mm", "second_offset_mm"), rows
        ),
        "Path of the cylinder, true and added up from pairs of images, with the mean "
        f"step scaled to {STEP_MM:g} mm. Second level, the run with the median final "
        "error of those that have a cylinder.",
        Check(
            bool(abs(off - of_trial) < ROUNDING),
            f"the drawn final error of {off:.2f} mm is that of the trial",
        ),
    )


@figure("fig_5_21", needs=("table_5_7_runs",), evidence="rendered", scene=True)
def fig_5_21(results):
    """Reconstructed points and the cylinder through them."""
    runs = MotionRuns(results)
    camera = runs.drawn_camera()
    scaled = runs.of("scaled_mm", camera)
    seed = runs.middling(np.abs(scaled - RADIUS_MM))
    points = runs.array(f"{camera}.{WAY}.points", seed)
    at, axis, (radius,) = np.split(runs.array(f"{camera}.{WAY}.cylinder", seed), (3, 6))
    basis = tangent_bases(axis[None])[0]
    across, height = (points - at) @ basis, (points - at) @ axis
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    drawn.set_layout_engine("none")
    left.set_position([0.1, 0.22, 0.38, 0.72])
    right.set_position([0.52, 0.14, 0.47, 0.82])
    turn = np.linspace(0, 2 * np.pi, AROUND + 1)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    true = runs.of("scaled_mm", "true")[seed]
    for size, words, look in (
        (radius, "estimated", series(0)),
        (true, "true mirror", look_of("true mirror")),
        (RADIUS_MM, "truth", {"color": INK, "ls": "-", "lw": 1.0}),
    ):
        left.plot(*(size * circle).T, label=words, **look | {"marker": ""})
    for place in across:
        left.plot(*(place[:, None] + MARKER_MM * circle.T), color=series(1)["color"],
                  marker="", ls="-")  # fmt: skip
    left.set(xlabel="x across the axis (mm)", ylabel="y across the axis (mm)")
    left.set_aspect("equal")
    legend_below(drawn, left, ncols=3)
    ends = np.array([np.nanmin(height), np.nanmax(height)])
    wall = at + radius * (circle @ basis.T)[None] + ends[:, None, None] * axis
    known = np.isfinite(points).all(axis=1)
    scene = framed(
        [
            Surface(wall, series(0)["color"], 0.5, "estimated cylinder"),
            Points(points[known], series(1)["color"], "points", 12.0),
        ],
        SIGHT,
        up=tuple(-axis * np.sign(axis[1])),
        aspect=0.9,
        note="Points reconstructed from six images, and the cylinder fitted to them.",
    )
    draw_scene(right, scene)
    off = np.abs(np.linalg.norm(across[known], axis=1) - radius)
    of_trial = runs.of("fit_mm", camera)[seed]
    return Drawing(
        drawn,
        columns(
            ("across_x_mm", "across_y_mm", "along_mm"),
            np.column_stack([across, height]).tolist(),
        ),
        f"Reconstructed points as markers of {MARKER_MM:g} mm, and the cylinder fitted "
        "to them, scaled by the mean step. Second level, the run with the median error "
        "of the radius. The circle of the true mirror has the same axis.",
        Check(
            bool(abs(off.mean() - of_trial) < 1e-6),
            f"mean distance from the cylinder as drawn {off.mean():.3f} mm, as in the "
            "trial",
        ),
        scene,
    )


@figure("ext_motion_scale", needs=("table_5_7_runs",), evidence="rendered")
def ext_motion_scale(results):
    """Uncertainty of a length, by stage and by baseline."""
    drawn, (left, right) = new_figure(1, 2, height_in=3.6, sharey=True)
    rows = []
    for index, level in enumerate(CONTRASTED):
        runs = MotionRuns(results, bench=level)
        by_stage = runs.column(STAGE_NAMES, "told1", "length_percent")
        ways = [f"told{k}" for k in EACH_STEP]
        by_way = runs.column(STAGE_NAMES[LAST], ways, "length_percent")
        six = [runs.of("told_percent", "true", "together")]
        for panel, x, trials, look, label in (
            (left, STAGES_MM, by_stage, index, LEVEL_NAMES[level]),
            (right, PLACES_MM, by_way, index, LEVEL_NAMES[level]),
            (
                right,
                PLACES_MM[-1:],
                six,
                2 + index,
                f"{LEVEL_NAMES[level]}, six images at once",
            ),
        ):
            some = [
                (at, one[np.isfinite(one)])
                for at, one in zip(x, trials, strict=True)
                if np.isfinite(one).any()
            ]
            if some:
                rows += plot_estimates(
                    panel,
                    [at for at, _ in some],
                    [median_interval(one) for _, one in some],
                    ("deflection" if panel is left else "baseline", label),
                    look=series(look),
                    label=label,
                    bars=True,
                )
    left.set(xlabel="Deflection (mm)", yscale="log")
    left.set_ylabel("SD of the length (%)")
    right.set(xlabel="Baseline at 15 mm (mm)")
    legend_below(drawn, right, ncols=2)
    return Drawing(
        drawn,
        columns(("over", "rays", "x", "median", "low", "high"), rows),
        "Standard deviation with which rays of the true mirror determine a length, % "
        "of the length; medians over runs with 95 % intervals. Left: one step of "
        f"{STEP_MM:g} mm at each deflection; a flat mirror at the low-noise level "
        "determines none. Right: at 15 mm, from the first position to later ones with "
        "two images, and with all six at once.",
    )


# Table 5.7 and the numbers of 5.3.5 about motion.


NEEDS = ("table_5_7_runs",)
MOVED = "the cylinder is moved by this distance"
MADE = "the cylinder has this size"


@table("table_5_7", needs=NEEDS, evidence="rendered")
def table_5_7(results):
    """Translations and rotations added up, as in the thesis."""
    runs = MotionRuns(results)
    lengths, turns, off = (
        runs.steps(name) for name in ("length_mm", "turn_deg", "off_mm")
    )
    given = runs.steps("turn_deg", way="given")
    true = runs.steps("turn_deg", "true", "given")
    rows = [
        (int(k * STEP_MM), *(reached(one[k - 1]) for one in
         (lengths, turns, off, given, true)))
        for k in EACH_STEP
    ]  # fmt: skip
    names = (
        "Ground truth (mm)",
        "Translation (mm)",
        "Rotation (°)",
        "Position error (mm)",
        "Rotation, lengths given (°)",
        "Rotation, lengths given, true mirror (°)",
    )
    ids = {
        title: [f"t5_7_{k * STEP_MM:.0f}_{end}" for k in EACH_STEP]
        for title, end in zip(names, ("gt", "t", "r"), strict=False)
    }
    return Table(
        columns(names, rows),
        "Translations and rotations of the cylinder, estimated from each image to the "
        "next and added up, with the mean step scaled to the true one. Second level, "
        f"mirror calibrated stage by stage; the true rotation is 0. {MEDIANS} Right: "
        "rotations with given step lengths.",
        printed=ids,
    )


def of_runs(runs, found, unit):
    """Return the Value of a measure (runs,), and how many runs have none.

    Infinite where no run has one.
    """
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} runs have none" if lost else ""
    if lost == runs.seeds:
        return Value(np.inf, unit=unit, reason=reason)
    return Value.of_seeds(found, unit, reason)


@numbers("table_5_7", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_7(results):
    """Translations and rotations after each step."""
    runs, found = MotionRuns(results), {}
    lengths, turns = (runs.steps(name) for name in ("length_mm", "turn_deg"))
    for k in EACH_STEP:
        prefix = f"t5_7_{k * STEP_MM:.0f}"
        found[f"{prefix}_gt"] = Value(k * STEP_MM, unit="mm", put_in=MOVED)
        found[f"{prefix}_t"] = of_runs(runs, lengths[k - 1], "mm")
        found[f"{prefix}_r"] = of_runs(runs, turns[k - 1], "deg")
    return found


@numbers("fig_5_20", needs=NEEDS, evidence="rendered")
def numbers_of_fig_5_20(results):
    """Error of the final position."""
    runs = MotionRuns(results)
    return {"s5_3_5_final": of_runs(runs, runs.steps("off_mm")[-1], "mm")}


@numbers("sec_5_3_5", needs=NEEDS, evidence="rendered")
def numbers_of_the_text(results):
    """The mean step before it is scaled."""
    runs = MotionRuns(results)
    return {"s5_3_5_unscaled": of_runs(runs, runs.of("mean_mm"), "mm")}


@numbers("fig_5_21", needs=NEEDS, evidence="rendered")
def numbers_of_fig_5_21(results):
    """The cylinder: radii, distances, markers that miss."""
    runs = MotionRuns(results)
    return {
        "s5_3_5_rad_un": of_runs(runs, runs.of("radius_mm"), "mm"),
        "s5_3_5_rad_sc": of_runs(runs, runs.of("scaled_mm"), "mm"),
        "s5_3_5_rad_true": Value(RADIUS_MM, unit="mm", put_in=MADE),
        "s5_3_5_fit_mean": of_runs(runs, runs.of("fit_mm"), "mm"),
        "s5_3_5_fit_sd": of_runs(runs, runs.of("fit_sd_mm"), "mm"),
        "s5_3_5_npts": Value(MARKS, unit="count", put_in=MADE),
        "s5_3_5_miss": of_runs(runs, runs.of("missed"), "count (of 25)"),
        "s5_3_5_marker": Value(MARKER_MM, unit="mm", put_in="radius of a marker"),
    }
