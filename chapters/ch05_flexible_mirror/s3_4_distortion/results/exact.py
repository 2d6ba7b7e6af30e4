"""Noise-free checks: a circle on a plane, and its conic in a flat mirror."""

from functools import cache

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import (
    PLACES,
    RADIUS_MM,
    held,
    ring_on,
)
from chapters.shared.mirror_bench import ABERRATION_UM
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from raxel.cameras import FlexibleMirrorCamera, PerspectiveCamera
from raxel.multiview.fits.conics import fit_conic
from raxel.multiview.plane_points import circle_outline, measured_circle

SEED = 0  # of the target's pose and of the mirror's waves


@cache
def exact_radii():
    """Errors (8,) mm of the radius at stages 0 to 3, smooth and uneven mirror."""
    rig = mirror_rig("A")
    return np.array(
        [
            _radius(rig, deflection, uneven) - RADIUS_MM
            for uneven in (0.0, ABERRATION_UM)
            for deflection in STAGES_MM
        ]
    )


def _radius(rig, deflection, uneven):
    camera, T = rig.camera(deflection, uneven, SEED), held(rig, deflection, SEED)
    centre = ring_on(rig.board).centre
    pixels = circle_outline(camera, T, centre, RADIUS_MM, PLACES)[0]
    return measured_circle(camera, pixels, T).fit.radius


@cache
def conic_of_flat_mirror():
    """Largest distance, px, from a conic; flat mirror, lens without distortion."""
    rig = mirror_rig("A")
    camera = rig.camera(0.0)
    viewer = PerspectiveCamera(rig.viewer.K, [], rig.viewer.width, rig.viewer.height)
    flat = FlexibleMirrorCamera(**camera.arguments() | {"viewer": viewer})
    T = held(rig, 0.0, SEED)
    centre = ring_on(rig.board).centre
    pixels = circle_outline(flat, T, centre, RADIUS_MM, PLACES)[0]
    seen = np.isfinite(pixels).all(axis=1)
    return float(np.abs(fit_conic(pixels[seen]).residuals).max())
