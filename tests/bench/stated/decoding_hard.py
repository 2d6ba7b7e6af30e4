"""Do stated deviations of decoded places hold where noise is not white or places bend?

A monitor of 1024 x 768 px, drawn at nine points of each camera pixel, blurred, behind
noise, a tone curve, light that drifts and JPEG, in an image set of files that is
decoded as `raxel decode` does.
"""

import tempfile
from itertools import product
from pathlib import Path

import cv2
import numpy as np

from raxel.errors import InputError
from raxel.features.active_grid.view import decode_view
from raxel.sets import ActiveGrid, ImageSet, View, load_set, patterns_of, plan_of_cells
from raxel.sets.image_set import set_text
from raxel.sets.model import DESCRIPTION
from tests.active_grids import shown, sines

WHAT = (
    "decoded places in JPEG files, behind a tone curve, in light that drifts, in "
    "curved mirrors, at folds, and without Gray code"
)
TITLES = {"steps": "Steps", "gross": "Off by half a period or more"}
SEED = 20_261_124
SIZE, MONITOR = (480, 360), (1024, 768)
POINTS = 3  # each way in a pixel
NOISE, BLUR = 2.0, 1.0
MARGIN = 10  # px along the picture's border, about what is left out there
WITHIN = "within1", "within2", "within3"
NUMBERS = "count", *WITHIN, "ratio", "left_out", "gross"


def tilted(u, v, share=0.95):
    """Places in px of the monitor at (u, v), shares of the picture's width."""
    depth = 1 + 0.25 * u - 0.15 * v
    x = MONITOR[0] * (0.5 + (u + 0.05 * v) / (share * depth))
    return x, MONITOR[1] / 2 + MONITOR[0] * (v - 0.04 * u) / (share * depth)


def in_a_ball(turn, width):
    """Places as a ball shows them, that run away towards its rim."""

    def place(u, v):
        r = np.hypot(u, v) + 1e-9
        scale = width * np.tan(np.minimum(turn * r, 1.5)) / r
        return MONITOR[0] * (0.5 + scale * u), MONITOR[1] / 2 + MONITOR[0] * scale * v

    return place


def rippled(u, v):
    x, y = tilted(u, v, 1.05)
    wave = 0.01 * MONITOR[0]
    return x + wave * np.sin(25 * u + 3 * v), y + wave * np.cos(25 * v + 2 * u)


def joined(change):
    """Facets that meet edge to edge, four across the picture."""

    def place(u, v):
        x, y = tilted(u, v, 1.1)
        turn = 2 * u + 0.4 * v
        ridge = change * MONITOR[0] * np.abs(turn - np.round(turn))
        return x + ridge, y + ridge / 2

    return place


def turning(u, v):
    """A caustic: places turn round along two lines."""
    return MONITOR[0] * (0.5 + 0.3 * np.sin(6.5 * u)), MONITOR[1] * (0.5 + 0.9 * v)


def pictures(patterns, rng, place=tilted, noise=NOISE, blur=BLUR, drift=0.0, tone=1.0):
    """(H, W) uint8 of every pattern, then white and black; and true places (H, W, 2).

    drift: of the light over all pictures; tone: exponent of the camera's curve.
    """
    width, height = SIZE
    v, u = (np.indices((height * POINTS, width * POINTS)) + 0.5) / POINTS - 0.5
    u, v = (u - width / 2) / width, (v - height / 2) / width
    x, y = place(u, v)
    on = (x >= 0) & (x < MONITOR[0]) & (y >= 0) & (y < MONITOR[1])
    fade = on * (1 - 0.6 * (u * u + v * v))
    taken, count = [], len(patterns) + 2
    for k, pattern in enumerate([*patterns, 1.0, 0.0]):
        value = pattern
        if k < len(patterns):
            value = shown(pattern, (x, y)["xy".index(pattern.axis)], MONITOR)
        light = 20 + 190 * fade * (0.03 + 0.97 * value)
        light = cv2.resize(light, SIZE, interpolation=cv2.INTER_AREA)
        light = cv2.GaussianBlur(light, (0, 0), blur)
        light = light * (1 + drift * (k / (count - 1) - 0.5))
        light = light + rng.normal(0, noise, light.shape)
        light = 255 * (np.clip(light, 0, 255) / 255) ** tone
        taken.append(np.rint(light).astype(np.uint8))
    v, u = np.indices((height, width))
    x, y = place((u - width / 2) / width, (v - height / 2) / width)
    on = (x >= 0) & (x < MONITOR[0]) & (y >= 0) & (y < MONITOR[1])
    return taken, np.where(on[..., None], np.stack([x, y], axis=-1), np.nan)


def decoded(patterns, taken, quality=None):
    """The DecodedView of these pictures as a set of files; quality: of JPEG, or PNG."""
    names = [*(p.image for p in patterns), "white.png", "black.png"]
    ending, options = ".png", []
    if quality:
        ending, options = ".jpg", [cv2.IMWRITE_JPEG_QUALITY, quality]
    files = [name.replace(".png", ending) for name in names]
    listed = [
        type(p)(**{**vars(p), "image": file})
        for p, file in zip(patterns, files, strict=False)
    ]
    with tempfile.TemporaryDirectory() as folder:
        for file, picture in zip(files, taken, strict=True):
            cv2.imwrite(str(Path(folder) / file), picture, options)
        levels = dict(zip(("white", "black"), files[-2:], strict=True))
        view = View(name="pose", patterns=tuple(listed), **levels)
        grid = ActiveGrid(MONITOR)
        made = ImageSet("drawn", *SIZE, grid, (view,), Path(folder))
        (Path(folder) / DESCRIPTION).write_text(set_text(made), "utf-8")
        image_set = load_set(Path(folder))
        return decode_view(image_set, image_set.views[0])


def row(case, patterns, seed, quality=None, **changes):
    """A row of the part; changes: as of `pictures`."""
    rng = np.random.default_rng([SEED, seed])
    taken, true = pictures(patterns, rng, **changes)
    phases = [p for p in patterns if p.kind == "phase"]
    found = {"case": case, "steps": phases[0].of}
    try:
        view = decoded(patterns, taken, quality)
    except InputError as fault:
        return found | _empty(str(fault).rsplit(": ", 1)[-1])
    inner = np.zeros(true.shape[:2], bool)
    inner[MARGIN:-MARGIN, MARGIN:-MARGIN] = True
    inner &= np.isfinite(true[..., 0])
    use = inner & view.decoded.mask
    if view.reason or not use.any():
        return found | _empty(view.reason)
    error = np.abs(view.decoded.location - true)[use]
    off = error / view.decoded.sigma[use]
    period = [
        size / max(p.periods for p in phases if p.axis == axis)
        for axis, size in zip("xy", MONITOR, strict=True)
    ]
    told = [text.removeprefix("pose: ") for text in view.warnings]
    within = {name: 100 * float(np.mean(off < k)) for k, name in enumerate(WITHIN, 1)}
    return (
        found
        | within
        | {
            "count": int(off.size),
            "ratio": float(np.median(off) / 0.6745),
            "left_out": 100 * float(1 - use.sum() / inner.sum()),
            "gross": int(np.count_nonzero(error > np.array(period) / 2)),
            "told": told[0] if told else "",
        }
    )


def _empty(reason):
    return dict.fromkeys(NUMBERS) | {"told": reason}


def cases():
    """(case, patterns, quality of JPEG or None, changes)"""
    for steps in (3, 4, 6):
        usual = patterns_of(plan_of_cells(MONITOR, 8, steps))
        yield "PNG", usual, None, {}
        for quality in (75, 85, 90, 95):
            yield f"JPEG {quality}", usual, quality, {}
            toned = {"tone": 1 / 2.2}
            yield f"JPEG {quality} behind a tone curve", usual, quality, toned
        yield "JPEG 90, noise 0.5", usual, 90, {"noise": 0.5}
        for drift in (0.03, 0.1):
            yield f"light drifts by {drift:.0%}", usual, None, {"drift": drift}
    usual = patterns_of(plan_of_cells(MONITOR, 8, 6))
    fine = patterns_of(plan_of_cells(MONITOR, 16, 6))
    for noise, blur in product((0.5, 2.0), (1.0, 3.0)):
        told = f", noise {noise:g}, blur {blur:g} px"
        changes = {"noise": noise, "blur": blur}
        for name, place, patterns in (
            ("ball", in_a_ball(3.0, 0.12), usual),
            ("ball, fine sines", in_a_ball(4.0, 0.1), fine),
            ("rippled mirror", rippled, usual),
            ("facets, small folds", joined(0.01), usual),
            ("facets, large folds", joined(0.1), usual),
            ("places turn round", turning, usual),
        ):
            yield name + told, patterns, None, changes | {"place": place}
    alone = (8, 9), (1, 16), (5.3, 8.7), (1, 6, 40)
    for periods, noise in product(alone, (1.0, 6.0)):
        told, changes = " and ".join(f"{n:g}" for n in periods), {"noise": noise}
        yield f"{told} periods, noise {noise:g}", sines(periods), None, changes
    yield "1 and 90 periods, noise 12", sines((1, 90)), None, {"noise": 12.0}
    yield "8 and 10 periods", sines((8, 10)), None, {}


def measured():
    """Rows of the part."""
    for seed, (case, patterns, quality, changes) in enumerate(cases()):
        yield row(case, patterns, seed, quality, **changes)
