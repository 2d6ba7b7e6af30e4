"""Results of section 4.3.1, and the numbers of the text."""

import numpy as np

from chapters.shared.central_sets import FISH, OMNI
from repro.page.reader import value

FIELD = "sec_4_3_1_field"
TURNED = "sec_4_3_1_turned"
CAMERAS = {"omni": OMNI, "fish": FISH}
SETS = ("upright", "turned")  # the camera for grids 2 and 3


def seeds_of(result, camera, key):
    """Return a value of each run of a camera, (runs,)."""
    return result.select(camera=camera).column(key)


def name_values(open_results):
    """Name the numbers that the text quotes: medians over the runs."""
    turned = open_results(TURNED)
    for short, camera in CAMERAS.items():
        for name in SETS:
            key = f"{name}.cgsp.centre_off_mm"
            value(f"{short}.{key}", np.median(seeds_of(turned, camera, key)))
    for name in SETS:
        key = f"{name}.cgsp.ray_mean_mm"
        value(f"omni.{key}", np.median(seeds_of(turned, OMNI, key)))
