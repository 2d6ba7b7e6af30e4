"""Table 5.9 at all levels, other features, and the numbers of 5.4."""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.results.runs import (
    OBJECTS,
    STAGES,
    STEP_MM,
    THESIS_SCENE,
    Courses,
)
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.course import SCENES
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.scene import DEPTHS_MM
from chapters.shared.mirror_bench import BENCHES, SAID
from chapters.shared.mirror_tables import MEDIANS, beside, reached
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Table, Value

NEEDS = ("table_5_9_runs",)
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
        columns(_heads(), rows),
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
        columns(_heads("Features", names=OF_FEATURES), rows),
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
