"""Pictures of active grids drawn from formulas, and a plain decoder to compare with."""

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


def plainly_decoded(scene, variance, smooth=True):
    """location, cells and mask by plain array arithmetic, both axes, one cell a period.

    In px of the monitor; before the rim is left out. Written down once more, slowly.
    """
    images, size = scene.images.astype(np.int64), scene.grid.monitor_px
    axes = [read_axis(images, scene.patterns, axis) for axis in "xy"]
    most = np.max([np.abs(d) for _, bits, _ in axes for d in bits], axis=0)
    good = np.ones(most.shape, bool)
    for z, bits, steps in axes:
        far = np.sort(np.abs(bits), axis=0)
        good &= 4 * far[1] >= most if len(far) > 1 else True
        good &= most.astype(float) ** 2 >= 49 * variance
        good &= np.abs(z) ** 2 >= 25 * variance * 2 / steps
    good &= ~saturated(images, scene.patterns)
    codes = [code_of(bits) for _, bits, _ in axes]
    breaks = [broken(good, axes, codes, along) for along in (1, 0)]
    crossed = ~good | breaks[0] | breaks[1]
    mixed = cv2.dilate(crossed.astype(np.uint8), np.ones((7, 7)), borderValue=1) > 0
    mixed[:3], mixed[-3:], mixed[:, :3], mixed[:, -3:] = (True,) * 4
    before = [np.roll(breaks[0], 1, 1), np.roll(breaks[1], 1, 0)]
    before[0][:, 0], before[1][0] = True, True
    mask = good & ~(breaks[0] & breaks[1] & before[0] & before[1])
    places, cells = [], []
    for axis, (z, bits, steps) in enumerate(axes):
        sums = [
            cv2.boxFilter(part, -1, (7, 7), normalize=False)
            for part in parts(z / np.abs(z).clip(1e-10))
        ]
        mean = (sums[0] + 1j * sums[1]) / 49
        alone = mixed | (np.abs(mean) < 0.7) | (not smooth)
        mean = np.where(alone, z, mean)
        turn = np.angle(mean) / (2 * np.pi) % 1
        sd = np.sqrt(2 / steps * variance) / (2 * np.pi * np.abs(z).clip(1e-10))
        sd = np.where(alone, sd, sd / 7)
        width = scene_cell(scene, axis)
        edges = min(int(np.ceil(size[axis] / width)), 2 ** len(bits))
        step, unreadable = settled(good, z, bits, codes[axis], turn, sd, most, edges)
        places.append(width * (codes[axis] + step + turn))
        cells.append(codes[axis] + step)
        mask &= ~unreadable & (places[-1] >= -4 * width * sd)
        mask &= places[-1] <= size[axis] + 4 * width * sd
    return np.stack(places, axis=-1), np.stack(cells, axis=-1), mask


def parts(z):
    return np.ascontiguousarray(z.real), np.ascontiguousarray(z.imag)


def scene_cell(scene, axis):
    gray = [p for p in scene.patterns if p.axis == "xy"[axis] and p.kind == "gray"]
    return cell_width(gray[0], scene.grid.monitor_px)


def read_axis(images, patterns, axis):
    """(B exp(i phi), picture less inverse of each bit, number of steps)"""
    own = [(p, i) for p, i in zip(patterns, images, strict=True) if p.axis == axis]
    steps = {p.step: i for p, i in own if p.kind == "phase"}
    bits = {(p.bit, p.inverse): i for p, i in own if p.kind == "gray"}
    angle = 2 * np.pi * np.arange(len(steps)) / len(steps)
    stack = np.array([steps[k] for k in range(len(steps))])
    sine = np.tensordot(np.cos(angle), stack, 1)
    cosine = np.tensordot(np.sin(angle), stack, 1)
    # Rounded, so that sums of whole grey values stay exact.
    z = np.round(2 / len(steps) * (cosine + 1j * sine), 9)
    apart = [bits[k, False] - bits[k, True] for k in range(len(bits) // 2)]
    return z, np.array(apart), len(steps)


def saturated(images, patterns):
    sines = [i for p, i in zip(patterns, images, strict=True) if p.kind == "phase"]
    return np.max(sines, axis=0) >= 255


def code_of(bits):
    value = np.cumsum(np.array(bits) > 0, axis=0) % 2
    return sum(bit << (len(bits) - 1 - k) for k, bit in enumerate(value))


def broken(good, axes, codes, along):
    """Pixels that break with the next one along an axis of the picture."""
    after = [np.roll(a, -1, along) for a in (good, *codes)]
    result = ~good | ~after[0]
    for (z, *_), code, other in zip(axes, codes, after[1:], strict=True):
        result |= unit_cosine(z, np.roll(z, -1, along)) < -1e-6
        result |= np.abs(code - other) > 1
    result[-1 if along == 0 else slice(None), -1 if along else slice(None)] = True
    return result


def unit_cosine(a, b):
    return (a * b.conj()).real / (np.abs(a) * np.abs(b)).clip(1e-10)


def settled(good, z, bits, code, turn, sd, most, edges):
    """(-1, 0 or 1 to add to the cell; what cannot be read) by the wrap rule."""
    around, count = np.zeros(bits.shape), np.zeros(code.shape)
    for shift in np.ndindex(3, 3):
        same = moved_by(shift, good, False)
        same &= unit_cosine(z, moved_by(shift, z, 0j)) >= -1e-6
        same &= np.abs(code - moved_by(shift, code, 0)) <= 1
        count += same
        around += same * [moved_by(shift, bit, 0) for bit in bits]
    around *= np.where(bits > 0, 1, -1)
    framed = np.pad(code, 1, "edge")
    others = framed[:-2, 1:-1], framed[2:, 1:-1], framed[1:-1, :-2], framed[1:-1, 2:]
    at_edge = np.any([other != code for other in others], axis=0)
    weak = 2 * np.abs(bits).min(axis=0) < most
    low = turn < 0.5
    gap = 0.5 - np.abs(turn - 0.5)
    even = gap < 4 * sd
    seen = weak | at_edge
    doubt = good & seen & (even | (gap < 0.3))
    near, far = np.where(low, code, code + 1), np.where(low, code + 1, code)

    def contrast(edge, values, full):
        bit = len(bits) - 1 - (np.log2((edge & -edge).clip(1))).astype(int)
        value = np.take_along_axis(values, bit.clip(0)[None], 0)[0]
        return np.where((edge > 0) & (edge < edges), 2 * value, full)

    def is_seen(edge, by_others):
        beyond = np.any([(other >= edge) != (code >= edge) for other in others], axis=0)
        inside = (edge > 0) & (edge < edges)
        weak = 2 * contrast(edge, np.abs(bits), most) < 3 * most
        return inside & (weak | (beyond & by_others))

    across = is_seen(far, even | (gap < 0.02))
    at_near = np.abs(contrast(near, around, count * most))
    at_far = contrast(far, around, count * most)
    moved = doubt & across & (at_far < count * most) & (at_far < at_near)
    near_seen = np.where(across, at_near < count * most, is_seen(near, True))
    lost = even & ~moved & ~(seen & near_seen)
    return np.where(moved, np.where(low, 1, -1), 0), lost


def moved_by(shift, array, beyond):
    """The neighbour of each pixel, (0, 0) to (2, 2) for the eight and itself."""
    framed = np.pad(array, 1, constant_values=beyond)
    h, w = array.shape
    return framed[shift[0] : shift[0] + h, shift[1] : shift[1] + w]
