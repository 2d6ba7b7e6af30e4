"""Table 5.6 on both benches and with the true mirror, and its numbers."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.results.predicates import (
    BY_SEED,
    face_left,
    radius_errors,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.results.runs import (
    JUDGED,
    SCALE,
    STAGES,
    WAYS,
    CircleRuns,
    PictureRuns,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.face import DEFLECTION_MM
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import RADIUS_MM
from chapters.shared.mirror_bench import BENCH, BENCHES, SWEPT
from chapters.shared.mirror_tables import MEDIANS, ranged, reached
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Table, Value

DRAWN = "the target is drawn with this radius"
ROUNDING_MM = 1e-9
IN_MM = ("residual", "residual_sd", "radius")
PRINTED = {
    "Residual (mm)": "mean",
    "SD (mm)": "sd",
    "Radius (mm)": "radius",
    "Radius error (%)": "err",
}


def nothing_below(values):
    """Lengths, mm, with what is rounding alone as 0."""
    return np.where(values < ROUNDING_MM, 0.0, values)


# What is compared of rendered runs: (runs, stage, way) -> (seeds,).
RENDERED = {
    "Radius error (%)": lambda runs, stage, way: np.abs(
        radius_errors(runs, way)[stage]
    ),
    "Residual (mm)": lambda runs, stage, way: runs.of(stage, "residual_mm", way),
    "Pose (mm)": lambda runs, stage, way: runs.of(stage, "pose_mm", way),
}


def circle_table(results, geometry="A"):
    """Columns of both benches by the published way: what Table 5.6 has, and what it
    does not show."""
    rows = []
    for bench in reversed(BENCHES):
        runs = CircleRuns(results, bench=bench, geometry=geometry)
        off = np.abs(radius_errors(runs))
        rows += [
            (
                bench,
                stage,
                runs.came_to(stage),
                *(reached(runs.of(stage, f"{name}_mm")) for name in IN_MM),
                reached(off[stage]),
                reached(runs.of(stage, "angle_deg")),
                reached(runs.of(stage, "pose_mm")),
            )
            for stage in STAGES
        ]
    heads = ("Bench", "Stage", "Seeds", *PRINTED, "Rays (°)", "Pose (mm)")
    return columns(heads, rows)


@table("table_5_6", needs=("table_5_6_runs",), evidence="rendered")
def table_5_6(results):
    """Residuals and radii of the corrected circle at four stages."""
    found = circle_table(results)
    rest = [None] * (len(found["Stage"]) - len(STAGES))
    return Table(
        found,
        "Residuals and radius of the circle of 87.21 mm after correction, with the "
        "pose of the board that the same camera finds; to the right what these do not "
        "show: angles to the true rays over the whole mirror, and how far the middle "
        f"of the board was found from where it is. Geometry A. {MEDIANS}",
        printed={
            head: [f"t5_6_s{stage}_{end}" for stage in STAGES] + rest
            for head, end in PRINTED.items()
        },
    )


@table("ext_circle_ways", needs=("table_5_6_runs",), evidence="rendered")
def ext_circle_ways(results):
    """The circle with all stages calibrated at once, and with the true mirror."""
    rows = []
    for bench in reversed(BENCHES):
        runs = CircleRuns(results, bench=bench)
        for way in ("bundle", "true"):
            off = np.abs(radius_errors(runs, way))
            rows += [
                (
                    bench,
                    WAYS[way],
                    stage,
                    reached(runs.of(stage, "residual_mm", way)),
                    reached(off[stage]),
                    None
                    if way == "true"
                    else reached(runs.of(stage, "angle_deg", way)),
                    reached(runs.of(stage, "pose_mm", way)),
                )
                for stage in STAGES
            ]
    heads = (
        "Bench",
        "Mirror",
        "Stage",
        "Residual (mm)",
        "Radius error (%)",
        "Rays (°)",
        "Pose (mm)",
    )
    return Table(
        columns(heads, rows),
        "Table 5.6 with all stages calibrated at once, of the seeds that came to the "
        "last stage, and with the true mirror, which has the errors of corners and "
        f"edges alone. Geometry A. {MEDIANS}",
    )


@table(
    "ext_circle_rendered",
    needs=("fig_5_14_pictures", "table_5_6_runs"),
    evidence="rendered",
)
def ext_circle_rendered(results):
    """Rendered runs beside those with drawn errors."""
    pictures = PictureRuns(results, bench=BENCH)
    runs, rows = CircleRuns(results, bench=BENCH), []
    for way in ("published", "true"):
        for stage in STAGES:
            row = [WAYS[way], stage, pictures.came_to(stage, way)]
            for measure in RENDERED.values():
                row += [
                    ranged(measure(pictures, stage, way)),
                    reached(measure(runs, stage, way)),
                ]
            rows.append(tuple(row))
    heads = [f"{head}{drawn}" for head in RENDERED for drawn in ("", ", drawn")]
    return Table(
        columns(("Mirror", "Stage", "Runs", *heads), rows),
        "Runs whose pictures were rendered, 768 x 576 px with corners and edges found "
        "in them: medians and ranges of the runs that came so far. *Drawn*: the runs "
        "of Table 5.6, whose corners and edges are those of a picture of 3072 x 2304 "
        f"px with errors drawn. Geometry A on the bench. {MEDIANS}",
    )


@table("ext_circle_other", needs=("table_5_6_other",), evidence="rendered")
def ext_circle_other(results):
    """Table 5.6 on geometry B."""
    return Table(
        circle_table(results, "B"),
        "The same as in Table 5.6 on geometry B, whose camera and mirror are nearer to "
        f"each other. {MEDIANS}",
    )


@table("ext_single_evaluation", needs=("table_5_6_runs",), evidence="rendered")
def ext_single_evaluation(results):
    """Conics on a random plane: the camera's own parallax and its error together."""
    rows = []
    for bench in reversed(BENCHES):
        runs = CircleRuns(results, bench=bench)
        rows += [
            (
                bench,
                stage,
                reached(nothing_below(runs.of(stage, "parallax_mm", "true"))),
                reached(runs.of(stage, "single_mm", "true")),
                reached(runs.of(stage, "single_mm")),
                reached(runs.of(stage, "residual_mm")),
            )
            for stage in STAGES
        ]
    heads = (
        "Bench",
        "Stage",
        "True mirror, no noise (mm)",
        "True mirror (mm)",
        "Calibrated (mm)",
        "Calibrated, on the board (mm)",
    )
    return Table(
        columns(heads, rows),
        "Mean distances of the circle's points from the best conic where their rays "
        "meet a plane that was drawn at random, as far away as the board and tilted "
        "by up to 25°, and, last, from the best circle on the board. Without noise and "
        "with the true mirror, the first would be nothing if the camera had a centre. "
        "Geometry A. "
        f"{MEDIANS}",
    )


@table("ext_circle_swept", needs=JUDGED, evidence="rendered")
def ext_circle_swept(results):
    """Shares of the seeds in which claims are true, from bench to bench."""
    benches = [*reversed(BENCHES), *SWEPT]
    rows = [
        (
            claim.removeprefix("c5_"),
            *(
                100 * float(np.mean(predicate(CircleRuns(results, bench=bench))[0]))
                for bench in benches
            ),
        )
        for claim, predicate in BY_SEED.items()
    ]
    return Table(
        columns(("Claim", *(f"{bench} (%)" for bench in benches)), rows),
        "Share of the seeds in which each claim is true; of one that was refused it is "
        "not. On the bench and in the laboratory, "
        f"{CircleRuns(results).seeds} seeds, and with one of the bench's two numbers "
        f"halved or doubled, {CircleRuns(results, bench=benches[-1]).seeds} others "
        "each. A claim whose share is on another side of 90 % at one of these ends is "
        "left undecided.",
    )


@table("ext_face_left", needs=("table_5_6_runs",), evidence="rendered")
def ext_face_left(results):
    """What a plane leaves of a face's distortion, by calibrated and true mirror."""
    rows = []
    for bench in reversed(BENCHES):
        runs = CircleRuns(results, bench=bench)
        for camera, name in (("calibrated", "stage by stage"), ("true", "true mirror")):
            pinhole = runs.face("corrected_pinhole", camera)
            rows.append(
                (
                    bench,
                    name,
                    reached(runs.face("raw_px", camera)),
                    reached(runs.face("corrected_px", camera)),
                    reached(face_left(runs, camera)),
                    reached(pinhole / runs.face("raw_pinhole", camera)),
                )
            )
    heads = (
        "Bench",
        "Mirror",
        "Raw (px)",
        "Corrected (px)",
        "Left (1)",
        "Left, nearest pinhole (1)",
    )
    return Table(
        columns(heads, rows),
        "Landmarks of the bust after the best homography to the picture that the "
        "view's own pinhole would have taken, root mean squares in its px, before and "
        "after correction over a plane; and the same share by the nearest pinhole of "
        f"either picture. Geometry A, a push of 12 mm. {MEDIANS}",
    )


@numbers("table_5_6", needs=("table_5_6_runs",), evidence="rendered")
def numbers_of_table_5_6(results):
    """Residuals, radii and their errors at each stage."""
    runs = CircleRuns(results)
    measures = {
        "mean": (runs.at("residual_mm"), "mm"),
        "sd": (runs.at("residual_sd_mm"), "mm"),
        "radius": (runs.at("radius_mm"), "mm"),
        "err": (np.abs(radius_errors(runs)), "%"),
    }
    found = {"t5_6_true": Value(RADIUS_MM, unit="mm", put_in=DRAWN)}
    for stage in STAGES:
        for end, (values, unit) in measures.items():
            found[f"t5_6_s{stage}_{end}"] = value_of(values[stage], unit)
    return found


def value_of(trials, unit):
    """The Value of seeds (n,), and how many have none: in words if that is all."""
    lost = np.count_nonzero(~np.isfinite(trials))
    reason = f"{lost} of {len(trials)} seeds were refused before" if lost else ""
    if lost == len(trials):
        return Value("nothing", unit=unit, reason=reason)
    return Value.of_seeds(trials, unit, reason)


@numbers("fig_5_14", needs=(), evidence="analytic")
def numbers_of_fig_5_14(results):
    """How many times the vectors are drawn."""
    return {"fig5_14_scale": Value(SCALE, unit="x")}


@numbers("fig_5_19", needs=(), evidence="analytic")
def numbers_of_fig_5_19(results):
    """How far the mirror is pushed for the face."""
    return {"fig5_19_defl": Value(DEFLECTION_MM, unit="mm")}
