"""CELECT: chessboard corners in order from four clicks, however bent the image.

`celect` is the algorithm of section 3.1.2, `CelectSettings` its values.
"""

from raxel.features.celect.algorithm import (
    OUTER_CORNER,
    TOO_FEW,
    TOO_MANY,
    TRACING,
    CelectResult,
    CelectSettings,
    ContourFailure,
    ContourTrace,
    along_contour,
    celect,
)

__all__ = [
    "OUTER_CORNER",
    "TOO_FEW",
    "TOO_MANY",
    "TRACING",
    "CelectResult",
    "CelectSettings",
    "ContourFailure",
    "ContourTrace",
    "along_contour",
    "celect",
]
