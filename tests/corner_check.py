"""Is a rendered corner where it should be? Small boards, and a fit by areas.

The fit knows how much of a pixel an edge covers, so it finds a corner of an image
without lens and noise to a few thousandths of a pixel. It checks renderings, and is no
detector: it starts near the corner.
"""

import numpy as np

from raxel.errors import InputError
from raxel.geometry.poses import pose
from raxel.sets.model import Chessboard

BOARD = Chessboard(3, 2, 1.0)
SQUARE_PX = 17.0


def board_before(camera, middle, square_px=SQUARE_PX, distance=600.0, tilt=0.25):
    """(Chessboard, T_camera_board): a board around a pixel, squares about this big.

    camera: any Camera; middle: (u, v). It stands across the ray of `middle`, at a
    distance in mm, turned in its plane and tilted. How large a pixel is there is
    measured along rays. Raises InputError where the camera has no ray at `middle`.
    """
    u, v = middle
    pixels = np.array([[u, v], [u + 2, v], [u - 2, v], [u, v + 2], [u, v - 2]], float)
    origins, directions, valid = camera.rays(pixels)
    if not valid.all():
        raise InputError(f"{camera.kind}: no ray near {middle}; give another pixel")
    points = origins + distance * directions
    across = (points[1] - points[2]) / 4
    z = directions[0]
    x = across - (across @ z) * z
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    scale = np.sqrt(np.linalg.norm(np.cross(across, points[3] - points[4]) / 4))
    turn = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0]])
    x, y = turn[:, :2] @ np.stack([x, y])
    x = np.cos(tilt) * x + np.sin(tilt) * z
    R = np.column_stack([x, y, np.cross(x, y)])
    board = Chessboard(BOARD.columns, BOARD.rows, square_px * scale)
    centre = np.append(board.points().mean(axis=0), 0)
    return board, pose(R, points[0] - R @ centre)


def fitted_corners(image, pixels, off=(0.3, -0.2)):
    """(corners (N, 2), misfit (N,)) near the board's projected corners (N, 2).

    The fits start `off` px away, with edges along the lattice.
    """
    lattice = pixels.reshape(BOARD.rows, BOARD.columns, 2)
    along = np.gradient(lattice, axis=1).reshape(-1, 2)
    down = np.gradient(lattice, axis=0).reshape(-1, 2)
    fits = [
        fitted_corner(
            image, pixel + off, (np.arctan2(-a[0], a[1]), np.arctan2(-d[0], d[1]))
        )
        for pixel, a, d in zip(pixels, along, down, strict=True)
    ]
    corners, misfit = zip(*fits, strict=True)
    return np.array(corners), np.array(misfit)


def fitted_corner(image, start, angles, half=5, skip=1.6):
    """The corner (2,) near `start` of two bent edges, fitted to the pixels' areas.

    angles: of the edges' normals, to start from. Returns the corner and the rms of what
    is left, as a share of the contrast.

    Each edge covers a pixel by a known share (exact for a straight one); where both
    cross one pixel the product of shares is no longer exact, so pixels nearer than
    `skip` to the corner are left out.
    """
    from scipy.optimize import least_squares

    u0, v0 = np.rint(start).astype(int)
    v, u = np.mgrid[v0 - half : v0 + half + 1, u0 - half : u0 + half + 1]
    u, v, grey = u.ravel(), v.ravel(), image[v, u].ravel()
    keep = np.hypot(u - start[0], v - start[1]) > skip
    u, v, grey = u[keep], v[keep], grey[keep]
    low, high = grey.min(), grey.max()

    def residual(p):
        one = edge_share(u - p[0], v - p[1], p[2], p[4])
        two = edge_share(u - p[0], v - p[1], p[3], p[5])
        return p[6] + p[7] * (one * two + (1 - one) * (1 - two)) - grey

    fits = []
    for base, gain in ((low, high - low), (high, low - high)):
        start_at = [*start, *angles, 0, 0, base, gain]
        fits.append(least_squares(residual, start_at, method="lm", x_scale="jac"))
        if fits[-1].cost < 1e-4 * len(grey) * gain**2:
            break
    best = min(fits, key=lambda fit: fit.cost)
    return best.x[:2], np.sqrt(2 * best.cost / len(grey)) / (high - low)


def edge_share(u, v, angle, bend):
    """Share of the pixel at (u, v) on the positive side of an edge through 0."""
    a, b = np.cos(angle), np.sin(angle)
    away = a * u + b * v + bend / 2 * (a * v - b * u) ** 2
    a, b = max(abs(a), 1e-3), max(abs(b), 1e-3)
    wide, narrow = (a + b) / 2, (a - b) / 2
    share = _ramp(away + wide) - _ramp(away + narrow)
    share += _ramp(away - wide) - _ramp(away - narrow)
    return share / (a * b)


def _ramp(x):
    return np.maximum(x, 0) ** 2 / 2
