"""Test of tilt: do the boards determine the focal length of a camera, whatever model?

A stretch of space along the common normal of parallel boards shifts each of them along
its normal, and changes none. A camera whose rays are stretched alike, tan theta' = k
tan theta about that normal, then has the same residuals. So parallel boards leave the
focal length undetermined, and a fit that nevertheless returns one owes it to the
stiffness of its formula. Tilted boards determine what is left of the information on
log k if the poses, principal point, aspect ratio and a smooth radial correction are
free. It is independent of the model and grows with the fourth power of the tilts t,
since a board is foreshortened by t^2 / 2.

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
# Sets with ten boards tilted by 20 to 45 degrees have 0.01 to 0.7 %.
WARN_SD = 0.01
RADIAL_POWERS = 3, 5, 7  # of the angle: the terms that follow the focal length
# Prior SDs. Those of log k, aspect ratio, radial terms and principal point (in widths
# of the image) bound what is undetermined. Pixels have no skew. Decentring moves the
# principal point from the centre of distortion by a few tenths of a degree.
PRIOR_SD = np.array([1.0] * (4 + len(RADIAL_POWERS)) + [1e-4, 0.003, 0.003])


def focal_length_sd(camera, scores, views, shape, scatter_px):
    """Relative standard deviation of the focal length by the tilts of the boards alone;
    about 1 where these determine nothing, NaN without any pose.

    scores: ImageScores of the views; shape: BoardShape or None; scatter_px: RMS
    distance by which single corners scatter.
    """
    pairs = scored_pairs(scores, views)
    if not pairs:
        return np.nan
    corners = near_corners(pairs)
    pixels = [view.pixels[own] for (_, view), own in zip(pairs, corners, strict=True)]
    terms = partial(_corrections, *_frame(camera, np.concatenate(pixels)))
    fields = CorrectionFields(*[np.empty(0)] * 3, np.diag(PRIOR_SD), terms)
    normal, _, variance, _ = image_equations(camera, pairs, shape, corners, fields)
    # Both contain more than the noise: a misfit the one, wrong corners the other.
    variance = max(np.fmin(variance, scatter_px**2 / 2), MIN_SD_PX**2)
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
    """Axes (3, 3): that of the camera, of a table the mean of the rays of pixels (N,
    2), and the directions across it along u and v; largest angle of rays to the
    first."""
    rays = camera.rays(pixels)
    d, places = rays.directions[rays.valid], pixels[rays.valid]
    axis = d.mean(axis=0) if camera.kind == "general" else np.array([0, 0, 1.0])
    along_u = np.linalg.lstsq(np.column_stack([places, np.ones(len(d))]), d)[0][0]
    e = np.cross(axis, np.cross(along_u, axis))
    frame = np.stack([axis, e, np.cross(axis, e)])
    frame /= np.linalg.norm(frame, axis=1, keepdims=True)
    return frame, np.arccos(np.min(d @ frame[0]))


def _corrections(frame, widest, pixels, camera):
    """(N, 2, 10): effects in the image of log k, aspect ratio, radial terms, principal
    point, skew and decentring."""
    rays = camera.rays(pixels)
    (axis, e, f), (z, x, y) = frame, (rays.directions @ frame.T).T[..., None]
    sine = np.hypot(x, y)
    outward = z * (x * e + y * f) / np.maximum(sine, 1e-12) - sine * axis
    theta = np.arctan2(sine, z) / widest
    changes = [
        -z * axis,
        x * e - y * f,
        *(outward * theta**power for power in RADIAL_POWERS),
        x * f + y * e,
        z * e + x * axis,
        z * f + y * axis,
    ]
    by_point = pixels_by_point(camera, pixels, rays.origins + rays.directions)
    corrections = by_point @ np.nan_to_num(np.stack(changes, axis=2))
    centre = np.broadcast_to(camera.width * np.eye(2), (len(pixels), 2, 2))
    return np.concatenate(
        [corrections[..., :-3], centre, corrections[..., -3:]], axis=2
    )
