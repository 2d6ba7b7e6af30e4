"""Numbers that the prose of section 3.1.2 quotes."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.celect_claims import BROKEN
from chapters.ch03_planar_grids.celect_scenes import CAMERAS
from repro.reader import value

LARGE_PX = 15
NAMES = dict(
    zip(CAMERAS, ("fisheye", "sphere", "hyperboloid", "sheet"), strict=True)
)


def name_values(open_results):
    """Name every quoted number, from the results of this effort."""
    of_cameras(open_results("fig_3_1_cameras"))
    of_windows(open_results("table_3_1_window"))
    growth = open_results("table_3_1_growth")
    first = next(iter(BROKEN.values()))
    value("grown", percent(growth.column("published.success", **first)))
    value("fixed", percent(growth.column("no growth.success", **first)))
    start = open_results("table_3_2_start")
    predicted = start.column("predicted")
    value("cases", len(predicted))
    value("agree", percent(predicted == start.column("went_wrong")))


def of_cameras(result):
    """Success of each camera, of large squares, and candidates per corner."""
    large, many = [], []
    for camera, name in NAMES.items():
        success = result.column("success", camera=camera)
        value(name, percent(success))
        least = result.column("least_px", camera=camera)
        large.append(success[least >= LARGE_PX])
        read = success == 1
        candidates = result.column("candidates", camera=camera)
        wanted = result.column("wanted", camera=camera)
        many.append((candidates / wanted)[read])
    large, many = np.concatenate(large), np.concatenate(many)
    value("large", percent(large) if len(large) else 0.0)
    value("candidates", float(many.mean()) if len(many) else 0.0)


def of_windows(result):
    """Success with the smallest and the largest window."""
    run = [c["multiplier"] for c in result.conditions]
    for name, multiplier in (("small", run[0]), ("large", run[-1])):
        success = result.column("success", multiplier=multiplier)
        value(f"{name}_window", multiplier)
        value(f"{name}_success", percent(success))


def percent(flags):
    """Share of trials (n,) that are 1, in percent."""
    return 100 * float(np.mean(flags))
