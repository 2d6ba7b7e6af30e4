"""Points seen along rays from two places: by a bent mirror, and by a rig of cameras."""

import numpy as np

from raxel.cameras import FlexibleMirrorCamera, PerspectiveCamera
from raxel.geometry.poses import inverse_pose, pose, rotation_from_vector, transform
from raxel.multiview.ray_noise import NoisyRays

W, H = 768, 576
VIEWER = PerspectiveCamera(
    [[1900, 0, 386.0], [0, 1900, 285.0], [0, 0, 1]], [-0.11], W, H
)
BENT = FlexibleMirrorCamera(
    VIEWER,
    (160.0, 100.0),
    150.0,
    15.0,
    offset=(66, 0, 370),
    rotation=np.radians([-46.29, -0.48, -172.75]),
)
SD_PX = 0.05  # of an image four times as large, 0.2
ACROSS = np.array([-0.35, 0.0, 0.94])
T_MIRROR = pose(rotation_from_vector([0.02, -0.03, 0.04]), 30 * ACROSS + [2, 8, 3])


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def in_mirror(rng, count, Ts=(T_MIRROR,), camera=BENT, near=300.0, far=600.0):
    """Points (count, 3) that a camera sees before it moves by any of Ts, and after; and
    their pixels [(count, 2), ...] without noise, one array more than Ts."""
    pixels = rng.uniform([20, 20], [W - 20, H - 20], (5 * count, 2))
    rays = camera.rays(pixels)
    X = rays.origins + rng.uniform(near, far, (len(pixels), 1)) * rays.directions
    seen, ok = [pixels], rays.valid & _well_inside(camera, pixels)
    for T in Ts:
        found = camera.project(transform(T, X))
        seen.append(found.pixels)
        ok = ok & found.valid & _well_inside(camera, found.pixels)
    keep = np.flatnonzero(ok)[:count]
    assert len(keep) == count
    return X[keep], [x[keep] for x in seen]


def _well_inside(camera, pixels):
    """Whether rays of pixels (N, 2) are there a pixel to all sides as well."""
    steps = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1.0]])
    around = camera.rays((pixels + steps[:, None]).reshape(-1, 2)).valid
    inside = np.all((pixels > 0) & (pixels < [W - 1, H - 1]), axis=1)
    return inside & around.reshape(4, -1).all(axis=0)


def jittered(rng, pixels, sd=SD_PX):
    return pixels + sd * rng.standard_normal(pixels.shape)


def by_rig(rng, count, T, sd=1e-3, cameras=4, radius=100.0, depth=(500, 3000), **scene):
    """Points (count, 3) all around, and their NoisyRays in two places of a rig of
    central cameras on a circle, sd radians.

    scene: flat, points on a plane; crossing=False: a point is seen by one and the same
    camera; spread=False: all cameras in one position.
    """
    angle = 2 * np.pi * np.arange(cameras) / cameras
    aims = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    X = unit(rng.standard_normal((6 * count, 3)))
    X = X * rng.uniform(*depth, (len(X), 1))
    if scene.get("flat"):
        X = np.column_stack([rng.uniform(-1000, 1000, (len(X), 2)), len(X) * [1500.0]])
    Y = transform(T, X)
    first, second = np.argmax(X @ aims.T, axis=1), np.argmax(Y @ aims.T, axis=1)
    if not scene.get("crossing", True):
        keep = first == second
        X, Y, first, second = (x[keep] for x in (X, Y, first, second))
    views = []
    for points, which in ((X[:count], first), (Y[:count], second)):
        o = radius * aims[which[:count]] * scene.get("spread", True)
        d = unit(points - o)
        d = unit(d + sd * rng.standard_normal(d.shape))
        C = np.zeros((len(o), 6, 6))
        C[:, 3:, 3:] = max(sd, 1e-9) ** 2 * (np.eye(3) - d[:, :, None] * d[:, None])
        views.append(NoisyRays(o, d, C))
    return X[:count], *views


def wrong_pairs(rng, rays, share):
    """(rays, wrong (N,)): a share of them handed round."""
    count = len(rays.origins)
    wrong = np.arange(count) < share * count
    order = np.arange(count)
    order[wrong] = np.roll(order[wrong], 1 + rng.integers(wrong.sum() - 2))
    return rays.of(order), wrong


def off(T, true, centre):
    """(rotation, direction, length as a ratio) of a motion about a centre; radians."""
    turn = T[:3, :3] @ true[:3, :3].T
    u, v = (P[:3, 3] - centre + P[:3, :3] @ centre for P in (T, true))
    cosine = unit(u) @ unit(v)
    angle = np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))
    lengths = np.linalg.norm(u), np.linalg.norm(v)
    return angle, np.arccos(np.clip(cosine, -1, 1)), lengths[0] / lengths[1]


def relative(T_view_world):
    """T_2_1 of two poses."""
    return T_view_world[1] @ inverse_pose(T_view_world[0])
