"""Scatter of an estimated deflection at the load and among the corners.

One push, calibrated as for Table 5.1. How far the mirror was found to go is held
against how far it went: at the load, and at places that lie among the corners.
"""

import numpy as np
from scipy.spatial import Delaunay

from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary, seen_board
from raxel.errors import CalibrationError
from raxel.geometry import inverse_pose, transform

STEP_MM = STAGES_MM[:2]
# Places of the sheet, along and across, and the share of its width that they cover.
PLACES, ACROSS = (33, 11), 0.9
NEWTON_STEPS, ARRIVED_MM = 20, 1e-9


def one_push(rig, bench, errors, seed):
    """Errors of the mirror's movement, mm: `tip_mm` at the load, and mean and mean
    square of points in the convex hull of the common corners; the same for the position
    after the push, `surface`. `beyond_mm`: from the last corner to the load. `refused`:
    the code of the rejection of a run without a value.
    """
    rng = np.random.default_rng(seed)
    cameras = [rig.camera(mm, bench.aberration_um, seed) for mm in STEP_MM]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    T = rig.board_pose(rng, deflections=STEP_MM)
    pictures = [seen_board(rig, camera, T, errors, rng) for camera in cameras]
    try:
        stage = deflected(
            first.camera,
            cameras[1],
            pictures,
            rig.board.points(),
            first.clamp,
            PUBLISHED,
        )
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    corners = sheet_mm(cameras[1], pictures[1][stage.used])
    inside = places_among(corners, cameras[1])
    places = {
        "load": [rig.load_point(true)[None] for true in cameras],
        "among": [on_mirror(true, inside) for true in cameras],
    }
    pair = first.camera, stage.camera
    off = {
        name: [beyond(rig, one, at) for one, at in zip(pair, points, strict=True)]
        for name, points in places.items()
    }
    went = {name: after - before for name, (before, after) in off.items()}
    last = corners[:, 0].max()
    return {
        "beyond_mm": float(cameras[1].mirror.profile.places[0] - last),
        "places": len(inside),
        **spread("", went["load"][0], went["among"]),
        **spread("surface.", off["load"][1][0], off["among"][1]),
    }


def spread(prefix, tip, among):
    """The error at the load, and mean and mean square of those among the corners."""
    return {
        f"{prefix}tip_mm": float(tip),
        f"{prefix}mean_mm": float(np.mean(among)),
        f"{prefix}square_mm2": float(np.mean(among**2)),
    }


def sheet_mm(true, pixels):
    """Points of the sheet that pixels (N, 2) see, (N, 2) mm in the mirror's frame."""
    points = transform(inverse_pose(true.T_viewer_mirror), true.rays(pixels).origins)
    return points[:, :2]


def places_among(corners, true):
    """Places (n, 2) mm of a lattice over the sheet in the hull of corners (N, 2)."""
    mirror = true.mirror
    half = ACROSS * mirror.half_width
    x = np.linspace(0, mirror.end, PLACES[0])
    y = np.linspace(-half, half, PLACES[1])
    lattice = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return lattice[Delaunay(corners).find_simplex(lattice) >= 0]


def on_mirror(true, places):
    """Points (n, 3) of a true mirror over places (n, 2) mm, viewer's frame."""
    x, y = np.transpose(places)
    return transform(
        true.T_viewer_mirror, np.column_stack([x, y, true.mirror.height(x, y)[0]])
    )


def beyond(rig, found, points):
    """How far (n,) mm a calibrated mirror lies beyond points (n, 3), along the push."""
    along = rig.deflection_direction()
    shift = np.zeros(len(points))
    for _ in range(NEWTON_STEPS):
        P = points + shift[:, None] * along
        # The mirror's point on the same viewing ray, and its tangent plane there.
        S = found.mirror.points(P[:, :2] / P[:, 2:])
        n = found.mirror.normals(S)
        step = np.sum(n * (S - P), axis=1) / (n @ along)
        shift += step
        if not np.nanmax(np.abs(step)) > ARRIVED_MM:
            break
    return shift
