"""Predicted standard deviations beside actual errors, on drawn images: stated.json.

Corners are drawn by `tests.drawn_images`, active grids and boards by the formulas
here. `ratio` is a robust standard deviation of errors over the predicted one,
`within1` to `within3` the shares of errors within so many of them, in per cent.
"""

from typing import NamedTuple

import cv2
import numpy as np

from raxel.calibration.parametric.lens_formula import calibrate_lens, calibrate_pinhole
from raxel.calibration.views.correspondence import BoardShape, BoardView
from raxel.cameras import KannalaBrandtCamera, PerspectiveCamera
from raxel.features import find_board
from raxel.features.active_grid import decode
from raxel.features.lattice import orders
from raxel.geometry.poses import pose, rotation_from_vector, transform
from raxel.sets import ActiveGrid, patterns_of, plan_of_cells
from tests.drawn_images import Lens, Photo, board_in_view, drawn, gaussian

ROBUST = 1.4826  # of a Gaussian's standard deviation over its median deviation
# Corners.
CORNER_SEED, IMAGES, BOARD_SIZE = 20_261_123, 10, (9, 6)
PLAIN = Lens("perspective", 600.0)
LENSES = {
    "perspective": PLAIN,
    "barrel": Lens("barrel", 380.0),
    "fisheye of 180 degrees": Lens("equidistant", 200.0, 640, 640),
    "mirror": Lens("mirror", 170.0, 640, 640),
}
NONE = np.zeros((0, 2)), np.zeros(0)
# Active grids.
GRID_SEED = 20_261_124
STEPS, GAMMAS, RIGS = (3, 4, 5, 6, 8), (1.0, 1.5, 2.0, 2.4), 3
GRID_SIZE, MONITOR_PX, PIXEL_MM, CELLS = (560, 420), (1600, 1000), 0.3, 12
BEYOND = 24  # px drawn around the image, so that blur at its border is right
NOISES, BLURS_PX = (1.0, 8.0), (0.0, 4.0)
# Calibrations: 14 boards of 10 x 7 corners.
FIT_SEED = 25_301
SIZE, COUNT, NOISE_PX = (1280, 960), 14, 0.1
SETS = {"pinhole": 40, "fisheye": 20}
BOARD = 24.0 * np.stack(np.meshgrid(np.arange(10), np.arange(7)), -1).reshape(-1, 2)
MIDDLE, HALF = BOARD.mean(axis=0), np.ptp(BOARD, axis=0) / 2
CASES = {
    "sound": (0, 0, 0, 0),
    "board bent by 1 mm along x": (1, 0, 0, 0),
    "board bent by 0.6, -0.4 mm, twisted by 0.5": (0.6, -0.4, 0.5, 0),
}


def summary(case, errors, **more):
    """A row: errors (N,) in predicted standard deviations."""
    errors = np.abs(errors)
    within = {f"within{k}": 100 * np.mean(errors <= k) for k in (1, 2, 3)}
    ratio = ROBUST * np.median(errors)
    return {"case": case, "count": len(errors), **within, "ratio": ratio, **more}


# Corners.


def _lens(lens, rng):
    return lens, (16, 40), Photo(gaussian(rng.uniform(0.4, 0.9)), noise=_low(rng))


def _low(rng):
    return rng.uniform(0.5, 2)


def _noisy(rng):
    blur = gaussian(rng.uniform(0.5, 1.2))
    noise, shot = rng.uniform(2, 10), rng.uniform(0, 0.8)
    return PLAIN, (18, 40), Photo(blur, noise=noise, shot=shot)


def _coded(rng):
    blur, quality = gaussian(rng.uniform(0.5, 1.5)), int(rng.uniform(75, 96))
    return PLAIN, (18, 40), Photo(blur, noise=rng.uniform(0.5, 4), quality=quality)


def _dim(rng):
    black = rng.uniform(10, 80)
    grey = black, black + rng.uniform(15, 50)
    return PLAIN, (18, 40), Photo(gaussian(0.9), noise=_low(rng), grey=grey)


def _small(rng):
    return PLAIN, (8, 13), Photo(gaussian(rng.uniform(0.4, 0.9)), noise=_low(rng))


def _mosaic(rng):
    photo = Photo(gaussian(rng.uniform(0.7, 1.2)), noise=_low(rng), mosaic=True)
    return PLAIN, (18, 40), photo


def _of_best(found, truth):
    if not found.found or {found.columns, found.rows} != set(BOARD_SIZE):
        return NONE
    options = [
        (found.corners[order] - truth, found.sd[order])
        for order, size in orders(found.columns, found.rows)
        if size == BOARD_SIZE
    ]
    off, sd = min(options, key=lambda one: np.nansum(np.abs(one[0])))
    return off[np.isfinite(sd)], sd[np.isfinite(sd)]


CORNER_SETS = {
    **{name: lambda rng, lens=lens: _lens(lens, rng) for name, lens in LENSES.items()},
    "noise of 2 to 10": _noisy,
    "JPEG 75 to 95": _coded,
    "contrast of 15 to 50": _dim,
    "squares of 8 to 13 px": _small,
    "colour mosaic": _mosaic,
}


def corners():
    """Yield a row for each drawn set of chessboards."""
    for number, name in enumerate(CORNER_SETS):
        rng = np.random.default_rng([CORNER_SEED, number])
        found = [_of_best(*_searched(name, rng)) for _ in range(IMAGES)]
        off, sd = (np.concatenate(part) for part in zip(*found, strict=True))
        refused = sum(len(own) == 0 for _, own in found)
        yield summary(
            name,
            (off / sd[:, None]).ravel(),
            sd_px=np.median(sd),
            error_px=ROBUST * np.median(np.abs(off)),
            truth_px=0.0,
            left_out=100 * refused / IMAGES,
        )


def _searched(name, rng):
    board = None
    while board is None:
        lens, squares, photo = CORNER_SETS[name](rng)
        board = board_in_view(lens, *BOARD_SIZE, rng.uniform(*squares), rng)
    image, truth = drawn(lens, board, photo, rng)
    return find_board(image, *BOARD_SIZE), truth


# Active grids.


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
    width, height = GRID_SIZE
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
    """Images (n, H, W), true points (H, W, 2) mm, and what sees them (H, W)."""
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


def decoding():
    """Yield a row for each number of steps and gamma."""
    for steps in STEPS:
        for gamma in GAMMAS:
            every, lost = [], []
            for k in range(RIGS):
                rng = np.random.default_rng([GRID_SEED, steps, round(10 * gamma), k])
                off, share, _ = scored(drawn_rig(gamma, k, rng), steps, rng)
                every.append(off)
                lost.append(share)
            case = f"{steps} steps, gamma {gamma:g}"
            yield summary(case, np.concatenate(every), left_out=100 * max(lost))


# Calibrations.


def camera_of(kind, longer=1.0):
    """The camera that is looked through, its focal length times `longer`."""
    if kind == "pinhole":
        K = [[1040 * longer, 0, 655.0], [0, 1037 * longer, 468.0], [0, 0, 1]]
        return PerspectiveCamera(K, [-0.22, 0.07], *SIZE)
    focal = 405.0 * longer, 406.0 * longer
    return KannalaBrandtCamera([1, -0.025, 0.003, -6e-4], focal, (628.0, 489.0), *SIZE)


def poses(rng, kind):
    """Poses of boards all over the image, tilted and turned, without end."""
    camera = camera_of(kind)
    near, far = (380, 700) if kind == "pinhole" else (190, 380)
    while True:
        pixel = rng.uniform(0.12, 0.88, 2) * SIZE
        sight = camera.rays(pixel[None]).directions[0]
        across = np.cross([0.0, 0.0, 1.0], sight)
        angle = np.arctan2(np.linalg.norm(across), sight[2])
        facing = rotation_from_vector(across / np.linalg.norm(across) * angle)
        around, tilt = rng.uniform(0, 2 * np.pi), rng.uniform(0.2, 0.7)
        tilted = rotation_from_vector(
            tilt * np.array([np.cos(around), np.sin(around), 0])
        )
        R = facing @ tilted @ rotation_from_vector([0, 0, rng.uniform(-np.pi, np.pi)])
        yield pose(R, rng.uniform(near, far) * sight - R @ [*MIDDLE, 0.0])


def views_of(rng, kind, shape):
    """Return BoardViews of one set of a bent board; shape: values of a BoardShape."""
    solid = BoardShape(MIDDLE, HALF, np.array(shape, float)).points(BOARD)
    camera, placed, views = camera_of(kind), poses(rng, kind), []
    while len(views) < COUNT:
        pixels = camera.project(transform(next(placed), solid)).pixels
        if camera.in_image(np.nan_to_num(pixels, nan=-1.0)).all():
            pixels = pixels + NOISE_PX * rng.normal(size=pixels.shape)
            views.append(BoardView(pixels, BOARD, 10, 7, f"{len(views)}.png"))
    return views


def calibration():
    """Yield a row for each case and camera: both focal lengths of each set."""
    for number, (case, shape) in enumerate(CASES.items()):
        for kind, sets in SETS.items():
            first = FIT_SEED + 1000 * number
            errors = [_focal_errors(first + k, kind, shape) for k in range(sets)]
            yield summary(f"{case}, {kind}", np.concatenate(errors), sets=sets)


def _focal_errors(seed, kind, shape):
    views, true = views_of(np.random.default_rng(seed), kind, shape), camera_of(kind)
    if kind == "pinhole":
        found, focal = calibrate_pinhole(views, *SIZE), true.K[[0, 1], [0, 1]]
    else:
        found = calibrate_lens(views, *SIZE, "kannala-brandt")
        focal = true.pixels_per_unit
    return (found.values[:2] - focal) / np.sqrt(np.diag(found.covariance)[:2])


PARTS = {
    "corners": (corners, "corners of drawn chessboards, ten images a set"),
    "decoding": (decoding, "active grids of 12 cells on drawn monitors"),
    "calibration": (calibration, "focal lengths from 14 drawn boards a set"),
}
