"""Table 5.8 at all levels, its numbers, and what they depend on."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.results.runs import (
    MATCHED,
    PUBLISHED,
    WAYS,
    TinRuns,
)
from chapters.ch05_flexible_mirror.s3_5_tin.trials.tin import (
    ANGLES_DEG,
    PAIRS,
    SHIFT_MM,
)
from chapters.shared.mirror_bench import BENCHES, SAID
from chapters.shared.mirror_tables import beside, reached
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Table, Value

SET = "the tin's faces meet at the angles of the thesis's laser scan"
MOVED = "the camera is moved by this distance"
MEDIANS = "Medians over the runs that have a tin, with 95 % intervals."


@table("table_5_8", needs=("table_5_8_runs",), evidence="rendered")
def table_5_8(results):
    """Angles between the faces, estimated and true."""
    rows = []
    for bench in BENCHES:
        runs = TinRuns(results, bench=bench)
        for k, pair in enumerate(PAIRS):
            rows.append(
                (
                    SAID[bench],
                    pair.replace("_", " - "),
                    reached(runs.angles(PUBLISHED)[k]),
                    float(ANGLES_DEG[k]),
                    reached(runs.angles("true")[k]),
                )
            )
    ids = {
        "As published (°)": beside([f"t5_8_{pair}_est" for pair in PAIRS], len(rows)),
        "Reference (°)": beside([f"t5_8_{pair}_ref" for pair in PAIRS], len(rows)),
    }
    heads = ("Error level", "Faces", *ids, "True mirror (°)")
    return Table(
        columns(heads, rows),
        "Angles between the planes of the tin's faces: with the published calibration, "
        f"reference, and with the true mirror. Geometry A. {MEDIANS}",
        printed=ids,
    )


@table("ext_tin_ways", needs=("table_5_8_runs",), evidence="rendered")
def ext_tin_ways(results):
    """Errors of angles, rays and planes, by mirror."""
    rows = []
    for bench, way in ((b, w) for b in BENCHES for w in WAYS):
        runs = TinRuns(results, bench=bench)
        found = runs.of("off_deg", way)
        rows.append(
            (
                SAID[bench],
                WAYS[way],
                int(np.isfinite(found).sum()),
                reached(runs.of("ray_deg", way)),
                reached(runs.of("rms_mm", way)),
                reached(found),
            )
        )
    heads = (
        "Error level",
        "Mirror",
        "Runs",
        "Mean ray error (°)",
        "Distance from planes, RMS (mm)",
        "Worst angle error (°)",
    )
    return Table(
        columns(heads, rows),
        "Errors of the rays, distances of points from their own planes, and error of "
        f"the worst of the three angles, by mirror. Geometry A. {MEDIANS}",
    )


def of_runs(runs, found, unit):
    """Return the Value of a measure (seeds,), and how many runs have none."""
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} runs were rejected" if lost else ""
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
    """Translation of the camera, and matches on the tin in rendered images."""
    counts = results["fig_5_22_pictures"].column(MATCHED)
    return {
        "s5_3_5_tin_t": Value(SHIFT_MM, unit="mm", put_in=MOVED),
        "s5_3_5_tin_n": Value.of_seeds(counts, "count"),
    }
