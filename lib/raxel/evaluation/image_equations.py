"""Normal equations of each image for parameters that all images share.

Each image's pose is free and eliminated. The joint solution leaves the scatter of
single corners. What one image requires beyond the joint solution is of scatter alone
too, if each corner errs independently: its squares then have a known sum, and whatever
moves the corners of one image together makes that sum larger.
"""

import numpy as np

from raxel.calibration.views.board_shape import board_points
from raxel.calibration.views.near_copies import once_each
from raxel.evaluation.pixel_pose import pixels_by_point
from raxel.geometry.poses import cross_matrix, transform

MIN_N_BOARDS = 6  # three in each half
WIDTH, RAYLEIGH = 6.0, 1.1774  # of wrong corners; median distance at unit scale
MIN_SD_PX = 0.01  # of a coordinate: no corner is known better
SINGULAR = 1e-9  # of the largest eigenvalue: undetermined


def scored_pairs(scores, views):
    """[(ImageScore, view), ...] of all views with a score, near copies once."""
    pairs = zip(scores, views, strict=True)
    return once_each([pair for pair in pairs if np.isfinite(pair[0].rms_px)])


def near_corners(pairs):
    """(K,) bool of each view: corners no farther off than WIDTH times their scatter."""
    distances = [np.linalg.norm(score.residuals_px, axis=1) for score, _ in pairs]
    typical = np.nanmedian(np.concatenate(distances)) / RAYLEIGH
    return [own <= WIDTH * max(typical, MIN_SD_PX) for own in distances]


def image_equations(camera, pairs, shape, corners, fields, moves=None):
    """(normal (n, K, K), right (n, K), variance) of images, for shared parameters.

    The parameters are factors of CorrectionFields and, after these, of displacements
    (N, 3, M) of the board's points, in its frame: moves. variance: of a coordinate
    about the joint solution; corners: (N,) bool of each view, those that count; shape:
    BoardShape or None.
    """
    squares, free = [], 0
    for (score, view), own in zip(pairs, corners, strict=True):
        off, solid = score.residuals_px[own], board_points(view.points[own], shape)
        pixels, T = view.pixels[own] - off, score.T_camera_grid
        along = np.broadcast_to(np.eye(3), (len(solid), 3, 3))
        shifts = [-cross_matrix(solid), along] + ([] if moves is None else [moves[own]])
        by_point = pixels_by_point(camera, pixels, transform(T, solid)) @ T[:3, :3]
        by_shift = by_point @ np.concatenate(shifts, axis=2)
        corrected = fields.terms(pixels, camera) @ fields.mixing
        rows = [corrected, by_shift[..., 6:], off[..., None]]
        rows = np.concatenate(rows, axis=2)
        rows = rows.reshape(off.size, rows.shape[2])
        of_pose, _ = np.linalg.qr(by_shift[..., :6].reshape(off.size, 6))
        rows = rows - of_pose @ (of_pose.T @ rows)
        squares.append(rows.T @ rows)
        free += max(off.size - 6, 0)
    squares = np.array(squares)
    whole = squares.sum(axis=0)
    root, _ = inverse_root(whole[:-1, :-1])
    left = whole[-1, -1] - np.sum((root.T @ whole[:-1, -1]) ** 2)
    variance = max(left / max(free - root.shape[1], 1), MIN_SD_PX**2)
    return squares[:, :-1, :-1], squares[:, :-1, -1], variance


def inverse_root(normal):
    """W of W W', the pseudo-inverse of a normal matrix, and its axes."""
    size, axes = np.linalg.eigh(normal)
    known = size > SINGULAR * size[-1]
    return axes[:, known] / np.sqrt(size[known]), axes[:, known]


def within_groups(normal, right, groups):
    """(variance, freedom): of scatter that explains how far images lie from the joint
    solution of their group, and the number of independent squares.

    normal (n, K, K), right (n, K): their equations; groups: (n,) bool each. As squares
    are larger in some directions than in others, each image has fewer than directions
    (F. E. Satterthwaite 1946, doi:10.2307/3002019).
    """
    expected, products = 0.0, 0.0
    for group in groups:
        root, axes = inverse_root(normal[group].sum(axis=0))
        share = root.T @ normal[group] @ root
        joint = root @ (root.T @ right[group].sum(axis=0))
        excess = (right[group] - normal[group] @ joint) @ root @ axes.T
        expected += np.einsum("nii->", share) - np.sum(share**2)
        products = products + excess.T @ excess
    squares = np.trace(products)
    several = squares**2 / np.sum(products**2)
    return squares / expected, (len(right) - len(groups)) * several
