"""Table 5.7 with the cameras and ways beside it, what rays tell, and the numbers."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.results.runs import (
    CAMERAS,
    EACH_STEP,
    PICTURES,
    STAGES,
    MotionRuns,
)
from chapters.ch05_flexible_mirror.s3_5_motion.trials.motion import MARKER_MM
from chapters.ch05_flexible_mirror.s3_5_motion.trials.run import SET_BESIDE
from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import (
    MARKS,
    NOISE_PX,
    RADIUS_MM,
    STEP_MM,
)
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_tables import MEDIANS, ranged, reached
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Table, Value

NEEDS = ("table_5_7_runs",)
WAYS = {"open": "told by the rays", "given": "given"}
SEEN_AS = {
    "true": "true mirror",
    "published": "calibrated, stage by stage",
    "bundle": "calibrated, all stages at once",
}
MOVED = "the cylinder is moved by this length"
MADE = "the cylinder is made so"


@table("table_5_7", needs=NEEDS, evidence="rendered")
def table_5_7(results):
    """Shifts and turns added up, on the bench, as the thesis has them."""
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
        "Shift off (mm)",
        "Rotation, lengths given (°)",
        "Rotation, lengths given, true mirror (°)",
    )
    ids = {
        title: [f"t5_7_{k * STEP_MM:.0f}_{end}" for k in EACH_STEP]
        for title, end in zip(names, ("gt", "t", "r"), strict=False)
    }
    return Table(
        columns(names, rows),
        "Translations and rotations of the cylinder, found from each picture to the "
        "next and added up, the mean step scaled to the true one; the bench, mirror "
        f"calibrated stage by stage. The true rotation is 0. {MEDIANS} To the right "
        "what is left where each step's length is known.",
        printed=ids,
    )


@table("ext_motion_ways", needs=NEEDS, evidence="rendered")
def ext_motion_ways(results):
    """Each bench, camera and way: first and last turn, scale, radius."""
    rows = []
    for bench in reversed(BENCHES):
        runs = MotionRuns(results, bench=bench)
        for camera in CAMERAS:
            for way, words in WAYS.items():
                turn = runs.steps("turn_deg", camera, way)
                rows.append(
                    (
                        bench,
                        SEEN_AS[camera],
                        words,
                        reached(turn[0]),
                        reached(turn[-1]),
                        reached(runs.of("mean_mm", camera, way)),
                        reached(runs.steps("off_mm", camera, way)[-1]),
                        reached(runs.of("scaled_mm", camera, way)),
                        None,
                    )
                )
            rows.append(
                (
                    bench,
                    SEEN_AS[camera],
                    "told, six pictures at once",
                    None,
                    reached(runs.of("turn_deg", camera, "together")),
                    reached(runs.of("length_mm", camera, "together") / len(EACH_STEP)),
                    None,
                    reached(runs.of("radius_mm", camera, "together")),
                    reached(runs.of("told_percent", camera, "together")),
                )
            )
    names = (
        "Bench",
        "Mirror",
        "Length of a step",
        "Rotation after 1 (°)",
        "after 5 (°)",
        "Mean step (mm)",
        "Shift off after 5 (mm)",
        "Radius (mm)",
        "Length told to (%)",
    )
    return Table(
        columns(names, rows),
        f"Motion from pairs of pictures and from all six at once: {MARKS} marks, "
        f"{NOISE_PX:g} px, steps of {STEP_MM:g} mm, a radius of {RADIUS_MM:g} mm. "
        f"{MEDIANS} Where lengths are told by the rays, shift and radius are scaled "
        "by the mean step, but as they are found from six pictures. *Told to*: the "
        "standard deviation that noise alone leaves six pictures.",
    )


@table("ext_motion_baselines", needs=NEEDS, evidence="rendered")
def ext_motion_baselines(results):
    """Two pictures at growing distance: turn and radius, on both benches."""
    rows = []
    for bench in reversed(BENCHES):
        runs = MotionRuns(results, bench=bench)
        for camera in CAMERAS:
            for k in SET_BESIDE[camera]:
                cells = [
                    reached(runs.of(f"{way}.{name}", camera, f"from_first{k}"))
                    for way in WAYS
                    for name in ("turn_deg", "radius_mm")
                ]
                rows.append((bench, SEEN_AS[camera], int(k * STEP_MM), *cells))
    names = [
        f"{what}, length {words} ({unit})"
        for words in WAYS.values()
        for what, unit in (("Rotation", "°"), ("Radius", "mm"))
    ]
    return Table(
        columns(("Bench", "Mirror", "Baseline (mm)", *names), rows),
        "Two pictures alone, of the first place and of a later one; the cylinder's "
        f"radius is {RADIUS_MM:g} mm. Where the length is told, the search starts from "
        f"the motion that was found with it given. {MEDIANS}",
    )


@table("ext_motion_told", needs=NEEDS, evidence="rendered")
def ext_motion_told(results):
    """What rays without any error of calibration can tell, by stage."""
    rows = []
    for bench in reversed(BENCHES):
        runs = MotionRuns(results, bench=bench)
        for stage in STAGES:

            def at(name, stage=stage, runs=runs):
                return runs.column(f"stage{stage}.{name}")

            rows.append(
                (
                    bench,
                    STAGES_MM[stage],
                    reached(at("spread_mm")),
                    reached(at("told1.length_percent")),
                    reached(at("told5.length_percent")),
                    reached(at("told1.turn_deg")),
                    reached(at("told1.turn_given_deg")),
                    reached(runs.scales(stage)),
                )
            )
    names = (
        "Bench",
        "Deflection (mm)",
        "Spread of the rays (mm)",
        "Length of 25 mm told to (%)",
        "of 125 mm (%)",
        "Rotation told to (°)",
        "length given (°)",
        "Scale found, calibrated",
    )
    return Table(
        columns(names, rows),
        "Standard deviations that the information of the rays leaves, true mirror, "
        f"{NOISE_PX:g} px: nothing unbiased does better. *Spread*: RMS distance of the "
        "rays from the point next to them; where it is 0, no length is told at all. "
        f"To the right what the calibrated mirror finds for the mean step. {MEDIANS}",
    )


@table(
    "ext_motion_swept",
    needs=("table_5_7_runs", "table_5_7_swept", "table_5_7_other"),
    evidence="rendered",
)
def ext_motion_swept(results):
    """The published way from bench to bench, and on geometry B."""
    rows = []
    for geometry, bench in (
        *(("A", bench) for bench in (*reversed(BENCHES), *SWEPT)),
        *(("B", bench) for bench in reversed(BENCHES)),
    ):
        runs = MotionRuns(results, bench=bench, geometry=geometry)
        mean = runs.of("mean_mm")
        rows.append(
            (
                geometry,
                bench,
                runs.seeds,
                int(np.isfinite(mean).sum()),
                int(np.isfinite(runs.of("radius_mm")).sum()),
                reached(runs.column("published.ray_deg")),
                reached(runs.steps("turn_deg")[-1]),
                reached(runs.steps("off_mm")[-1]),
                reached(mean),
                reached(runs.of("scaled_mm")),
                reached(runs.of("missed")),
            )
        )
    names = (
        "Geometry",
        "Bench",
        "Seeds",
        "with a motion",
        "with a cylinder",
        "Mean to true rays (°)",
        "Rotation after 5 (°)",
        "Shift off after 5 (mm)",
        "Mean step (mm)",
        "Scaled radius (mm)",
        "Marks that miss (1)",
    )
    return Table(
        columns(names, rows),
        "Mirror calibrated stage by stage, lengths told by the rays, from half to "
        f"twice the bench's numbers and on the second geometry. {MEDIANS}",
    )


@table("ext_motion_pictures", needs=("fig_5_21_pictures",), evidence="rendered")
def ext_motion_pictures(results):
    """Marks found in rendered pictures, and what each camera makes of them."""
    result, rows = results[PICTURES], []
    for bench in reversed(BENCHES):
        for camera in CAMERAS:
            given, far = f"{bench}.{camera}.given", f"{bench}.{camera}.from_first4"
            found = (
                result.column(name)
                for name in (
                    f"{bench}.found",
                    f"{bench}.mark_px",
                    f"{given}.step1.turn_deg",
                    f"{given}.step5.turn_deg",
                    f"{given}.radius_mm",
                    f"{far}.given.radius_mm",
                )
            )
            rows.append((bench, SEEN_AS[camera], *map(ranged, found)))
    names = (
        "Bench",
        "Mirror",
        "Marks found (1)",
        "off along an axis (px)",
        "Rotation after 1 (°)",
        "after 5 (°)",
        "Radius, six pictures (mm)",
        "two, 100 mm apart (mm)",
    )
    return Table(
        columns(names, rows),
        f"The cylinder in rendered pictures, {result.trials_per_condition} runs: "
        "medians and ranges of those that came so far. Each step's length is given. "
        "Marks are found by OpenCV's connected components; px are those of the whole "
        "camera, of which the pictures have a quarter each way.",
    )


def of_runs(runs, found, unit):
    """The Value of a measure (seeds,), and how many seeds have none; without any it is
    as bad as can be."""
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} seeds have none" if lost else ""
    if lost == runs.seeds:
        return Value(np.inf, unit=unit, reason=reason)
    return Value.of_seeds(found, unit, reason)


@numbers("table_5_7", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_7(results):
    """Shifts and turns after each step."""
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
    """How far the last shift is off."""
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
        "s5_3_5_marker": Value(MARKER_MM, unit="mm", put_in="this is what meets"),
    }
