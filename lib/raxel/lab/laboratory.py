"""A camera with its lens and sensor: the physical order of a photograph lives here.

Scene radiance; blur, vignetting and chromatic aberration of the lens; charge with its
shot noise, saturation and blooming; read noise; tone curve; rounding.
"""

from dataclasses import dataclass, field

import numpy as np

from raxel.cameras.core.base import Camera
from raxel.lab.optics import Optics
from raxel.lab.render import render
from raxel.lab.sensor import Sensor

# Pixels each way that stand for one of the sensor where the lens blurs: with two,
# corners of a chessboard are found as well as with four.
FINENESS = 2


@dataclass(frozen=True)
class Laboratory:
    """camera: any Camera with rays; optics: its lens; sensor: what counts the light."""

    camera: Camera
    sensor: Sensor
    optics: Optics = field(default_factory=Optics)

    def photograph(self, scene, T_world_camera, rng, *, colour=False):
        """A picture of the scene, uint8 or uint16, (H, W), or (H, W, 3) in colour.

        scene: a TexturedScene; T_world_camera: (4, 4), mm; rng: numpy Generator, used
        for noise alone. Colour is red, green, blue. Behind a mosaic the scene is always
        taken in colour.
        """
        coloured = colour or self.sensor.bayer is not None
        irradiance = self.irradiance(scene, T_world_camera, colour=coloured)
        return self.sensor.expose(irradiance, rng, colour=colour)

    def irradiance(self, scene, T_world_camera, *, colour=False, window=None):
        """Light on the sensor, (H, W) or (H, W, 3), or on a `Crop` of it."""
        fineness = FINENESS if max(self.optics.blur_sd_px) > 0 else 1
        radiance = render(
            self.camera,
            T_world_camera,
            scene,
            colour=colour,
            fineness=fineness,
            window=window,
        )
        return self.optics.apply(radiance, fineness, window)

    def develop(self, radiance, rng, *, colour=False, fineness=1):
        """The picture that radiance leaves in the file.

        radiance: (H, W) or (H, W, 3), or with `fineness` times as many pixels each way
        (`Optics.apply`).
        """
        if self.sensor.bayer is not None and radiance.ndim == 2:
            radiance = np.repeat(radiance[..., None], 3, axis=-1)
        irradiance = self.optics.apply(radiance, fineness)
        return self.sensor.expose(irradiance, rng, colour=colour)
