"""Does an image of another target show a grid of circles?"""

import numpy as np
from scipy.spatial import cKDTree

# Size of the searched image; a smaller circle is not tested.
N_PIXELS, MIN_N_EDGE_PIXELS, MAX_SCALE = 6e5, 16, 2
# The threshold is a local mean less a margin; window as fraction of the shorter side.
WINDOW_FRACTION, MARGIN_GREY = 0.2, 5
# Area over that of the ellipse with the same second moments; a square has 0.955.
MIN_ELLIPSE_FRACTION = 0.95
# Fourfold symmetry of an edge, as the mean of r cos(4 angle) in radii: below 0.02 on
# rendered circles of 5 px and more, above 0.07 on blurred and sharp squares.
MAX_FOURFOLD = 0.03
INSIDE_RADII, OUTSIDE_RADII = 0.8, 1.15
# Number of circles between two pairs of neighbours; a grid of 4 x 4 has as many.
MIN_N_INNER_CIRCLES, N_NEIGHBOURS = 4, 8
PAIR_TOL = 0.2  # of the distance of a neighbour
MIN_SINE = 0.3  # of the angle between the pairs
# Of the contrast, between two discs: dots in the squares of a board vary in ground.
GROUND_TOL, MIN_GROUND_FRACTION = 1 / 3, 2 / 3


def is_circle_grid(grey):
    """Whether an image (height, width) uint8 shows a lattice of separate discs.

    They are dark or bright, in a square, staggered or hexagonal pattern. Squares of a
    blurred chessboard are not discs: their edges have a fourfold symmetry.
    """
    import cv2

    grey = cv2.GaussianBlur(resized(grey, N_PIXELS), (3, 3), 0)
    return any(_has_lattice(image) for image in (grey, 255 - grey))


def resized(grey, n_pixels):
    """An image of about so many pixels, enlarged at most MAX_SCALE times."""
    import cv2

    scale = min(MAX_SCALE, np.sqrt(n_pixels / grey.size))
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    return cv2.resize(grey, None, fx=scale, fy=scale, interpolation=how)


def _discs(grey):
    """Dark discs (N, 3): their centres, px, and the grey level of the ground."""
    import cv2

    window = int(WINDOW_FRACTION * min(grey.shape)) | 1
    mean, dark = cv2.ADAPTIVE_THRESH_MEAN_C, cv2.THRESH_BINARY_INV
    binary = cv2.adaptiveThreshold(grey, 1, mean, dark, window, MARGIN_GREY)
    edges = cv2.findContours(binary, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)[0]
    edges = [e for e in edges if MIN_N_EDGE_PIXELS <= len(e) <= 4 * window]
    discs = [_disc(edge, cv2.moments(edge), grey) for edge in edges]
    return np.array([disc for disc in discs if disc is not None])


def _disc(edge, moments, grey):
    """Centre and ground of an edge (N, 1, 2) px, None unless it is that of a dark disc.

    moments: of the enclosed area.
    """
    area, x, xy, y = (moments[name] for name in ("m00", "mu20", "mu11", "mu02"))
    spread = np.array([[x, xy], [xy, y]]) / max(area, 1)
    ellipse = 4 * np.pi * np.sqrt(max(np.linalg.det(spread), 0))
    if area <= MIN_ELLIPSE_FRACTION * ellipse or not ellipse:
        return None
    centre = np.array([moments["m10"], moments["m01"]]) / area
    offsets = edge[:, 0] - centre
    # On the unit circle where the edge is an ellipse.
    circle = np.linalg.solve(2 * np.linalg.cholesky(spread), offsets.T)
    z = circle[0] + 1j * circle[1]
    lengths = np.abs(np.roll(z, -1) - np.roll(z, 1))
    if abs(np.average(z**4 / abs(z) ** 3, weights=lengths)) > MAX_FOURFOLD:
        return None
    inside, outside = (
        np.rint(centre + k * offsets).astype(int) for k in (INSIDE_RADII, OUTSIDE_RADII)
    )
    if np.any(outside < 0) or np.any(outside >= grey.shape[::-1]):
        return None
    dark, bright = (grey[v, u] for u, v in (inside.T, outside.T))
    return (*centre, np.median(bright)) if dark.max() < bright.min() else None


def _has_lattice(grey):
    """Whether enough dark discs have opposite pairs of neighbours and one ground."""
    discs = _discs(grey)
    if len(discs) <= N_NEIGHBOURS:
        return False
    centres, ground = discs[:, :2], discs[:, 2]
    nearest = cKDTree(centres).query(centres, k=N_NEIGHBOURS + 1)[1][:, 1:]
    middles = (centres[:, None] + centres[nearest]) / 2
    u, v = np.rint(np.concatenate([centres[:, None], middles], axis=1)).astype(int).T
    dark, *between = grey[v, u].astype(float)
    on_ground = np.abs(between - ground) < GROUND_TOL * (ground - dark)
    offsets = centres[nearest] - centres[:, None]
    length = np.linalg.norm(offsets, axis=2)
    sums = np.linalg.norm(offsets[:, :, None] + offsets[:, None], axis=3)
    paired = (sums < PAIR_TOL * length[..., None]).any(axis=2)
    unit = offsets / length[..., None] * paired[..., None]
    scatter = np.einsum("nki,nkj->nij", unit, unit)
    # The square of half the sine of the angle between two pairs, 0 along one line.
    spread = np.linalg.det(scatter) / np.maximum(paired.sum(axis=1), 1) ** 2
    inner = (on_ground.mean(axis=0) > MIN_GROUND_FRACTION) & (
        spread > (MIN_SINE / 2) ** 2
    )
    return inner.sum() >= MIN_N_INNER_CIRCLES
