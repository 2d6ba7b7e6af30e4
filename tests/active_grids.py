"""Images of active grids drawn from formulas."""

from dataclasses import dataclass

import cv2
import numpy as np

from raxel.sets import ActiveGrid, Pattern, patterns_of, plan_of_cells
from raxel.sets.patterns import advance, cell_width


@dataclass
class Scene:
    """Pictures (n, H, W) with their patterns, and the true point (H, W, 2) in mm."""

    images: np.ndarray
    patterns: list
    grid: ActiveGrid
    true: np.ndarray
    white: np.ndarray
    black: np.ndarray


def drawn(
    size=(160, 120), monitor=(200, 144), cells=8, steps=4, noise=0.0, blur=0.0,
    tilt=0.2, vignetting=1.0, share=0.8, plan=None, seed=0, dtype=np.uint8,
    place=None, shift=0.0, patterns=None,
):  # fmt: skip
    """A monitor of square cells in mm and oblong pixels, seen on `share` of the width.

    place: (u, v) in shares of the width -> points in px of the monitor, in place of a
    tilted plane; patterns: in place of those of a plan. dark 20, light 200 grey levels
    of 8 bit, times the vignetting.
    """
    rng = np.random.default_rng(seed)
    v, u = np.indices(size[::-1])
    u, v = (u - size[0] / 2) / size[0], (v - size[1] / 2) / size[0]
    if place is None:
        depth = 1 + tilt * u - 0.6 * tilt * v
        x = monitor[0] * (0.5 + (u + 0.05 * v) / (share * depth))
        y = monitor[1] * 0.5 + monitor[0] * (v - 0.04 * u) / (share * depth)
    else:
        x, y = place(u, v, monitor)
    on = (x >= 0) & (x < monitor[0]) & (y >= 0) & (y < monitor[1])
    light = on * (1 - vignetting * (u * u + v * v))
    patterns = patterns or patterns_of(plan or plan_of_cells(monitor, cells, steps))
    values = [shown(p, (x, y)["xy".index(p.axis)], monitor, shift) for p in patterns]
    depth = 1 if dtype == np.uint8 else 257
    pictures = []
    for value in (*values, 1.0, 0.0):
        picture = depth * (20 + light * (10 + 170 * value))
        if blur:
            picture = cv2.GaussianBlur(picture, (0, 0), blur)
        picture = picture + rng.normal(0, noise * depth, light.shape)
        pictures.append(np.clip(np.rint(picture), 0, np.iinfo(dtype).max))
    pictures = np.array(pictures).astype(dtype)
    mm = np.array([1.5, 1.25])
    grid = ActiveGrid(monitor, tuple(mm * monitor))
    true = np.where(on[..., None], np.stack([x, y], axis=-1) * mm, np.nan)
    return Scene(pictures[:-2], patterns, grid, true, pictures[-2], pictures[-1])


def sines(periods, steps=4, offset=0.0):
    """The Patterns of sines alone, of each of these periods along both axes."""
    return [
        Pattern(
            f"sine-{axis}-{count:g}-{step}.png", axis, "phase", steps,
            step=step, periods=float(count), offset=offset,
        )
        for axis in "xy" for count in periods for step in range(steps)
    ]  # fmt: skip


def shown(pattern, place, monitor, shift=0.0):
    """The value at places in px; shift: of the sines against the code, in periods."""
    if pattern.kind == "phase":
        turns = pattern.periods * place / monitor["xy".index(pattern.axis)]
        turns = turns + advance(pattern) + shift
        return 0.5 + 0.5 * np.sin(2 * np.pi * turns)
    cell = np.floor(place / cell_width(pattern, monitor)).astype(int)
    value = (cell ^ (cell >> 1)) >> (pattern.of - 1 - pattern.bit) & 1
    return 1 - value if pattern.inverse else value
