"""A camera with its lens and sensor: the physical order of a photograph lives here.

Scene radiance; vignetting, blur and chromatic aberration of the lens; charge with its
shot noise, saturation and blooming; read noise; tone curve; rounding.
"""

from dataclasses import dataclass, field

import numpy as np

from raxel.cameras.base import Camera
from raxel.lab.optics import Optics
from raxel.lab.render import render
from raxel.lab.sensor import Sensor


@dataclass(frozen=True)
class Laboratory:
    """camera: any Camera with rays; optics: its lens; sensor: what counts the light."""

    camera: Camera
    sensor: Sensor
    optics: Optics = field(default_factory=Optics)

    def photograph(self, scene, T_world_camera, rng, *, colour=False):
        """A picture of the scene, uint8 or uint16, (H, W), or (H, W, 3) in colour.

        scene: raxel.lab Scene; T_world_camera: (4, 4), mm; rng: numpy Generator, used
        for noise alone. Colour is red, green, blue. Behind a mosaic the scene is always
        taken in colour.
        """
        coloured = colour or self.sensor.bayer is not None
        radiance = render(self.camera, T_world_camera, scene, colour=coloured)
        return self.develop(radiance, rng, colour=colour)

    def develop(self, radiance, rng, *, colour=False):
        """The picture that radiance (H, W) or (H, W, 3) leaves in the file."""
        if self.sensor.bayer is not None and radiance.ndim == 2:
            radiance = np.repeat(radiance[..., None], 3, axis=-1)
        irradiance = self.optics.apply(radiance)
        return self.sensor.expose(irradiance, rng, colour=colour)
