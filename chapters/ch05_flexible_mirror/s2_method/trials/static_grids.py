"""Primary calibration from chessboards in place of a monitor, both without noise.

The same pixels see the same two planes. The point that each sees is exact, as from an
active grid, or interpolated between the corners of a chessboard (5.2.1).
"""

import numpy as np

from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import (
    CLAMP_PICKS,
    PUBLISHED,
    STEP_PX,
    lattice,
    true_points,
)
from raxel.calibration.mirror.clamp_line import clamp_line
from raxel.calibration.mirror.primary import primary_from_points
from raxel.calibration.views.correspondence import BoardView
from raxel.calibration.views.interpolation import interpolated_view
from raxel.geometry import transform
from raxel.geometry.planes import on_plane

PITCH_MM = 20.0
# A square as its four corners have it, as in section 3.2.
INTERPOLATION = "homographic"


def static_trial(condition, rng):
    """Errors of the surface before any deflection, mm, by where points come from.

    `pixel`: each pixel's own point; `grid`: interpolated. In each case of the surface
    as published (5.15, 5.16, and the scale), `linear_mm`, and of the refined one,
    `refined_mm`. aberration_um: of the mirror.
    """
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    camera = rig.camera(0.0, condition["aberration_um"], seed)
    poses = rig.monitor_poses(rng)
    pixels = lattice(camera, STEP_PX)
    exact = np.stack([true_points(rig, camera, pixels, T) for T in poses])
    read = [
        between_corners(chessboard(camera, T, seen), pixels)
        for T, seen in zip(poses, exact, strict=True)
    ]
    # Only pixels that both know of, so that nothing but the points differs.
    both = np.isfinite([exact, read]).all(axis=(0, 1, 3))
    out = {"pixels": int(np.count_nonzero(both))}
    for name, points in (("pixel", exact), ("grid", np.stack(read))):
        out[name] = surface_errors(rig, camera, pixels[both], points[:, both], poses)
    return out


def chessboard(camera, T_camera_board, seen):
    """BoardView of the exact corners, 20 mm apart, of a board that covers what the
    mirror shows of its plane, points (N, 2) mm; NaN where it does not show one."""
    corner = np.floor(np.nanmin(seen, axis=0) / PITCH_MM)
    ends = np.ceil(np.nanmax(seen, axis=0) / PITCH_MM)
    columns, rows = (ends - corner).astype(int) + 1
    across, down = np.meshgrid(np.arange(columns), np.arange(rows))
    points = PITCH_MM * (corner + np.column_stack([across.ravel(), down.ravel()]))
    pixels, valid = camera.project(transform(T_camera_board, on_plane(points)))
    shown = valid & camera.in_image(pixels)
    pixels = np.where(shown[:, None], pixels, np.nan)
    return BoardView(pixels, points, int(columns), int(rows))


def between_corners(board, pixels):
    """Points (N, 2) mm that pixels (N, 2) see between board corners, NaN elsewhere."""
    points, inside = interpolated_view(board, INTERPOLATION)[0].locate(pixels)
    return np.where(inside[:, None], points, np.nan)


def surface_errors(rig, camera, pixels, points, T_camera_board):
    """Mean distances from the true mirror along the viewing rays, mm."""
    line = clamp_line(rig.viewer, rig.clamp_pixels(camera, CLAMP_PICKS))
    found = primary_from_points(
        rig.viewer,
        pixels,
        points,
        T_camera_board,
        shape=PUBLISHED.shape,
        angle=line.angle,
        quantity=PUBLISHED.quantity,
        span=line.points(CLAMP_PICKS),
    )
    true = camera.rays(pixels).origins
    return {
        f"{name}_mm": float(
            np.mean(np.linalg.norm(one.rays(pixels).origins - true, axis=1))
        )
        for name, one in (("linear", found.linear), ("refined", found.camera))
    }
