"""What the mirror shows at each stage: a room, how wide a fan, and where corners go."""

import numpy as np

from chapters.shared.mirror_bench import BENCHES
from chapters.shared.mirror_pictures import scene_picture
from chapters.shared.mirror_rigs import mirror_rig
from raxel.geometry import pose, transform
from raxel.lab import room

# Deflections from stage 0 on over which features are followed, mm.
DEFLECTIONS_MM = (1.0, 2.0, 3.5, 5.0, 7.5, 10.0, 12.5, 15.0)
ALONG = 60  # places along the mirror's middle line
EYE_MM = np.array([-600.0, 0.0, 500.0])


def pictures_trial(condition, rng):
    """The room in the mirror of the small rig at some stages, grey."""
    rig = mirror_rig(condition["geometry"], small=True)
    cameras = rig.stages()
    T = T_world_camera(cameras)
    return {
        f"stage{k}": scene_picture(rig, cameras[k], room(), T, rng)
        for k in condition["stages"]
    }


def T_world_camera(cameras):
    """The camera in the room, so that its mirror shows the bookcase at the right."""
    middle = np.mean([_ends(camera) for camera in cameras], axis=(0, 1))
    turn = np.arctan2(middle[2], middle[0])
    c, s = np.cos(turn), np.sin(turn)
    return pose(np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]), EYE_MM)


def fan_trial(condition, rng):
    """Angle of the fan of rays of the mirror's middle line, degrees, at each stage."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    return {
        name: np.array(
            [
                fan_deg(c)
                for c in rig.stages(aberration_um=bench.aberration_um, seed=seed)
            ]
        )
        for name, bench in BENCHES.items()
    }


def fan_deg(camera):
    """Largest angle between rays of the middle line, from clamp to free edge, deg."""
    d = _line(camera)
    return float(np.degrees(np.arccos(np.clip(d @ d.T, -1, 1))).max())


def displacement_trial(condition, rng):
    """Mean displacement of the board's corners in the image, px, for DEFLECTIONS_MM."""
    rig = mirror_rig(condition["geometry"])
    T = rig.board_pose(rng, deflections=(0.0, *DEFLECTIONS_MM))
    before, seen = rig.corners(rig.camera(0.0), T)
    found = []
    for deflection in DEFLECTIONS_MM:
        after, also = rig.corners(rig.camera(deflection), T)
        both = seen & also
        found.append(np.linalg.norm(after - before, axis=1)[both].mean())
    return {"moved_px": np.array(found)}


def _ends(camera):
    return _line(camera)[[0, -1]]


def _line(camera):
    """Unit directions (n, 3) of the rays along the mirror's middle line."""
    mirror = camera.mirror
    x = mirror.end * np.linspace(1e-4, 1 - 1e-4, ALONG)
    z = mirror.height(x, 0 * x)[0]
    points = transform(camera.T_viewer_mirror, np.column_stack([x, 0 * x, z]))
    directions = camera.rays(camera.viewer.project(points).pixels).directions
    return directions[np.isfinite(directions[:, 0])]
