"""What each pixel of a view sees of a monitor, kept to show one pattern after another.

The means over pixels are those of `raxel.lab.render`, in a tenth of the time: almost
all pixels of the lit area see nothing else, and of these a pattern needs only where
they look along its axis.
"""

import numba
import numpy as np

from raxel.lab.patterns import MonitorLevel, MonitorPattern, monitor_scene, odd_share
from raxel.lab.render import lit_pixels, trace
from raxel.sets.patterns import advance

LIT = 0  # the part of the scene


class MonitorSight:
    """A rig's camera before its monitor at one pose, T_camera_target (4, 4), mm."""

    def __init__(self, rig, T_camera_target):
        self.rig, monitor = rig, rig.monitor
        scene = monitor_scene(rig.target, T_camera_target, **rig.radiances)
        traced = trace(rig.camera, np.eye(4), scene)
        self._lit, uv, across, down, cosine = lit_pixels(traced, LIT)
        self._axes = [(uv[:, k], across[:, k], down[:, k]) for k in (0, 1)]
        self._falloff = monitor.falloff(cosine).astype(np.float32)
        self._surround = traced.shade({LIT: MonitorLevel(1.0, monitor.radiance)})
        self._mixed = traced.mixed_pixels(LIT, self._lit)
        self._waves = {}

    def level(self, value):
        """Radiance (H, W) of the monitor at one value, float32."""
        texture = MonitorLevel(value, self.rig.monitor.radiance)
        return self._picture(np.float32(self.rig.monitor.light(value)), texture)

    def pattern(self, pattern):
        """Radiance (H, W) of the monitor with a `raxel.sets.Pattern`, float32."""
        target, monitor = self.rig.target, self.rig.monitor
        size = target.monitor_px, target.monitor_mm
        texture = MonitorPattern(*size, pattern, monitor.radiance)
        show = self._gray if pattern.kind == "gray" else self._sine
        return self._picture(show(texture), texture)

    def _picture(self, light, texture):
        image = self._surround.copy()
        image.reshape(-1)[self._lit] = light * self._falloff
        for pixels, mean in self._mixed:
            image.reshape(-1)[pixels] = mean(texture)
        return image

    def _gray(self, texture):
        monitor, inverse = self.rig.monitor, texture.pattern.inverse
        x, across, down = self._axes[texture.axis]
        low, high = monitor.light(np.float32([inverse, not inverse]))
        light, crossed = _stripes(x, across, down, texture.frequency, low, high)
        crossed = np.flatnonzero(crossed)
        edge = (part[crossed] * texture.frequency for part in (x, across, down))
        light[crossed] = low + odd_share(*edge).astype(np.float32) * (high - low)
        return light

    def _sine(self, texture):
        key = texture.axis, texture.frequency
        if key not in self._waves:
            x, across, down = (part * texture.frequency for part in self._axes[key[0]])
            swing = 0.5 * np.sinc(across) * np.sinc(down)
            turn = 2 * np.pi * x
            waves = swing * np.sin(turn), swing * np.cos(turn)
            self._waves[key] = tuple(wave.astype(np.float32) for wave in waves)
        sine, cosine = self._waves[key]
        angle = 2 * np.pi * advance(texture.pattern)
        value = np.float32(np.cos(angle)) * sine + np.float32(np.sin(angle)) * cosine
        return self.rig.monitor.light(value + np.float32(0.5))


@numba.njit(cache=True)
def _stripes(x, across, down, frequency, low, high):
    """Light (N,) where no edge of a Gray code is near, and where one may be."""
    light, crossed = np.empty(len(x), np.float32), np.empty(len(x), np.bool_)
    for n in range(len(x)):
        at = x[n] * frequency + 0.5
        reach = (abs(across[n]) + abs(down[n])) * frequency / 2
        whole = np.floor(at)
        light[n] = high if whole % 2 else low
        crossed[n] = min(at - whole, whole + 1 - at) <= reach
    return light, crossed
