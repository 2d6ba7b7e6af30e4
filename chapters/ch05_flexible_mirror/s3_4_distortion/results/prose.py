"""The numbers that the page quotes: medians over the seeds that came so far, in words.

Where no seed came so far, as in quick builds, there is a word for that.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.results.exact import exact_radii
from chapters.ch05_flexible_mirror.s3_4_distortion.results.predicates import (
    alike,
    conic_departs,
    face_left,
    radius_errors,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.results.runs import (
    FIRST,
    LAST,
    RUNS,
    STAGES,
    SWEPT_RUNS,
    CircleRuns,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.face import PER_PX
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import RADIUS_MM
from chapters.shared.mirror_bench import LABORATORY, LEVEL
from repro.judge.statistics import median_and_range, ratio_of
from repro.page.reader import value

SHORT = {LEVEL: "", LABORATORY: "lab."}
ENDS = {"half the aberration": "evener", "twice the aberration": "waved"}


def in_words(number, form=".2g"):
    """A number as the prose has it."""
    return format(float(number), form) if np.isfinite(number) else "(no number)"


def middle(found):
    """Median of the trials that have a value, nan without any."""
    return median_and_range(found).value


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, SWEPT_RUNS)}
    for name, said in of_results(results).items():
        value(name, said)


def of_results(results):
    """{name: words or a count} of all that is quoted."""
    found = {"exact": in_words(np.abs(exact_radii()).max(), ".0e")}
    for bench, short in SHORT.items():
        of_bench = quoted(CircleRuns(results, bench=bench))
        found |= {f"{short}{name}": said for name, said in of_bench.items()}
    for end, short in ENDS.items():
        runs = CircleRuns(results, bench=end)
        found[f"{short}.refused"] = runs.refused()
        found[f"{short}.conic"] = share_of_conic(runs)
    return found | {"ends.seeds": runs.seeds}


def quoted(runs):
    """{name: words or a count} of one bench."""
    found = {
        "seeds": runs.seeds,
        "refused": runs.refused(),
        "face.refused": runs.face_refused(),
    }
    for name, stages in by_stage(runs).items():
        medians = [middle(of_stage) for of_stage in stages]
        for stage, median in zip(STAGES, medians, strict=True):
            found[f"{name}.{stage}"] = in_words(median)
        found[f"{name}.most"] = in_words(max(medians))
    off = np.abs(radius_errors(runs))
    found["radius.worst"] = in_words(median_and_range(off.max(axis=0)).high)
    found["growth"] = in_words(growth(runs, "residual_mm"))
    found["angle.growth"] = in_words(growth(runs, "angle_deg"))
    found["alike"] = in_words(middle(alike(runs)))
    for name, camera in (("face", "calibrated"), ("face.true", "true")):
        found[name] = in_words(100 * middle(face_left(runs, camera)), ".0f")
    for name in ("raw", "corrected"):
        found[f"face.{name}"] = in_words(PER_PX * middle(runs.face(f"{name}_px")))
    found["conic.share"] = share_of_conic(runs)
    return found


def by_stage(runs):
    """{name: (stages, seeds)} of what is quoted stage by stage."""
    placed = runs.at("true_pose_radius_mm") / RADIUS_MM - 1
    return {
        "radius": np.abs(radius_errors(runs)),
        "placed": 100 * np.abs(placed),
        "residual": runs.at("residual_mm"),
        "angle": runs.at("angle_deg"),
        "pose": runs.at("pose_mm"),
        "true": runs.at("residual_mm", "true"),
        "conic": runs.at("conic_px", "picture"),
    }


def growth(runs, name):
    """From the first calibrated deflection to the last, seed by seed; a seed that was
    refused counts as the worst, as where it is judged."""
    pair = (runs.of(stage, name) for stage in (LAST, FIRST))
    return ratio_of("median", *pair, paired=True).value


def share_of_conic(runs):
    """Of the seeds, those whose circle departs from a conic step by step, %."""
    return in_words(100 * np.mean(conic_departs(runs)[0]), ".0f")
