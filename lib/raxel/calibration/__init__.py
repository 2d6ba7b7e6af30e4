"""Calibration: from points seen on planar targets to cameras and poses."""

from raxel.calibration.adjust.bundle import (
    BundleResult,
    bundle_adjust_fixed_centre,
    ray_directions,
    ray_point_distances,
    ray_point_residuals,
)
from raxel.calibration.adjust.consistent import (
    ConsistentResult,
    adjust_consistent,
    centroid_directions,
    centroid_weights,
    relax_poses,
)
from raxel.calibration.adjust.free_lines import (
    FreeCentreResult,
    FreeLines,
    adjust_concurrence,
    adjust_ray_point,
    relax_centrality,
)
from raxel.calibration.generic.board_growth import GenericCalibration
from raxel.calibration.generic.central_test import CentralTest, centrality_test
from raxel.calibration.generic.cgsp import (
    CentralCalibration,
    calibrate_central,
    calibrate_cgsp,
    relaxed_start,
)
from raxel.calibration.generic.known_motion import (
    KnownMotionRays,
    rays_from_known_motion,
)
from raxel.calibration.generic.standard import calibrate_generic
from raxel.calibration.linear.cgsp import CgspSolution, linear_cgsp
from raxel.calibration.linear.standard import (
    LinearSolution,
    bilinear_products,
    coefficient_vectors,
    linear_as_printed,
    linear_well_conditioned,
    solve_coefficients,
    table_2_1,
)
from raxel.calibration.mirror.bundle import StageBundle, StageView, bundle_stages
from raxel.calibration.mirror.clamp import (
    Clamp,
    ClampLine,
    FixedLine,
    clamp_line,
    clamp_of_camera,
    edge_picks,
    fixed_line,
)
from raxel.calibration.mirror.platter import (
    GridMotion,
    PlatterPicture,
    PlatterPoses,
    grid_poses_in_platter,
)
from raxel.calibration.mirror.primary import (
    PrimaryCalibration,
    calibrate_primary,
    primary_from_points,
)
from raxel.calibration.mirror.track import FilmTracker, MirrorTracker
from raxel.calibration.mirror.update import (
    MirrorSettings,
    MirrorUpdate,
    update_from_scene,
    update_mirror,
)
from raxel.calibration.parametric.lens_formula import LensCalibration, calibrate_lens
from raxel.calibration.parametric.opencv_fits import ZhangCalibration, calibrate_zhang
from raxel.calibration.pose.grid_pose import (
    AngularPose,
    facing_plane_normal,
    grid_pose_ransac,
    linear_grid_pose,
    refine_pose_angular,
    synthetic_plane_normal,
)
from raxel.calibration.pose.non_central import (
    NonCentralPose,
    pose_from_non_central_rays,
)
from raxel.calibration.pose.three_point import (
    RayPose,
    pose_from_rays,
    pose_three_point_ransac,
    refine_pose_ray_point,
    three_point_depths,
)
from raxel.calibration.smooth.adjustment import SplineAdjustment, adjust_spline
from raxel.calibration.smooth.boards import SplineCalibration, calibrate_spline
from raxel.calibration.smooth.table import SmoothTable, smoothed_rays
from raxel.calibration.views.correspondence import (
    BoardView,
    locate_pixels,
    pixels_on_board,
)
from raxel.calibration.views.dense import DenseView, dense_view
from raxel.calibration.views.interpolation import interpolated_view

__all__ = [
    "AngularPose",
    "BoardView",
    "BundleResult",
    "CentralCalibration",
    "CentralTest",
    "CgspSolution",
    "Clamp",
    "ClampLine",
    "ConsistentResult",
    "DenseView",
    "FilmTracker",
    "FixedLine",
    "FreeCentreResult",
    "FreeLines",
    "GenericCalibration",
    "GridMotion",
    "KnownMotionRays",
    "LensCalibration",
    "LinearSolution",
    "MirrorSettings",
    "MirrorTracker",
    "MirrorUpdate",
    "NonCentralPose",
    "PlatterPicture",
    "PlatterPoses",
    "PrimaryCalibration",
    "RayPose",
    "SmoothTable",
    "SplineAdjustment",
    "SplineCalibration",
    "StageBundle",
    "StageView",
    "ZhangCalibration",
    "adjust_concurrence",
    "adjust_consistent",
    "adjust_ray_point",
    "adjust_spline",
    "bilinear_products",
    "bundle_adjust_fixed_centre",
    "bundle_stages",
    "calibrate_central",
    "calibrate_cgsp",
    "calibrate_generic",
    "calibrate_lens",
    "calibrate_primary",
    "calibrate_spline",
    "calibrate_zhang",
    "centrality_test",
    "centroid_directions",
    "centroid_weights",
    "clamp_line",
    "clamp_of_camera",
    "coefficient_vectors",
    "dense_view",
    "edge_picks",
    "facing_plane_normal",
    "fixed_line",
    "grid_pose_ransac",
    "grid_poses_in_platter",
    "interpolated_view",
    "linear_as_printed",
    "linear_cgsp",
    "linear_grid_pose",
    "linear_well_conditioned",
    "locate_pixels",
    "pixels_on_board",
    "pose_from_non_central_rays",
    "pose_from_rays",
    "pose_three_point_ransac",
    "primary_from_points",
    "ray_directions",
    "ray_point_distances",
    "ray_point_residuals",
    "rays_from_known_motion",
    "refine_pose_angular",
    "refine_pose_ray_point",
    "relax_centrality",
    "relax_poses",
    "relaxed_start",
    "smoothed_rays",
    "solve_coefficients",
    "synthetic_plane_normal",
    "table_2_1",
    "three_point_depths",
    "update_from_scene",
    "update_mirror",
]
