"""Numbers of section 2.2 for its claim and its prose."""

import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.trials.planes import FOVS_DEG
from chapters.shared.zoo import ZOO, camera
from repro.page.reader import value


def fov_with_plane(result):
    """Return the largest field of view (deg) with a plane in front of all rays."""
    return max(np.array(FOVS_DEG)[feasible_shares(result) == 1])


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    found = {
        "cameras": len(ZOO),
        "not_central": sum(not camera(name).central for name in ZOO),
        "kb": camera("Kannala-Brandt, complete").parameters,
        "cubic": camera("rational cubic").parameters,
        "table_size": camera("look-up table").parameters,
        "plane_fov": fov_with_plane(open_results("exp_c2_fov180")),
    }
    for name, number in found.items():
        value(name, number)


def feasible_shares(result):
    """Return the share of trials with a plane, for every field of view (fov,)."""
    return np.array([result.column("feasible", fov_deg=fov).mean() for fov in FOVS_DEG])


def free_of_cubics(coordinates):
    """Return the number of free parameters of two ratios of cubics.

    coordinates: 3 for cubics of (X, Y, Z) with all lower terms, 2 for
    those of (X / Z, Y / Z).
    """
    return 4 * {3: 20, 2: 10}[coordinates] - 2
