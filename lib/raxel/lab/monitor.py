"""A monitor as a light source: pattern value and viewing angle in, radiance out."""

from dataclasses import dataclass

import numpy as np

from raxel.errors import InputError


@dataclass(frozen=True)
class Monitor:
    """How a monitor turns the value of a pixel into light.

    white: radiance of value 1 seen straight on, 1.0 being a white diffuse surface.
    black_level: radiance of value 0 as a share of white. gamma: the radiance between
    them rises as value^gamma. falloff_exponent: n of cos^n of the viewing angle.
    Raises InputError naming the field that no monitor can have.
    """

    gamma: float = 2.2
    black_level: float = 0.0
    falloff_exponent: float = 0.0
    white: float = 1.0

    def __post_init__(self):
        limits = {
            "gamma": (self.gamma > 0, "it must be above 0"),
            "black_level": (0 <= self.black_level < 1, "give a share of white below 1"),
            "falloff_exponent": (self.falloff_exponent >= 0, "it must be 0 or more"),
            "white": (self.white > 0, "it must be above 0"),
        }
        for name, (good, advice) in limits.items():
            if not good:
                found = getattr(self, name)
                raise InputError(f"field '{name}': found {found}; {advice}")

    def radiance(self, value, cosine):
        """Radiance of pixels of `value` in [0, 1] seen at an angle of this cosine.

        Arrays of one shape, or numbers. From behind (cosine < 0) it is dark.
        """
        return self.light(value) * self.falloff(cosine)

    def light(self, value):
        """Radiance straight on of pixels of `value`, an array or a number."""
        value = np.clip(value, 0, 1)
        share = self.black_level + (1 - self.black_level) * value**self.gamma
        return self.white * share

    def falloff(self, cosine):
        """Share of `light` that is left at an angle of this cosine."""
        return (np.asarray(cosine) > 0) * np.maximum(cosine, 0) ** self.falloff_exponent
