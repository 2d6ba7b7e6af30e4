"""What figures, tables, claims and the prose of the camera zoo read."""

import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.trials.planes import FOVS_DEG
from chapters.shared.zoo import ELSEWHERE, ZOO
from repro.page.reader import value

# Rounding: an error that is smaller counts as none.
NONE_PX = 1e-6
NONE_MM = 1e-9

# Curved mirrors of the zoo that have no single centre.
CURVED_MIRRORS = ("hyperboloid off the focus", "spherical mirror", "bent mirror")

# Families with as few radial numbers as they have, the focal length included.
FEWEST = {
    "radial": 3,
    "division": 2,
    "field of view": 2,
    "equidistance": 1,
    "Micusik-Pajdla, rational": 2,
    "unified sphere": 2,
    "Scaramuzza": 3,
}


def fov_with_plane(result):
    """Largest field of view (deg) with a plane in front of all rays."""
    return max(np.array(FOVS_DEG)[feasible_shares(result) == 1])


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    counted = open_results("exp_zoo")
    reflected = open_results("exp_zoo_mirrors")
    of_zoo = counted.select().column
    curved_mm = [
        counted.column("centrality_mm", model=name)[0] for name in CURVED_MIRRORS
    ]
    fits = open_results("exp_zoo_fits")
    found = {
        "cameras": len(ZOO),
        "elsewhere": ", ".join(ELSEWHERE),
        "trip_px": of_zoo("round_trip_px").max(),
        "returned": 100 * of_zoo("returned").min(),
        "not_central": np.count_nonzero(of_zoo("centrality_mm") > NONE_MM),
        "kb": counted.column("parameters", model="Kannala-Brandt, complete")[0],
        "cubic": counted.column("parameters", model="rational cubic")[0],
        "table_size": counted.column("parameters", model="look-up table")[0],
        "brown_end": counted.column("model_end_deg", model="radial and decentring")[0],
        "sphere_px": reflected.select().column("rms_px").max(),
        "plane_fov": fov_with_plane(open_results("exp_c2_fov180")),
        "axial_mm": counted.column("centrality_mm", model="axial")[0],
        "curved_least_mm": min(curved_mm),
        "curved_most_mm": max(curved_mm),
        "radial_px": left_on_fisheye(fits, "radial", 3),
        "fov_px": left_on_fisheye(fits, "field of view", 2),
        "ideal_px": left_on_fisheye(fits, "equidistance", 1),
        "rational_px": left_on_fisheye(fits, "Micusik-Pajdla, rational", 2),
        "sphere_fit_px": left_on_fisheye(fits, "unified sphere", 2),
        "poly_2_px": left_on_fisheye(fits, "Scaramuzza", 2),
        "poly_3_px": left_on_fisheye(fits, "Scaramuzza", 3),
    }
    for name, number in found.items():
        value(name, number)


def fits_of(result, lens, family):
    """Free parameters (n,) and rms (n,) px of a family's fits."""
    rows = [c for c in result.conditions if c["lens"] == lens and c["family"] == family]
    free = [result.column("free", **row)[0] for row in rows]
    return np.array(free), np.array([result.column("rms_px", **row)[0] for row in rows])


def left_on_fisheye(result, family, free):
    """What a family with so many free numbers leaves of the FC-E8 fisheye, px."""
    counts, rms = fits_of(result, "FC-E8", family)
    return float(rms[counts == free][0])


def feasible_shares(result):
    """Share of trials with a plane, for every field of view: (fov,)."""
    return np.array([result.column("feasible", fov_deg=fov).mean() for fov in FOVS_DEG])


def free_of_cubics(coordinates):
    """Free numbers of two ratios of cubics, homogeneous or not.

    coordinates: 3 for cubics of (X, Y, Z) with all lower terms, 2 for
    those of (X / Z, Y / Z).
    """
    return 4 * {3: 20, 2: 10}[coordinates] - 2
