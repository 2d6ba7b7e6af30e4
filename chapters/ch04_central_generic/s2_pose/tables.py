"""Table 4.1, from pictures and redrawn; samples of three and four; times."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s2_pose.results import (
    TABLE_MEASURES,
    finite_of_four,
    table_trials,
    without_solution,
)
from chapters.ch04_central_generic.s2_pose.trials.estimators import ESTIMATORS, NAMES
from chapters.ch04_central_generic.s2_pose.trials.kodak import (
    OUTLIERS,
    PUT_IN,
    TABULATED,
)
from chapters.ch04_central_generic.s2_pose.trials.sources import NOISE_PX, SOURCES
from chapters.ch04_central_generic.s2_pose.trials.triplets import APART
from repro.judge.statistics import proportion
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

PRINTED = ("standard", "cgsp", "cgsp_ransac")
NICE = (1, 2, 5)
BOTH = ("table_4_1_rendered", "table_4_1_redrawn")
SAMPLES = ("exp_c4_3pt_sensitive", "exp_c4_3pt_no_solution", "exp_c4_linear_always")


def errors_of(result, name):
    """Both errors of one estimator or sample, for two cells."""
    return [
        Measured.median_or_none(result.column(f"{name}.{measure}"))
        for measure in TABLE_MEASURES
    ]


@table("table_4_1", needs=("table_4_1_rendered",), evidence="rendered")
def table_4_1(results):
    """Pose errors of the three estimators, from rendered pictures."""
    result = results["table_4_1_rendered"]
    units = ("Rotation error (°)", "Translation error (mm)")
    rows = [
        (unit, *(float(np.median(table_trials(result, e, measure))) for e in PRINTED))
        for unit, measure in zip(units, TABLE_MEASURES, strict=True)
    ]
    estimators = ("Standard + RANSAC", "CGSP", "CGSP + RANSAC")
    printed = {
        head: [f"t4_1_{short}_rot", f"t4_1_{short}_trans"]
        for head, short in zip(
            estimators, ("std_ransac", "cgsp", "cgsp_ransac"), strict=True
        )
    }
    return Table(
        columns(("Error", *estimators), rows),
        "Error of the pose of an active grid relative to another, decoded "
        f"from rendered pictures with errors as large as the bench's, with {PUT_IN} "
        "of outliers put in: medians "
        f"over {len(result.conditions)} seeds, against a laser scan. The "
        "standard method is refined on its inliers.",
        printed=printed,
    )


@table("ext_table_4_1", needs=BOTH, evidence="rendered")
def all_of_table_4_1(results):
    """Every estimator, with and without outliers, rendered and redrawn."""
    rendered, redrawn = (results[name] for name in BOTH)
    rows = []
    for noise, outliers, name in product(TABULATED, OUTLIERS, ESTIMATORS):
        cells = []
        for measure in TABLE_MEASURES:
            of_seeds, of_scenes = (
                table_trials(result, name, measure, outliers, noise)
                for result in (rendered, redrawn)
            )
            cells += [float(np.median(of_seeds)), Measured.median_or_none(of_scenes)]
        rows.append((noise, outliers, NAMES[name], *cells))
    return Table(
        columns(
            (
                "Noise",
                "Outliers",
                "Estimator",
                "Rotation, pictures (°)",
                "Rotation, redrawn (°)",
                "Translation, pictures (mm)",
                "Translation, redrawn (mm)",
            ),
            rows,
        ),
        f"Medians over {len(rendered.conditions)} seeds from pictures, and "
        f"over {redrawn.trials_per_condition} scenes with the decoding "
        "errors of those pictures (with 95 % intervals): as they are in the "
        "laboratory, or as large as the bench's.",
    )


@table("ext_samples", needs=SAMPLES, evidence="synthetic")
def samples(results):
    """What three points and four give, one sample at a time."""
    errors, counts, four = (results[name] for name in SAMPLES)
    rows = [
        (
            f"three points, {kind.replace(' three points', '')}",
            *lost_share(*without_solution(counts, kind)),
            *errors_of(errors, kind),
        )
        for kind in APART
    ]
    off = [Measured.median_or_none(four.column(measure)) for measure in TABLE_MEASURES]
    for plane, name in (
        ("of_4_24", "four points, plane of (4.24)"),
        ("facing", "four points, plane that all rays meet"),
    ):
        finite, total = finite_of_four(four, plane)
        cells = off if plane == "facing" else (None, None)
        rows.append((name, *lost_share(total - finite, total), *cells))
    return Table(
        columns(
            (
                "Sample",
                "Samples",
                "Without a pose (%)",
                "Rotation error (°)",
                "Translation error (mm)",
            ),
            rows,
        ),
        "The smallest samples that give a pose, with half a pixel of noise: "
        "medians over scenes of the median over their samples. Of several "
        "solutions of three points the nearest to the truth counts.",
    )


def lost_share(lost, total):
    """(samples, share without a pose in % with its exact interval)."""
    return total, Measured(*proportion(np.arange(total) < lost).times(100)[:3])


@table("ext_pose_rays", needs=("ext_pose_rays_run",), evidence="synthetic")
def pose_rays(results):
    """The refined pose by the source of its rays."""
    result = results["ext_pose_rays_run"]
    rows = [(name, *errors_of(result, source)) for source, name in SOURCES.items()]
    return Table(
        columns(("Rays", "Rotation error (°)", "Translation error (mm)"), rows),
        "Error of a further grid's pose with the smallest angles, by where "
        f"its rays come from; {NOISE_PX:g} px of noise on every grid. Centre "
        "and other poses are known in all rows but the last. Medians over "
        "trials with their intervals.",
    )


@table("ext_pose_times", needs=("ext_pose_times_run",), evidence="synthetic")
def pose_times(results):
    """Processor time of each estimator, coarsely."""
    result = results["ext_pose_times_run"]
    counts = result.levels("points")
    rows = [
        (
            NAMES[name],
            *(coarse(1000 * result.column(name, points=count)[0]) for count in counts),
        )
        for name in ESTIMATORS
    ]
    return Table(
        columns(("Estimator", *(f"{count} points (ms)" for count in counts)), rows),
        "Time of each estimator on one processor, to the nearest of 1, 2, "
        "5, 10, ... ms.",
    )


def coarse(number):
    """The nearest of 1, 2, 5, 10, ... by ratio."""
    scales = [m * 10.0**e for e in range(-3, 6) for m in NICE]
    nearest = scales[int(np.argmin([abs(np.log(number / scale)) for scale in scales]))]
    return round(nearest) if nearest >= 1 else round(nearest, 3)
