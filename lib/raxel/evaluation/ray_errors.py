"""Predicted errors of the rays of a camera, at nodes over its image.

A formula has the covariance of its parameters. Images do not determine a rotation of
all rays, so errors are those after the best rotation of the rays that boards covered:
other rays are extrapolated, and have far larger errors, which would rotate all. Where a
fit uses displaced corners of the board, their errors move the rays, too. Where no board
was, the lens may depart from the fit, and the larger error counts. A table has no
covariance: half of the difference between the rays of halves of the images is the error
of all, in the root mean square.
"""

import numpy as np
from scipy.linalg import block_diag

from raxel.cameras.core.base import under_boards
from raxel.evaluation.distortion import pixels_by_point
from raxel.evaluation.misfit import polynomials, with_radial_terms, without_turns
from raxel.geometry.poses import cross_matrix

N_CELLS = 32  # along the longer side of the image
ROWS, COLUMNS = ("upper", "middle", "lower"), ("left", "centre", "right")


def node_pixels(camera):
    """Pixels (rows, columns, 2) of `Camera.error_nodes`."""
    size = np.array([camera.width, camera.height])
    counts = np.ceil(size * N_CELLS / size.max()).astype(int) + 1
    u, v = (np.linspace(-0.5, w - 0.5, n) for w, n in zip(size, counts, strict=True))
    return np.stack(np.meshgrid(u, v), axis=-1)


def errors_of_formula(camera, distance, slopes, covariance, of_corners=None):
    """`Camera.error_nodes` by the covariance (P, P) of parameters.

    distance: of the boards, at which rays are compared; slopes: function of points (N,
    3), which returns the derivatives (N, 2, P) of their pixels; of_corners: covariance
    (Q, Q) of `polynomials` by errors of displaced corners.
    """
    places = node_pixels(camera)
    pixels = places.reshape(-1, 2)
    rays = camera.rays(pixels)
    points = rays.origins + distance * rays.directions
    turns = pixels_by_point(camera, pixels, points) @ -cross_matrix(points)
    changes = slopes(points)
    if of_corners is not None:
        changes = np.concatenate([changes, polynomials(pixels, camera)], axis=2)
        covariance = block_diag(covariance, of_corners)
    known = np.isfinite(turns).all(axis=(1, 2)) & np.isfinite(changes).all(axis=(1, 2))
    seen = under_boards(camera, pixels[known])
    own = without_turns(turns[known], changes[known], seen)
    errors = own @ covariance @ own.transpose(0, 2, 1)
    found = np.full((len(pixels), 3), np.nan)
    found[known] = errors[:, [0, 0, 1], [0, 1, 1]]
    return found.reshape(*places.shape[:2], 3)


def errors_with_deviation(camera, distance, covariance):
    """`Camera.error_nodes` of a camera with own errors: where no board was, the larger
    of these and those of a lens that departs from the fit.

    covariance (P, P): of `with_radial_terms`, as far as boards do not constrain them.
    """
    places = node_pixels(camera)
    pixels = places.reshape(-1, 2)
    own = camera.pixel_covariance(pixels)[:, [0, 0, 1], [0, 1, 1]]
    other = errors_of_formula(
        camera, distance, lambda _: with_radial_terms(pixels, camera), covariance
    ).reshape(-1, 3)
    squares, others = (errors[:, 0] + errors[:, 2] for errors in (own, other))
    larger = ~under_boards(camera, pixels) & (others == np.fmax(squares, others))
    return np.where(larger[:, None], other, own).reshape(*places.shape[:2], 3)


def errors_of_directions(camera, sd):
    """`Camera.error_nodes` by the standard deviation (N,), rad, of both components of
    the directions at `inner_nodes`, NaN where unknown."""
    slopes = camera.direction_slopes(inner_nodes(camera))
    known = np.isfinite(sd) & np.isfinite(slopes).all(axis=(1, 2))
    found = np.full((len(sd), 3), np.nan)
    back = np.linalg.pinv(slopes[known])
    errors = back @ back.transpose(0, 2, 1)
    found[known] = sd[known, None] ** 2 * errors[:, [0, 0, 1], [0, 1, 1]]
    return found.reshape(*node_pixels(camera).shape[:2], 3)


def inner_nodes(camera):
    """Pixels (N, 2) of the nodes, those at the edge moved to the outermost centres."""
    largest = [camera.width - 1, camera.height - 1]
    return np.clip(node_pixels(camera), 0, largest).reshape(-1, 2)


def errors_of_table(camera, halves):
    """`Camera.error_nodes` by the SplitHalf of a camera: the same at each ray."""
    shape = node_pixels(camera).shape[:2]
    known = camera.rays(inner_nodes(camera)).valid.reshape(shape)
    squares = np.mean([each.disagreement_px**2 for each in halves.divisions]) / 4
    return np.where(known[..., None], squares / 2 * np.array([1.0, 0, 1.0]), np.nan)


def next_place(camera):
    """Name of the ninth of the image whose rays are least certain, None where no errors
    are known. A ray without errors is uncertain by the width of the image."""
    errors = camera.pixel_covariance(node_pixels(camera).reshape(-1, 2))
    squares = np.trace(errors, axis1=1, axis2=2).reshape(node_pixels(camera).shape[:2])
    if np.isnan(squares).all():
        return None
    squares = np.where(np.isnan(squares), float(camera.width) ** 2, squares)
    ninths = {
        f"{row} {column}": part.mean()
        for row, rows in zip(ROWS, np.array_split(squares, 3, axis=0), strict=True)
        for column, part in zip(COLUMNS, np.array_split(rows, 3, axis=1), strict=True)
    }
    return max(ninths, key=ninths.__getitem__)
