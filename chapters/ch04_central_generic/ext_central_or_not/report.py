"""Results of this page read: values of the prose, figures, tables."""

import numpy as np

from chapters.ch04_central_generic.ext_central_or_not.experiment import (
    ALARM,
    CAMERAS,
    CENTRAL,
    NOISES_MM,
)
from repro.page import new_figure, series, value
from repro.run import Drawing, columns, figure, median_interval, proportion

# Names of the cameras, and the numbers of the text.


NAMES = {
    "central": "fisheye, central",
    "pupil": "fisheye, moving pupil",
    "mirror_aligned": "mirror, aligned",
    "mirror_half": "mirror, 0.5 mm offset",
    "mirror_one": "mirror, 1 mm offset",
    "mirror_two": "mirror, 2 mm offset",
}


def median(result, field, camera, noise_mm):
    """Return the median of a field over a camera's trials at one noise."""
    found = result.column(field, camera=camera, noise_mm=noise_mm)
    return median_interval(found).value


def alarms(result, camera, noise_mm):
    """Return the share (%) of trials that the test calls non-central, an Estimate."""
    p = result.column("p", camera=camera, noise_mm=noise_mm)
    return proportion(p < ALARM).times(100)


def name_values(open_results):
    """Name the numbers that the text quotes."""
    result, noise = open_results("ext_centrality_runs"), max(NOISES_MM)
    p = [result.select(camera=camera).column("p") for camera in CENTRAL]
    false = proportion(np.concatenate(p) < ALARM)
    value("false", 100 * false.value)
    value("false.high", 100 * false.high)
    for camera in ("mirror_one", "mirror_two"):
        value(f"alarms.{camera}", alarms(result, camera, noise).value)
    for field in ("lines_miss_mm", "central_miss_mm"):
        value(f"{field}.central", median(result, field, "central", noise))


# Measured against true distance, and detection rates of the test.


@figure("ext_centrality", needs=("ext_centrality_runs",), evidence="synthetic")
def central_or_not(results):
    """Draw distances with bounds on the left, detection rates on the right."""
    from matplotlib.ticker import FixedFormatter

    result = results["ext_centrality_runs"]
    drawn, (left, right) = new_figure(1, 2, height_in=3.6)
    rows, records = np.arange(len(CAMERAS))[::-1], []
    for index, noise in enumerate(NOISES_MM):
        look = series(index) | {"linestyle": "", "capsize": 3}
        found = np.array(
            [
                [
                    median(result, field, camera, noise)
                    for field in ("true_mm", "found_mm", "least_mm", "most_mm")
                ]
                for camera in CAMERAS
            ]
        )
        true, middle, low, high = found.T
        ends = np.abs([middle - low, high - middle])
        left.errorbar(true, middle, yerr=ends, label=f"noise {noise:g} mm", **look)
        shares = [alarms(result, camera, noise)[:3] for camera in CAMERAS]
        share, low, high = np.transpose(shares)
        right.errorbar(
            share,
            rows + 0.2 * (0.5 - index),
            xerr=np.abs([share - low, high - share]),
            **look,
        )
        records += [
            (camera, noise, *row, *percent)
            for camera, row, percent in zip(CAMERAS, found, shares, strict=True)
        ]
    reach = [0, 1.1 * max(row[2] for row in records)]
    left.plot(reach, reach, color="0.5", linewidth=0.8, marker="", label="equal")
    left.set(xlabel="True RMS distance (mm)", ylabel="Measured RMS distance (mm)")
    left.legend()
    right.set_yticks(rows)
    right.yaxis.set_major_formatter(FixedFormatter([NAMES[c] for c in CAMERAS]))
    right.set(xlabel="Alarms at the 1 % level (%)", xlim=(-3, 103))
    names = ("camera", "noise_mm", "true_mm", "found_mm", "least_mm", "most_mm")
    shares = ("alarms_percent", "alarms_low", "alarms_high")
    return Drawing(
        drawn,
        columns((*names, *shares), records),
        "Left: measured against true RMS distance of the rays from one point, medians "
        "over trials, with bars between the medians of the two 95 % bounds. Right: "
        "share of trials in which the test rejects centrality at 1 %, with 95 % "
        "intervals.",
    )
