"""Does an image of another target show a grid of circles?"""

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


def is_circle_grid(grey):
    """Whether an image (height, width) uint8 shows a lattice of separate discs.

    They are dark or bright, in a square, staggered or hexagonal pattern. Squares of a
    blurred chessboard are not discs: their edges have a fourfold symmetry.
    """
    import cv2

    grey = cv2.GaussianBlur(resized(grey, N_PIXELS), (3, 3), 0)
    return any(_has_lattice(image, _discs(image)) for image in (grey, 255 - grey))


def resized(grey, n_pixels):
    """An image of about so many pixels, enlarged at most MAX_SCALE times."""
    import cv2

    scale = min(MAX_SCALE, np.sqrt(n_pixels / grey.size))
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    return cv2.resize(grey, None, fx=scale, fy=scale, interpolation=how)


def _discs(grey):
    """Centres (N, 2) px of dark discs."""
    import cv2

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


def _has_lattice(grey, centres):
    """Whether enough dark discs have opposite neighbours with ground between them."""
    if len(centres) <= N_NEIGHBOURS:
        return False
    nearest = cKDTree(centres).query(centres, k=N_NEIGHBOURS + 1)[1]
    offsets = centres[nearest] - centres[:, None]
    u, v = np.rint(centres[:, None] + offsets / 2).astype(int).T
    dark, *between = grey[v, u].astype(float)
    ground = np.mean(between > (dark + np.max(between, axis=0)) / 2, axis=0)
    offsets = offsets[:, 1:]
    length = np.linalg.norm(offsets, axis=2, keepdims=True)
    sums = np.linalg.norm(offsets[:, :, None] + offsets[:, None], axis=3)
    paired = np.where((sums < PAIR_TOL * length).any(axis=2)[..., None], 1 / length, 0)
    scatter = np.einsum("nki,nkj->nij", offsets * paired, offsets * paired)
    # Four times this is the squared sine of the angle between two pairs.
    spread = np.linalg.det(scatter) / np.maximum(np.trace(scatter.T), 1) ** 2
    inner = (ground > MIN_GROUND_FRACTION) & (spread > MIN_SINE**2 / 4)
    return inner.sum() >= max(MIN_N_INNER, MIN_INNER_FRACTION * len(centres))
