"""Evaluation: how far a calibrated camera is from what it should be, with intervals."""

from raxel.evaluation.cross_validation import (
    Evaluation,
    ImageScore,
    cross_validate,
    evaluate_camera,
)
from raxel.evaluation.distortion import (
    SyntheticPlane,
    angular_residual,
    corrected_view,
    distortion_residual,
    synthetic_plane,
)

__all__ = [
    "Evaluation",
    "ImageScore",
    "SyntheticPlane",
    "angular_residual",
    "corrected_view",
    "cross_validate",
    "distortion_residual",
    "evaluate_camera",
    "synthetic_plane",
]
