"""Errors, ratios and counts of section 4.2, and the numbers that its page quotes."""

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.simulated import RAYS
from chapters.ch04_central_generic.s2_pose.trials.triplets import APART, DRAWS
from repro.judge.statistics import bootstrap, median_interval, with_worst
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


def ratio(numerator, denominator):
    """Ratio of the medians of paired trials, failures counting as worst."""
    return bootstrap(
        lambda a, b: np.median(a, axis=-1) / np.median(b, axis=-1),
        with_worst(numerator),
        with_worst(denominator),
        paired=True,
    )


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
    of_noise(open_results("fig_4_4_noise"))
    of_table(open_results("table_4_1_redrawn"))
    of_decoding(open_results("table_4_1_rendered"))
    of_triplets(
        open_results("exp_c4_3pt_no_solution"), open_results("exp_c4_3pt_sensitive")
    )
    of_planes(open_results("exp_c4_plane_orientation"))
    of_sources(open_results("ext_pose_rays_run"))


def of_noise(result):
    """Medians of the simulation at half a pixel."""
    for estimator in ("three_points", "cgsp_ransac", "angular"):
        trials = trials_of(result, estimator, "rotation_deg", SHOWN_PX)
        value(f"{estimator}_deg", median_interval(trials).value)
    exact = trials_of(result, "angular", "rotation_deg", SHOWN_PX, rays="exact")
    value("angular_exact_deg", median_interval(exact).value)
    coarse = trials_of(result, "three_points", "rotation_deg", SHOWN_PX)
    fine = trials_of(result, "standard", "rotation_deg", SHOWN_PX)
    value("refining", float(np.median(coarse) / np.median(fine)))


def of_sources(result):
    """Medians of the angular pose by the source of its rays."""
    for source in ("three", "smooth", "calibrated"):
        trials = result.column(f"{source}.rotation_deg")
        value(f"rays_{source}_deg", median_interval(trials).value)


def of_table(result):
    """Medians of Table 4.1's redrawn scenes with the outliers put in."""
    for estimator in ("cgsp", "cgsp_ransac"):
        trials = table_trials(result, estimator, "translation_mm")
        value(f"scenes_{estimator}_mm", float(np.median(trials)))


def of_decoding(result):
    """What the pictures' decoding was like, and the calibration from boards."""
    seeds = result.select()
    bias = [np.abs(found).max() for found in seeds.arrays("decoding.bias_mm")]
    sd = [found.mean() for found in seeds.arrays("decoding.sd_mm")]
    value("rendered_seeds", len(seeds.conditions))
    value("wrong_percent", 100 * float(seeds.column("decoding.outlier_share").max()))
    value("bias_mm", float(max(bias)))
    value("noise_mm", float(np.mean(sd)))
    value("zhang_px", float(seeds.column("zhang.rms_px").mean()))


def of_triplets(counts, errors):
    """Shares of triples without a solution, and how errors compare."""
    for kind in APART:
        lost, total = without_solution(counts, kind)
        value(f"lost_{kind.split()[0]}", 100 * lost / total)
    close, far = (
        np.median(errors.column(f"{kind}.rotation_deg"))
        for kind in ("close together", "far apart")
    )
    value("close_far", float(close / far))


def of_planes(result):
    """How much worse a plane at 60 degrees is."""
    best, other = (
        np.median(result.column(f"common.{tilt}.rotation_deg")) for tilt in (0, 60)
    )
    value("tilt_60", float(other / best))
    lost = 1 - np.median(result.column("share_common"))
    value("lost_rays", 100 * float(lost))
