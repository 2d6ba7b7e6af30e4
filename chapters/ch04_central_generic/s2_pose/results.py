"""Errors, ratios and counts of section 4.2, and the numbers that its page quotes."""

from functools import partial

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.simulated import RAYS
from chapters.ch04_central_generic.s2_pose.trials.triplets import APART, DRAWS
from repro.judge.statistics import median_ratio
from repro.page.reader import value

PRIMARY = {"domain": "px", "rays": RAYS[0], "unit": "length"}
MEASURES = ("rotation_deg", "translation_percent")
TABLE_MEASURES = ("rotation_deg", "translation_mm")
IN_WORDS = {
    "rotation_deg": "rotation",
    "translation_percent": "translation",
    "translation_mm": "translation",
}
PUT_IN = "0.3 %"
SHOWN_PX = 0.5


def trials_of(result, estimator, measure, noise, **condition):
    """Errors (n,) of an estimator at one noise, nan where it failed."""
    condition = PRIMARY | condition
    return result.column(f"{estimator}.{measure}", noise=noise, **condition)


def table_trials(result, estimator, measure, outliers=PUT_IN):
    """Errors (n,) of Table 4.1's scenes, or seeds, nan where it failed."""
    return result.select().column(f"errors.{outliers}.{estimator}.{measure}")


def without_solution(result, kind):
    """(triples without a pose, all triples) of one kind."""
    lost = result.column(f"{kind}.without")
    return int(lost.sum()), DRAWS * len(lost)


def finite_of_four(result, plane):
    """(samples of four points with a finite pose, all of them)."""
    finite = result.column(f"finite.{plane}")
    return int(finite.sum()), DRAWS * len(finite)


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    turns = partial(
        trials_of, open_results("fig_4_4_noise"), measure="rotation_deg", noise=SHOWN_PX
    )
    scenes = open_results("table_4_1_redrawn")
    counts = open_results("exp_c4_3pt_no_solution")
    triples = open_results("exp_c4_3pt_sensitive")
    planes = open_results("exp_c4_plane_orientation")
    sources = open_results("ext_pose_rays_run")
    seeds = open_results("table_4_1_rendered").select()
    medians = {
        **{f"{e}_deg": turns(e) for e in ("three_points", "cgsp_ransac", "angular")},
        "angular_exact_deg": turns("angular", rays="exact"),
        **{
            f"rays_{source}_deg": sources.column(f"{source}.rotation_deg")
            for source in ("three", "smooth", "calibrated")
        },
        **{
            f"scenes_{e}_mm": table_trials(scenes, e, "translation_mm")
            for e in ("cgsp", "cgsp_ransac")
        },
    }
    found = {name: np.median(trials) for name, trials in medians.items()} | {
        "refining": median_ratio(turns("three_points"), turns("standard")).value,
        "rendered_seeds": len(seeds.conditions),
        "wrong_percent": 100 * seeds.column("decoding.outlier_share").max(),
        "bias_mm": max(np.abs(bias).max() for bias in seeds.arrays("decoding.bias_mm")),
        "noise_mm": np.mean([sd.mean() for sd in seeds.arrays("decoding.sd_mm")]),
        "zhang_px": seeds.column("zhang.rms_px").mean(),
        **{
            f"lost_{kind.split()[0]}": 100 * np.divide(*without_solution(counts, kind))
            for kind in APART
        },
        "close_far": median_ratio(
            triples.column("close together.rotation_deg"),
            triples.column("far apart.rotation_deg"),
        ).value,
        "tilt_60": median_ratio(
            *(planes.column(f"common.{tilt}.rotation_deg") for tilt in (60, 0))
        ).value,
        "lost_rays": 100 * (1 - np.median(planes.column("share_common"))),
    }
    for name, number in found.items():
        value(name, number)
