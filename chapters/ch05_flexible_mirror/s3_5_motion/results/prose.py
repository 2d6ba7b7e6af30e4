"""The numbers that the page quotes: medians over the seeds that came so far."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.results import predicates
from chapters.ch05_flexible_mirror.s3_5_motion.results.runs import (
    CAMERAS,
    LAST,
    RUNS,
    STAGES,
    MotionRuns,
)
from chapters.ch05_flexible_mirror.s3_5_motion.trials.motion import seen_by
from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import (
    AWAY_MM,
    RADIUS_MM,
    STEP_MM,
    STEPS,
    moved_cylinder,
)
from chapters.shared.mirror_bench import LABORATORY, LEVEL
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from repro.page.reader import value

SHORT = {LEVEL: "", LABORATORY: "lab."}
WAYS = ("open", "given")
LENGTH_MM = STEPS * STEP_MM


def middle(found):
    """Median of the trials that have a value, as words; a build may have none."""
    known = found[np.isfinite(found)]
    return said(np.median(known)) if len(known) else "no"


def said(number):
    """A number in two digits, or in whole ones, as words."""
    return f"{number:.2g}" if abs(number) < 10 else f"{number:.0f}"


def ends(found, end):
    """The least or the most of the trials that have a value, as words."""
    known = found[np.isfinite(found)]
    return said(end(known)) if len(known) else "no"


def percent_off(radii):
    """Median of how far radii are off, %."""
    return middle(100 * np.abs(radii / RADIUS_MM - 1))


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {RUNS: open_results(RUNS)}
    found = dict(
        zip(("way", "alike", "parallax"), map(said, seen_shift()), strict=True)
    )
    found["away"] = AWAY_MM
    for bench, short in SHORT.items():
        runs = MotionRuns(results, bench=bench)
        found |= named(short, of_cameras(runs) | of_rays(runs) | of_judged(runs))
    for name, number in found.items():
        value(name, number)


def seen_shift():
    """(mm, degrees, degrees): from the rays' centre to the middle of the marks, the
    turn under which one step is seen there, and by how much less at the farthest mark
    than at the nearest. Of a smooth mirror at stage 3."""
    camera = mirror_rig("A").camera(STAGES_MM[LAST])
    scene = moved_cylinder(camera, np.random.default_rng(0))
    away = np.linalg.norm(scene.points - seen_by(camera, scene.pixels).centre, axis=1)
    turns = np.degrees(STEP_MM / away)
    return float(away.mean()), float(turns.mean()), float(np.ptp(turns))


def named(prefix, numbers):
    """The numbers, with a prefix before each name."""
    return {f"{prefix}{name}": number for name, number in numbers.items()}


def of_cameras(runs):
    """Name -> turns, scale and radius that each camera finds by each way."""
    out = {}
    for camera in CAMERAS:
        for way in WAYS:
            turn = runs.steps("turn_deg", camera, way)
            out |= named(
                f"{camera}.{way}.",
                {
                    "first": middle(turn[0]),
                    "last": middle(turn[-1]),
                    "off": middle(runs.steps("off_mm", camera, way)[-1]),
                    "mean": middle(runs.of("mean_mm", camera, way)),
                    "radius": percent_off(runs.of("scaled_mm", camera, way)),
                },
            )
        out[f"{camera}.ray"] = middle(runs.column(f"{camera}.ray_deg"))
        sd = runs.of("told_percent", camera, "together")
        out[f"{camera}.six.told"] = middle(sd)
        length = runs.of("length_mm", camera, "together") / LENGTH_MM
        out[f"{camera}.six.share"] = middle(length)
    return out


def of_rays(runs):
    """Name -> what rays of the true mirror tell, and the scales that are found."""
    out = {}
    for stage in STAGES:
        for name, what in (
            ("spread", "spread_mm"),
            ("told", "told1.length_percent"),
            ("told.far", "told5.length_percent"),
        ):
            out[f"{name}.{stage}"] = middle(runs.column(f"stage{stage}.{what}"))
    logs = predicates.log_scales(runs)
    out |= {f"times.{s}": said(np.exp(np.median(logs[s]))) for s in STAGES}
    out |= {f"scatter.{s}": said(np.exp(np.std(logs[s]))) for s in STAGES}
    return out


def of_judged(runs):
    """Name -> seeds, refusals, and the range of mean steps."""
    lost = [bool(reason) for reason in runs.refused()]
    has = np.isfinite(runs.of("radius_mm"))
    return {
        "seeds": runs.seeds,
        "refused": sum(lost),
        "no_shape": int(runs.seeds - sum(lost) - has.sum()),
        "least": ends(runs.of("mean_mm"), np.min),
        "most": ends(runs.of("mean_mm"), np.max),
    }
