"""What a monitor shows: coded patterns and even levels, as textures.

uv is in mm from the upper left corner of the lit area, x right and y down. The value
of a pattern runs from 0 to 1; `response(value, cosine)` makes it radiance, so gamma
and the falloff with the viewing angle belong to the monitor (`raxel.lab.Monitor`).

The lit area is drawn as a continuous picture: the fine raster of its own pixels is
left out, but a Gray code's edges lie on the borders of its cells exactly.
"""

import numpy as np

from raxel.errors import InputError
from raxel.geometry import pose
from raxel.lab.scene import TexturedScene
from raxel.lab.surfaces import Rectangle
from raxel.lab.textures import GridTexture, Plain, Texture, share_in_bars
from raxel.sets.patterns import advance, cell_width


class MonitorLevel(Texture):
    """The whole monitor at one value, as for the white and the black photograph."""

    averages = True

    def __init__(self, value, response=None):
        self.value = float(value)
        self.response = response or _linear

    def radiance(self, uv, cosine):
        """The same everywhere but for the viewing angle."""
        return self.response(np.full(len(uv), self.value), cosine)

    def average(self, uv, across, down, cosine):
        """As `radiance`."""
        return self.radiance(uv, cosine)


class MonitorBoard(GridTexture):
    """The chessboard of a monitor (`raxel.sets.MonitorChessboard`)."""

    regional = False  # its radiance changes with the viewing angle
    even_inside = True

    def __init__(self, monitor_px, monitor_mm, board, response=None):
        pixel = np.divide(monitor_mm or monitor_px, monitor_px)
        counts = board.columns, board.rows
        lines = [
            mm * (first + board.pitch_px * np.arange(-1, count + 1))
            for mm, first, count in zip(pixel, board.origin_px, counts, strict=True)
        ]
        white = np.add.outer(np.arange(counts[1] + 1), np.arange(counts[0] + 1)) % 2 < 1
        super().__init__(lines, np.pad(white, 1, constant_values=True).ravel() * 1.0)
        self.response = response or _linear

    def radiance(self, uv, cosine):
        """At points."""
        return self.response(self.colours[self.label(uv)], cosine)

    def average(self, uv, across, down, cosine):
        """Exact where at most one line crosses the parallelogram, else NaN."""
        white = super().average(uv, across, down, cosine)
        return _two_levels(self.response, white, cosine)


class MonitorPattern(Texture):
    """One pattern of an active grid (`raxel.sets.Pattern`), Gray code or phase step.

    monitor_px, monitor_mm: (width, height); without mm, a pixel is 1 mm wide. Gray
    code counts 2^of cells from the left or upper border, bit 0 is the most significant.
    Step k of a phase pattern is 1/2 + 1/2 sin(phi + 2 pi (k / of + offset)), where phi
    = 2 pi periods x / width starts at 0 on the left or upper border, as (3.23) decodes.

    Means over a pixel's footprint are exact for Gray code, whose edges are parallel,
    if the map is affine within the pixel. Of a phase pattern the mean value is exact;
    `response` is applied to it, as the value hardly changes within a pixel.

    frequency: (1 / mm) periods of a phase pattern along `axis` (0 or 1), and for Gray
    code a half of its stripes: the brightness changes where frequency x + 1/2 is whole.
    """

    averages = True

    def __init__(self, monitor_px, monitor_mm, pattern, response=None):
        size_mm = np.array(monitor_mm or monitor_px, float)
        if pattern.axis not in ("x", "y") or pattern.kind not in ("gray", "phase"):
            raise InputError(
                f"pattern: found axis {pattern.axis!r} and kind {pattern.kind!r}; give "
                "axis x or y and kind gray or phase"
            )
        self.pattern = pattern
        self.axis = "xy".index(pattern.axis)
        self.response = response or _linear
        if pattern.kind == "gray":
            # Bit k changes at odd multiples of 2^(of - 1 - k) cells; so in units of
            # twice that, shifted by a half, it is whether the whole part is odd.
            code_px = cell_width(pattern, monitor_px) * 2.0**pattern.of
            code_mm = code_px * size_mm[self.axis] / monitor_px[self.axis]
            self.frequency = 2.0**pattern.bit / code_mm
        else:
            self.frequency = pattern.periods / size_mm[self.axis]

    def radiance(self, uv, cosine):
        """At points."""
        x = uv[:, self.axis] * self.frequency
        if self.pattern.kind == "gray":
            return self._two_levels(np.floor(x + 0.5) % 2, cosine)
        return self.response(0.5 + 0.5 * self._sine(x), cosine)

    def average(self, uv, across, down, cosine):
        """Means over footprints."""
        x = uv[:, self.axis] * self.frequency
        a = across[:, self.axis] * self.frequency
        b = down[:, self.axis] * self.frequency
        if self.pattern.kind == "gray":
            return self._two_levels(odd_share(x, a, b), cosine)
        swing = 0.5 * np.sinc(a) * np.sinc(b)
        return self.response(0.5 + swing * self._sine(x), cosine)

    def _sine(self, periods):
        return np.sin(2 * np.pi * (periods + advance(self.pattern)))

    def _two_levels(self, share, cosine):
        if self.pattern.inverse:
            share = 1 - share
        return _two_levels(self.response, share, cosine)


def odd_share(x, across, down):
    """Share of a parallelogram where floor(x + 1/2) is odd: the bright of a Gray code.

    x: (N,) its middle; across, down: (N,) how far its sides reach, all as `frequency`.
    """
    return share_in_bars((x - 0.5) / 2, across / 2, down / 2, 0.5)


def monitor_scene(
    active_grid, T_world_target, texture=None, frame_mm=20.0, frame=0.03, background=0.2
):
    """A monitor (`raxel.sets.ActiveGrid`) in its frame; part 0 is the lit area.

    T_world_target: pose of the lit area, origin at its upper left corner, x right, y
    down. texture: what it shows, white if not given (`Traced.shade` exchanges it).
    """
    size = np.array(active_grid.monitor_mm or active_grid.monitor_px, float)
    lit = Rectangle(T_world_target, *size)
    parts = [(lit, texture or MonitorLevel(1.0))]
    if frame_mm > 0:
        # Behind the lit area by a hair, so that which one is nearer is not left open.
        behind = T_world_target @ pose(np.eye(3), [0, 0, 1e-3])
        rim = Rectangle(behind, *(size + 2 * frame_mm), (-frame_mm, -frame_mm))
        parts.append((rim, Plain(frame)))
    return TexturedScene(tuple(parts), background)


def _two_levels(response, share, cosine):
    low = response(np.zeros_like(share), cosine)
    return low + share * (response(np.ones_like(share), cosine) - low)


def _linear(value, cosine):
    return value
