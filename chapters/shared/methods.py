"""The methods that chapter 2 compares, and how they are scored."""

from __future__ import annotations

METHODS = ("parametric", "generic_as_printed", "generic_well_conditioned")
# The linear stage that a generic method begins with.
LINEAR = {
    "generic_as_printed": "as printed",
    "generic_well_conditioned": "well conditioned",
}
NAMES = {
    "parametric": "standard perspective",
    "generic_as_printed": "central generic, as printed",
    "generic_well_conditioned": "central generic, well conditioned",
    "opencv_fisheye": "OpenCV fisheye",
    "exact": "exact rays",
}
# Scored on fresh noise of the same size, on the noise calibrated with, or
# without noise; in px of the corrected view, or of the source image.
SCORINGS = ("fresh", "noisy", "clean")
SCALES = ("corrected", "source")
