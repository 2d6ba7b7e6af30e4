"""Cameras with a known smooth field on a lens formula, for the tests of smooth rays."""

import numpy as np

from raxel.cameras import KannalaBrandtCamera, RaySplineCamera, control_shape
from raxel.geometry import (
    nearest_rotation,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)

W, H = 320, 240
LENS = KannalaBrandtCamera([1, -0.03, 0.004], (120, 120), (162, 118), W, H)
SPACING = W / 8
SHAPE = control_shape(W, H, SPACING)


def bent(amplitude=1.0, seed=0):
    """A camera whose field has waves about as long as the image."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]] / SHAPE[1]
    phase, slope = rng.uniform(0, 6, 2), rng.uniform(3, 6, (2, 2))
    control = [
        np.sin(p + a * u + b * v) for p, (a, b) in zip(phase, slope, strict=True)
    ]
    control = amplitude * np.stack(control, axis=2)
    return RaySplineCamera(LENS, SPACING, control, W, H)


def positions(rng, count, width=W):
    """Pixels (count, 2) evenly over the image, or its left part."""
    return rng.uniform(-0.5, [width - 0.5, H - 0.5], (count, 2))


def noisy_rays(camera, rng, count, sd_px):
    """Pixels (count, 2) and the directions that pixels off by sd_px see."""
    pixels = positions(rng, count)
    off = sd_px * rng.standard_normal(pixels.shape)
    return pixels, camera.rays(pixels + off).directions


def boards(camera, rng, count, sd_px, columns=8, rows=6, pitch=20.0):
    """count times (pixels, points), and poses (count, 4, 4): boards seen whole."""
    points = np.mgrid[:rows, :columns].reshape(2, -1)[::-1].T * pitch
    middle = np.append(points.mean(axis=0), 0)
    seen, poses = [], []
    while len(seen) < count:
        axis = rng.uniform(0, 2 * np.pi)
        turn = rng.uniform(0.1, 0.6) * np.array([np.cos(axis), np.sin(axis), 0])
        sight = camera.rays(positions(rng, 1)).directions[0]
        across = np.cross([0, 0, 1.0], sight)
        across *= np.arccos(sight[2]) / max(np.linalg.norm(across), 1e-9)
        R = rotation_from_vector(across) @ rotation_from_vector(turn)
        T = pose(R, rng.uniform(100, 250) * sight - R @ middle)
        found = camera.project(transform(T, on_plane(points)))
        if (found.valid & camera.in_image(found.pixels)).all():
            off = sd_px * rng.standard_normal(found.pixels.shape)
            seen.append((found.pixels + off, points))
            poses.append(T)
    return seen, np.array(poses)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def disturbed(poses, rng, angle=0.01, shift=2.0):
    """Poses (n, 4, 4) off by some hundredths of a radian and mm."""
    R = poses[:, :3, :3] @ rotation_from_vector(rng.normal(0, angle, (len(poses), 3)))
    return pose(R, poses[:, :3, 3] + rng.normal(0, shift, (len(poses), 3)))


def misfit_px(found, true, pixels):
    """How far off (N, 2) px the rays of a camera are, a common rotation apart."""
    ours, exact = found.rays(pixels).directions, true.rays(pixels).directions
    R = nearest_rotation(exact.T @ ours)
    return true.project(ours @ R.T).pixels - pixels
