"""The tin with drawn matches: published calibration and true mirror.

Matches are projections by the true camera with Gaussian noise; no feature is detected.
Both mirrors have the same boards and the same matches.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.trials.calibrated import (
    EVERY_WAY,
    bent_mirror,
    boards_by_hand,
    calibrations,
)
from chapters.ch05_flexible_mirror.s3_5_tin.trials.calibrated import SETTINGS as STAGES
from chapters.ch05_flexible_mirror.s3_5_tin.trials.faces import ray_pairs, tin_of
from chapters.ch05_flexible_mirror.s3_5_tin.trials.tin import (
    ANGLES_DEG,
    DISTANCE_MM,
    SHIFT_MM,
    tin_points,
    two_places,
)
from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import lattice
from chapters.shared.mirror_scores import ray_angles
from raxel.errors import InputError
from raxel.geometry import pose, transform

# Number of matches in the thesis, and noise of each end along an axis, px.
MATCHES, MATCH_PX = 460, 0.2
# px between the pixels whose rays are compared.
COMPARED_PX = 96
SETTINGS = STAGES | {
    "matches": MATCHES,
    "match_px": MATCH_PX,
    "shift_mm": SHIFT_MM,
    "tin_mm": DISTANCE_MM,
    "angles_deg": list(map(float, ANGLES_DEG)),
}


def tin_trial(condition, rng, errors, benches, ways=EVERY_WAY):
    """Every measure of one run, for some levels and mirrors, with the same draws.

    errors: {geometry: MirrorErrors}; benches: {name: Bench}.
    """
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    of_rig, boards = errors[condition["geometry"]], boards_by_hand(rig, rng)
    out = {}
    for name, bench in benches.items():
        given, drawn = of_rig.on(bench), np.random.default_rng(seed)
        bent = bent_mirror(rig, bench, given, boards, drawn)
        out[name] = of_bench(bent, seed, ways, drawn)
    return out


def of_bench(bent, seed, ways, rng):
    """{mirror: scores} of a BentMirror; `refused`: code of the error that ended one."""
    T = two_places(bent.true, rng)
    points, face = tin_points(rng, MATCHES)
    pixels = np.stack([bent.true.project(transform(one, points)).pixels for one in T])
    pixels += rng.normal(0, MATCH_PX, pixels.shape)
    out = {}
    for way, (camera, code) in calibrations(bent, seed, ways).items():
        out[way] = {"refused": code}
        if camera is None:
            continue
        try:
            out[way] = scored(camera, pixels, face, motion_of(T))
        except InputError as refusal:
            out[way] = {"refused": refusal.code}
            continue
        rays = lattice(bent.true, COMPARED_PX)
        out[way]["ray_deg"] = float(np.nanmean(ray_angles(camera, bent.true, rays)))
    return out


def motion_of(T_camera_tin):
    """T_second_first (4, 4) of the camera, known from the stage that carries it."""
    shift = T_camera_tin[1][:3, 3] - T_camera_tin[0][:3, 3]
    return pose(np.eye(3), shift)


def scored(camera, pixels, face, T_second_first):
    """Scores of the tin reconstructed from matches (2, N, 2), with a known motion."""
    rays, known = ray_pairs(camera, pixels, MATCH_PX)
    found = tin_of(rays, face[known], T_second_first)
    return found.scores() | {"distances": found.distances, "face": found.face}
