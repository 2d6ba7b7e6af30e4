"""White and black pictures that something passed before, where they decide on bits.

Bits without an inverse are compared with the middle of white and black. A hand in one
of the two moves that middle: codes cannot be read there, and edges are measured that
the monitor does not show. But what white and black are follows from level and
modulation of the sines; by how much is the same all over the picture, or changes over
it slowly. Where a lamp is reflected, a tone curve makes it something else; but whatever
the response, white and black lie near the brightest and the darkest step there.
"""

import cv2
import numpy as np

from raxel.features.active_grid.checks.leftover import Steps, robust
from raxel.features.active_grid.checks.outliers import STRIDE
from raxel.features.active_grid.layout import BRIGHT, LIT

FITTED = 2000  # pixels, of all that are lit
MIN_FITTED = 1000
ROWS = 43 * STRIDE  # at once
# Pixels so far from what is not lit are asked: at the monitor's rim a blur brings in
# what lies beside it, which does not follow its pictures.
INSIDE = 12  # px
OFF = 0.2  # of the contrast: an edge moves by half a standard deviation of its blur
EVERYWHERE = 0.5  # of the lit pixels: something else is wrong
OF_PLACE = [0, 6, 7, 8, 9, 10]  # of the shares, those that go with the place alone
WORTH_SAYING = 30  # pixels


def mended_levels(images, codes, levels):
    """White and black, and lines on where they were off.

    images: n pictures (H, W); codes: AxisCodes; levels: {"white": (H, W), "black":
    (H, W)}, or None in their place. Where one is off, it has what the sines say. They
    come back as they are where no bit is compared with them, or no sine tells.
    """
    alone = any(dark is None for code in codes for _, dark in code.bits)
    codes = [code for code in codes if len(code.steps) > 2]
    if not alone or not codes or any(level is None for level in levels.values()):
        return levels, []
    found = [_predictor(images, code, levels) for code in codes]
    if None in found:
        return levels, []
    own, count = {name: level.copy() for name, level in levels.items()}, {}
    inside, lit, off = _inside(found, levels)
    for top in range(0, len(images[0]), ROWS):
        few = slice(top // STRIDE, (top + ROWS) // STRIDE)
        if not off[few].any():
            continue
        rows = slice(top, top + ROWS)
        due, _, all_off = _asked(found, levels, (rows,))
        amid = inside[few].repeat(STRIDE, 0).repeat(STRIDE, 1)
        for name, level in levels.items():
            height, width = all_off[name].shape
            odd = all_off[name] & amid[:height, :width]
            count[name] = count.get(name, 0) + int(np.count_nonzero(odd))
            most = np.iinfo(level.dtype).max
            own[name][rows][odd] = np.rint(due[name][odd]).clip(0, most)
    said = {name: n for name, n in count.items() if n >= WORTH_SAYING}
    if not said or max(said.values()) > EVERYWHERE * STRIDE**2 * np.count_nonzero(lit):
        return levels, []
    return own, [
        f"something passed before the monitor in its {name} picture: {n} pixels have "
        "what the sines say in its place; take it again"
        for name, n in said.items()
    ]


def _inside(found, levels):
    """Of every STRIDE-th pixel each way, (rows, columns) bool: which lie amid lit ones,
    which are lit, and where, amid them, a level is off."""
    lit, off = [], []
    for top in range(0, len(levels["white"]), ROWS):
        some = slice(top, top + ROWS, STRIDE), slice(None, None, STRIDE)
        _, good, odd = _asked(found, levels, some)
        lit.append(good)
        off.append(np.logical_or.reduce(list(odd.values())))
    lit, off = np.concatenate(lit), np.concatenate(off)
    own = np.ones((2 * INSIDE // STRIDE + 1,) * 2, np.uint8)
    # A hand before white or black leaves the sines, and what they light, as they were.
    inside = cv2.erode(lit.astype(np.uint8), own) > 0
    return inside, lit, off & inside


def _asked(found, levels, where):
    """What levels should be, which pixels are lit, and {name: where it is off}."""
    # A hand in one of the sines is told by those along the other axis.
    dues, steps, good = zip(*(of_axis(where) for of_axis in found), strict=True)
    good = np.logical_and.reduce(good)
    light = np.concatenate(steps)
    nearly = {"white": light.max(axis=0), "black": light.min(axis=0)}
    every = *dues, nearly
    off = {
        name: good & _off([_away(level[where], due, name) for due in every])
        for name, level in levels.items()
    }
    return dues[0], good, off


def _off(away):
    """(rows, columns) bool: where a level is off by each account, and the same way."""
    return (np.min(away, axis=0) > OFF) | (np.max(away, axis=0) < -OFF)


def _away(level, due, name):
    """(rows, columns): by how much a level is not what is due, in contrasts."""
    off = cv2.blur(level.astype(np.float32) - due[name], (3, 3))
    return off / np.maximum(due["white"] - due["black"], 1)


def _predictor(images, code, levels):
    """Index, a tuple -> what white and black should be there, {name: (rows, columns)},
    the steps' light (N, rows, columns), and which of these pixels are lit; None of too
    few."""
    stride = max(1, int(np.sqrt(images[0].size / (2 * FITTED))))
    grid = [np.arange(0, n, stride) for n in images[0].shape]
    grid = np.array(np.meshgrid(*grid, indexing="ij")).reshape(2, -1)
    steps = Steps.of(images, code, tuple(grid))
    size = steps.at(tuple(grid)).size
    least = LIT * np.percentile(size, BRIGHT)
    some = tuple(grid[:, size > least])
    if len(some[0]) < MIN_FITTED:
        return None
    basis = _columns(steps.at(some))[:, None]
    shares = {
        name: robust(level[some][None].astype(float), basis).astype(np.float32)
        for name, level in levels.items()
    }

    def predicted(where):
        seen = steps.at(where)
        columns = _columns(seen)
        due = {name: np.tensordot(own, columns, 1) for name, own in shares.items()}
        return due, seen.light, seen.size > least

    return predicted


def _columns(seen):
    places = seen.shares()[OF_PLACE]
    return np.concatenate([seen.mean * places, seen.size * places, places[:1]])
