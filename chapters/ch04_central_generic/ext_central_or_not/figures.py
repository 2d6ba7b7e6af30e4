"""Measured against true distance, and detection rates of the test."""

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch04_central_generic.ext_central_or_not.results import (
    NAMES,
    RUNS,
    alarms,
    median,
)
from chapters.ch04_central_generic.ext_central_or_not.trials import CAMERAS, NOISES_MM
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing


@figure("ext_centrality", needs=("ext_centrality_runs",), evidence="synthetic")
def central_or_not(results):
    """Draw distances with bounds on the left, detection rates on the right."""
    result = results[RUNS]
    drawn, (left, right) = new_figure(1, 2, height_in=3.6)
    rows, records = np.arange(len(CAMERAS))[::-1], []
    for index, noise in enumerate(NOISES_MM):
        look = series(index) | {"linestyle": "", "capsize": 3}
        label = f"noise {noise:g} mm"
        found = np.array(
            [
                [
                    median(result, field, camera, noise).value
                    for field in ("true_mm", "found_mm", "least_mm", "most_mm")
                ]
                for camera in CAMERAS
            ]
        )
        true, middle, low, high = found.T
        ends = np.abs([middle - low, high - middle])
        left.errorbar(true, middle, yerr=ends, label=label, **look)
        shares = [alarms(result, camera, noise) for camera in CAMERAS]
        share, least, most = 100 * np.array([s[:3] for s in shares]).T
        right.errorbar(
            share,
            rows + 0.2 * (0.5 - index),
            xerr=np.abs([share - least, most - share]),
            **look,
        )
        records += [
            (camera, noise, *found[i], share[i], least[i], most[i])
            for i, camera in enumerate(CAMERAS)
        ]
    reach = [0, 1.1 * max(row[2] for row in records)]
    left.plot(reach, reach, color="0.5", linewidth=0.8, marker="", label="equal")
    left.set(xlabel="True RMS distance (mm)", ylabel="Measured RMS distance (mm)")
    left.legend()
    right.set_yticks(rows)
    right.yaxis.set_major_formatter(
        FixedFormatter([NAMES[camera] for camera in CAMERAS])
    )
    right.set(xlabel="Alarms at the 1 % level (%)", xlim=(-3, 103))
    names = ["camera", "noise_mm", "true_mm", "found_mm", "least_mm", "most_mm"]
    names += ["alarms_percent", "alarms_low", "alarms_high"]
    return Drawing(
        drawn,
        columns(tuple(names), records),
        "Left: measured against true RMS distance of the rays from one point, medians "
        "over trials, with bars between the medians of the two 95 % bounds. Right: "
        "share of trials in which the test rejects centrality at 1 %, with 95 % "
        "intervals.",
    )
