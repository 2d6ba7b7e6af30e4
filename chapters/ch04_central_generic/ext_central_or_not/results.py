"""Names of the cameras, and the numbers of the text."""

import numpy as np

from chapters.ch04_central_generic.ext_central_or_not.trials import (
    ALARM,
    CENTRAL,
    NOISES_MM,
)
from repro.judge.statistics import median_interval, proportion
from repro.page.reader import value

NAMES = {
    "central": "fisheye, central",
    "pupil": "fisheye, moving pupil",
    "mirror_aligned": "mirror, aligned",
    "mirror_half": "mirror, 0.5 mm offset",
    "mirror_one": "mirror, 1 mm offset",
    "mirror_two": "mirror, 2 mm offset",
}
RUNS = "ext_centrality_runs"


def median(result, field, camera, noise_mm):
    """Return the median of a field over a camera's trials at one noise, Estimate."""
    return median_interval(result.column(field, camera=camera, noise_mm=noise_mm))


def alarms(result, camera, noise_mm):
    """Return the share of trials that the test calls non-central, an Estimate."""
    p = result.column("p", camera=camera, noise_mm=noise_mm)
    return proportion(np.asarray(p) < ALARM)


def false_alarms(result):
    """Return the share over all central cameras and both noises, an Estimate."""
    p = [result.select(camera=camera).column("p") for camera in CENTRAL]
    return proportion(np.concatenate(p) < ALARM)


def name_values(open_results):
    """Name the numbers that the text quotes."""
    result = open_results(RUNS)
    false, noise = false_alarms(result), max(NOISES_MM)
    value("false", 100 * false.value)
    value("false.high", 100 * false.high)
    for camera in ("mirror_one", "mirror_two"):
        value(f"alarms.{camera}", 100 * alarms(result, camera, noise).value)
    for field in ("lines_miss_mm", "central_miss_mm"):
        value(f"{field}.central", median(result, field, "central", noise).value)
