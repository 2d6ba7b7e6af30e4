"""Errors of corners and decoded points in rendered images of rigs A and B."""

import numpy as np

from chapters.shared.mirror_errors import measured
from chapters.shared.mirror_rigs import mirror_rig

RENDERED = {"quick": 1, "full": 2}
SMALL = {"quick": True, "full": False}
GEOMETRIES = ("A", "B")


def errors_trial(condition, rng):
    """`measured` of one geometry, and how large these errors are."""
    found = measured(mirror_rig(condition["geometry"], condition["small"]), rng)
    sizes = {
        f"{name}_rms": float(np.sqrt(np.mean(found[key] ** 2)))
        for name, key in (
            ("corner_px", "corner"),
            ("plate_px", "plate"),
            ("mirror_mm", "mirror.error"),
            ("platter_mm", "platter.error"),
        )
    }
    return found | sizes
