"""Boards found, with their size and without: right, wrong or refused."""

import os
from collections import Counter
from pathlib import Path

import numpy as np

from raxel.evaluation.reference_corners import corner_errors, is_right
from raxel.features import find_board, symmetries
from raxel.sets import Chessboard, load_reference, load_set, read_image
from tests.bench.stated._board_pictures import (
    PATTERNS,
    Plane,
    chessboard,
    cloth,
    discs,
    hidden,
    table,
)

WHAT = (
    "Boards drawn by random numbers: on paper, cut along their squares on a patterned "
    "cloth, partly covered or shaded; patterns that are no board; and photographs. "
    "Right: every corner within a pixel (drawn), or within its reference's tolerance."
)
TITLES = {
    "pictures": "Pictures",
    "right": "Right",
    "wrong": "Wrong",
    "refused": "Refused",
}
SEED, COUNT, OF_PATTERN = 20_261_125, 24, 4
MOST_PX = 1.0
MARGINS = 0.0, 0.1, 0.25, 0.5, 1.0, 1.05, 2.0
SEEN = {"given": True, "not given": False}


def measured():
    """A row for each kind of picture, and for each recorded set that is there."""
    for kind, drawn in SCENES.items():
        pictures = list(drawn())
        for told, known in SEEN.items():
            outcomes = Counter(_outcome(*picture, known) for picture in pictures)
            yield _row(f"{kind}, size {told}", outcomes)
    yield _row("grids of circles", Counter(map(_found, _patterns([discs] * COUNT))))
    others = [lambda rng, one=one: one for one in PATTERNS.values()] * OF_PATTERN
    yield _row("other patterns", Counter(map(_found, _patterns(others))))
    for folder in sorted(Path(os.environ.get("RAXEL_RECORDED", "nowhere")).glob("*")):
        yield from _recorded(folder)


def _row(case, outcomes):
    counts = {name: outcomes[name] for name in ("right", "wrong", "refused")}
    return {"case": case, "pictures": outcomes.total()} | counts


def _drawn(number, ground, margins, after=lambda image, plane, rng: image):
    """Yields (image, Board) of COUNT drawn boards."""
    rng = np.random.default_rng([SEED, number])
    count = 0
    while count < COUNT:
        rows = int(rng.integers(4, 9))
        columns = int(rng.integers(max(rows, 6), 13))
        plane = Plane.drawn(rng, columns, rows)
        if not plane.inside() or plane.square_px < 10:
            continue
        tone = chessboard(columns, rows, rng, rng.choice(margins), ground(rng))
        yield after(plane.picture(tone, rng), plane, rng), plane.board
        count += 1


SCENES = {
    "on paper": lambda: _drawn(0, table, MARGINS),
    "cut along the squares, on cloth": lambda: _drawn(1, cloth, [0.0]),
    "partly hidden": lambda: _drawn(2, table, MARGINS, hidden),
}


def _patterns(tones):
    """Yields pictures of patterns, functions of random numbers."""
    rng = np.random.default_rng([SEED, 3])
    for tone in tones:
        plane = Plane.drawn(rng, int(rng.integers(8, 28)), int(rng.integers(6, 14)))
        yield plane.picture(tone(rng), rng)


def _outcome(image, board, known):
    size = (board.columns, board.rows) if known else (None, None)
    found = find_board(image, *size)
    if not found.found:
        return "refused"
    off = [
        np.nanmax(np.linalg.norm(order - board.corners(), axis=1))
        for order, size in symmetries(found.corners, found.columns, found.rows)
        if size == (board.columns, board.rows)
    ]
    return "right" if min(off, default=np.inf) < MOST_PX else "wrong"


def _found(image):
    return "wrong" if find_board(image).found else "refused"


def _recorded(folder):
    """Rows of a recorded set of a chessboard with reference corners."""
    image_set = load_set(folder)
    target = image_set.target
    if not isinstance(target, Chessboard) or not image_set.reference:
        return
    reference = load_reference(image_set)
    for told, known in SEEN.items():
        size = (target.columns, target.rows) if known else (None, None)
        outcomes = Counter()
        for view in image_set.views:
            found = find_board(read_image(image_set, view), *size)
            truth = reference[view.image]
            right = is_right(corner_errors(found, truth), truth)
            outcomes[("right" if right else "wrong") if found.found else "refused"] += 1
        yield _row(f"{image_set.name}, size {told}", outcomes)
