"""Variations of the synthetic board of 3.3.1, and images with broken edges."""

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.trials.scenes import photographed
from chapters.shared.scoring import scored
from chapters.shared.synthetic_board import SyntheticBoard, clicks
from raxel.features.celect import CelectSettings, celect

NOISE_SD = 4.0
MULTIPLIERS = (0.4, 0.5, 0.63, 0.8, 1.0, 1.26, 1.6, 2.0, 2.5)
BIG_FOVS = (152, 146, 134)
# Length of the faded stretch in sides of squares, and the share of all sides.
BROKEN = {
    "large squares with long breaks": {
        "length": 0.6,
        "share": 0.15,
        "squares_across": 6,
        "fov_deg": 100,
    },
    "large squares with short breaks": {
        "length": 0.4,
        "share": 0.15,
        "squares_across": 6,
        "fov_deg": 100,
    },
    "small squares with long breaks": {
        "length": 0.6,
        "share": 0.30,
        "squares_across": 10,
        "fov_deg": 134,
    },
}
FADE = 0.15
PUBLISHED = CelectSettings()
GROWN = {"published": PUBLISHED, "no growth": CelectSettings(most_growths=0)}


def clicked_score(board, noise_sd, rng, settings=PUBLISHED):
    """Score of one run on a blurred and noisy image of a SyntheticBoard."""
    image = board.image(1.0, noise_sd, rng)
    where = clicks(board.outer_corners, rng)
    result = celect(image, where, board.columns, board.rows, settings=settings)
    return scored(result, board.lattice)


def broken_edges(image, lattice, share, length, rng):
    """The image with the middle of some squares' sides faded to grey.

    share: of all sides; length: of the faded stretch, in sides. The fade ends
    FADE of a side further out on both sides.
    """
    grey = image.astype(np.float32)
    level = float(np.median(lattice_means(image, lattice)))
    v, u = np.indices(image.shape, np.float32)
    keep = np.ones(image.shape, np.float32)
    for a, b in all_sides(lattice):
        if rng.random() >= share:
            continue
        middle, side = (a + b) / 2, np.linalg.norm(b - a)
        reach = int((length / 2 + FADE) * side) + 2
        first = np.maximum(np.rint(middle).astype(int) - reach, 0)
        last = np.rint(middle).astype(int) + reach + 1
        part = slice(first[1], last[1]), slice(first[0], last[0])
        off = np.hypot(u[part] - middle[0], v[part] - middle[1]) / side
        faded = np.clip((off - length / 2) / FADE, 0, 1)
        keep[part] = np.minimum(keep[part], faded)
    return np.rint(level + keep * (grey - level)).astype(np.uint8)


def all_sides(lattice):
    """Pairs of neighbouring corners."""
    for first, second in (
        (lattice[:, :-1], lattice[:, 1:]),
        (lattice[:-1], lattice[1:]),
    ):
        yield from zip(first.reshape(-1, 2), second.reshape(-1, 2), strict=True)


def lattice_means(image, lattice):
    """Lowest and highest grey level at the centres of the squares."""
    cells = (lattice[:-1, :-1] + lattice[1:, 1:]) / 2
    u, v = np.rint(cells.reshape(-1, 2)).astype(int).T
    levels = image[v, u].astype(float)
    return np.array([levels.min(), levels.max()])


def growth_trial(condition, rng):
    """The same image of broken edges with and without growing windows.

    It is blurred by 1 px before and after the edges fade.
    """
    board = SyntheticBoard(
        square_px=1000 / condition["squares_across"], fov_deg=condition["fov_deg"]
    )
    lattice = board.lattice
    image = broken_edges(
        board.image(1.0), lattice, condition["share"], condition["length"], rng
    )
    image = photographed(image.astype(np.float32), rng, 1.0, NOISE_SD)
    where = clicks(board.outer_corners, rng)
    return {
        name: scored(
            celect(image, where, board.columns, board.rows, settings=settings), lattice
        )
        for name, settings in GROWN.items()
    }
