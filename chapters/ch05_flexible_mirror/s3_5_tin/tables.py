"""Table 5.8 on both benches, its numbers, and what they hang on."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.results.runs import (
    JUDGED,
    MATCHED,
    PUBLISHED,
    WAYS,
    TinRuns,
)
from chapters.ch05_flexible_mirror.s3_5_tin.trials.run import MOTIONS
from chapters.ch05_flexible_mirror.s3_5_tin.trials.tin import (
    ANGLES_DEG,
    PAIRS,
    SHIFT_MM,
)
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_tables import reached
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Table, Value

SET = "the tin's faces meet at the angles of the thesis's laser scan"
MOVED = "the camera is moved by this length"
MEDIANS = "Medians over the seeds that have a tin, with 95 % intervals."


@table("table_5_8", needs=("table_5_8_runs",), evidence="rendered")
def table_5_8(results):
    """Angles between the faces as found, and as they are."""
    rows = []
    for bench in reversed(BENCHES):
        runs = TinRuns(results, bench=bench)
        for k, pair in enumerate(PAIRS):
            of_ways = [reached(runs.angles(way)[k]) for way in (PUBLISHED, "bundle")]
            rows.append(
                (
                    bench,
                    pair.replace("_", " - "),
                    of_ways[0],
                    float(ANGLES_DEG[k]),
                    of_ways[1],
                    reached(runs.angles("true")[k]),
                )
            )
    ids = {
        "As published (°)": [f"t5_8_{pair}_est" for pair in PAIRS] + 3 * [None],
        "Reference (°)": [f"t5_8_{pair}_ref" for pair in PAIRS] + 3 * [None],
    }
    heads = ("Bench", "Faces", *ids, "All stages at once (°)", "True mirror (°)")
    return Table(
        columns(heads, rows),
        "Angles between the planes of the tin's faces: by the mirror calibrated stage "
        "by stage as published, as they are, by a calibration of all stages at once, "
        f"and by the true mirror. Geometry A. {MEDIANS}",
        printed=ids,
    )


@table("ext_tin_ways", needs=("table_5_8_runs", "table_5_8_other"), evidence="rendered")
def ext_tin_ways(results):
    """How far angles are off by each way, with the motion known and found."""
    rows = []
    for geometry, bench, way in (
        (g, b, w) for g in "AB" for b in reversed(BENCHES) for w in WAYS
    ):
        runs = TinRuns(results, bench=bench, geometry=geometry)
        found = runs.of("off_deg", way)
        moved = [
            reached(runs.of(f"{name}.off_deg", way)) if way != PUBLISHED else None
            for name in reversed(MOTIONS)
        ]
        rows.append(
            (
                geometry,
                bench,
                WAYS[way],
                int(np.isfinite(found).sum()),
                reached(runs.of("ray_deg", way)),
                reached(runs.of("rms_mm", way)),
                reached(found),
                *moved,
            )
        )
    heads = (
        "Geometry",
        "Bench",
        "Mirror",
        "Seeds",
        "Mean to true rays (°)",
        "Off the planes, RMS (mm)",
        "Worst angle (°)",
        "its motion found but for the length (°)",
        "all of the motion found (°)",
    )
    return Table(
        columns(heads, rows),
        "By how much the worst of the three angles is off: with the motion known, and "
        "with a motion that was found from the same matches. Beside it the error of "
        f"the rays, and how far points lie off their own planes. {MEDIANS}",
    )


def of_runs(runs, found, unit):
    """The Value of a measure (seeds,), and how many seeds have none."""
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} seeds were refused" if lost else ""
    return Value.of_seeds(found, unit, reason)


@numbers("table_5_8", needs=("table_5_8_runs",), evidence="rendered")
def numbers_of_table_5_8(results):
    """Angles found and put in, and the largest difference."""
    runs = TinRuns(results)
    found, out = runs.angles(), {}
    for k, pair in enumerate(PAIRS):
        out[f"t5_8_{pair}_est"] = of_runs(runs, found[k], "deg")
        out[f"t5_8_{pair}_ref"] = Value(float(ANGLES_DEG[k]), unit="deg", put_in=SET)
    most = np.abs(runs.off()).max(axis=0)
    return out | {"t5_8_max": of_runs(runs, most, "deg")}


@numbers("fig_5_22", needs=("fig_5_22_pictures",), evidence="rendered")
def numbers_of_fig_5_22(results):
    """How far the camera moves, and matches on the tin in pictures."""
    counts = results["fig_5_22_pictures"].column(MATCHED)
    return {
        "s5_3_5_tin_t": Value(SHIFT_MM, unit="mm", put_in=MOVED),
        "s5_3_5_tin_n": Value.of_seeds(counts, "count"),
    }


@table("ext_tin_swept", needs=JUDGED, evidence="rendered")
def ext_tin_swept(results):
    """The worst angle from bench to bench."""
    rows = []
    for bench in (*reversed(BENCHES), *SWEPT):
        runs = TinRuns(results, bench=bench)
        found = runs.of("off_deg")
        least = runs.normality().min(axis=0)
        bundle = runs.of("off_deg", "bundle")
        counts = f"{np.isfinite(found).sum()} of {runs.seeds}"
        rows.append((bench, counts, *map(reached, (found, least, bundle))))
    heads = (
        "Bench",
        "Seeds as published",
        "Worst angle as published (°)",
        "Least correlation as published (1)",
        "Worst angle, all stages at once (°)",
    )
    return Table(
        columns(heads, rows),
        "The worst angle, and the least correlation of a face's distances with a "
        "normal law, with one of the bench's two numbers halved or doubled. Geometry "
        f"A. {MEDIANS}",
    )
