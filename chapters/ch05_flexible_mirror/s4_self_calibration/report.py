"""Results of this page read: values of the prose, figures, tables."""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.experiment import (
    ALONG_MM,
    DEPTHS_MM,
    SCENES,
    STEPS,
)
from chapters.shared.mirror import (
    BENCHES,
    CONTRASTED,
    LABORATORY,
    LEVEL,
    MEDIANS,
    SAID,
    STAGES_MM,
    BenchRuns,
    beside,
    mirror_rig,
    reached,
)
from chapters.shared.mirror import middle as medians
from repro.page import INK, legend_below, new_figure, series, value
from repro.run import Drawing, Table, Value, figure, median_and_range, numbers, table
from repro.run import columns as as_csv

# Errors over many steps of a mirror that moves back and forth.


def errors_of(result, way):
    """Mean ray angles (STEPS, seeds), degrees; nan from a rejected step on."""
    return np.array([result.column(f"{way}.step{k}") for k in range(1, STEPS + 1)])


def slopes(result, way):
    """Slopes (seeds,) of the error, % of its mean per step.

    The mean at each of both deflections is 100 %. A rejected run counts as the worst
    of the others.
    """
    errors = errors_of(result, way)
    relative = np.empty_like(errors)
    for place in (0, 1):
        mine = errors[place::2]
        relative[place::2] = 100 * mine / np.mean(mine, axis=0)
    step = np.arange(STEPS) - (STEPS - 1) / 2
    # Both deflections have equal means: only the order of the steps gives a slope.
    found = step @ relative / (step @ step)
    return np.where(np.isfinite(found), found, np.nanmax(found))


# Runs of self-calibration: result, error level and features.


RUNS, SWEPT_RUNS = "table_5_9_runs", "table_5_9_swept"
STAGES = (1, 2, 3)
STEP_MM = STAGES_MM[1]
# As 5.4 describes: features across the middle, and near ones at the free end.
THESIS_SCENE = next(iter(SCENES))
OBJECTS = ("plane", "object", "wall")


class Courses(BenchRuns):
    """Three pushes."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)

    def column(self, name):
        """A value (seeds,) of each run, nan where it ended before."""
        return self.result.column(f"{self.bench}.{name}")

    def of(self, way, name, stages=STAGES):
        """A value (stages, seeds) of `board` or one of SCENES."""
        return np.array([self.column(f"{way}.stage{k}.{name}") for k in stages])

    def refused(self, way):
        """Codes (seeds,) of the errors that ended a method, None where none did."""
        return self.result.texts(f"{self.bench}.{way}.refused")

    def arrays(self, name):
        """One array for each run that has it; none where nothing was run."""
        result = self.result
        return result.arrays(f"{self.bench}.{name}") if result.names() else []

    def of_seed(self, name, seed, came, columns=2):
        """Array of one run, where `came` (seeds,) marks the runs that have it.

        One without rows where `seed` is None.
        """
        if seed is None:
            return np.empty((0, columns))
        return self.arrays(name)[np.count_nonzero(came[:seed])]

    def profiles(self, way, stage):
        """Heights (completed runs, places), mm, along the middle line."""
        return self.arrays(f"{way}.stage{stage}.profile_mm")

    def inflected(self, way):
        """Whether the profile has an inflexion (stages 2 and 3, seeds).

        False where a run ended before.
        """
        back = np.zeros((len(STAGES) - 1, self.seeds), bool)
        for row, stage in zip(back, STAGES[1:], strict=True):
            came = np.isfinite(self.column(f"{way}.stage{stage}.angle_deg"))
            row[came] = [bends_back(z) for z in self.profiles(way, stage)]
        return back


def first_seed(*came):
    """Index of the first run for which all conditions hold; None without one."""
    every = np.flatnonzero(np.logical_and.reduce(came))
    return int(every[0]) if len(every) else None


# Fraction of the largest curvature: less of the other sign is no inflexion.
MIN_INFLEXION_RATIO = 0.1
POLYNOMIAL = 5  # degree of the polynomial that is differentiated


def bends_back(heights):
    """Whether a profile (n,), evenly spaced, has an inflexion.

    A tenth or more of its largest curvature has the other sign, in its middle eight
    tenths. False for a profile that the spline does not cover everywhere.
    """
    if not np.isfinite(heights).all():
        return False
    x = np.linspace(-1, 1, len(heights))
    bend = np.polynomial.Polynomial.fit(x, heights, POLYNOMIAL).deriv(2)(0.8 * x)
    return bool(min(-bend.min(), bend.max()) > MIN_INFLEXION_RATIO * np.abs(bend).max())


# Claims of 5.4 for single runs.
#
# Each function takes the `Courses` at an error level. It returns whether the claim
# holds (seeds,), the measured value (seeds,), its unit, and words. The value is nan
# where a run was rejected.


LINEAR_TOL = 0.1
MAX_SAG_RATIO = 0.25
MIN_BASELINE_RATIO, MAX_TREND = 5.0, -0.8
MIN_SPREAD = 0.2
MIN_GROWTH, MIN_REFINED_RATIO = 1.5, 3.0


def _by_stage(values):
    return ", ".join(medians(one) for one in values)


def better_early(runs):
    """Estimates of stages 1 and 2 are nearer to 5 mm than the linear ones of boards."""
    own, near = runs.of(THESIS_SCENE, "deflection_mm"), runs.of("board", "linear_mm")
    off, was = np.abs(own - STEP_MM), np.abs(near - STEP_MM)
    even = np.abs(runs.of("even", "deflection_mm") - STEP_MM) < was
    return (
        np.all(off[:2] < was[:2], axis=0),
        (off / was)[:2].max(axis=0),
        "",
        f"error over that of the near scene, larger of two; found {_by_stage(own)} mm, "
        f"near {_by_stage(near)} mm; with evenly spread far features true in "
        f"{100 * np.mean(even[:2].all(axis=0)):.0f} % of the seeds",
    )


def degrades(runs):
    """Smaller from stage to stage, the last within 10 % of the near linear estimate."""
    own, near = (
        runs.of(THESIS_SCENE, "deflection_mm"),
        runs.of("board", "linear_mm")[-1],
    )
    falls = np.all(np.diff(own, axis=0) < 0, axis=0)
    ratio = own[-1] / near
    return (
        falls & (np.abs(ratio - 1) <= LINEAR_TOL),
        ratio,
        "",
        f"stage 3 over the near scene's; falling in {100 * np.mean(falls):.0f} % of "
        f"the seeds; found {_by_stage(own)} mm",
    )


def vertical(runs):
    """Sag at the load rises over the stages; even features have at most a quarter."""
    sag, even = (
        np.abs(runs.of("clustered", "sag_mm")),
        np.abs(runs.of("even", "sag_mm")),
    )
    share = even[-1] / sag[-1]
    return (
        np.all(np.diff(sag, axis=0) > 0, axis=0) & (share <= MAX_SAG_RATIO),
        share,
        "",
        f"sag of even over clustered features, stage 3; clustered {_by_stage(sag)} mm, "
        f"even {_by_stage(even)} mm",
    )


def inflexion(runs):
    """An inflexion at stages 2 and 3 with near features, and at neither without."""
    near = runs.inflected("near").all(axis=0)
    without = runs.inflected("even").any(axis=0)
    told = runs.inflected(THESIS_SCENE).all(axis=0)
    came = np.isfinite(runs.of("even", "deflection_mm")).all(axis=0)
    both = came & np.isfinite(runs.of("near", "deflection_mm")).all(axis=0)
    return (
        near & ~without,
        np.where(both, near, np.nan),
        "",
        f"with near features at both in {100 * near.mean():.0f} % of the seeds, "
        f"without at one or both in {100 * without.mean():.0f} %, where features are "
        f"spread evenly; as told {100 * told.mean():.0f} %; without near ones "
        f"{came.sum()} of {runs.seeds} came to stage 3",
    )


def large_error(runs):
    """Depth errors between bent states are at least five times those from 100 mm."""
    ratio, true = (
        runs.column(f"stereo.{name}.deflected") / runs.column(f"stereo.{name}.baseline")
        for name in ("found", "true")
    )
    return (
        ratio >= MIN_BASELINE_RATIO,
        ratio,
        "x",
        "median relative error of depths in the far scene, over that of 100 mm; with "
        f"the true mirror {medians(true)}; boards are off by "
        f"{medians(100 * runs.column('stereo.found.board'))} %",
    )


def edge_times(runs):
    """SD of a depth in the strip at the clamp over that at the free end, (seeds,)."""
    sd = runs.arrays("stereo.sd_mm")
    # A quick build has no sweep, and so no strips of it.
    return np.array([one[0] / one[-1] for one in sd] or [np.nan])


def fixed_edge(runs):
    """The SD of a depth falls from the clamp on."""
    trend = runs.column("stereo.trend")
    return (
        trend <= MAX_TREND,
        trend,
        "",
        "Spearman's rank correlation of the SD with the distance from the clamp; in "
        f"the strip at the clamp the SD is {medians(edge_times(runs))} times that at "
        "the free end; that there is no depth at all at the clamp is not tested",
    )


def _multi(runs, name, cameras="found"):
    return np.array([runs.column(f"multi.{cameras}.{one}.{name}") for one in OBJECTS])


def spread_of_runs(runs):
    """A fifth of the depth or more, and more for the wall than for the plane."""
    plane, _, wall = _multi(runs, "spread_mm")
    true = _multi(runs, "spread_mm", "true")
    share = np.minimum(plane / 3980, wall / 5000)
    return (
        (share >= MIN_SPREAD) & (wall > plane),
        share,
        "",
        f"smaller share of the depth; plane {medians(plane)} mm, wall {medians(wall)} "
        f"mm; with the true mirror {medians(true[0])} and {medians(true[2])} mm",
    )


def order(runs):
    """Plane, object and wall in this order by their centroids."""
    plane, thing, wall = _multi(runs, "centroid_mm")
    return (
        (plane < thing) & (thing < wall),
        wall - plane,
        "mm",
        f"wall behind the plane; centroids {medians(plane)}, {medians(thing)}, "
        f"{medians(wall)} mm",
    )


def under(runs):
    """All three centroids are nearer than the true ones."""
    ratio = _multi(runs, "ratio")
    return (
        np.all(ratio < 1, axis=0),
        ratio.max(axis=0),
        "",
        f"largest of the three ratios; plane, object, wall {_by_stage(ratio)}; with "
        f"the true mirror {_by_stage(_multi(runs, 'ratio', 'true'))}",
    )


def impractical(runs):
    """Back-projection errors grow by half, and end at three times those of boards.

    A self-calibration that is rejected where boards are not supports the claim. Where
    boards are rejected as well, there is nothing to compare with.
    """
    own, board = runs.of(THESIS_SCENE, "back_mm"), runs.of("board", "back_mm")
    even, over = runs.of("even", "back_mm"), own[-1] / board[-1]
    rejected = np.isnan(own[-1]) & np.isfinite(board[-1])
    grows = (own[-1] >= MIN_GROWTH * own[0]) & (over >= MIN_REFINED_RATIO)
    return (
        grows | rejected,
        np.where(rejected, np.inf, over),
        "x",
        f"over the refined method, stage 3; {_by_stage(own)} mm; boards "
        f"{_by_stage(board)} mm; even features {_by_stage(even)} mm; "
        f"{rejected.sum()} self-calibrations were rejected where the boards' were not",
    )


# Numbers quoted on the page: medians over the runs that completed, as words.
#
# All runs of a stage may be rejected.


NONE = "none"


def median_words(found, digits=2):
    """Median of the runs that have a value, as words."""
    middle = median_and_range(found).value
    return f"{middle:.{digits}f}" if np.isfinite(middle) else NONE


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {RUNS: open_results(RUNS)}
    low_noise = Courses(results, bench=LABORATORY)
    found = low_noise.of(THESIS_SCENE, "deflection_mm")
    value("lab.told.1", median_words(found[0]))
    value("lab.told.3", median_words(found[-1]))
    for way, digits in ((THESIS_SCENE, 1), ("board", 3)):
        angle = low_noise.of(way, "angle_deg")[-1]
        value(f"lab.{way}.deg.3", median_words(angle, digits))
    runs = Courses(results, bench=LEVEL)
    for cameras, digits in (("found", 1), ("true", 2)):
        error = 100 * runs.column(f"stereo.{cameras}.deflected")
        value(f"{cameras}.deflected", median_words(error, digits))


# Profiles, stereo between bent states, the plan of a scene and its features.


NEEDS = ("table_5_9_runs",)
SD_TICKS = (1, 2, 3, 5, 10, 20, 30, 50)


def first_of(arrays, columns=2):
    """The first array; one without rows where no run has one."""
    return arrays[0] if arrays else np.empty((0, columns))


@figure("fig_5_24", needs=NEEDS, evidence="rendered")
def fig_5_24(results):
    """Profiles of the middle line, found and true, of a run at each of two levels."""
    drawn, panels = new_figure(1, 2, height_in=3.8, sharey=True)
    rig, rows = mirror_rig("A"), []
    for panel, bench in zip(panels, CONTRASTED, strict=True):
        runs = Courses(results, bench=bench)
        came = np.isfinite(runs.of(THESIS_SCENE, "angle_deg"))
        # A quick build has one push.
        pushed = [row for row in came if row.any()]
        seed = first_seed(*pushed) if pushed else None
        for k, stage in enumerate(STAGES):
            true = rig.camera(STAGES_MM[stage]).mirror.height(ALONG_MM, 0 * ALONG_MM)[0]
            label = "true" if k == 0 else None
            panel.plot(ALONG_MM, true, color=INK, linestyle=":", marker="", label=label)
            look = series(k) | {"markevery": 4}
            # Where all runs were rejected the legend still names the stage.
            curve = np.full(len(ALONG_MM), np.nan)
            if seed is not None and came[k][seed]:
                curve = runs.of_seed(
                    f"{THESIS_SCENE}.stage{stage}.profile_mm", seed, came[k]
                )
                rows += [
                    (SAID[bench], stage, *row)
                    for row in zip(ALONG_MM, true, curve, strict=True)
                ]
            panel.plot(ALONG_MM, curve, label=f"stage {stage}", **look)
        panel.set(
            title=SAID[bench], xlabel="Distance from the clamp (mm)", ylim=(-4, 18)
        )
    panels[0].set_ylabel("Height above the flat sheet (mm)")
    legend_below(drawn, panels[0], ncols=4)
    return Drawing(
        drawn,
        as_csv(("level", "stage", "along_mm", "true_mm", "found_mm"), rows),
        "Middle line of the mirror after each push of 5 mm: true, and by linear "
        "self-calibration from features across the middle and near ones at the free "
        "end. The first run that reaches the last stage, at each of two levels.",
    )


@figure("fig_5_25", needs=NEEDS, evidence="rendered")
def fig_5_25(results):
    """A board by stereo between stages 0 and 1, and depth noise along the mirror."""
    runs = Courses(results)
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    met = first_of(runs.arrays("stereo.found.met"), 3)
    # A run that was rejected has a board, and no reconstructed points.
    came = np.flatnonzero(np.isfinite(runs.column("stereo.found.board")))
    boards = runs.arrays("stereo.board_points")
    board = first_of([boards[k] for k in came], 3)
    for number, (name, points) in enumerate((("true", board), ("found", met))):
        look = series(number) | {"linestyle": "", "markersize": 3}
        left.plot(points[:, 0], points[:, 2], label=name, **look)
    left.set(xlabel="x (mm)", ylabel="z (mm)", title="board, seen from above")
    left.legend()
    along = np.mean(runs.arrays("stereo.along"), axis=0)
    sd = np.median(runs.arrays("stereo.sd_mm"), axis=0)
    right.plot(along, sd, **series(0))
    right.set_yscale("log")
    right.set_yticks(SD_TICKS, map(str, SD_TICKS), minor=False)
    right.set_yticks([], minor=True)
    right.set(xlabel="Distance from the clamp (fraction of the length)")
    right.set(ylabel="Depth SD (mm per px)", title="true mirror")
    rows = [("board", *p, *q) for p, q in zip(board, met, strict=True)]
    return Drawing(
        drawn,
        as_csv(("of", "x", "y", "z", "found_x", "found_y", "found_z"), rows),
        "Stereo between stages 0 and 1, both calibrated with boards. Left: corners of "
        "a board, true and reconstructed, one run at the second level. Right: standard "
        "deviation of depths at 260 mm with the true mirror, for noise of 1 px in both "
        "images. Next to the clamp depth is undetermined.",
    )


def scene_seed(runs):
    """({mirror: which runs (seeds,) have the scene}, the first that has both)."""
    name = f"{OBJECTS[0]}.spread_mm"
    came = {
        mirror: np.isfinite(runs.column(f"multi.{mirror}.{name}"))
        for mirror in ("found", "true")
    }
    return came, first_seed(*came.values())


@figure("fig_5_26", needs=NEEDS, evidence="rendered")
def fig_5_26(results):
    """Plan of the scene from four stages, calibrated and true mirror."""
    runs, rows = Courses(results), []
    came, seed = scene_seed(runs)
    drawn, panels = new_figure(1, 2, height_in=4.2, sharex=True, sharey=True)
    for panel, cameras in zip(panels, ("found", "true"), strict=True):
        plan, of = (
            runs.of_seed(f"multi.{cameras}.{name}", seed, came[cameras])
            for name in ("plan", "of")
        )
        of = of.ravel() if seed is not None else np.empty(0)
        for k, one in enumerate(OBJECTS):
            look = series(k) | {"linestyle": "", "markersize": 4}
            panel.plot(*plan[of == k].T, label=one, **look)
            panel.axhline(DEPTHS_MM[one], color=look["color"], linewidth=0.8, marker="")
            rows += [(cameras, one, *p) for p in plan[of == k]]
        title = "calibrated mirror" if cameras == "found" else "true mirror"
        panel.set(
            title=title,
            xlabel="Lateral position (mm)",
            ylim=(0, 9000),
            xlim=(-1500, 1500),
        )
    panels[0].set_ylabel("Depth from the mirror (mm)")
    legend_below(drawn, panels[0], ncols=3)
    return Drawing(
        drawn,
        as_csv(("mirror", "of", "lateral_mm", "depth_mm"), rows),
        "Plan view of a scene triangulated from images at all four stages, with "
        "features picked to half a pixel. Lines: true depths. The first run of the "
        "second level that boards calibrate at all stages. Points outside the frame "
        "are not drawn.",
    )


@figure("fig_5_27", needs=NEEDS, evidence="rendered")
def fig_5_27(results):
    """Features that all four images show, in that of stage 2."""
    runs = Courses(results)
    came, seed = scene_seed(runs)
    pixels = runs.of_seed("multi.pixels", seed, came["true"])
    pixels = pixels[np.isfinite(pixels[:, 0])]
    drawn, panel = new_figure(height_in=3.6)
    panel.plot(*pixels.T, **series(0) | {"linestyle": "", "markersize": 4})
    panel.set(xlim=(0, 3072), ylim=(2304, 0), xlabel="u (px)", ylabel="v (px)")
    panel.set_aspect("equal")
    return Drawing(
        drawn,
        as_csv(("u_px", "v_px"), pixels),
        "Features of the scene in the image of stage 2, in the run of Fig. 5.26.",
    )


# Table 5.9 at all levels, other features, and the numbers of 5.4.


REACH = "Not every estimated shape reaches the load, and fewer have its sides."
FEATURES = {
    "clustered": "clustered, all far",
    "near": "even, near at the end",
    "even": "even, all far",
}
PUSHED = "the simulated mirror is pushed by this distance"
PLACED = "the simulated scene is at this depth"


HEADS = {
    "deflection_mm": "Self-calibration (mm)",
    "sag_mm": "Sag (mm)",
    "angle_deg": "Ray error (°)",
    "back_mm": "Back-projection (mm)",
    "back_true_mm": "Back-projection, true pose (mm)",
}
# Back-projection with an estimated pose is measured for some features only.
OF_FEATURES = [name for name in HEADS if name != "back_mm"]


def _rows(runs, way, bench, names=tuple(HEADS)):
    of = {name: runs.of(way, name) for name in names}
    # Features as in 5.4 have a table of their own.
    features = () if way == THESIS_SCENE else (FEATURES[way],)
    return [
        (
            SAID[bench],
            *features,
            stage,
            int(np.isfinite(of["deflection_mm"][k]).sum()),
            STEP_MM,
            *(reached(of[name][k]) for name in names),
        )
        for k, stage in enumerate(STAGES)
    ]


def _heads(*features, names=tuple(HEADS)):
    first = ("Error level", *features, "Stage", "Runs", "Actual (mm)")
    return (*first, *(HEADS[name] for name in names))


@table("table_5_9", needs=NEEDS, evidence="rendered")
def table_5_9(results):
    """Deflections by linear self-calibration, features as in 5.4."""
    rows = [
        row
        for bench in BENCHES
        for row in _rows(Courses(results, bench=bench), THESIS_SCENE, bench)
    ]
    return Table(
        as_csv(_heads(), rows),
        "Deflections from a distant scene by linear self-calibration, with features "
        "across the middle of the mirror and near ones at the free end; sag at the "
        "load; and, not in the thesis, errors of rays and back-projection. Geometry A. "
        f"{MEDIANS} {REACH}",
        printed={
            "Actual (mm)": _beside("actual", rows),
            "Self-calibration (mm)": beside(
                [f"t5_9_s{k}_est" for k in STAGES], len(rows)
            ),
        },
    )


def _beside(end, rows):
    return beside([f"t5_9_s{k}_{end}" for k in STAGES], len(rows))


@table("ext_self_features", needs=NEEDS, evidence="rendered")
def ext_self_features(results):
    """Deflections with other distributions of features."""
    rows = [
        row
        for bench in BENCHES
        for way in SCENES
        if way != THESIS_SCENE
        for row in _rows(Courses(results, bench=bench), way, bench, OF_FEATURES)
    ]
    return Table(
        as_csv(_heads("Features", names=OF_FEATURES), rows),
        "Deflections by linear self-calibration with other distributions of features: "
        f"over the whole mirror, and without near ones. {MEDIANS} {REACH}",
    )


def _value(runs, found, unit):
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} runs have none: rejected, or load not reached"
    reason = reason if lost else ""
    if lost == runs.seeds:
        return Value(np.inf, unit=unit, reason=reason)
    return Value.of_seeds(found, unit, reason)


@numbers("table_5_9", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_9(results):
    """Deflections found."""
    runs = Courses(results)
    found = runs.of(THESIS_SCENE, "deflection_mm")
    return {
        f"t5_9_s{k}_actual": Value(STEP_MM, unit="mm", put_in=PUSHED) for k in STAGES
    } | {f"t5_9_s{k}_est": _value(runs, found[k - 1], "mm") for k in STAGES}


@numbers("sec_5_4", needs=NEEDS, evidence="rendered")
def numbers_of_the_text(results):
    """Linear estimates of boards less the final ones, and the sag at the load."""
    runs = Courses(results)
    linear, final = (
        runs.of("board", f"{name}_mm") for name in ("linear", "deflection")
    )
    below = 100 * (1 - linear / final)
    sag = np.abs(runs.of("clustered", "sag_mm"))[-1]
    return {
        "s5_4_lin_min": _value(runs, below.min(axis=0), "%"),
        "s5_4_lin_max": _value(runs, below.max(axis=0), "%"),
        "s5_4_vcurv": _value(runs, sag, "mm"),
    }


@numbers("fig_5_26", needs=NEEDS, evidence="rendered")
def numbers_of_fig_5_26(results):
    """Centroids and spreads of the four-stage reconstruction."""
    runs = Courses(results)

    def of(one, name):
        return _value(runs, runs.column(f"multi.found.{one}.{name}_mm"), "mm")

    found = {f"fig5_26_{one}_est": of(one, "centroid") for one in OBJECTS}
    found |= {
        f"fig5_26_{one}_meas": Value(DEPTHS_MM[one], unit="mm", put_in=PLACED)
        for one in OBJECTS
    }
    return found | {
        "fig5_26_front": of("plane", "spread"),
        "fig5_26_rear": of("wall", "spread"),
    }
