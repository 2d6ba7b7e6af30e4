"""Grids of circles in an image of any target."""

from typing import NamedTuple

import cv2
import numpy as np
from scipy.spatial import cKDTree

# Size of the searched image; a smaller circle is not tested.
N_PIXELS, MIN_N_EDGE_PIXELS, MAX_SCALE = 6e5, 16, 2
# The threshold is a local mean less a margin; window as fraction of the shorter side.
WINDOW_FRACTION, MARGIN_GREY = 0.2, 5
# Area over that of the ellipse with the same second moments (0.955 of a square), and
# fourfold symmetry of the edge, the mean of r cos(4 angle) in radii: below 0.02 on
# rendered circles of 5 px and more, above 0.07 on blurred and sharp squares.
MIN_ELLIPSE_FRACTION, MAX_FOURFOLD = 0.95, 0.03
# Number of circles between two pairs of neighbours (a grid of 4 x 4 has as many), and
# their smallest fraction of all discs.
MIN_N_INNER, MIN_INNER_FRACTION, N_NEIGHBOURS = 4, 0.2, 8
# Of the distance of a neighbour; sine of the angle between the pairs; fraction of the
# middles to neighbours that are ground, unlike those of dots in squares of a board.
PAIR_TOL, MIN_SINE, MIN_GROUND_FRACTION = 0.2, 0.3, 2 / 3


class CircleLattice(NamedTuple):
    """Discs of a lattice.

    centres: (N, 2) px of all discs; dark: whether they are darker than the ground;
    hexagonal: whether an equilateral triangle is less distorted than a square.
    """

    centres: np.ndarray
    dark: bool
    hexagonal: bool


def circle_lattice(grey):
    """The lattice of separate discs of an image (height, width) uint8, or None.

    They are dark or bright, in a square, staggered or hexagonal pattern. Squares of a
    blurred chessboard are not discs: their edges have a fourfold symmetry.
    """
    small = cv2.GaussianBlur(resized(grey, N_PIXELS), (3, 3), 0)
    scale = np.divide(grey.shape, small.shape)[::-1]
    for image in (small, 255 - small):
        centres = _discs(image)
        cells = _cells(image, centres)
        if cells is not None:
            centres = (centres + 0.5) * scale - 0.5
            return CircleLattice(centres, image is small, _is_hexagonal(cells))
    return None


def resized(grey, n_pixels):
    """An image of about so many pixels, enlarged at most MAX_SCALE times."""
    scale = min(MAX_SCALE, np.sqrt(n_pixels / grey.size))
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    return cv2.resize(grey, None, fx=scale, fy=scale, interpolation=how)


def _discs(grey):
    """Centres (N, 2) px of dark discs."""
    window = int(WINDOW_FRACTION * min(grey.shape)) | 1
    mean, dark = cv2.ADAPTIVE_THRESH_MEAN_C, cv2.THRESH_BINARY_INV
    binary = cv2.adaptiveThreshold(grey, 1, mean, dark, window, MARGIN_GREY)
    edges = cv2.findContours(binary, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)[0]
    edges = [e for e in edges if MIN_N_EDGE_PIXELS <= len(e) <= 4 * window]
    centres = [_disc_centre(edge[:, 0], cv2.moments(edge)) for edge in edges]
    return np.array([centre for centre in centres if centre is not None])


def _disc_centre(edge, moments):
    """The centre of an edge (N, 2) px with these moments; None if it is no ellipse."""
    area, x, xy, y = (moments[name] for name in ("m00", "mu20", "mu11", "mu02"))
    spread = np.array([[x, xy], [xy, y]]) / max(area, 1)
    ellipse = 4 * np.pi * np.sqrt(max(np.linalg.det(spread), 1))
    if area <= MIN_ELLIPSE_FRACTION * ellipse:
        return None
    centre = np.array([moments["m10"], moments["m01"]]) / area
    # On the unit circle where the edge is an ellipse.
    circle = np.linalg.solve(2 * np.linalg.cholesky(spread), (edge - centre).T)
    z = circle[0] + 1j * circle[1]
    lengths = np.abs(np.roll(z, -1) - np.roll(z, 1))
    fourfold = abs(np.average(z**4 / abs(z) ** 3, weights=lengths))
    return centre if fourfold < MAX_FOURFOLD else None


def _cells(grey, centres):
    """Offsets (M, 2, 2) px of two neighbours of the inner discs of a lattice, or None.

    Enough dark discs have opposite neighbours with ground between them.
    """
    if len(centres) <= N_NEIGHBOURS:
        return None
    nearest = cKDTree(centres).query(centres, k=N_NEIGHBOURS + 1)[1]
    offsets = centres[nearest] - centres[:, None]
    u, v = np.rint(centres[:, None] + offsets / 2).astype(int).T
    dark, *between = grey[v, u].astype(float)
    ground = np.mean(between > (dark + np.max(between, axis=0)) / 2, axis=0)
    offsets = offsets[:, 1:]
    length = np.linalg.norm(offsets, axis=2, keepdims=True)
    sums = np.linalg.norm(offsets[:, :, None] + offsets[:, None], axis=3)
    paired = (sums < PAIR_TOL * length).any(axis=2)
    first = offsets[range(len(centres)), paired.argmax(axis=1)]
    area = first[:, None, 0] * offsets[..., 1] - first[:, None, 1] * offsets[..., 0]
    across = (
        np.abs(area)
        > MIN_SINE * length[..., 0] * np.linalg.norm(first, axis=1)[:, None]
    )
    second = offsets[range(len(centres)), (paired & across).argmax(axis=1)]
    inner = (ground > MIN_GROUND_FRACTION) & (paired & across).any(axis=1)
    if inner.sum() < max(MIN_N_INNER, MIN_INNER_FRACTION * len(centres)):
        return None
    return np.stack([first, second], axis=1)[inner]


def _is_hexagonal(cells):
    """Whether cells (M, 2, 2) px are triangles with equal sides rather than squares.

    A view in perspective distorts both. The pattern is that with the smaller ratio of
    singular values of the map from it to the image.
    """
    acute = np.sign(np.sum(cells[:, 0] * cells[:, 1], axis=1))[:, None]
    cells = np.stack([cells[:, 0], cells[:, 1] * np.where(acute, acute, 1)], axis=1)
    triangle = np.linalg.inv([[1, 0], [0.5, np.sqrt(0.75)]])
    square, hexagon = (np.median(np.linalg.cond(m)) for m in (cells, triangle @ cells))
    return bool(hexagon < square)
