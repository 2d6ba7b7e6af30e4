"""Corners by Harris's response at several scales and a measure of symmetry (6.3.1).

A corner of a chessboard looks the same when it is turned by half a turn about itself:
its gradient at +d is minus that at -d. The two corners into which blur splits it do
not, and neither do edges and noise. The middle of a small square does, but it is a peak
of brightness or darkness, and a corner is a saddle.
"""

import math

import cv2
import numpy as np

from raxel.features.celect.window import harris_response

LEVELS = (1.0, 2.0)
"""Scales, as factors of the image's own smoothing; the finest first."""

LEAST_SYMMETRY = 0.5
"""Symmetry from which on a maximum is a corner; 1 is complete, an edge has -1."""

SUPPORT_SD = 2.0
"""SD of the weights of the symmetry, in SDs of the smoothing of that scale."""

SUPPORT_REACH = 2.0
"""Where these weights end, in their SDs."""


def symmetric_corners(window, scale, settings):
    """Corners (n, 2) px of a window: symmetric maxima, each at its finest scale.

    Takes the place of `window.harris_corners`. At every scale Harris's response,
    normalised (K. Mikolajczyk and C. Schmid, 2004,
    doi:10.1023/B:VISI.0000027790.02288.f2), is weighted with the symmetry, where the
    brightness has a saddle. A maximum of a coarser scale counts where no finer one lies
    within two SDs of its tensor's window. Nothing so close to the end of the patch that
    its symmetry is not known is a corner.
    """
    pixels = np.empty((0, 2))
    for level in LEVELS:
        found, strength = _at_level(window, scale, settings, level)
        reach = 2 * level * scale.smoothing.tensor
        found = strongest_apart(found, strength, reach)
        off = np.linalg.norm(found[:, None] - pixels[None], axis=2)
        pixels = np.vstack((pixels, found[(off > reach).all(axis=1)]))
    return pixels


def _at_level(window, scale, settings, level):
    """Corners (n, 2) px of a level and their strength (n,)."""
    grey, tensor = (level * sd for sd in scale.smoothing)
    step = int(level)
    coarse = coarser(window, scale.smoothing.grey * math.sqrt(level**2 - 1), step)
    response = level**4 * harris_response(coarse, tensor / step, settings.harris_k)
    least = max(settings.harris_share * scale.response, np.finfo(np.float32).tiny)
    places = np.argwhere((response >= least) & saddles(coarse))[:, ::-1]
    symmetry = symmetry_at(coarse, places, SUPPORT_SD * grey / step)
    places, symmetry = (x[symmetry >= LEAST_SYMMETRY] for x in (places, symmetry))
    columns, rows = places.T
    strength = np.zeros_like(response)
    strength[rows, columns] = response[rows, columns] * symmetry
    places = places[(strength >= cv2.dilate(strength, None))[rows, columns]]
    pixels = window.first + step * (places + peak_offsets(strength, places))
    inside = np.linalg.norm(pixels - window.centre, axis=1) <= window.radius
    columns, rows = places[inside].T
    return pixels[inside], strength[rows, columns]


def peak_offsets(strength, places):
    """Offsets (n, 2) of a map's (h, w) maxima from their elements (n, 2).

    Of a parabola through a maximum and its neighbours, along either axis; at most half
    an element. The elements are not on the map's rim.
    """
    offsets = np.zeros(places.shape)
    for axis, (row, column) in enumerate(((0, 1), (1, 0))):
        u, v = places.T
        before, here, after = (
            strength[v + k * row, u + k * column].astype(float) for k in (-1, 0, 1)
        )
        bend = before - 2 * here + after
        np.divide(before - after, 2 * bend, out=offsets[:, axis], where=bend < 0)
    return np.clip(offsets, -0.5, 0.5)


def saddles(window):
    """Where the brightness of a window has a saddle, (h, w): Hessian's det below 0."""
    across, down = window.gradient_u, window.gradient_v
    uv = (np.gradient(across, axis=0) + np.gradient(down, axis=1)) / 2
    return np.gradient(across, axis=1) * np.gradient(down, axis=0) < uv**2


def coarser(window, extra_px, step):
    """The Window with gradients smoothed by another `extra_px`, every `step`th pixel.

    Its elements are `step` px apart, the first where it was.
    """
    fields = window.gradient_u, window.gradient_v
    if extra_px:
        fields = (
            cv2.GaussianBlur(g, (0, 0), extra_px, borderType=cv2.BORDER_REPLICATE)
            for g in fields
        )
    across, down = (np.ascontiguousarray(g[::step, ::step]) for g in fields)
    return window._replace(gradient_u=across, gradient_v=down)


def symmetry_at(window, places, support):
    """Symmetry (n,) of a window's gradients g about its elements (n, 2), (column, row).

    -sum w(d) g(d).g(-d) / sum w(d) |g(d)|^2, with Gaussian weights of SD `support`, in
    elements: 1 for a picture that half a turn leaves as it is, -1 for an edge. -inf
    where the weights reach beyond the patch, or nothing has a gradient.
    """
    reach = max(1, math.ceil(SUPPORT_REACH * support))
    offsets = np.arange(-reach, reach + 1)
    weights = np.exp(-0.5 * (offsets / support) ** 2)
    weights = np.outer(weights, weights).ravel().astype(np.float32)
    height, width = window.gradient_u.shape
    known = ((places >= reach) & (places < (width - reach, height - reach))).all(axis=1)
    symmetry = np.full(len(places), -np.inf)
    if not known.any():
        return symmetry
    step = (offsets[:, None] * width + offsets).ravel()
    flat = (places[known] @ (1, width))[:, None] + step
    turned = energy = 0.0
    for gradient in (window.gradient_u, window.gradient_v):
        values = gradient.ravel()[flat]
        turned = turned - (values * values[:, ::-1]) @ weights
        energy = energy + values**2 @ weights
    some = energy > 0
    symmetry[np.flatnonzero(known)[some]] = turned[some] / energy[some]
    return symmetry


def strongest_apart(pixels, strength, reach):
    """Those of pixels (n, 2) that have no stronger one of these within `reach` px."""
    left = np.argsort(-strength, kind="stable")
    kept = []
    while len(left):
        kept.append(left[0])
        off = np.linalg.norm(pixels[left] - pixels[left[0]], axis=1)
        left = left[off > reach]
    return pixels[kept]
