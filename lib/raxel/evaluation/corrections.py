"""Corrections of a camera: fields over the image by which its pixels may be off.

They are all polynomials of third degree in the pixel's place, along u and along v, less
what a common rotation of all rays does, since that is no error of a camera.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from raxel.evaluation.pixel_pose import pixels_by_point
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import cross_matrix, transform

DEGREE = 3
ACROSS = 24  # pixels along the longer side at which fields are compared


def polynomials(pixels, camera):
    """(N, 2, P): each polynomial along u, then each along v."""
    size = np.array([camera.width, camera.height])
    x, y = ((2 * pixels - (size - 1)) / size.max()).T
    along = np.stack(
        [x**a * y**b for a in range(DEGREE + 1) for b in range(DEGREE + 1 - a)], axis=1
    )
    none = np.zeros_like(along)
    return np.stack(
        [np.hstack([along, none]), np.hstack([none, along])], axis=1
    )  # fmt: skip


class CorrectionFields(NamedTuple):
    """pixels (N, 2) that have a ray; shapes (N, 2, K): corrections of 1 px RMS each,
    without rotations; turns (N, 2, 3): what rotations do; mixing (P, K): the shapes'
    `terms`."""

    pixels: np.ndarray
    shapes: np.ndarray
    turns: np.ndarray
    mixing: np.ndarray
    terms: Callable = polynomials


def with_radial_terms(pixels, camera):
    """(N, 2, P + 2): these, and radial fields of fifth and of seventh degree, by which
    a lens departs from a formula that has fewer terms."""
    size = np.array([camera.width, camera.height])
    places = (2 * pixels - (size - 1)) / size.max()
    squares = np.sum(places**2, axis=1, keepdims=True)
    radial = np.stack([places * squares**2, places * squares**3], axis=2)
    return np.concatenate([polynomials(pixels, camera), radial], axis=2)


def correction_fields(camera, pairs, terms=polynomials):
    """The CorrectionFields of a camera, mixed of `terms`, None where hardly a pixel has
    a ray."""
    step = max(camera.width, camera.height) / ACROSS
    u = np.arange(step / 2, camera.width, step)
    v = np.arange(step / 2, camera.height, step)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2) - 0.5
    middles = [
        transform(score.T_camera_grid, on_plane(view.points)).mean(axis=0)
        for score, view in pairs
    ]
    rays = camera.rays(pixels)
    points = rays.origins + np.median(np.linalg.norm(middles, axis=1)) * rays.directions
    turns = pixels_by_point(camera, pixels, points) @ -cross_matrix(points)
    known = rays.valid & np.isfinite(turns).all(axis=(1, 2)) & turns.any(axis=(1, 2))
    pixels, turns = pixels[known], turns[known]
    powers = terms(pixels, camera)
    count = powers.shape[2]
    if len(pixels) < count:
        return None
    rest = without_turns(turns, powers).reshape(-1, count)
    size, axes = np.linalg.eigh(rest.T @ rest)
    # Three of the polynomials are nearly what the rotations do.
    mixing = axes[:, 3:] * np.sqrt(len(pixels) / size[3:])
    shapes = rest @ mixing
    shapes = shapes.reshape(len(pixels), 2, -1)
    return CorrectionFields(pixels, shapes, turns, mixing, terms)


def without_turns(turns, fields):
    """Fields (N, 2, K) less what of them is a rotation, turns (N, 2, 3)."""
    flat, basis = fields.reshape(-1, fields.shape[2]), turns.reshape(-1, 3)
    share = np.linalg.solve(basis.T @ basis, basis.T @ flat)
    return (flat - basis @ share).reshape(fields.shape)


def rms_moved(fields, seen, change):
    """RMS px by which a correction (K,) moves the rays of pixels, seen (N,) bool, after
    the best rotation."""
    moved = without_turns(fields.turns[seen], fields.shapes[seen]) @ change
    return float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))


def seen_on(view, camera, pixels):
    """Which of the pixels (N, 2) lie on a view's board: (N,) bool."""
    u, v = np.rint(pixels).astype(int).T
    return view.covered(camera.width, camera.height)[v, u] > 0
