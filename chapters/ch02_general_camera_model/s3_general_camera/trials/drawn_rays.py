"""Data of Figs 2.1 and 2.2: rays of tables, and rays that meet grids."""

import numpy as np

from chapters.shared.general_cameras import CAMERAS
from raxel.calibration import bundle_adjust_fixed_centre, linear_well_conditioned
from raxel.cameras import GeneralCamera
from raxel.cameras.core.base import pixel_grid
from raxel.geometry import intersect_rays_plane, transform

# Fig. 2.1: a small image, so that its pixels can be drawn, and the pixel i
# whose matrix is printed.
TABLE_PX = (14, 10)
PIXEL_I = (3, 3)


def table_trial(condition, rng):
    """Return the look-up table of one camera: rays and matrices of its pixels."""
    width, height = TABLE_PX
    camera = CAMERAS[condition["camera"]](width, height)
    table = GeneralCamera.from_camera(camera)
    pixels = pixel_grid(width, height)
    rays = table.rays(pixels)
    out = {
        "pixels": pixels,
        "origins": rays.origins,
        "directions": rays.directions,
        "matrices": table.pluecker().reshape(-1, 4, 4),
        "rays": int(rays.valid.sum()),
    }
    if condition["camera"] == "faceted":
        out["facets"] = np.stack(
            [
                transform(T, np.column_stack([outline, np.zeros(4)]))
                for T, outline in zip(
                    camera.T_viewer_facets, camera.outlines, strict=True
                )
            ]
        )
    return out


# Fig. 2.2: the camera sees three grids; world = the first, the base grid.
IMAGE_PX = (33, 25)
DRAWN_STEP = 8
TILTS_DEG = ((0, 0, 0), (18, -10, 4), (-12, 14, -6))
SHIFTS_MM = ((0, 0, 420), (25, -15, 560), (-10, 20, 700))
KNOWN_SHIFT_MM = (0, 0, 160)
MARGIN_MM = 30.0


def three_unknown_poses(points):
    """Return poses, centre and directions from three grids in unknown poses."""
    start = linear_well_conditioned(points)
    seen = np.isfinite(points).all(axis=2)
    adjusted = bundle_adjust_fixed_centre(points, seen, start.centre, start.T_base_grid)
    return adjusted.T_base_grid, start.centre, adjusted.directions


def meetings_of(origins, directions, poses):
    """Return intersections with the grids (n, N, 3), and outlines (n, 5, 3).

    An anchor on the first grid meets it at distance zero, so the origins are
    moved back along their lines.
    """
    behind = origins - 1000.0 * directions
    hits = intersect_rays_plane(behind, directions, poses).points
    low = hits.min(axis=1) - MARGIN_MM
    high = hits.max(axis=1) + MARGIN_MM
    corners = np.stack(
        [
            np.stack([low[:, 0], high[:, 0], high[:, 0], low[:, 0]], 1),
            np.stack([low[:, 1], low[:, 1], high[:, 1], high[:, 1]], 1),
        ],
        axis=2,
    )
    return {
        "meetings": transform(poses, _flat(hits)),
        "outlines": transform(poses, _flat(corners)),
    }


def _flat(points):
    return np.concatenate([points, np.zeros((*points.shape[:2], 1))], 2)
