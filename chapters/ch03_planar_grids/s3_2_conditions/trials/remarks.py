"""Trials of section 3.3.2's remarks: light, shadow, order of the clicks, merging."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chapters.ch03_planar_grids.s3_2_conditions.trials.click_orders import (
    corner_areas,
    detected,
    draw_clicks,
    run,
)
from chapters.ch03_planar_grids.s3_2_conditions.trials.merge_failures import (
    merge_failed,
    size_variation,
)
from chapters.ch03_planar_grids.s3_2_conditions.trials.sheet_views import (
    cut_photograph,
    sheet_of,
)
from chapters.shared.grid_trials import (
    CELECT,
    CLICKLESS,
    LINEAR,
    OPENCV,
    OPENCV_SB,
    tone_undone,
)
from raxel.lab.lighting import Shadow

LIGHT_LEVELS = (0.8, 0.4, 0.2, 0.1, 0.05, 0.025, 0.0125)
SHADOW_DEPTH = 0.3
METHODS = {
    CELECT: "CELECT",
    LINEAR: "CELECT, tone curve undone",
    OPENCV: "findChessboardCorners",
    OPENCV_SB: "findChessboardCornersSB",
    CLICKLESS: "without clicks (ours)",
}


def level_name(level):
    """Key of a light level in a trial's values."""
    return f"light {level:g}".replace(".", "_")


def contrast_trial(condition, rng):
    """One image of the Spherical set's rig in every light, all detectors."""
    sheet = sheet_of("spherical", rng)
    light = sheet.rig.light.draw(rng, sheet.rig.extent)
    offsets = draw_clicks(rng)
    values = {}
    for level in condition["levels"]:
        image, lattice = cut_photograph(sheet, replace(light, level=level))
        values[level_name(level)] = {
            "contrast_grey": contrast(image, lattice),
            **every_detector(image, lattice, offsets),
        }
    return values


def shadow_trial(condition, rng):
    """One image of the Fisheye set's rigs, without and with a shadow."""
    sheet = sheet_of("fisheye", rng)
    rig = sheet.rig
    light = replace(rig.light.draw(rng, rig.extent), shadow=None)
    offsets = draw_clicks(rng)
    corner, size = rig.extent
    shadow = Shadow(
        corner + rng.random(2) * size,
        SHADOW_DEPTH,
        rng.uniform(*rig.light.shadow_radius),
        rng.uniform(*rig.light.shadow_edge),
    )
    values = {}
    for name, cast in (("plain", None), ("shadow", shadow)):
        image, lattice = cut_photograph(sheet, replace(light, shadow=cast))
        values[name] = every_detector(image, lattice, offsets)
        if cast is None:
            linear = run(tone_undone(image), lattice, offsets)
            values |= merging(run(image, lattice, offsets))
            values["linear"] = merging(linear)
    return values


def merging_trial(condition, rng):
    """One image of the Fisheye set's rigs: was a contour lost by merging?"""
    sheet = sheet_of("fisheye", rng)
    light = replace(
        sheet.rig.light.draw(rng, sheet.rig.extent), shadow=None
    )
    offsets = draw_clicks(rng)
    image, lattice = cut_photograph(sheet, light)
    linear = run(tone_undone(image), lattice, offsets)
    return merging(run(image, lattice, offsets)) | {
        "linear": merging(linear)
    }


def merging(clicked):
    """Values of one CELECT run for the question of merging."""
    return {
        "size_ratio": size_variation(clicked.lattice),
        "merge_failed": merge_failed(clicked.result, clicked.lattice),
        "success": clicked.right,
        "stage": clicked.stage,
    }


def direction_trial(condition, rng):
    """One image, as it is and with its tone curve undone, clicked in eight orders."""
    sheet = sheet_of(condition["set"], rng)
    light = sheet.rig.light.draw(rng, sheet.rig.extent)
    offsets = draw_clicks(rng)
    image, lattice = cut_photograph(sheet, light)
    areas = corner_areas(lattice)
    # By rising area: order 0 begins at the smallest square.
    starts = np.argsort(areas)
    values = {"area_ratio": float(areas.max() / areas.min())}
    pictures = {"": image, "linear_": tone_undone(image)}
    for tone, picture in pictures.items():
        for reverse, way in ((False, "clockwise"), (True, "reverse")):
            for rank, first in enumerate(starts):
                clicked = run(
                    picture, lattice, offsets, int(first), reverse
                )
                values[f"{tone}{way}_{rank}"] = clicked.right
                values[f"{tone}{way}_{rank}_stage"] = clicked.stage
    return values


def every_detector(image, lattice, offsets):
    """Whether CELECT and the detectors without clicks have the grid."""
    clicked = run(image, lattice, offsets)
    linear = run(tone_undone(image), lattice, offsets)
    values = {
        CELECT: clicked.right,
        LINEAR: linear.right,
        "stage": clicked.stage,
    }
    without = (OPENCV, OPENCV_SB, CLICKLESS)
    return values | {
        name: detected(name, image, lattice) for name in without
    }


def contrast(image, lattice):
    """Median over the squares of how far their grey is from their neighbours'."""
    middles = (
        lattice[:-1, :-1]
        + lattice[1:, 1:]
        + lattice[:-1, 1:]
        + lattice[1:, :-1]
    ) / 4
    u, v = np.rint(middles).astype(int).transpose(2, 0, 1)
    grey = image[v, u].astype(float)
    return float(np.median(np.abs(np.diff(grey, axis=1))))
