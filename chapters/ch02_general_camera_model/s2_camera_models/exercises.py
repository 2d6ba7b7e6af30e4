"""What the exercises of section 2.2 compare an answer with."""

from __future__ import annotations

import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.trials.zoo import (
    mirror_trial,
)
from chapters.shared.zoo import K_of, camera, made
from raxel.cameras.fit import fit_camera


def omega_of_equidistance():
    """omega (deg) of the FOV model fitted to the law of equidistance."""
    angles = np.linspace(0, np.radians(70), 30)
    start = made("field of view", omega=1.0, K=K_of(100))()
    found = fit_camera(start, angles, 100 * angles)
    return float(np.degrees(found.camera.omega))


def sphere_of_hyperboloid():
    """xi of the unified sphere that equals the zoo's hyperboloid."""
    return mirror_trial({"model": "hyperboloid mirror"}, None)["xi"]


def divided_edge():
    """Radius (px) at which the zoo's division model reaches 90 deg."""
    model = camera("division")
    (first,) = model.coefficients
    return float(model.K[0, 0] / np.sqrt(-first))
