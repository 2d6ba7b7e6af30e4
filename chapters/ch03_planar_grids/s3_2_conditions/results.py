"""The numbers that the page on the conditions of section 3.3.2 quotes."""

from __future__ import annotations

from collections import Counter

import numpy as np

from chapters.ch03_planar_grids.s3_2_conditions.claims import (
    CAMERAS,
    all_orders,
    differing,
    in_light,
    levels_run,
    merging_of,
    shadow_effects,
)
from chapters.ch03_planar_grids.s3_2_conditions.tables import (
    ends_of_orders,
)
from chapters.ch03_planar_grids.s3_2_conditions.trials.click_orders import (
    DONE,
    WRONG,
)
from chapters.shared.grid_trials import (
    CELECT,
    CLICKLESS,
    LINEAR,
    OPENCV,
    OPENCV_SB,
)
from repro.page.reader import value

NAMES = {
    CELECT: "celect",
    LINEAR: "linear",
    OPENCV: "opencv",
    OPENCV_SB: "sector",
    CLICKLESS: "raxel",
}
DIM = 0.1


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    _name_parts(open_results("fig_3_14_parts"))
    _name_light(open_results("exp_c3_low_contrast"))
    shadow = open_results("exp_c3_shadow")
    for method, name in NAMES.items():
        value(f"shadow.{name}", 100 * shadow_effects(shadow, method).value)
    value(
        "shadow.celect.plain",
        100 * shadow.column(f"plain.{CELECT}").mean(),
    )
    direction = open_results("exp_c3_trace_direction")
    for name, tone in (("orders", ""), ("undone", "linear_")):
        orders = all_orders(direction, tone)
        value(f"{name}.differ", 100 * differing(orders).mean())
        value(f"{name}.smallest", 100 * orders[0, 0].mean())
        value(f"{name}.largest", 100 * orders[0, -1].mean())
        value(f"{name}.best", 100 * orders.max(axis=(0, 1)).mean())
        value(f"{name}.never", 100 * (1 - orders.max(axis=(0, 1))).mean())
    ends = ends_of_orders(direction, direction.conditions)
    value("orders.failed", ends.total() - ends[DONE])
    value("orders.silent", ends[WRONG])
    both = {
        "exp_c3_shadow": shadow,
        "exp_c3_merge_images": open_results("exp_c3_merge_images"),
    }
    for name, tone in (("merge", ""), ("merge.undone", "linear.")):
        ratio, failed, success = merging_of(both, tone)
        value(f"{name}.images", len(failed))
        value(f"{name}.count", int(failed.sum()))
        value(f"{name}.lost", int((success == 0).sum()))
        thirds = np.array_split(failed[np.argsort(ratio)], 3)
        value(f"{name}.even", 100 * thirds[0].mean())
        value(f"{name}.uneven", 100 * thirds[-1].mean())


def _name_parts(result):
    value("pictures", result.trials_per_condition)
    lost = Counter()
    for camera in CAMERAS:
        ours, theirs = (
            result.column(f"{method}.count", camera=camera)
            for method in (CELECT, OPENCV)
        )
        value(
            f"part.{camera}",
            float(np.median(ours / np.maximum(theirs, 1))),
        )
        for name in result.names():
            if name.startswith("celect.lost."):
                count = np.nansum(result.column(name, camera=camera))
                lost[name.removeprefix("celect.lost.")] += int(count)
    value("part.stage", lost.most_common(1)[0][0] if lost else "none")


def _name_light(result):
    levels = levels_run(result)
    dim = min(levels, key=lambda v: abs(v - DIM))
    value("light.dim", dim)
    for method, name in NAMES.items():
        rates = {
            v: 100 * in_light(result, v, method).mean() for v in levels
        }
        value(f"light.{name}.best", max(rates.values()))
        value(f"light.{name}.dim", rates[dim])
