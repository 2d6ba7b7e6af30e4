"""Calibration: from points seen on planar targets to cameras and poses."""

from raxel.calibration.bilinear import (
    bilinear_products,
    coefficient_vectors,
    solve_coefficients,
    table_2_1,
)
from raxel.calibration.bundle import (
    BundleResult,
    bundle_adjust_fixed_centre,
    ray_directions,
    ray_point_residuals,
)
from raxel.calibration.generic_linear import (
    LinearSolution,
    linear_as_printed,
    linear_well_conditioned,
)

__all__ = [
    "BundleResult",
    "LinearSolution",
    "bilinear_products",
    "bundle_adjust_fixed_centre",
    "coefficient_vectors",
    "linear_as_printed",
    "linear_well_conditioned",
    "ray_directions",
    "ray_point_residuals",
    "solve_coefficients",
    "table_2_1",
]
