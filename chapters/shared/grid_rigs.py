"""The rigs that take the pictures of 3.3.2's sets, and those of Fig. 3.14."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from raxel.lab import load_rig

ROOT = Path(__file__).resolve().parents[2]
# Rigs of a set, each with how many of its images it takes (E-3.14).
SETS = {
    "spherical": (("spherical", 15),),
    "hyperboloidal": (("hyperboloidal", 15),),
    "fisheye": (("fisheye-9x7", 7), ("fisheye-12x9", 8)),
    "flexible-mirror": (("flexible-mirror", 15),),
    "large-hyperboloidal": (("large-hyperboloidal", 1),),
    "large-fisheye": (("large-fisheye", 1),),
}


@lru_cache(maxsize=8)
def rig_named(name):
    """The rig of one file of data/rigs."""
    return load_rig(ROOT / "data" / "rigs" / f"{name}.yaml")


def rig_of(set_name, image):
    """The rig that took an image, 0 to 14, of a set."""
    names = [name for name, count in SETS[set_name] for _ in range(count)]
    if not 0 <= image < len(names):
        raise ValueError(f"{set_name} has no image {image}")
    return rig_named(names[image])
