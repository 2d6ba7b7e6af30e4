"""Effect of a lens shift on a calibration, and the numbers of section 4.3.1."""

import numpy as np

from chapters.ch04_central_generic.s3_1_setup.results import (
    CAMERAS,
    FIELD,
    SETS,
    TURNED,
    seeds_of,
)
from chapters.shared.central_sets import FISH, LINEAR_GRIDS, OMNI, RIGS
from chapters.shared.methods import LINEAR_NAMES
from chapters.shared.rigs import rig_named
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Measured, Table, Value

WORDS = dict(zip(SETS, ("upright", "inverted"), strict=True))
FITTED = "grids and lens shift of the rig are chosen to give the printed value"


@table("ext_lens_shift", needs=("sec_4_3_1_turned",), evidence="rendered")
def ext_lens_shift(results):
    """Tabulate three methods on upright sets and on sets of an inverted camera."""
    result = results[TURNED]
    heads = {
        "ray_mean_mm": "Ray-point error (mm)",
        "ba_mean_mm": "after BA (mm)",
        "centre_off_mm": "Centre error (mm)",
    }
    rows = [
        (
            camera,
            name,
            words,
            *(
                Measured.median(seeds_of(result, camera, f"{how}.{method}.{key}"))
                for key in heads
            ),
        )
        for camera in CAMERAS.values()
        for method, name in LINEAR_NAMES.items()
        for how, words in WORDS.items()
    ]
    return Table(
        columns(("Camera", "Method", "Grids 2, 3", *heads.values()), rows),
        "Ray-point errors before and after bundle adjustment (BA), and errors of the "
        "centre, of calibrations from three grids. The camera is upright or inverted "
        "for grids 2 and 3. Median and range over the runs, images of reduced size, "
        "low-noise level.",
    )


@numbers(
    "sec_4_3_1", needs=("sec_4_3_1_field", "sec_4_3_1_turned"), evidence="rendered"
)
def numbers_of_section(results):
    """Return calibrated fields, numbers of grids, and lens shifts."""
    field, turned = results[FIELD], results[TURNED]
    rigs = {camera: rig_named(name) for camera, name in RIGS.items()}
    omni, fish = (field.select(camera=camera) for camera in (OMNI, FISH))
    shifts = {
        camera: Value.of_seeds(
            seeds_of(turned, camera, "shift_2_px"), "px", put_in=FITTED
        )
        for camera in (OMNI, FISH)
    }
    angle = np.degrees(rigs[FISH].camera.max_angle)
    sizes = {
        camera: Value(f"{rig.camera.width}x{rig.camera.height}", unit="px")
        for camera, rig in rigs.items()
    }
    return {
        "s4_3_1_d70_size": sizes[OMNI],
        "s4_3_1_cp_size": sizes[FISH],
        "s4_3_1_omni_h": Value.of_seeds(
            omni.column("horizontal_deg"), "deg", put_in=FITTED
        ),
        "s4_3_1_omni_v": Value.of_seeds(
            omni.column("vertical_deg"), "deg", put_in=FITTED
        ),
        "s4_3_1_fish": Value.of_seeds(100 * fish.column("share"), "%", put_in=FITTED),
        "s4_3_1_fish_fov": Value(round(2 * float(angle), 6), unit="deg"),
        "s4_3_1_lin": Value(LINEAR_GRIDS, unit="count"),
        "s4_3_1_omni_extra": Value(rigs[OMNI].count - LINEAR_GRIDS, unit="count"),
        "s4_3_1_fish_extra": Value(rigs[FISH].count - LINEAR_GRIDS, unit="count"),
        "s4_3_1_d70_shift": shifts[OMNI],
        "s4_3_1_cp_shift": shifts[FISH],
    }
