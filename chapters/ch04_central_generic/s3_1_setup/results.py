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

    mirror = rig_named("onevr-d70").camera
    aligned = rig_named("onevr-d70-aligned-small").camera
    off = mirror.T_viewer_mirror[:3, 3] - aligned.T_viewer_mirror[:3, 3]
    of_turned = (
        "shift_2_px",
        "upright.cgsp.ray_mean_mm",
        "upright.cgsp.centre_off_mm",
        "turned.cgsp.ray_mean_mm",
        "turned.cgsp.centre_off_mm",
    )
    found = {
        **{
            f"{short}.{key}": 100 * median(field, camera, key)
            for short, camera in CAMERAS.items()
            for key in ("share", "solid")
        },
        **{
            f"{short}.{key}": median(turned, camera, key)
            for short, camera in CAMERAS.items()
            for key in of_turned
        },
        "omni.horizontal_deg": median(field, OMNI, "horizontal_deg"),
        "omni.vertical_deg": median(field, OMNI, "vertical_deg"),
        "seeds": len(seeds_of(field, OMNI, "share")),
        "bracket_mm": np.linalg.norm(off),
    }
    for name, number in found.items():
        value(name, number)
