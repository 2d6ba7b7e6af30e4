"""Windows about corners: gathering, interpolation, and the noise in them."""

import numpy as np


def fits(shape, corners, reach):
    """Which corners (N,) have `reach` px of image on all sides, and are finite."""
    height, width = shape
    with np.errstate(invalid="ignore"):
        inside = (corners >= reach) & (corners <= np.array([width, height]) - 1 - reach)
    return inside.all(axis=1)


def gather(image, first, size):
    """Square windows (N, size, size) of `image` from their first pixels (N, 2)."""
    views = np.lib.stride_tricks.sliding_window_view(image, (size, size))
    return views[first[:, 1], first[:, 0]]


def cubic_taps(fraction):
    """Weights (N, 4) of cubic convolution at pixels -1, 0, 1, 2, for `fraction` (N,).

    Keys (1981), doi 10.1109/TASSP.1981.1163711: exact for quadratics.
    """
    t = fraction[:, None] + np.array([1.0, 0.0, -1.0, -2.0])
    d = np.abs(t)
    near = (1.5 * d - 2.5) * d**2 + 1
    far = ((-0.5 * d + 2.5) * d - 4) * d + 2
    return np.where(d <= 1, near, far)


def spread(weights, taps):
    """Weights on samples (rows, n) as weights on pixels (N, rows, n + taps - 1).

    A sample between pixels is a sum of pixels with `taps` (N, taps); its weight goes
    to them in that proportion.
    """
    rows, n = weights.shape
    out = np.zeros((len(taps), rows, n + taps.shape[1] - 1))
    for k in range(taps.shape[1]):
        out[:, :, k : k + n] += taps[:, k, None, None] * weights
    return out


def noise_variance(image, corners, weights):
    """Variance (N,) of the pixel noise about each corner, in squared grey levels.

    A chessboard corner looks the same after half a turn about itself, I(c + d) =
    I(c - d). So the noise shows in the difference of a window and its half turn, and
    nothing else does: neither the picture nor what a model cannot follow of it. The
    half turn is about the multiple of half a pixel next to the corner, where pixels
    fall on pixels; the first order of that shift is taken out.

    image: (H, W) float. corners: (N, 2), `reach` px inside it. weights: (N, m, m) of
    the pixels about the nearest whole pixel, m odd, `reach` = m / 2 + 3; those that
    matter for what the variance is wanted for.
    """
    half = weights.shape[1] // 2
    centre = np.rint(2 * corners) / 2
    pixel = np.floor(centre).astype(int)
    opposite = np.rint(2 * centre).astype(int) - pixel
    size = 2 * half + 5
    here = gather(image, pixel - half - 2, size)
    turned = gather(image, opposite - half - 2, size)[:, ::-1, ::-1]
    even = (here + turned) / 2
    slope_u = _slope(even[:, 2:-2])
    slope_v = _slope(even[:, :, 2:-2].transpose(0, 2, 1)).transpose(0, 2, 1)
    shift = 2 * (corners - centre)[:, :, None, None]
    odd = (here - turned)[:, 2:-2, 2:-2] + shift[:, 0] * slope_u + shift[:, 1] * slope_v
    total = weights.sum(axis=(1, 2))
    # Every pair is counted twice. The corner itself has taken two degrees of freedom.
    with np.errstate(invalid="ignore", divide="ignore"):
        pairs = total**2 / (weights**2).sum(axis=(1, 2)) / 2
        mean = (weights * odd**2).sum(axis=(1, 2)) / (2 * total)
    return mean * pairs / np.maximum(pairs - 2, 1)


def _slope(values):
    """Derivative along the last axis, of fourth order; two samples lost at each end."""
    near = values[..., 3:-1] - values[..., 1:-3]
    far = values[..., 4:] - values[..., :-4]
    return (8 * near - far) / 12
