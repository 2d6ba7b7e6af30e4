"""Bits: effect of a wrong one, methods of detection, and a whole display."""

import cv2
import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.trials.view import RIGS, rig
from raxel.features.active_grid import decode
from raxel.features.active_grid.layout import REACH
from raxel.sets import ActiveGrid, Pattern, PatternPlan, patterns_of, plan_of_cells
from raxel.sets.patterns import pattern_picture
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

ROWS = 64
EDGE_PX = 32
NEAR_PX = 2
LEVELS_GREY = (40.0, 200.0)
SINE_STEPS = 4
# How far edges shift over the rows: anywhere in a pixel, or between two of them.
SLANT_PX = {"anywhere": 1.0, "between pixels": 0.0}
# Wide enough for a window of cells on either side of an edge.
CELL_PX = 4
STRIP_ROWS = 8


def displayed(plan, monitor_px):
    """(patterns, images (n, H, W) uint16) as sent to the monitor."""
    patterns = patterns_of(plan)
    pictures = [pattern_picture(p, monitor_px) for p in patterns]
    return patterns, np.array(pictures).astype(np.uint16)


def whole_display_trial(condition, rng):
    """Decode every monitor pixel from the patterns as sent."""
    size = tuple(condition["monitor_px"])
    plan = plan_of_cells(size, phase_steps=4)
    patterns, pictures = displayed(plan, size)
    found = decode(
        pictures, patterns, ActiveGrid(size), smooth=False, margin_px=0,
        noise=0.3, linear=True, threads=1,
    )  # fmt: skip
    place = np.indices(size[::-1])[::-1].transpose(1, 2, 0)
    own = np.all(np.floor(found.location) == place, axis=-1)
    off = found.location - (place + 0.5)
    return {
        "patterns": len(patterns),
        "binary": sum(p.kind == "gray" for p in patterns),
        "sinusoidal": sum(p.kind == "phase" for p in patterns),
        "bits": plan.gray_bits[0],
        "phase_step_deg": 360 / plan.phase_steps,
        "window_px": 2 * REACH + 1,
        "pixels": own.size,
        "not_own": int((~own).sum()),
        "largest_px": float(np.nanmax(np.abs(off))),
    }


def wrong_bit_trial(condition, rng):
    """Error in cells by one wrong bit next to an edge: Gray and plain binary.

    At every edge the image of each bit in turn is exchanged with its inverse in the
    pixel left of it; the decoder reads the cells.
    """
    bits = condition["bits"]
    cells = 2**bits
    size = (CELL_PX * cells, STRIP_ROWS)
    patterns, pictures = displayed(PatternPlan((bits, 0), True), size)
    beside = CELL_PX * np.arange(1, cells) - 1
    cell = np.arange(cells)
    changed = (cell ^ cell >> 1)[1:] ^ (cell ^ cell >> 1)[:-1]
    at_edge, elsewhere = [], []
    for bit in range(bits):
        wrong = pictures.copy()
        pair = [2 * bit, 2 * bit + 1]
        wrong[np.ix_(pair, range(STRIP_ROWS), beside)] = pictures[
            np.ix_(pair[::-1], range(STRIP_ROWS), beside)
        ]
        found = decode(
            wrong, patterns, ActiveGrid(size),
            margin_px=0, noise=1.0, linear=True, threads=1,
        )  # fmt: skip
        shift = np.abs(found.cells[STRIP_ROWS // 2, beside, 0] - cell[:-1])
        changes = changed >> (bits - 1 - bit) & 1
        at_edge += shift[changes == 1].tolist()
        elsewhere += shift[changes == 0].tolist()
    plain = cell[1:] ^ cell[:-1]
    return {
        "bits_changed": max(int(c).bit_count() for c in changed),
        "shift": max(at_edge),
        "shift_elsewhere": max(elsewhere, default=0),
        "binary_bits_changed": max(int(c).bit_count() for c in plain),
        "binary_shift": 2 ** (bits - 1),
        "tested": len(at_edge),
    }


def bit_pictures(condition, rng):
    """(place (ROWS, W) from the first edge in cells, picture, inverse, white, black,
    mean of sines): noisy, 8 bits.

    Edges fall between pixels, or anywhere: then they cross the rows at a slant.
    Light that falls off does so along the row.
    """
    width = 8 * EDGE_PX
    slant = np.arange(ROWS)[:, None] / ROWS * condition["slant_px"]
    border = (np.arange(width + 1) - slant) / EDGE_PX
    low, high = LEVELS_GREY
    sharp = low + (high - low) * EDGE_PX * np.diff(_lit_length(border), axis=1)
    place = (np.arange(width) + 0.5 - slant) / EDGE_PX

    light = light_along(width, condition["light"])

    def taken(picture):
        soft = cv2.GaussianBlur(
            picture * light, (0, 0), condition["blur_px"],
            borderType=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        noisy = soft + rng.normal(0, condition["noise_grey"], soft.shape)
        return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)

    even = np.ones((ROWS, width))
    pair = taken(sharp), taken(low + high - sharp)
    white, black = taken(high * even), taken(low * even)
    flat = 0.5 * (low + high) * even
    sines = np.mean([taken(flat) for _ in range(SINE_STEPS)], axis=0)
    return place, *pair, white, black, sines


def light_along(width, light):
    """Share of light (width,) from the middle of the rig's monitor to its corner.

    The monitor is upright at the rig's mean distance, so that the camera's field
    angle, of which the light falls as cos^4, is the monitor's viewing angle too.
    """
    if light == "even":
        return np.ones(width)
    own = rig(1)
    reach_mm = np.hypot(*own.target.monitor_mm) / 2
    tangent = np.linspace(0, 1, width) * reach_mm / np.mean(own.poses.distance_mm)
    return np.cos(np.arctan(tangent)) ** (4 + own.monitor.falloff_exponent)


def _lit_length(x):
    """Length of odd cells from 0 to x, in cells."""
    whole = np.floor(x / 2)
    return whole + np.maximum(x - 2 * whole - 1, 0)


def wrong_bits(pictures, patterns, bit, white=None, black=None):
    """Flags (ROWS, W) of pixels that the decoder reads wrong."""
    found = decode(
        pictures, patterns, ActiveGrid(bit.shape[::-1]), white=white, black=black,
        margin_px=0, noise=1.0, linear=True, threads=1,
    )  # fmt: skip
    return found.cells[..., 0] != bit


def bits_trial(condition, rng):
    """Wrong bits within 2 px of edges: with an inverse, and with three thresholds."""
    place, picture, inverse, white, black, sines = bit_pictures(condition, rng)
    bit = np.floor(place).astype(int) % 2 == 1
    inner = (place > 0.5) & (place < place.max() - 0.5)
    near = inner & (EDGE_PX * np.abs(place - np.rint(place)) < NEAR_PX)
    patterns = [Pattern("", "x", "gray", of=1, bit=0, inverse=i) for i in (False, True)]
    mean = light_along(picture.shape[1], condition["light"]).mean()
    levels = [np.full(picture.shape, mean * level) for level in LEVELS_GREY]
    thresholds = {
        "one grey value": levels,
        "white and black": (white, black),
        "mean of the sines": (sines, sines),
    }
    paired = wrong_bits(np.array([picture, inverse]), patterns, bit)[near]

    def beside_paired(light, dark):
        wrong = wrong_bits(picture[None], patterns[:1], bit, light, dark)[near]
        return {
            "wrong": int(wrong.sum()),
            "only_threshold": int((wrong & ~paired).sum()),
            "only_inverse": int((paired & ~wrong).sum()),
        }

    counted = {"pixels": paired.size, "inverse.wrong": int(paired.sum())}
    return counted | {name: beside_paired(*pair) for name, pair in thresholds.items()}


MONITORS_PX = {
    "quick": ((1024, 768),),
    "full": ((1024, 768), (1280, 1024), (1920, 1080)),
}


@experiment("exp_c3_20_patterns", artefact="fig_3_8")
def whole_displays(effort):
    """Every pixel of a monitor, decoded from the patterns as sent."""
    sizes = MONITORS_PX[effort]
    return Plan(whole_display_trial, [{"monitor_px": list(m)} for m in sizes], 1)


@experiment("exp_c3_gray_single", artefact="sec_3_2_2")
def wrong_bits_at_edges(effort):
    """One wrong bit next to every edge of codes of 1 to 8 bits."""
    return Plan(wrong_bit_trial, [{"bits": bits} for bits in range(1, 9)], 1)


# Uneven light is tested with edges anywhere only.
EDGES_AND_LIGHT = (
    ("anywhere", "even"),
    ("between pixels", "even"),
    ("anywhere", "falls off"),
)
BIT_TRIALS = {"quick": 2, "full": 20}


@experiment("exp_c3_inverse_helps", artefact="sec_3_2_2", inputs=RIGS)
def bits_near_edges(effort):
    """Bits near edges, by an inverse and by three thresholds."""
    conditions = [
        {
            "slant_px": SLANT_PX[edges],
            "light": light,
            "blur_px": blur,
            "noise_grey": noise,
        }
        for edges, light in EDGES_AND_LIGHT
        for blur in (1, 2, 3)
        for noise in (4, 8)
    ]
    return Plan(bits_trial, conditions, BIT_TRIALS[effort])
