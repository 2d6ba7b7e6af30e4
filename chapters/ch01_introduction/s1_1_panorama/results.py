"""The mirrors of section 1.1.2 side by side, read from the results."""

from __future__ import annotations

import numpy as np

from chapters.ch01_introduction.s1_1_panorama.trials import ECCENTRICITIES


def over_mirrors(ran, name):
    """One value for each mirror, in the order of ECCENTRICITIES."""
    return np.array(
        [ran.column(name, mirror=mirror)[0] for mirror in ECCENTRICITIES]
    )
