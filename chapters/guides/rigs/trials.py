"""The rigs of data/rigs, and where their targets stand."""

from dataclasses import replace
from pathlib import PurePosixPath

import numpy as np

from chapters.shared.rigs import rig_named
from raxel.cameras import closest_point
from raxel.show.cameras import MEASURED, field_edge, spread_pixels
from raxel.show.rigs import drawn_poses

SEED = 0
EVEN_STEPS = 4
FILES = (
    "data/rigs/active-grid-demo.yaml",
    "data/rigs/coolpix-4500-fce8-boards.yaml",
    "data/rigs/coolpix-4500-fce8.yaml",
    "data/rigs/coolpix-fce8-zoom-1.yaml",
    "data/rigs/coolpix-fce8-zoom-2.yaml",
    "data/rigs/coolpix-fce8-zoom-3.yaml",
    "data/rigs/d200-boards.yaml",
    "data/rigs/d200-fisheye.yaml",
    "data/rigs/d200-lens-sharp.yaml",
    "data/rigs/d200-lens.yaml",
    "data/rigs/fisheye-12x9.yaml",
    "data/rigs/fisheye-9x7.yaml",
    "data/rigs/flexible-mirror-a-monitor.yaml",
    "data/rigs/flexible-mirror-a.yaml",
    "data/rigs/flexible-mirror-b-monitor.yaml",
    "data/rigs/flexible-mirror-b.yaml",
    "data/rigs/flexible-mirror.yaml",
    "data/rigs/hyperboloidal.yaml",
    "data/rigs/kodak-boards.yaml",
    "data/rigs/kodak-megaplus.yaml",
    "data/rigs/large-fisheye.yaml",
    "data/rigs/large-hyperboloidal.yaml",
    "data/rigs/mirror-ball.yaml",
    "data/rigs/monitor-d200.yaml",
    "data/rigs/onevr-d70-boards.yaml",
    "data/rigs/onevr-d70.yaml",
    "data/rigs/ordinary-lens.yaml",
    "data/rigs/panorama-hyperboloid.yaml",
    "data/rigs/spherical.yaml",
)
NAMES = tuple(PurePosixPath(path).stem for path in FILES)


def rig_trial(condition, rng):
    """Poses of a rig's targets, as raxel render draws them, and sizes.

    Distance and tilt of a target are told from the point that is nearest to
    all rays of the camera: from there its middle is so far, and its normal
    so far off the line of sight.
    """
    rig = rig_named(condition["rig"])
    poses = drawn_poses(rig, SEED)
    corner, size = rig.extent
    middles = poses[:, :3] @ [*(corner + size / 2), 0, 1]
    rays = rig.camera.rays(spread_pixels(rig.camera, MEASURED))
    sight = middles - closest_point(rays)
    distance = np.linalg.norm(sight, axis=1)
    # All of them are in view, or none would have been drawn.
    seen = whole = len(poses)
    if not rig.visibility.whole:
        strict = replace(rig, visibility=replace(rig.visibility, whole=True))
        whole = sum(bool(strict.shows(T)) for T in poses)
    along = (poses[:, :3, 2] * sight).sum(axis=1) / distance
    return {
        "T_camera_target": poses,
        "middle_mm": middles,
        "distance_mm": distance,
        "tilt_deg": np.degrees(np.arccos(np.clip(along, -1, 1))),
        "evaluate": rig.evaluate,
        "seen": seen,
        "whole": whole,
        "summary": rig.summary,
        "kind": rig.camera.kind,
        "width_px": rig.camera.width,
        "height_px": rig.camera.height,
        "seen_deg": angle_seen(rig.camera),
        "target": told_target(rig),
    }


def angle_seen(camera):
    """Largest angle (deg) by which rays turn from edge to opposite edge.

    Added up in steps, because it may be more than a half turn.
    """
    edge = field_edge(camera)[:-1]
    middle = (np.array([camera.width, camera.height]) - 1) / 2
    # The middle and what is near it may be where a mirror has a hole.
    share = np.linspace(-1, 1, EVEN_STEPS)[:, None, None]
    half = len(edge) // 2
    ways = np.where(share < 0, edge[half:] - middle, edge[:half] - middle)
    pixels = middle + np.abs(share) * ways
    rays = camera.rays(pixels.reshape(-1, 2)).directions.reshape(
        pixels.shape[:2] + (3,)
    )
    turns = (rays[1:] * rays[:-1]).sum(axis=2)
    return float(np.degrees(np.nanmax(np.arccos(np.clip(turns, -1, 1)).sum(axis=0))))


def told_target(rig):
    """A rig's target in words, with its sizes."""
    if rig.monitor is not None:
        w, h = rig.target.monitor_mm
        return f"a monitor of {w:g} x {h:g} mm"
    board = rig.target
    border = f"a border of {rig.border_mm:g} mm"
    return (
        f"a chessboard of {board.columns} x {board.rows} corners, "
        f"{board.pitch_mm:g} mm apart, with "
        f"{border if rig.border_mm else 'no border'}"
    )
