"""Names of the cameras, and the numbers that the page quotes."""

import numpy as np

from chapters.ch04_central_generic.ext_central_or_not.trials import (
    ALARM,
    CAMERAS,
    CENTRAL,
    NOISES_MM,
)
from repro.judge.statistics import median_interval, proportion
from repro.page.reader import value

NAMES = {
    "central": "fisheye, central",
    "pupil": "fisheye, moving pupil",
    "mirror_aligned": "mirror, aligned",
    "mirror_half": "mirror, 0.5 mm off",
    "mirror_one": "mirror, 1 mm off",
    "mirror_two": "mirror, 2 mm off",
}
RUNS = "ext_centrality_runs"


def median(result, field, camera, noise_mm):
    """Median of a field over the trials of a camera at a noise, an Estimate."""
    return median_interval(result.column(field, camera=camera, noise_mm=noise_mm))


def alarms(result, camera, noise_mm):
    """Share of trials that the test calls non-central, an Estimate."""
    p = result.column("p", camera=camera, noise_mm=noise_mm)
    return proportion(np.asarray(p) < ALARM)


def false_alarms(result):
    """The share over all cameras that are central, both noises together."""
    p = [result.select(camera=camera).column("p") for camera in CENTRAL]
    return proportion(np.concatenate(p) < ALARM)


def name_values(open_results):
    """Name the numbers of the prose."""
    result = open_results(RUNS)
    false, most = false_alarms(result), max(NOISES_MM)
    found = {
        "false": 100 * false.value,
        "false.high": 100 * false.high,
        **{f"alarms.{c}": 100 * alarms(result, c, most).value for c in CAMERAS},
        **{
            f"{field}.{camera}": median(result, field, camera, most).value
            for camera in CAMERAS
            for field in ("true_mm", "found_mm", "central_miss_mm", "lines_miss_mm")
        },
    }
    for name, number in found.items():
        value(name, number)
