"""What section 4.3.1 found, and the numbers that its page quotes."""

import numpy as np

from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.rigs import rig_named
from repro.page.reader import value

FIELD = "sec_4_3_1_field"
TURNED = "sec_4_3_1_turned"
CAMERAS = {"omni": OMNI, "fish": FISH}


def seeds_of(result, camera, key):
    """A value of every seed of a camera, (seeds,)."""
    return result.select(camera=camera).column(key)


def name_values(open_results):
    """Name the numbers of the prose: medians over the seeds."""
    field, turned = open_results(FIELD), open_results(TURNED)

    def median(result, camera, key):
        return float(np.median(seeds_of(result, camera, key)))

    for short, camera in CAMERAS.items():
        for key in ("share", "solid"):
            value(f"{short}.{key}", 100 * median(field, camera, key))
        value(f"{short}.shift_2_px", median(turned, camera, "shift_2_px"))
        for how in ("upright", "turned"):
            for key in ("ray_mean_mm", "centre_off_mm"):
                found = median(turned, camera, f"{how}.cgsp.{key}")
                value(f"{short}.{how}.cgsp.{key}", found)
    for key in ("horizontal_deg", "vertical_deg"):
        value(f"omni.{key}", median(field, OMNI, key))
    value("seeds", len(seeds_of(field, OMNI, "share")))
    mirror = rig_named("onevr-d70").camera
    aligned = rig_named("onevr-d70-aligned-small").camera
    off = mirror.T_viewer_mirror[:3, 3] - aligned.T_viewer_mirror[:3, 3]
    value("bracket_mm", float(np.linalg.norm(off)))
