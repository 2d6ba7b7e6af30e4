"""The rigs of the image sets of 3.3.2, and those of Fig. 3.14."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from chapters.shared.rigs import rig_named

# Rigs of a set, each with how many of its images it takes (E-3.14).
SETS = {
    "spherical": (("spherical", 15),),
    "hyperboloidal": (("hyperboloidal", 15),),
    "fisheye": (("fisheye-9x7", 7), ("fisheye-12x9", 8)),
    "flexible-mirror": (("flexible-mirror", 15),),
    "large-hyperboloidal": (("large-hyperboloidal", 1),),
    "large-fisheye": (("large-fisheye", 1),),
}
# What the experiments with them read.
RIGS = (
    "data/rigs/spherical.yaml",
    "data/rigs/hyperboloidal.yaml",
    "data/rigs/fisheye-9x7.yaml",
    "data/rigs/fisheye-12x9.yaml",
    "data/rigs/flexible-mirror.yaml",
)
LARGE_RIGS = ("data/rigs/large-hyperboloidal.yaml", "data/rigs/large-fisheye.yaml")
# Ranges that the poses of the four sets are drawn from (`pose_range` in the ledger).
WHOLE, HARD = "whole", "hard"
# Degrees; the hard ranges stand in the files of the rigs.
WHOLE_RANGES = {"polar": (0, 70), "tilt": (0, 70), "subtense": (35, 125)}
WHOLE_POLAR = {"hyperboloidal": (40, 110), "flexible-mirror": (0, 25)}

# What can be wiped off a rig's mirror, its random draws left as they are.
CLEANED = {"spots": {"spot_cover": (0.0, 0.0)}, "glare": {"glare_radiance": (0.0, 0.0)}}


@lru_cache(maxsize=8)
def with_whole_range(rig):
    """The rig of one of the four sets with its poses drawn from the whole range."""
    ranges = dict(WHOLE_RANGES)
    ranges["polar"] = WHOLE_POLAR.get(rig.name, ranges["polar"])
    limits = {name: tuple(np.deg2rad(ends)) for name, ends in ranges.items()}
    return replace(rig, poses=replace(rig.poses, **limits))


def rig_of(set_name, image, poses=HARD):
    """The rig that took an image, 0 to 14, of a set; poses: HARD or WHOLE."""
    names = [name for name, count in SETS[set_name] for _ in range(count)]
    if not 0 <= image < len(names):
        raise ValueError(f"{set_name} has no image {image}")
    rig = rig_named(names[image])
    return with_whole_range(rig) if poses == WHOLE else rig


def wiped(rig, blemish):
    """The rig without one blemish, a key of CLEANED; None leaves it as it is."""
    if blemish is None:
        return rig
    clean = replace(rig.blemishes, **CLEANED[blemish])
    return replace(rig, blemishes=clean)
