"""What section 4.3.1 found, and the numbers that its page quotes."""

from __future__ import annotations

import numpy as np

from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.rigs import rig_named
from repro.page.reader import value

FIELD = "sec_4_3_1_field"
TURNED = "sec_4_3_1_turned"
CAMERAS = {"omni": OMNI, "fish": FISH}
METHODS = ("as_printed", "well_conditioned", "cgsp")


def seeds_of(result, camera, key):
    """A value of every seed of a camera, (seeds,)."""
    return np.array(
        [
            result.column(key, **condition)[0]
            for condition in result.conditions
            if condition["camera"] == camera
        ]
    )


def name_values(open_results):
    """Name the numbers of the prose: medians over the seeds."""
    field, turned = open_results(FIELD), open_results(TURNED)
    for short, camera in CAMERAS.items():
        for key in ("share", "solid"):
            found = np.median(seeds_of(field, camera, key))
            value(f"{short}.{key}", 100 * float(found))
        found = np.median(seeds_of(turned, camera, "shift_2_px"))
        value(f"{short}.shift_2_px", float(found))
        for how in ("upright", "turned"):
            for key in ("ray_mean_mm", "centre_off_mm"):
                found = seeds_of(turned, camera, f"{how}.cgsp.{key}")
                value(f"{short}.{how}.cgsp.{key}", float(np.median(found)))
    for key in ("horizontal_deg", "vertical_deg"):
        value(f"omni.{key}", float(np.median(seeds_of(field, OMNI, key))))
    value("seeds", len(seeds_of(field, OMNI, "share")))
    mirror = rig_named("onevr-d70").camera
    aligned = rig_named("onevr-d70-aligned-small").camera
    off = mirror.T_viewer_mirror[:3, 3] - aligned.T_viewer_mirror[:3, 3]
    value("bracket_mm", float(np.linalg.norm(off)))
