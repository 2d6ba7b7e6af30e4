"""Numbers quoted on the page: medians over the runs that completed."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.results.runs import (
    LAST,
    RUNS,
    MotionRuns,
)
from chapters.ch05_flexible_mirror.s3_5_motion.trials.motion import seen_by
from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import (
    STEP_MM,
    STEPS,
    moved_cylinder,
)
from chapters.shared.mirror_bench import LABORATORY, LEVEL
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from repro.page.reader import value

LENGTH_MM = STEPS * STEP_MM


def middle(found):
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
    value("true.given.last", middle(turn[-1]))
    runs = MotionRuns(results, bench=LABORATORY)
    value("lab.published.open.off", middle(runs.steps("off_mm")[-1]))
    step_sd = runs.column(f"stage{LAST}.told1.length_percent")
    value(f"lab.told.{LAST}", middle(step_sd))
    length = runs.of("length_mm", way="together") / LENGTH_MM
    value("lab.published.six.share", middle(length))
    sd = runs.of("told_percent", way="together")
    value("lab.published.six.told", middle(sd))


def parallax():
    """How much more the nearest mark moves in one step than the farthest, degrees.

    Seen from the point next to all rays of a smooth mirror at stage 3.
    """
    camera = mirror_rig("A").camera(STAGES_MM[LAST])
    scene = moved_cylinder(camera, np.random.default_rng(0))
    away = np.linalg.norm(scene.points - seen_by(camera, scene.pixels).centre, axis=1)
    return float(np.ptp(np.degrees(STEP_MM / away)))
