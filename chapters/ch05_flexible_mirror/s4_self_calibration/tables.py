"""Table 5.9 on both benches, ways without a target, and the numbers of 5.4."""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.results.predicates import (
    BY_SEED,
    order,
)
from chapters.ch05_flexible_mirror.s4_self_calibration.results.runs import (
    BY_EITHER,
    OBJECTS,
    PICTURES,
    STAGES,
    STEP_MM,
    TOLD,
    Courses,
    pays,
)
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.course import SCENES
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.scene import DEPTHS_MM
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_tables import MEDIANS, reached
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Table, Value

NEEDS = ("table_5_9_runs",)
REACH = "A shape that was found need not reach the load, and its sides still less."
FEATURES = {
    "clustered": "clustered, all far",
    "near": "even, near at the end",
    "even": "even, all far",
}
WAY_NAMES = {
    "linear": "linear, scene at infinity (5.4)",
    "feedback1": "fed back once (5.4)",
    "feedback6": "fed back six times (5.4)",
    "edges": "straight edges, as worded (6.3.3)",
    "lines": "one line in space for each edge",
    "one_depth": "one unknown depth",
    "one_depth_held": "one unknown depth, slope of the clamp held",
}

OF_PICTURES = {
    "sift.kept": "Matches",
    "sift.wrong_kept": "Wrong",
    "sift.match_px": "Right ones off (px)",
    "sift.deflection_mm": "SIFT (mm)",
    "many.deflection_mm": "Drawn, as many (mm)",
    "drawn.deflection_mm": "Drawn, a tenth (mm)",
    "sift.angle_deg": "SIFT (°)",
    "many.angle_deg": "As many (°)",
    "drawn.angle_deg": "A tenth (°)",
}
PUSHED = "the simulated mirror is pushed by so much"
PLACED = "the simulated scene stands there"


HEADS = {
    "deflection_mm": "Self-calibration (mm)",
    "sag_mm": "Sag (mm)",
    "angle_deg": "To true rays (°)",
    "back_mm": "Back-projection (mm)",
    "back_true_mm": "true pose (mm)",
}
# Back-projection with the pose that is found is not asked of all features.
OF_FEATURES = [name for name in HEADS if name != "back_mm"]


def _rows(runs, way, bench, names=tuple(HEADS)):
    of = {name: runs.of(way, name) for name in names}
    # What 5.4 tells of stands in a table of its own.
    features = () if way == TOLD else (FEATURES[way],)
    return [
        (
            bench,
            *features,
            stage,
            int(np.isfinite(of["deflection_mm"][k]).sum()),
            STEP_MM,
            *(reached(of[name][k]) for name in names),
        )
        for k, stage in enumerate(STAGES)
    ]


def _heads(*features, names=tuple(HEADS)):
    first = ("Bench", *features, "Stage", "Seeds", "Actual (mm)")
    return (*first, *(HEADS[name] for name in names))


@table("table_5_9", needs=NEEDS, evidence="rendered")
def table_5_9(results):
    """Deflections by linear self-calibration, as 5.4 tells it."""
    rows = [
        row
        for bench in reversed(BENCHES)
        for row in _rows(Courses(results, bench=bench), TOLD, bench)
    ]
    none = [None for _ in STAGES]
    return Table(
        columns(_heads(), rows),
        "Deflections that self-calibration finds from a distant scene, its features "
        "across the middle of the mirror and near ones at the end that bends; how far "
        "both sides lie beyond the middle, at the load, and what 5.4 does not print: "
        f"rays and back-projection. Geometry A. {MEDIANS} {REACH}",
        printed={
            "Actual (mm)": [f"t5_9_s{k}_actual" for k in STAGES] + none,
            "Self-calibration (mm)": [f"t5_9_s{k}_est" for k in STAGES] + none,
        },
    )


@table("ext_self_features", needs=NEEDS, evidence="rendered")
def ext_self_features(results):
    """The same with features spread otherwise."""
    rows = [
        row
        for bench in reversed(BENCHES)
        for way in SCENES
        if way != TOLD
        for row in _rows(Courses(results, bench=bench), way, bench, OF_FEATURES)
    ]
    return Table(
        columns(_heads("Features", names=OF_FEATURES), rows),
        "The same where features are spread otherwise: over the whole mirror, and "
        f"without near ones. {MEDIANS} {REACH}",
    )


@table("ext_self_ways", needs=("ext_self_ways_runs",), evidence="synthetic")
def ext_self_ways(results):
    """One step by every way."""
    rows = []
    for depth, scene in ((0.0, "4 to 5 m"), (800.0, "0.7 to 0.9 m")):
        found = results["ext_self_ways_runs"].select(depth_mm=depth)
        for way, words in WAY_NAMES.items():
            values = {
                name: found.column(f"{way}.{name}")
                for name in ("deflection_mm", "angle_deg", "rms", "depth_mm")
            }
            came = int(np.isfinite(values["deflection_mm"]).sum())
            rows.append((scene, words, came, *map(reached, values.values())))
    heads = ("Scene", "Way", "Seeds", "Deflection (mm)", "To true rays (°)")
    return Table(
        columns((*heads, "Residual (SD)", "Depth found (mm)"), rows),
        "One step of 2.5 mm without a target, from a mirror that is known but for what "
        "a spline cannot follow: what each way finds of it. Features are spread "
        f"evenly. {MEDIANS}",
    )


@table("ext_self_anew", needs=NEEDS, evidence="rendered")
def ext_self_anew(results):
    """When a calibration by the general method pays (5.5)."""
    rows = []
    for bench in reversed(BENCHES):
        runs = Courses(results, bench=bench)
        start = runs.column("start_deg")
        rows.append((bench, 0, None, reached(start), None))
        for stage in STAGES:
            kept, anew = (runs.of(w, "angle_deg", (stage,))[0] for w in BY_EITHER)
            shares = 100 * pays(kept, anew) if np.isfinite(anew).any() else None
            rows.append((bench, stage, reached(kept), reached(anew), shares))
    heads = ("Bench", "Stage", "From stage to stage (°)", "Primary stage (°)")
    return Table(
        columns((*heads, "Primary nearer (% of the seeds)"), rows),
        "Mean angle to the true rays after each push: of the mirror calibrated from "
        "boards, stage after stage, and of one calibrated anew by the general method "
        f"with the monitor. {MEDIANS} A refused seed counts for the latter.",
    )


@table(
    "ext_self_pictures_table", needs=("ext_self_pictures_runs",), evidence="rendered"
)
def ext_self_pictures_table(results):
    """Each run from pictures, beside drawn features of the same mirror."""
    rows = []
    for bench in reversed(BENCHES):
        found = {
            name: results[PICTURES].column(f"{bench}.{name}") for name in OF_PICTURES
        }
        rows += [
            (bench, run, *(known(found[name][run - 1]) for name in OF_PICTURES))
            for run in range(1, results[PICTURES].trials_per_condition + 1)
        ]
    return Table(
        columns(("Bench", "Run", *OF_PICTURES.values()), rows),
        "One push of 5 mm in two steps, all features far: from rendered pictures, "
        "matched by SIFT, and from drawn features of the same mirror, about as many "
        "and a tenth of that, as in the runs of three pushes: the deflection found and "
        "the mean angle to the true rays. Pictures are of 768 x 576 px. A match is "
        "wrong where it is 3 px or more beside its place; what does not follow a "
        "smooth warp was left out before.",
    )


def known(value):
    """A number, whole where it counts something; None where there is none."""
    if not np.isfinite(value):
        return None
    return int(value) if value == int(value) else float(value)


@table(
    "ext_self_swept",
    needs=("table_5_9_runs", "table_5_9_swept", "table_5_9_other"),
    evidence="rendered",
)
def ext_self_swept(results):
    """Shares of the seeds in which claims are true, from bench to bench."""
    of = {
        bench: Courses(results, bench=bench) for bench in (*reversed(BENCHES), *SWEPT)
    }
    of |= {
        f"B, {bench}": Courses(results, bench=bench, geometry="B")
        for bench in reversed(BENCHES)
    }
    rows = [
        (claim.removeprefix("c5_"), *(share(predicate, runs) for runs in of.values()))
        for claim, predicate in (BY_SEED | {"c5_multi_order": order}).items()
    ]
    return Table(
        columns(("Claim", *(f"{name} (%)" for name in of)), rows),
        "Share of the seeds in which each claim is true, on either bench, with one "
        "of the bench's two numbers halved or doubled, and with geometry B, where "
        "boards are refused before the end. What a refused seed should have says no.",
    )


def share(predicate, runs):
    """% of the seeds in which a claim is true, None where nothing was run."""
    if not np.isfinite(runs.column("start_deg")).any():
        return None
    return 100 * float(np.mean(predicate(runs)[0]))


def _value(runs, found, unit):
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} seeds have none: refused, or out of reach"
    reason = reason if lost else ""
    if lost == runs.seeds:
        return Value(np.inf, unit=unit, reason=reason)
    return Value.of_seeds(found, unit, reason)


@numbers("table_5_9", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_9(results):
    """Deflections found."""
    runs = Courses(results)
    found = runs.of(TOLD, "deflection_mm")
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
