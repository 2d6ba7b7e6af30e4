"""Test of tilt: do the boards determine the focal length of a camera, whatever model?

A stretch of space along the common normal of parallel boards shifts each of them along
its normal, and changes none. A camera whose rays are stretched alike, tan theta' = k
tan theta about that normal, then has the same residuals. So parallel boards leave the
focal length undetermined, and a fit that nevertheless returns one owes it to the
stiffness of its formula. Tilted boards determine what is left of the information on
log k if the poses, all other linear maps of the rays (principal point, aspect ratio and
skew) and a smooth radial correction are free. It is independent of the model and grows
with the square of the tilts t, since a board is foreshortened by t^2 / 2.

Source: P. F. Sturm and S. J. Maybank 1999, doi:10.1109/CVPR.1999.786974.
"""

from functools import partial

import numpy as np

from raxel.errors import CalibrationError
from raxel.evaluation.diagnoses import diagnosis
from raxel.evaluation.distortion import (
    MIN_SD_PX,
    image_equations,
    near_corners,
    pixels_by_point,
    scored_pairs,
)
from raxel.evaluation.misfit import CorrectionFields

# SD of log k above which the boards may be parallel: as their foreshortening is
# proportional to k^2, it is then less than three of its standard deviations.
MAX_SD = 1 / 6
WARN_SD = 0.01  # sets of boards tilted by 20 to 45 degrees have 0.01 to 0.3 %
RADIAL_POWERS = 3, 5, 7  # of the angle: the terms that follow the focal length
# Prior SDs of log k, shears, aspect ratio and radial terms, to bound undetermined ones;
# and of the skew: pixels have none, and without a second tilt boards do not measure it.
PRIOR_SD = np.array([1.0] * (4 + len(RADIAL_POWERS)) + [0.001])


def focal_length_sd(camera, scores, views, shape, scatter_px):
    """Relative standard deviation of the focal length by the tilts of the boards alone;
    about 1 where these determine nothing.

    scores: ImageScores of the views; shape: BoardShape or None; scatter_px: RMS
    distance by which single corners scatter.
    """
    pairs = scored_pairs(scores, views)
    corners = near_corners(pairs)
    pixels = [view.pixels[own] for (_, view), own in zip(pairs, corners, strict=True)]
    terms = partial(_corrections, *_frame(camera, np.concatenate(pixels)))
    fields = CorrectionFields(*[np.empty(0)] * 3, np.diag(PRIOR_SD), terms)
    normal, _, _ = image_equations(camera, pairs, shape, corners, fields)
    variance = np.fmax(scatter_px**2 / 2, MIN_SD_PX**2)
    information = normal.sum(axis=0) / variance + np.eye(len(PRIOR_SD))
    return float(np.sqrt(np.linalg.inv(information)[0, 0]))


def focal_length_warnings(sd, words):
    """Yield the warning of a focal length with a relative standard deviation sd.

    Raises CalibrationError (code ``focal-undetermined``) where it is undetermined.
    """
    if sd > WARN_SD:
        found = diagnosis("focal-undetermined", words, sd_percent=min(100 * sd, 99.0))
        if sd > MAX_SD:
            raise CalibrationError(found, code=found.code)
        yield found


def _frame(camera, pixels):
    """Axes (3, 3): the ray in the middle of the image, or of all pixels (N, 2), and the
    directions across it along u and v; the largest angle of pixels to the first."""
    middle = (np.array([[camera.width, camera.height]]) - 1) / 2
    rays = camera.rays(np.concatenate([middle, pixels]))
    d = rays.directions[rays.valid]
    axis = d[0] if rays.valid[0] else d.mean(axis=0)
    u = np.concatenate([middle, pixels])[rays.valid, 0]
    e = np.cross(axis, np.cross((u - u.mean()) @ d, axis))
    frame = np.stack([axis, e, np.cross(axis, e)])
    frame /= np.linalg.norm(frame, axis=1, keepdims=True)
    return frame, np.arccos(np.min(d @ frame[0]))


def _corrections(frame, widest, pixels, camera):
    """(N, 2, 8): effects in the image of log k; of shears along the axis, which shift
    the principal point; of the aspect ratio; of radial terms; and of skew."""
    rays = camera.rays(pixels)
    (axis, e, f), (z, x, y) = frame, (rays.directions @ frame.T).T[..., None]
    sine = np.hypot(x, y)
    outward = z * (x * e + y * f) / np.maximum(sine, 1e-12) - sine * axis
    theta = np.arctan2(sine, z) / widest
    changes = [
        -z * axis,
        z * e + x * axis,
        z * f + y * axis,
        x * e - y * f,
        *(outward * theta**power for power in RADIAL_POWERS),
        x * f + y * e,
    ]
    by_point = pixels_by_point(camera, pixels, rays.origins + rays.directions)
    return by_point @ np.nan_to_num(np.stack(changes, axis=2))
