"""Decoding errors of rendered images, measured and redrawn.

An error has two parts. The bias repeats with the sines: tone curves that do not cancel
shift the phase. The shift depends on the position in a period and on the brightness of
the monitor, which falls with the viewing angle. The rest is noise, correlated between
neighbours because the decoder averages a window. A few errors are much larger.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import binary_erosion, map_coordinates

from raxel.geometry import inverse_pose, rotate, transform

PHASES, ANGLES = (48, 8)  # cells of the bias, along a period and over the cosine
LAG = 3  # px, at which the correlation of neighbours is measured
OUTLYING = 5.0  # standard deviations
MIN_PIXELS = 200  # pixels of a cell of cosines
MARGIN_PX = 6  # the decoder's


class DecodingErrors(NamedTuple):
    """Errors of a decoder on one rig, for x and y of the monitor.

    period_mm: (2,); bias_mm: (2, PHASES, ANGLES), by the position in a period and the
    cosine of the viewing angle; sd_mm: (2, ANGLES), of the noise; correlation_px: (2,),
    the distance at which the correlation falls to 1/e; outlier_share: of the pixels
    with a noise over OUTLYING of these deviations; outliers_mm: (n, 2) such errors.
    stated: (2,), the decoder's own sigma over the deviation of the noise, rms.
    """

    period_mm: np.ndarray
    bias_mm: np.ndarray
    sd_mm: np.ndarray
    correlation_px: np.ndarray
    outlier_share: float
    outliers_mm: np.ndarray
    stated: np.ndarray

    @classmethod
    def read(cls, trials, prefix="", share="outlier_share"):
        """Return those that one trial of a result stored, under names with a prefix.

        trials: a `Selection`; share: the name of the number `outlier_share`.
        """
        arrays = {
            name: trials.arrays(prefix + name)[0]
            for name in cls._fields
            if name != "outlier_share"
        }
        return cls(**arrays, outlier_share=trials.column(prefix + share)[0])

    @classmethod
    def by_rig(cls, result):
        """Return {rig: DecodingErrors} of the result that measured several rigs."""
        return {
            rig: cls.read(trials, share="share_of_outliers")
            for rig, trials in result.by("rig").items()
        }

    def bias_at(self, points, cosine):
        """Return the bias (..., 2) mm at true points (..., 2) and cosines (...)."""
        phase = points / self.period_mm % 1 * PHASES - 0.5
        angle = np.clip(cosine * ANGLES - 0.5, 0, ANGLES - 1)
        return np.stack(
            [
                map_coordinates(
                    self.bias_mm[k][np.r_[-1:PHASES, 0]],
                    [phase[..., k] + 1, angle],
                    order=1,
                )
                for k in (0, 1)
            ],
            axis=-1,
        )

    def sd_at(self, cosine):
        """Return the standard deviation (..., 2) mm of the noise at cosines (...)."""
        middles = (np.arange(ANGLES) + 0.5) / ANGLES
        return np.stack([np.interp(cosine, middles, sd) for sd in self.sd_mm], -1)


def measured_errors(seen, periods=(8, 8), size_mm=(376.9, 301.5)):
    """Return the DecodingErrors of views, an iterable of (ScoredGrid, cosine (H, W)).

    periods: of the sines over the monitor of size_mm, by axis.
    """
    period = np.divide(size_mm, periods)
    shape = 2, PHASES * ANGLES
    kept, sums, counts = [], np.zeros(shape), np.zeros(shape)
    for grid, cosine in seen:
        here = grid.decoded.mask & np.isfinite(grid.points[..., 0])
        error = grid.decoded.location - grid.points
        cell = _cells(grid.points[here], cosine[here], period)
        # Outliers are no bias.
        usual = np.abs(error[here]) < period / 20
        for k in (0, 1):
            one, good = cell[:, k], usual[:, k]
            sums[k] += np.bincount(one[good], error[here][good, k], shape[1])
            counts[k] += np.bincount(one[good], minlength=shape[1])
        kept.append((error, here, cell, cosine, grid.decoded.sigma))
    bias = _filled((sums / np.maximum(counts, 1)).reshape(2, PHASES, ANGLES), counts)
    return _with_rest(kept, period, bias)


def _with_rest(kept, period, bias):
    """Return the DecodingErrors, with the statistics of the noise."""
    rest, near, stated, angles = [], [], [], []
    for error, here, cell, cosine, sigma in kept:
        left = np.full(error.shape, np.nan)
        left[here] = error[here] - np.take_along_axis(
            bias.reshape(2, -1).T, cell, axis=0
        )
        rest.append(left[here])
        angles.append(np.minimum(cosine[here] * ANGLES, ANGLES - 1).astype(int))
        stated.append(sigma[here] ** 2)
        near.append(_likeness(left))
    rest, angles, stated = (np.concatenate(x) for x in (rest, angles, stated))
    sd = np.array(
        [[_spread(rest[angles == a, k]) for a in range(ANGLES)] for k in (0, 1)]
    )
    sd = _filled_along(sd)
    far = (np.abs(rest) > OUTLYING * sd[:, angles].T).any(axis=1)
    likeness = np.clip(np.median(near, axis=0), 0.01, 0.99)
    return DecodingErrors(
        period,
        bias,
        sd,
        -LAG / np.log(likeness),
        float(far.mean()),
        rest[far],
        np.sqrt(stated[~far].mean(axis=0) / (rest[~far] ** 2).mean(axis=0)),
    )


def _cells(points, cosine, period):
    """Return the index (N, 2) of each axis's cell of the bias."""
    phase = (points / period % 1 * PHASES).astype(int) % PHASES
    angle = np.clip((cosine * ANGLES).astype(int), 0, ANGLES - 1)
    return phase * ANGLES + angle[:, None]


def _filled(bias, counts):
    """Return the bias; empty cells get the mean of their phase."""
    seen = counts.reshape(bias.shape) > 0
    usual = (bias * seen).sum(2) / np.maximum(seen.sum(2), 1)
    return np.where(seen, bias, usual[..., None])


def _filled_along(sd):
    """Return deviations (2, ANGLES); cells with few pixels are interpolated."""
    at = np.arange(ANGLES)
    return np.array([np.interp(at, at[s > 0], s[s > 0]) for s in sd])


def _spread(values):
    """Return the robust standard deviation, 0 for too few values."""
    return 1.4826 * np.median(np.abs(values)) if len(values) >= MIN_PIXELS else 0.0


def _likeness(left):
    """Return the correlation (2,) of noise (H, W, 2) with neighbours at LAG px.

    Outliers are clipped.
    """
    reach = OUTLYING * 1.4826 * np.nanmedian(np.abs(left), axis=(0, 1))
    both = []
    for one, other in ((left[LAG:], left[:-LAG]), (left[:, LAG:], left[:, :-LAG])):
        pair = np.isfinite(one[..., 0]) & np.isfinite(other[..., 0])
        a, b = (np.clip(x[pair], -reach, reach) for x in (one, other))
        both.append((a * b).mean(axis=0) / (a**2).mean(axis=0))
    return np.mean(both, axis=0)


def redrawn_lattice(errors, points, cosine, rng, step=1):
    """Return points (h, w, 2) of a lattice of pixels with redrawn decoding errors.

    points: true ones, mm, NaN where a pixel sees no monitor; cosine: (h, w); step: px
    between neighbours of the lattice; rng: numpy Generator. Points within the decoder's
    margin of such pixels are NaN.
    """
    inside = np.isfinite(points[..., 0])
    reach = -(-MARGIN_PX // step)
    seen = binary_erosion(inside, np.ones((2 * reach + 1,) * 2), border_value=1)
    out = np.where(seen[..., None], points, np.nan)
    noise = np.stack(
        [
            _alike(rng, points.shape[:2], np.exp(-step / length))
            for length in errors.correlation_px
        ],
        axis=-1,
    )
    out[seen] += errors.bias_at(points[seen], cosine[seen])
    out[seen] += noise[seen] * errors.sd_at(cosine[seen])
    far = seen & (rng.random(seen.shape) < errors.outlier_share)
    if len(errors.outliers_mm):
        out[far] += rng.choice(errors.outliers_mm, np.count_nonzero(far))
    return out


def _alike(rng, shape, likeness):
    """Return unit Gaussian noise (h, w) with this correlation of neighbours."""
    from scipy.signal import lfilter

    noise = rng.standard_normal(shape)
    fresh = np.sqrt(1 - likeness**2)
    for _ in range(2):
        noise[0] /= fresh  # the first row has no predecessor that adds to its variance
        noise = lfilter([fresh], [1, -likeness], noise, axis=0).T
    return noise


def lattice_rays(camera, step):
    """Return `Rays` of every step-th pixel in both directions, and the shape."""
    v, u = np.mgrid[step // 2 : camera.height : step, step // 2 : camera.width : step]
    return camera.rays(np.column_stack([u.ravel(), v.ravel()]).astype(float)), u.shape


def true_lattice(rays, shape, T_camera_grid, size_mm):
    """Return points (h, w, 2) mm of a monitor that rays see, and cosines (h, w).

    NaN off the monitor, whose z axis points away from its visible side.
    """
    origins = transform(inverse_pose(T_camera_grid), rays.origins)
    directions = rotate(inverse_pose(T_camera_grid), rays.directions)
    cosine = directions[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        way = -origins[:, 2] / cosine
        points = origins[:, :2] + way[:, None] * directions[:, :2]
        seen = rays.valid & (way > 0) & (cosine > 0)
        seen &= np.all((points >= 0) & (points <= size_mm), axis=1)
    points[~seen] = np.nan
    return points.reshape(*shape, 2), cosine.reshape(shape)


def drawn_lattices(rays, shape, poses, size_mm, step, rng, errors=None):
    """Return (true, decoded) points (n, h, w, 2) of monitors at poses (n, 4, 4).

    rays, shape: of every step-th pixel (`lattice_rays`); errors: DecodingErrors to
    redraw, or None to decode the true points.
    """
    true, decoded = [], []
    for T in poses:
        points, cosine = true_lattice(rays, shape, T, size_mm)
        true.append(points)
        if errors is not None:
            points = redrawn_lattice(errors, points, cosine, rng, step)
        decoded.append(points)
    return np.stack(true), np.stack(decoded)
