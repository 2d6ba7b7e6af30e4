"""AprilTag grids and grids of circles drawn by a formula, seen by a lens."""

from functools import cache

import cv2
import numpy as np

from raxel.sets import AprilGrid

WIDTH, HEIGHT, FOCAL = 640, 480, 520.0
DISTORTION = np.array([-0.15, 0, 0, 0, 0])
K = np.array([[FOCAL, 0, 322.0], [0, FOCAL, 236.0], [0, 0, 1]])
PARTS = 3  # of a pixel along each axis
# Of prints; the sides of cells are whole numbers of px.
PRINT_SCALE, MARGIN = 4, 30  # px per mm, mm
POSES = ((30, 0, 5), (-25, 20, -8), (5, -35, 90), (25, 25, 186), (-32, -10, 20))
POSES += ((0, 32, -15), (15, -20, 40), (-15, -28, 3))


@cache
def print_of(target, border=2):
    """The print (uint8) of a target, PRINT_SCALE px per mm, from (-MARGIN, -MARGIN)."""
    size = PRINT_SCALE * (target.points().max(axis=0) + 2 * MARGIN)
    x, y = ((np.arange(n) + 0.5) / PRINT_SCALE - MARGIN for n in size)
    x, y = np.meshgrid(x, y)
    if isinstance(target, AprilGrid):
        return np.where(_is_tag_ink(target, x, y, border), 40, 200).astype(np.uint8)
    ink, reach = np.zeros(x.shape), int(PRINT_SCALE * target.pitch_mm / 2)
    for column, row in np.rint(PRINT_SCALE * (target.points() + MARGIN)).astype(int):
        near = np.s_[row - reach : row + reach, column - reach : column + reach]
        centre = np.array([column, row]) / PRINT_SCALE - MARGIN
        away = np.hypot(x[near] - centre[0], y[near] - centre[1])
        beyond = 0.32 * target.pitch_mm - away
        ink[near] += np.clip(0.5 + PRINT_SCALE * beyond, 0, 1)
    return np.rint(200 - 160 * ink).astype(np.uint8)


def _is_tag_ink(target, x, y, border):
    """Whether a grid of tags is black at points (x, y) of its `points()` frame."""
    (column, u), (row, v) = (np.divmod(a, target.pitch_mm) for a in (x, y))
    (columns, rows), tag = target.tags, target.tag_mm
    name = f"DICT_APRILTAG_{target.family}"
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
    cells = dictionary.markerSize + 2 * border
    codes = [
        dictionary.generateImageMarker(k, cells, borderBits=border)
        for k in range(target.first_id, target.first_id + columns * rows)
    ]
    on_board = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    number = np.where(on_board, (rows - 1 - row) * columns + column, 0).astype(int)
    i, j = (np.minimum(a / tag * cells, cells - 1).astype(int) for a in (v, u))
    code = (np.array(codes)[number, i, j] == 0) & on_board & (u < tag) & (v < tag)
    near = (column >= -1) & (column < columns) & (row >= -1) & (row < rows)
    return code | (near & (u >= tag) & (v >= tag))


def target_image(target, angles_deg, fill=0.62, border=2, offset=(0, 0), seed=0):
    """(image (HEIGHT, WIDTH) uint8, points of the target (N, 2) px).

    angles_deg: about x, y and the optical axis; fill: height of the target over that
    of the image; offset: of its middle, px.
    """
    points = target.points()
    R = cv2.Rodrigues(np.radians([*angles_deg[:2], 0.0]))[0]
    R = R @ cv2.Rodrigues(np.radians([0.0, 0.0, angles_deg[2]]))[0]
    size = np.ptp(points, axis=0).max()
    distance = FOCAL * size / (fill * HEIGHT)
    middle = np.array([*(points.max(axis=0) + points.min(axis=0)) / 2, 0])
    t = distance * np.array([*np.divide(offset, FOCAL), 1]) - R @ middle
    H = np.linalg.inv(np.column_stack([R[:, 0], R[:, 1], t]))
    place = PRINT_SCALE * (cv2.perspectiveTransform(_rays(), H) + MARGIN) - 0.5
    light = cv2.remap(
        print_of(target, border), place.astype(np.float32), None, 1, borderValue=200
    )
    image = cv2.resize(light.astype(np.float32), (WIDTH, HEIGHT), interpolation=3)
    image = cv2.GaussianBlur(image, (0, 0), 0.6)
    image += np.random.default_rng(seed).normal(0, 1.5, image.shape)
    solid = np.column_stack([points, np.zeros(len(points))])
    seen = cv2.projectPoints(solid, R, t, K, DISTORTION)[0][:, 0]
    return np.clip(np.rint(image), 0, 255).astype(np.uint8), seen


@cache
def _rays():
    """Rays (HEIGHT * PARTS, WIDTH * PARTS, 2) of parts of pixels, at a depth of 1."""
    u, v = ((np.arange(n * PARTS) + 0.5) / PARTS - 0.5 for n in (WIDTH, HEIGHT))
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 1, 2)
    return cv2.undistortPoints(pixels, K, DISTORTION).reshape(len(v), len(u), 2)
