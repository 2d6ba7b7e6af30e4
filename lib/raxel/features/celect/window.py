"""The circular window that moves along a contour: its edges and its corners.

Gradients are taken after Gaussian smoothing, on a patch wide enough that nothing of
them depends on where the window ends. The scale of the gradients (what is an edge,
what is a corner) comes from the four windows that the user clicked.
"""

import math
from typing import NamedTuple

import cv2
import numpy as np

MARGIN_IN_SD = 3.0
"""How far a Gaussian reaches, in its standard deviations."""

FULL_SCALE = 4000.0
"""Value of the reference gradient in the whole numbers that Canny's method takes."""


class Smoothing(NamedTuple):
    """Standard deviations in px: of the grey values, and of the tensor of a corner."""

    grey: float
    tensor: float


class Scale(NamedTuple):
    """What a clear edge and a clear corner are in this image, smoothed like this.

    `gradient`: grey levels per pixel. `response`: of the corner detector.
    """

    smoothing: Smoothing
    gradient: float
    response: float


class Window(NamedTuple):
    """A circle of the image with the gradients of the square patch around it.

    `centre` (2,) pixels (u, v); `radius` px; `first` (2,) pixel (u, v) of the patch's
    first element; `gradient_u`, `gradient_v` (h, w) float32, grey levels per pixel.
    """

    centre: np.ndarray
    radius: float
    first: np.ndarray
    gradient_u: np.ndarray
    gradient_v: np.ndarray

    def within(self, mask):
        """Pixels (n, 2) inside the circle where the mask (h, w) uint8 is set."""
        from raxel.features.celect.compiled import set_within

        return set_within(mask, self.first, self.centre, float(self.radius))


def smoothing_for(s, settings):
    """The Smoothing of an image whose smallest contour scale is `s` px."""
    grey = float(np.clip(settings.smoothing * s, *settings.smoothing_limits_px))
    return Smoothing(grey, settings.integration * grey)


def open_window(image, centre, radius, smoothing):
    """The Window of an image (height, width) around a centre (2,).

    The image's own border repeats its outermost pixels, and no pixel beyond it is ever
    an edge or a corner.
    """
    centre = np.asarray(centre, float)
    reach = radius + margin(smoothing)
    low = np.floor(centre - reach).astype(int)
    high = np.ceil(centre + reach).astype(int) + 1
    return Window(centre, radius, *gradients(image, low, high, smoothing))


def margin(smoothing):
    """How many px around a pixel decide whether it is an edge or a corner."""
    return math.ceil(MARGIN_IN_SD * (smoothing.grey + smoothing.tensor)) + 2


def gradients(image, low, high, smoothing):
    """First pixel (2,), and gradients (h, w) along u and v, of part of an image.

    `low`, `high` (2,): first pixel (u, v) and the one after the last; what lies beyond
    the image is left out.
    """
    height, width = image.shape
    left, top = np.maximum(low, 0)
    right, bottom = min(high[0], width), min(high[1], height)
    patch = image[top:bottom, left:right].astype(np.float32)
    smooth = blurred(patch, smoothing.grey)
    across, down = (
        cv2.Sobel(
            smooth,
            cv2.CV_32F,
            *order,
            ksize=1,
            scale=0.5,
            borderType=cv2.BORDER_REPLICATE,
        )
        for order in ((1, 0), (0, 1))
    )
    return np.array([left, top], np.int32), across, down


def blurred(image, sd):
    """A Gaussian blur that ends at MARGIN_IN_SD; the border's pixels are repeated."""
    size = 2 * math.ceil(MARGIN_IN_SD * sd) + 1
    return cv2.GaussianBlur(image, (size, size), sd, borderType=cv2.BORDER_REPLICATE)


def canny_edges(window, scale, high, low):
    """Edge pixels (n, 2) of a window by Canny's method, S_c (3.8).

    `high` and `low` are the two thresholds, as shares of the image's clear gradient.
    """
    factor = FULL_SCALE / scale.gradient
    across, down = (
        cv2.multiply(g, 1.0, scale=factor, dtype=cv2.CV_16S)
        for g in (window.gradient_u, window.gradient_v)
    )
    edges = cv2.Canny(
        across, down, low * FULL_SCALE, high * FULL_SCALE, L2gradient=True
    )
    return window.within(edges)


def harris_response(window, tensor_px, k):
    """Harris's R = det M - k trace(M)^2 over the patch of a window, (h, w)."""
    from raxel.features.celect.compiled import response_of, structure_tensor

    tensor = structure_tensor(window.gradient_u, window.gradient_v)
    return response_of(blurred(tensor, tensor_px), np.float32(k))


def harris_corners(window, scale, settings):
    """Corner pixels (n, 2) of a window: local maxima of Harris's response.

    A maximum counts from `harris_share` of the image's clear response on.
    """
    response = harris_response(window, scale.smoothing.tensor, settings.harris_k)
    least = max(settings.harris_share * scale.response, np.finfo(np.float32).tiny)
    peaks = (response >= cv2.dilate(response, None)) & (response >= least)
    return window.within(peaks.view(np.uint8))


def clear_scale(windows, smoothing, settings):
    """The Scale of an image from the windows around its clicked corners.

    Of each window the largest gradient and response count, of the windows the median:
    one window with glare or clutter does not matter. Both are 0 in a flat image.
    """
    gradients, responses = [], []
    for window in windows:
        steep = np.hypot(window.gradient_u, window.gradient_v)
        response = harris_response(window, smoothing.tensor, settings.harris_k)
        inside = window.within(np.ones(steep.shape, np.uint8)) - window.first
        u, v = inside.T
        gradients.append(steep[v, u].max(initial=0.0))
        responses.append(response[v, u].max(initial=0.0))
    return Scale(smoothing, float(np.median(gradients)), float(np.median(responses)))
