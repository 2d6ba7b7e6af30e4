"""Stated standard deviations of chessboard corners against their errors.

Boards are drawn by the formulas of `_drawn`; on recorded sets, whose folder
RAXEL_RECORDED names, the consensus of other detectors stands for the truth, and its
own error counts as the corner's: `truth_px` is how far they are from it, the farthest
of each corner, the median of all. Where one detector alone is the reference its corners
only say whether a board is right. `within` counts axes of corners; `beyond3` corners
whose distance from the truth is more than 3 SD of an axis, of which a Gaussian has
1.1 %. A decile is of the stated SD, over a set.
"""

import os
from pathlib import Path

import cv2
import numpy as np

from raxel.evaluation.reference_corners import corner_errors, is_right
from raxel.features import find_board
from raxel.features.lattice import orders, symmetries
from raxel.io.files import read_json
from raxel.sets import load_reference, load_set, read_image
from tests.bench.stated._drawn import (
    Board,
    Lens,
    Photo,
    board_in_view,
    disk,
    drawn,
    gaussian,
    motion,
)

WHAT = (
    "Corners of chessboards: drawn through five lenses in blur, noise, coding and "
    "light of many kinds, ten pictures a set, and photographed, with the consensus of "
    "other detectors for the truth, whose own error counts as the corner's"
)
TITLES = {
    "sd_px": "Stated SD (px)",
    "error_px": "Error (px)",
    "least_decile": "Least of a decile",
    "most_decile": "Most of a decile",
    "beyond3": "Corners beyond 3 SD (%)",
    "truth_px": "Detectors apart (px)",
    "right_wrong_refused": "Right / wrong / refused",
    "without_size": "Without the size",
}
SEED, PICTURES = 20261123, 10
SIZE = 9, 6
RECORDED = Path(os.environ.get("RAXEL_RECORDED", "nowhere"))
WRONG_PX = 2.0
PLAIN = Lens("perspective", 600.0)
LENSES = {
    "perspective": PLAIN,
    "barrel": Lens("barrel", 380.0),
    "fisheye of 180 degrees": Lens("equidistant", 200.0, 640, 640),
    "stereographic": Lens("stereographic", 200.0, 640, 640),
    "mirror": Lens("mirror", 170.0, 640, 640),
}
NEAR = Lens("equidistant", 220.0, 720, 720)
ALONG_PIXELS = "along"
NONE = np.zeros((0, 2)), np.zeros(0)


def measured():
    """Rows of drawn sets, then of recorded ones."""
    for number, name in enumerate(SETS):
        rng = np.random.default_rng([SEED, number])
        yield from _rows(name, [_tried(*_picture(name, rng)) for _ in range(PICTURES)])
    for folder in sorted(RECORDED.glob("*/corners.json")):
        pictures = list(_photographs(folder.parent))
        yield from _rows(folder.parent.name, pictures, _apart(folder))


def _lens(lens, rng):
    return lens, (16, 40), Photo(gaussian(rng.uniform(0.4, 0.9)), noise=_low(rng))


def _low(rng):
    return rng.uniform(0.5, 2)


def _soft(kernel, low, high):
    def kind(rng):
        blur = rng.uniform(low, high)
        return PLAIN, (24, 40), Photo(kernel(blur, rng), noise=_low(rng))

    return kind


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


def _large(rng):
    lens = Lens("perspective", 1000.0, 1280, 960)
    return lens, (70, 95), Photo(gaussian(rng.uniform(0.5, 3)), noise=_low(rng))


def _uneven(rng):
    light = rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0, 1.5)
    blur = gaussian(rng.uniform(0.5, 1.5))
    photo = Photo(blur, light, (10, 150), gamma=2.2, noise=_low(rng))
    return PLAIN, (22, 40), photo


def _clipped(rng):
    blur, grey = gaussian(rng.uniform(0.7, 2)), (30, rng.uniform(260, 420))
    gamma = rng.uniform(1, 2.2)
    return PLAIN, (22, 40), Photo(blur, grey=grey, gamma=gamma, noise=_low(rng))


def _clean(rng):
    return PLAIN, (22, 40), Photo(gaussian(rng.uniform(0.5, 1)), noise=0.05)


def _near(rng):
    light = rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(0, 1)
    grey, gamma = (15, rng.uniform(200, 300)), rng.uniform(1, 2.2)
    blur = gaussian(rng.uniform(0.5, 1.5))
    return NEAR, None, Photo(blur, light, grey, gamma, noise=_low(rng))


def _aligned(rng):
    photo = Photo(gaussian(rng.uniform(0.3, 1)), noise=_low(rng))
    return PLAIN, ALONG_PIXELS, photo


def _sharpened(rng):
    blur, sharpened = gaussian(rng.uniform(0.4, 1)), rng.uniform(0.3, 1.2)
    quality = int(rng.uniform(85, 97))
    photo = Photo(blur, noise=_low(rng), sharpened=sharpened, quality=quality)
    return PLAIN, (18, 40), photo


def _mosaic(rng):
    photo = Photo(gaussian(rng.uniform(0.7, 1.2)), noise=_low(rng), mosaic=True)
    return PLAIN, (18, 40), photo


SETS = {
    **{name: lambda rng, lens=lens: _lens(lens, rng) for name, lens in LENSES.items()},
    "near board in a fisheye": _near,
    "Gaussian blur of 1 to 4 px": _soft(lambda blur, rng: gaussian(blur), 1, 4),
    "defocus of 1 to 5 px": _soft(lambda blur, rng: disk(blur), 1, 5),
    "motion of 2 to 9 px": _soft(lambda b, rng: motion(b, rng.uniform(0, 3)), 2, 9),
    "noise of 2 to 10": _noisy,
    "JPEG 75 to 95": _coded,
    "contrast of 15 to 50": _dim,
    "squares of 8 to 13 px": _small,
    "squares of 70 to 95 px": _large,
    "uneven light": _uneven,
    "clipped whites": _clipped,
    "without noise": _clean,
    "edges along the pixels": _aligned,
    "sharpened, JPEG 85 to 97": _sharpened,
    "colour mosaic": _mosaic,
}


def _picture(name, rng):
    """(picture, true corners (N, 2)) of a drawn set."""
    while True:
        lens, squares, photo = SETS[name](rng)
        if squares is None:
            board = _board_before(lens, rng)
        elif squares == ALONG_PIXELS:
            board = _board_along(lens, rng)
        else:
            board = board_in_view(lens, *SIZE, rng.uniform(*squares), rng)
        if board is not None:
            return drawn(lens, board, photo, rng)


def _board_before(lens, rng):
    """A board that fills much of a fisheye's view, or None."""
    lean = np.append(rng.uniform(0, 0.9) * _unit(rng), 0)
    turn = np.array([0, 0, rng.uniform(-3, 3)])
    R = cv2.Rodrigues(lean)[0] @ cv2.Rodrigues(turn)[0]
    middle = np.append(rng.uniform(1, np.array(SIZE) - 2), 0)
    board = Board(*SIZE, R, np.array([0, 0, rng.uniform(1.2, 3.5)]) - R @ middle)
    outer = board._replace(columns=SIZE[0] + 3, rows=SIZE[1] + 3)
    pixels = lens.pixels(outer.points() - R @ np.array([2.0, 2.0, 0]))
    lattice = lens.pixels(board.points()).reshape(SIZE[1], SIZE[0], 2)
    steps = [np.linalg.norm(np.diff(lattice, axis=k), axis=2).min() for k in (0, 1)]
    inside = np.all((pixels > 4) & (pixels < np.array([lens.width, lens.height]) - 4))
    return board if inside and min(steps) > 8 else None


def _board_along(lens, rng):
    """A board whose edges run along the pixels, nearly."""
    turn = np.append(0.03 * _unit(rng), rng.uniform(-0.03, 0.03))
    R = cv2.Rodrigues(turn)[0]
    middle = np.append((np.array(SIZE) - 1) / 2 + rng.uniform(-1, 1, 2), 0)
    distance = np.array([0, 0, lens.focal / rng.uniform(24, 40)])
    return Board(*SIZE, R, distance - R @ middle)


def _unit(rng):
    angle = rng.uniform(0, 2 * np.pi)
    return np.array([np.cos(angle), np.sin(angle)])


def _tried(image, truth):
    """(right with the size, right without, errors (N, 2), sd (N,)) of one picture.

    Right is True, or False for a board that is wrong, or None for one refused.
    """
    told, counted = find_board(image, *SIZE), find_board(image)
    off, sd = _of_best(told, truth)
    return _right(off, told), _right(_of_best(counted, truth)[0], counted), off, sd


def _of_best(found, truth):
    if not found.found or {found.columns, found.rows} != set(SIZE):
        return NONE
    options = [
        (found.corners[order] - truth, found.sd[order])
        for order, size in orders(found.columns, found.rows)
        if size == SIZE
    ]
    off, sd = min(options, key=lambda one: np.nansum(np.abs(one[0])))
    return off[np.isfinite(sd)], sd[np.isfinite(sd)]


def _right(off, found):
    if not found.found:
        return None
    return bool(len(off) and np.abs(off).max() < WRONG_PX)


def _photographs(folder):
    """As `_tried`, of each photograph of a recorded set, from its certain corners."""
    image_set = load_set(folder)
    reference = load_reference(image_set)
    agreed = _agreed(folder / "corners.json")
    for view in image_set.views:
        image, known = read_image(image_set, view), reference[view.image]
        size = known.columns, known.rows
        told, counted = find_board(image, *size), find_board(image)
        right = [
            is_right(corner_errors(one, known), known) if one.found else None
            for one in (told, counted)
        ]
        consensus = told.found and view.image in agreed
        yield *right, *(_from_consensus(told, known) if consensus else NONE)


def _agreed(path):
    """{image: median distance, px, of the farthest detector} of those with several."""
    images = read_json(path)["images"]
    apart = {name: one["spread_median_px"] for name, one in images.items()}
    return {name: px for name, px in apart.items() if px is not None}


def _apart(path):
    return float(np.median(list(_agreed(path).values())))


def _from_consensus(found, known):
    options = [
        order
        for order, size in symmetries(found.corners, found.columns, found.rows)
        if size == (known.columns, known.rows)
    ]
    corners = min(options, key=lambda one: _farthest(one, known))
    place = {tuple(one): number for number, one in enumerate(found.corners)}
    both = known.certain & np.isfinite(corners[:, 0])
    sd = np.array([found.sd[place[tuple(one)]] for one in corners[both]])
    return (corners - known.corners)[both], sd


def _farthest(corners, known):
    off = np.linalg.norm(corners - known.corners, axis=1)
    return np.nanmax(off[known.certain])


def _rows(name, pictures, apart=0.0):
    """The row of a set: all its corners, and its deciles. apart: px, see `truth_px`."""
    told, counted, off, sd = zip(*pictures, strict=True)
    off, sd = np.concatenate(off), np.concatenate(sd)
    missing = sum(1 for one in told if one is None)
    z = off / sd[:, None]
    deciles = [_robust(z[part]) for part in np.array_split(np.argsort(sd), 10)]
    yield {
        "case": name,
        "count": len(sd),
        "sd_px": np.median(sd),
        "error_px": _robust(off),
        **{f"within{k}": 100 * np.mean(np.abs(z) <= k) for k in (1, 2, 3)},
        "ratio": _robust(z),
        "least_decile": min(deciles),
        "most_decile": max(deciles),
        "beyond3": 100 * np.mean(np.linalg.norm(z, axis=1) > 3),
        "truth_px": apart,
        "left_out": 100 * missing / len(told),
        "right_wrong_refused": _counts(told),
        "without_size": _counts(counted),
    }


def _counts(right):
    return " / ".join(
        str(sum(one is kind for one in right)) for kind in (True, False, None)
    )


def _robust(values):
    """SD of errors of both axes about 0, by their median."""
    return 1.4826 * np.median(np.abs(values)) if len(values) else np.nan
