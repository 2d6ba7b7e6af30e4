"""What a lens that moves does to a calibration, and the numbers of section 4.3.1."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s3_1_setup.results import (
    CAMERAS,
    FIELD,
    METHODS,
    TURNED,
    seeds_of,
)
from chapters.shared.central_sets import FISH, LINEAR_GRIDS, OMNI, RIGS
from chapters.shared.rigs import rig_named
from repro.judge.statistics import median_interval
from repro.run.experiment import numbers, table
from repro.run.outcomes import Measured, Table, Value

NAMES = dict(
    zip(
        METHODS,
        ("standard, as printed", "standard, well conditioned", "CGSP"),
        strict=True,
    )
)
SEEN = ("upright", "turned")


@table("ext_lens_shift", needs=("sec_4_3_1_turned",), evidence="rendered")
def ext_lens_shift(results):
    """Three methods on upright sets, and on sets of a camera that was turned over."""
    result = results[TURNED]
    heads = {
        "ray_mean_mm": "Ray-point error (mm)",
        "ba_mean_mm": "after BA (mm)",
        "centre_off_mm": "Centre off (mm)",
    }
    columns = {"Camera": [], "Method": [], "Grids 2, 3": []}
    columns |= {head: [] for head in heads.values()}
    for camera in CAMERAS.values():
        for method, name in NAMES.items():
            for how in SEEN:
                columns["Camera"].append(camera)
                columns["Method"].append(name)
                columns["Grids 2, 3"].append(how)
                for key, head in heads.items():
                    found = seeds_of(result, camera, f"{how}.{method}.{key}")
                    columns[head].append(Measured(*median_interval(found)[:3]))
    return Table(
        columns,
        "Calibrations from three grids, taken upright, or with the camera turned "
        "over for the second and third one. Median and range over the seeds, sets of "
        "reduced size.",
    )


def _of_seeds(values, unit):
    return Value(
        float(np.median(values)), (float(np.min(values)), float(np.max(values))), unit
    )


@numbers(
    "sec_4_3_1", needs=("sec_4_3_1_field", "sec_4_3_1_turned"), evidence="rendered"
)
def numbers_of_section(results):
    """Shares of the field, counts of grids, shifts of the lens."""
    field, turned = results[FIELD], results[TURNED]
    rigs = {camera: rig_named(name) for camera, name in RIGS.items()}
    shift = {
        camera: _of_seeds(seeds_of(turned, camera, "shift_2_px"), "px")
        for camera in CAMERAS.values()
    }
    angle = np.degrees(rigs[FISH].camera.max_angle)
    return {
        "s4_3_1_omni_h": _of_seeds(seeds_of(field, OMNI, "horizontal_deg"), "deg"),
        "s4_3_1_omni_v": _of_seeds(seeds_of(field, OMNI, "vertical_deg"), "deg"),
        "s4_3_1_fish": _of_seeds(100 * seeds_of(field, FISH, "share"), "%"),
        "s4_3_1_fish_fov": Value(round(2 * float(angle), 6), unit="deg"),
        "s4_3_1_lin": Value(LINEAR_GRIDS, unit="count"),
        "s4_3_1_omni_extra": Value(rigs[OMNI].count - LINEAR_GRIDS, unit="count"),
        "s4_3_1_fish_extra": Value(rigs[FISH].count - LINEAR_GRIDS, unit="count"),
        "s4_3_1_d70_shift": shift[OMNI],
        "s4_3_1_cp_shift": shift[FISH],
    }
