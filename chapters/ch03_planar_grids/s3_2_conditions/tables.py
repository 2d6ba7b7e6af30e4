"""The parts of large grids one by one, and where CELECT's runs ended."""

from __future__ import annotations

from collections import Counter

from chapters.ch03_planar_grids.s3_2_conditions.results import (
    CAMERAS,
    METHODS,
    ends_of_orders,
    levels_run,
)
from chapters.ch03_planar_grids.s3_2_conditions.trials.sheet_views import (
    level_name,
)
from chapters.shared.grid_detectors import CELECT, OPENCV, OPENCV_SB
from repro.run.experiment import table
from repro.run.outcomes import Table


@table(
    "ext_partial_grids",
    needs=("fig_3_14_parts", "fig_3_14_parts_sb"),
    evidence="rendered",
)
def ext_partial_grids(results):
    """Every picture of Fig. 3.14's kind."""
    plain, sector = results["fig_3_14_parts"], results["fig_3_14_parts_sb"]
    columns = {
        name: []
        for name in (
            "camera",
            "picture",
            "method",
            "part",
            "corners",
            "to the frame (px)",
            "parts tried",
        )
    }
    for camera in CAMERAS:
        for method, result in (
            (CELECT, plain),
            (OPENCV, plain),
            (OPENCV_SB, sector),
        ):
            values = {
                name: result.column(f"{method}.{name}", camera=camera)
                for name in (
                    "columns",
                    "rows",
                    "count",
                    "border_px",
                    "tries",
                )
            }
            for k, count in enumerate(values["count"]):
                size = "none"
                if count:
                    long, short = values["columns"][k], values["rows"][k]
                    size = f"{long:.0f}\u00a0×\u00a0{short:.0f}"
                cells = (
                    camera,
                    k + 1,
                    METHODS[method],
                    size,
                    int(count),
                    round(float(values["border_px"][k]), 1)
                    if count
                    else "",
                    int(values["tries"][k]),
                )
                for column, cell in zip(columns, cells, strict=True):
                    columns[column].append(cell)
    return Table(
        columns,
        "Largest part of a large grid without a border that each method "
        "returns, correct and in order, and the distance of its nearest "
        "corner from the frame of the picture. OpenCV's detectors get white "
        "painted round the part.",
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
    columns = {"runs of CELECT": list(runs)}
    columns["all"] = [sum(s.values()) for s in runs.values()]
    for stage, _ in kinds.most_common():
        columns[stage] = [s[stage] for s in runs.values()]
    return Table(
        columns,
        "Where CELECT's runs ended. A run is lost by the first contour that "
        "fails; 'wrong corner returned' means that CELECT took it for a "
        "success.",
    )


def stages_of(results):
    """Stage counts of CELECT's runs: what was run -> Counter."""
    light = results["exp_c3_low_contrast"]
    shadow = results["exp_c3_shadow"]
    runs = {
        f"spherical, light {v:g}": Counter(
            light.texts(f"{level_name(v)}.stage")
        )
        for v in levels_run(light)
    }
    runs["fisheye, no shadow"] = Counter(shadow.texts("plain.stage"))
    runs["fisheye, shadow"] = Counter(shadow.texts("shadow.stage"))
    runs["fisheye, more images"] = Counter(
        results["exp_c3_merge_images"].texts("stage")
    )
    result = results["exp_c3_trace_direction"]
    for condition in result.conditions:
        runs[f"{condition['set']}, eight orders"] = ends_of_orders(
            result, [condition]
        )
    return runs
