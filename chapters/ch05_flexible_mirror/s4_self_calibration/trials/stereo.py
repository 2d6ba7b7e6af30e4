"""Stereo between bent states: depth of a scene from the bending of the mirror."""

import numpy as np
from scipy.stats import spearmanr

from chapters.ch05_flexible_mirror.s4_self_calibration.trials.scene import (
    DEPTHS_MM,
    features,
)
from chapters.shared.mirror_rigs import DYNAMIC_MM, STAGES_MM
from chapters.shared.mirror_runs import lattice, seen_board
from raxel.calibration.mirror.self_calibration import met_points
from raxel.geometry import transform
from raxel.geometry.planes import on_plane

BASELINE_MM = np.array([100.0, 0.0, 0.0])
PICKED_PX = 0.5  # by hand, as the clamp's line is (5.3.3)
STEP_PX, SPREAD_PX = 0.25, 96
STRIPS, FINER = 8, 16
OF = ("plane", "object", "wall")


def between_states(rig, view, fields, chain, errors, rng):
    """Pairs of states, calibrated (`found`) and true (`true`), one noise for both.

    `deflected`, `baseline`: medians of the relative errors of depths in the far scene,
    of stages 0 and 1 and of stage 0 moved by 100 mm; `board`: of the board at its
    position in dynamic calibration. `sd_mm`, `along`: depth noise at DYNAMIC_MM, mm per
    px, in strips from the clamp on; `finer`: ratio of the first to the last of more
    such strips. `apart_mm`: median distance of the points on the mirror where both
    states show a feature.
    """
    stages = [field.camera for field in fields]
    points, _ = features(view, fields[:1], rng)
    T = rig.board_pose(rng, deflections=STAGES_MM[:2])
    board = transform(T, on_plane(rig.board.points()))
    pixels = [field.pictured(points, errors, rng) for field in fields[:2]]
    moved = fields[0].pictured(points - BASELINE_MM, errors, rng)
    of_board = [seen_board(rig, camera, T, errors, rng) for camera in stages[:2]]
    told = depth_sd(stages)
    out = dict(zip(("along", "sd_mm"), in_strips(*told, STRIPS), strict=True))
    starts = [stage.rays(p).origins for stage, p in zip(stages, pixels, strict=False)]
    apart = np.linalg.norm(starts[1] - starts[0], axis=1)
    out["apart_mm"] = float(np.nanmedian(apart))
    finer = in_strips(*told, FINER)[1]
    out["finer"] = float(finer[0] / finer[-1])
    out["trend"] = float(spearmanr(out["along"], out["sd_mm"]).statistic)
    for name, pair in (("found", chain[:2]), ("true", stages[:2])):
        if len(pair) < 2:
            continue
        shifted = _Moved(pair[0].rays(moved), BASELINE_MM)
        first = pair[0].rays(pixels[0])
        met = met_points(_of(pair[0].rays(of_board[0])), pair[1].rays(of_board[1]))[0]
        out[name] = {
            "deflected": off(first, pair[1].rays(pixels[1]), points),
            "baseline": off(first, shifted, points),
            "board": off(pair[0].rays(of_board[0]), pair[1].rays(of_board[1]), board),
            "met": met,
        }
    out["board_points"] = board
    return out


class _Moved:
    """Rays of a camera after a known translation."""

    def __init__(self, rays, shift):
        self.origins, self.directions = rays.origins + shift, rays.directions


def _of(rays):
    return rays.origins, rays.directions


def off(first, second, points):
    """Median of |found / true - 1| of the depths of points (N, 3) along first rays."""
    met = met_points(_of(first), second)[0]
    true = np.linalg.norm(points - first.origins, axis=1)
    depth = np.sum((met - first.origins) * first.directions, axis=1)
    return float(np.nanmedian(np.abs(depth / true - 1)))


def depth_sd(stages):
    """Relative distance (n,) from the clamp, 0 to 1, and depth noise (n,) there.

    Standard deviation, mm, for 1 px in each coordinate of both images.
    """
    before = lattice(stages[0], SPREAD_PX)
    rays = stages[0].rays(before)
    points = rays.origins + DYNAMIC_MM * rays.directions
    after, valid = stages[1].project(points)
    before, after = before[valid], after[valid]
    square = 0.0
    for axis in 0.5 * STEP_PX * np.eye(4):
        ends = [
            _depths(stages, before + sign * axis[:2], after + sign * axis[2:])
            for sign in (1, -1)
        ]
        square = square + ((ends[0] - ends[1]) / STEP_PX) ** 2
    place = np.abs(rays.origins[valid, 0] - stages[0].T_viewer_mirror[0, 3])
    return place / np.nanmax(place), np.sqrt(square)


def in_strips(share, sd, count):
    """Middles (n,) and medians (n,) of the standard deviations (N,) of depths in strips
    from the clamp to the end."""
    strips = [
        (share >= k / count) & (share <= (k + 1) / count) & np.isfinite(sd)
        for k in range(count)
    ]
    some = [strip for strip in strips if strip.any()]
    return (
        np.array([share[strip].mean() for strip in some]),
        np.array([np.median(sd[strip]) for strip in some]),
    )


def _depths(stages, before, after):
    first = stages[0].rays(before)
    met = met_points(_of(first), stages[1].rays(after))[0]
    return np.sum((met - first.origins) * first.directions, axis=1)


def four_views(view, fields, chain, errors, rng):
    """The far scene from all stages: centroids, spreads, points; pixels of stage 2."""
    stages = [field.camera for field in fields]
    points, names = features(view, fields, rng)
    pixels = [field.pictured(points, errors, rng, PICKED_PX) for field in fields]
    out = {}
    for name, cameras in (("found", chain), ("true", stages)):
        if len(cameras) < len(stages):
            continue
        rays = [camera.rays(seen) for camera, seen in zip(cameras, pixels, strict=True)]
        met = nearest(rays)
        known = np.isfinite(met).all(axis=1)
        depth = view.depth(met)
        across = np.cross([0.0, 1.0, 0.0], view.axis)
        out[name] = {
            "plan": np.column_stack([(met - view.middle) @ across, depth])[known],
            "of": np.array([OF.index(one) for one in names])[known],
        }
        for one in OF:
            mine = depth[known & (names == one)]
            out[name][one] = {
                "centroid_mm": float(mine.mean()),
                "spread_mm": float(np.ptp(mine)),
                "ratio": float(mine.mean() / DEPTHS_MM[one]),
            }
    out["pixels"] = pixels[-2]
    return out


def nearest(views):
    """Points (N, 3) nearest to the rays of all views, NaN where one is missing."""
    normal, right = 0.0, 0.0
    for rays in views:
        d = rays.directions
        P = np.eye(3) - d[:, :, None] * d[:, None, :]
        normal, right = normal + P, right + np.einsum("nij,nj->ni", P, rays.origins)
    known = np.isfinite(right).all(axis=1)
    met = np.full(right.shape, np.nan)
    met[known] = np.linalg.solve(normal[known], right[known][..., None])[..., 0]
    return met
