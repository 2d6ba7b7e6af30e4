"""A monitor seen in a flat mirror, without pixels that were decoded wrongly.

At the rim of a mirror, and in the dark beside it, a pixel now and then decodes to a
point that it does not see. In a flat mirror the picture of a flat monitor is a
homography (undistorted), which few wrong pixels do not hide. How far the others lie
from it says how exactly they were decoded, with what a decoder cannot know of.
"""

import numpy as np

from raxel.calibration.mirror.matches import wrong_matches
from raxel.calibration.mirror.sightings import magnification, normalised
from raxel.errors import CalibrationError
from raxel.geometry.homography import apply_homography, homography_dlt

# Pixels beyond this many medians, or px where the median is less, are wrong.
FAR, LEAST_PX, ROUNDS = 6.0, 0.5, 10
# More than this share is not left out in silence.
MOST_WRONG = 0.25


def flat_view(viewer, view):
    """The view, a BoardView or DenseView, with pixels NaN whose points do not fit, and
    for all others the standard deviation (px) that the picture shows.

    viewer: calibrated central camera. Raises CalibrationError where more than a quarter
    would be left out.
    """
    pixels = np.asarray(view.pixels, float)
    image = normalised(viewer, pixels)
    seen = np.isfinite(image).all(axis=1)
    scale = np.full(len(pixels), np.nan)
    scale[seen] = magnification(viewer, pixels[seen])
    right = seen & ~wrong_matches(view.points, pixels)
    for _ in range(ROUNDS):
        H = homography_dlt(view.points[right], image[right])
        off = scale * np.linalg.norm(apply_homography(H, view.points) - image, axis=1)
        fits = off <= max(FAR * np.median(off[right]), LEAST_PX)
        if np.array_equal(fits, right):
            break
        right = fits
    left, whole = np.count_nonzero(seen & ~right), np.count_nonzero(seen)
    if left > MOST_WRONG * whole:
        raise CalibrationError(
            f"{view.name}: {left} of {whole} pixels do not see a flat monitor in a "
            "flat mirror; photograph its patterns anew, with nothing moved",
            code="not-flat",
        )
    # Two components, and the median of their length.
    sd = np.median(off[right]) / np.sqrt(2 * np.log(2))
    return view._replace(
        pixels=np.where(right[:, None], pixels, np.nan), sd=np.full(len(pixels), sd)
    )
