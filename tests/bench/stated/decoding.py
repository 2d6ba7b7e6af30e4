"""Places decoded behind drawn monitors and cameras that do not answer in proportion.

A monitor has a gamma, a black level, and a gamma that changes with the angle at which
it is seen; a camera blurs what it sees, adds light of the room, loses light towards its
corners, and answers by a curve of its own. Pictures are drawn from these formulas
alone. The place that each pixel sees is known.
"""

from typing import NamedTuple

import cv2
import numpy as np

from raxel.features.active_grid import decode
from raxel.features.active_grid.response import response_warnings
from raxel.sets import ActiveGrid, patterns_of, plan_of_cells

WHAT = (
    "Active grids of 12 cells on three drawn monitors, by three drawn cameras (noise 1 "
    "to 8 grey levels, blur 0 to 4 px, 8 and 16 bits), for each number of steps and "
    "gamma. Left out: of what lies farther from the lit area's end than the margin"
)
TITLES = {"shift_um": "Shift by the response (um)", "left_um": "Left of it (um)"}
SEED = 20_261_124
STEPS, GAMMAS, RIGS = (3, 4, 5, 6, 8), (1.0, 1.5, 2.0, 2.4), 3
SIZE, MONITOR_PX, PIXEL_MM, CELLS = (560, 420), (1600, 1000), 0.3, 12
BEYOND = 24  # px drawn around the picture, so that blur at its border is right
NOISES, BLURS_PX = (1.0, 8.0), (0.0, 4.0)


class DrawnRig(NamedTuple):
    """A monitor and a camera. angle: by how much of it gamma changes across the
    picture; falloff: of light at the corners; answer: light 0 to 1 -> signal; tilt:
    (2,), turn: rad, share: of the monitor's width that is seen."""

    gamma: float
    black: float
    angle: float
    room: float
    falloff: float
    answer: object
    tilt: np.ndarray
    turn: float
    share: float
    noise: float
    blur_px: float
    depth: int


def drawn_rig(gamma, k, rng):
    """The k-th rig; cameras answer in proportion, by a filling well, or by sRGB."""
    bend = rng.uniform(0.2, 1.5)
    answers = (
        lambda light: light,
        lambda light: 1 - np.exp(-bend * light),
        lambda light: np.where(
            light < 0.0031308,
            12.92 * light,
            1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055,
        ),
    )
    return DrawnRig(
        gamma,
        rng.uniform(0, 0.03),
        rng.choice([0.0, 0.08]),
        rng.uniform(0, 0.1),
        rng.uniform(0, 1.0),
        answers[k % len(answers)],
        rng.uniform(-0.3, 0.3, 2),
        rng.uniform(-0.5, 0.5),
        rng.uniform(0.9, 1.3),
        float(np.exp(rng.uniform(*np.log(NOISES)))),
        rng.uniform(*BLURS_PX),
        int(rng.choice([255, 65535])),
    )


def seen_points(rig):
    """x and y on the monitor, px, that the pixels of a larger picture see."""
    width, height = SIZE
    v, u = np.indices((height + 2 * BEYOND, width + 2 * BEYOND)) - float(BEYOND)
    u, v = (u - width / 2) / width, (v - height / 2) / width
    c, s = np.cos(rig.turn), np.sin(rig.turn)
    a, b = c * u + s * v, c * v - s * u
    depth = 1 + rig.tilt[0] * a + rig.tilt[1] * b
    scale = MONITOR_PX[0] * rig.share / depth
    places = MONITOR_PX[0] / 2 + scale * a, MONITOR_PX[1] / 2 + scale * b
    return places, u, v


def level_of(pattern, place, length):
    """What the monitor is sent at places along the pattern's axis, 0 to 1."""
    if pattern.kind == "phase":
        turns = pattern.periods * place / length + pattern.step / pattern.of
        return 0.5 + 0.5 * np.sin(2 * np.pi * turns)
    cell = np.floor(place / pattern.cell_px).astype(int)
    bit = (cell ^ (cell >> 1)) >> (pattern.of - 1 - pattern.bit) & 1
    return (1.0 - bit) if pattern.inverse else bit.astype(float)


def photographs(rig, patterns, rng):
    """Pictures (n, H, W), true points (H, W, 2) mm, and what sees them (H, W)."""
    places, u, v = seen_points(rig)
    inside = [(p >= 0) & (p < n) for p, n in zip(places, MONITOR_PX, strict=True)]
    lit = inside[0] & inside[1]
    gamma = rig.gamma * (1 + rig.angle * u)
    kept = np.s_[BEYOND:-BEYOND, BEYOND:-BEYOND]
    full = rig.answer(np.float64(1 + rig.room))
    pictures = []
    for pattern in patterns:
        axis = "xy".index(pattern.axis)
        level = level_of(pattern, places[axis], MONITOR_PX[axis])
        light = lit * (rig.black + (1 - rig.black) * level**gamma)
        if rig.blur_px:
            light = cv2.GaussianBlur(light, (0, 0), rig.blur_px)
        light = light * (1 - rig.falloff * (u * u + v * v)) + rig.room
        signal = 0.92 * rig.answer(light)[kept] / full
        noise = rng.normal(0, rig.noise / 255, signal.shape)
        value = np.clip(np.rint(rig.depth * (signal + noise)), 0, rig.depth)
        pictures.append(value.astype(np.uint8 if rig.depth == 255 else np.uint16))
    true = np.where(lit, places, np.nan)[:, *kept]
    return np.array(pictures), PIXEL_MM * np.moveaxis(true, 0, 2), lit[kept]


def scored(rig, steps, rng):
    """(errors in stated SD, share of good pixels left out, Decoded)"""
    patterns = patterns_of(plan_of_cells(MONITOR_PX, CELLS, steps))
    pictures, true, lit = photographs(rig, patterns, rng)
    grid = ActiveGrid(MONITOR_PX, tuple(PIXEL_MM * side for side in MONITOR_PX))
    found = decode(pictures, patterns, grid)
    reach = 2 * (found.margin_px + 2) + 1
    good = cv2.erode(lit.astype(np.uint8), np.ones((reach, reach), np.uint8)) > 0
    off = ((found.location - true) / found.sigma)[found.mask & lit]
    return off.ravel(), 1 - found.mask[good].mean(), found


def measured():
    """A row for each number of steps and gamma."""
    for steps in STEPS:
        for gamma in GAMMAS:
            yield _row(steps, gamma)


def _row(steps, gamma):
    every, lost, sizes, told = [], [], [], 0
    for k in range(RIGS):
        rng = np.random.default_rng([SEED, steps, round(10 * gamma), k])
        off, share, found = scored(drawn_rig(gamma, k, rng), steps, rng)
        every.append(off)
        lost.append(share)
        sizes += [(own.size or 0.0, own.left or 0.0) for own in found.response]
        told += bool(response_warnings(found, False))
    off = np.abs(np.concatenate(every))
    shift, left = 1e3 * np.sqrt(np.mean(np.square(sizes), axis=0))
    return {
        "case": f"{steps} steps, gamma {gamma:g}",
        "count": len(off),
        **{f"within{n}": 100 * np.mean(off < n) for n in (1, 2, 3)},
        "ratio": np.median(off) / 0.6744897501960817,
        "left_out": 100 * max(lost),
        "shift_um": shift,
        "left_um": left,
        "told": f"{told} of {RIGS} views warned of" if told else "",
    }
