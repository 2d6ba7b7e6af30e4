"""The parts of large grids one by one, and where CELECT's runs ended."""

from collections import Counter

import numpy as np

from chapters.ch03_planar_grids.s3_2_conditions.results import (
    CAMERAS,
    METHODS,
    SPOTS,
    all_orders,
    dim_of,
    ends_of_orders,
    in_light,
    levels_run,
    merging_of,
    numbers_of,
    thirds_of,
)
from chapters.ch03_planar_grids.s3_2_conditions.trials.sheet_views import level_name
from chapters.shared.grid_detectors import CELECT, LINEAR, OPENCV, OPENCV_SB
from chapters.shared.grid_rigs import HARD, WHOLE
from repro.judge.statistics import proportion
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

SHADOWS = {"plain": "fisheye, no shadow", "shadow": "fisheye, a shadow of 30 %"}


@table(
    "ext_partial_grids",
    needs=("fig_3_14_parts", "fig_3_14_parts_sb"),
    evidence="rendered",
)
def ext_partial_grids(results):
    """Every picture of Fig. 3.14's kind."""
    plain, sector = results["fig_3_14_parts"], results["fig_3_14_parts_sb"]
    rows = [
        row
        for camera in CAMERAS
        for method, result in ((CELECT, plain), (OPENCV, plain), (OPENCV_SB, sector))
        for row in parts_of(result, method, camera)
    ]
    heads = (
        "Camera",
        "Picture",
        "Method",
        "Columns",
        "Rows",
        "Corners",
        "To the frame (px)",
        "Parts tried",
    )
    return Table(
        columns(heads, rows),
        "Largest part of a large grid without a border that each method "
        "returns, correct and in order, and the distance of its nearest "
        "corner from the frame of the picture. OpenCV's detectors get white "
        "painted round the part.",
    )


def parts_of(result, method, camera):
    """A row for each picture of one camera."""
    names = ("columns", "rows", "count", "border_px", "tries")
    found = [result.column(f"{method}.{n}", camera=camera) for n in names]
    for k, (long, short, count, border, tries) in enumerate(zip(*found, strict=True)):
        size = [int(long), int(short)] if count else [None, None]
        yield [
            camera,
            k + 1,
            METHODS[method],
            *size,
            int(count),
            float(border) if count else None,
            int(tries),
        ]


CONDITIONS = ("exp_c3_low_contrast", "exp_c3_shadow", "exp_c3_trace_direction")
ORDERS = {
    "all sets, first corner at the smallest square": lambda o: o[0, 0],
    "all sets, first corner at the largest square": lambda o: o[0, -1],
    "all sets, at least one of eight orders": lambda o: o.max(axis=(0, 1)),
    "all sets, all eight orders": lambda o: o.min(axis=(0, 1)),
}


@table("ext_condition_rates", needs=CONDITIONS, evidence="rendered")
def ext_condition_rates(results):
    """Shares of right grids under every condition, in both ranges of poses."""
    light, shadow, direction = (results[name] for name in CONDITIONS)
    levels = levels_run(light)
    shown = {max(levels), dim_of(levels)}
    rows = []
    for poses in (WHOLE, HARD):
        for level in sorted(shown, reverse=True):
            for spots in SPOTS:
                told = f"mirror ball, {level:g} of full light, {spots}"
                found = {m: in_light(light, level, m, poses, spots) for m in METHODS}
                rows.append(rates_row(told, poses, found))
        for name, told in SHADOWS.items():
            found = {m: numbers_of(shadow, f"{name}.{m}", poses) for m in METHODS}
            rows.append(rates_row(told, poses, found))
        for told, taken in ORDERS.items():
            found = {
                m: taken(all_orders(direction, tone, poses))
                for m, tone in ((CELECT, ""), (LINEAR, "linear_"))
            }
            rows.append(rates_row(told, poses, found))
    heads = ("Condition", "Poses", "Images", *METHODS.values())
    return Table(
        columns(heads, rows),
        "Share of boards that come back complete and in order, with its exact "
        "95 % interval. Where a method was not run, nothing stands.",
    )


def rates_row(told, poses, found):
    """One condition: share and interval of each method that was run."""
    shares = [
        Measured(*proportion(found[m])[:3])
        if m in found and np.isfinite(found[m]).all()
        else None
        for m in METHODS
    ]
    return [told, poses, len(found[CELECT]), *shares]


@table(
    "ext_merge_failures",
    needs=("exp_c3_shadow", "exp_c3_merge_images"),
    evidence="rendered",
)
def ext_merge_failures(results):
    """Merge failures by how much the squares vary, in both ranges of poses."""
    rows = []
    for poses in (WHOLE, HARD):
        for told, tone in (("as it is", ""), ("undone", "linear.")):
            ratio, failed, success = merging_of(results, tone, poses)
            even, uneven = (
                Measured(*proportion(part)[:3]) for part in thirds_of(ratio, failed)
            )
            lost = int((success == 0).sum())
            counts = [len(failed), lost, int(failed.sum())]
            rows.append([poses, told, *counts, even, uneven])
    heads = (
        "Poses",
        "Tone curve",
        "Images",
        "Lost",
        "With a merge failure",
        "Share, most even third",
        "Share, most uneven third",
    )
    return Table(
        columns(heads, rows),
        "Fisheye images without a shadow: those that CELECT loses, those with "
        "a merge failure, and the share of these where the squares vary least "
        "and most along a contour, with exact 95 % intervals.",
    )


@table(
    "ext_condition_failures",
    needs=(
        "exp_c3_low_contrast",
        "exp_c3_shadow",
        "exp_c3_trace_direction",
        "exp_c3_merge_images",
    ),
    evidence="rendered",
)
def ext_condition_failures(results):
    """Where CELECT's runs ended, by experiment."""
    runs = stages_of(results)
    kinds = Counter()
    for stages in runs.values():
        kinds.update(stages)
    stages = [stage for stage, _ in kinds.most_common()]
    rows = [
        [told, poses, ends.total(), *(ends[stage] for stage in stages)]
        for (told, poses), ends in runs.items()
    ]
    return Table(
        columns(("Runs of CELECT", "Poses", "All", *stages), rows),
        "Where CELECT's runs ended. A run is lost by the first contour that "
        "fails; 'wrong corner returned' means that CELECT took it for a "
        "success.",
    )


def stages_of(results):
    """Stage counts of CELECT's runs: what was run, poses -> Counter."""
    light = results["exp_c3_low_contrast"]
    direction = results["exp_c3_trace_direction"]
    named = {
        f"mirror ball, light {v:g}": (light, f"{level_name(v)}.stage")
        for v in levels_run(light)
    }
    named |= {
        "fisheye, no shadow": (results["exp_c3_shadow"], "plain.stage"),
        "fisheye, shadow": (results["exp_c3_shadow"], "shadow.stage"),
        "fisheye, more images": (results["exp_c3_merge_images"], "stage"),
    }
    runs = {}
    for poses in (WHOLE, HARD):
        for what, (result, name) in named.items():
            runs[what, poses] = Counter(result.select(poses=poses).texts(name))
        for name, trials in direction.by("set", poses=poses).items():
            runs[f"{name}, eight orders", poses] = ends_of_orders(trials)
    return runs
