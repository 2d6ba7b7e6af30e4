"""Calibrated part of the field, and the effect of a lens shift (4.3.1)."""

import numpy as np

from chapters.shared.central import (
    FISH,
    OMNI,
    RIGS,
    RUNS,
    calibrated,
    decoded_grids,
    first_points,
    shared_rays,
    true_camera,
    true_grids_of_set,
    true_poses,
)
from repro.run.rendered import rendered_set

BAND_DEG = 1.5  # half width about the horizon, and about the middle
BINNED = 4  # px of the camera that make one of the small rigs
REACH_PX = 3
# Literals, which the workflow reads without running them.
TURNED_SETS = {
    "quick": (
        "onevr-d70-small/0", "onevr-d70-turned-small/0",
        "coolpix-4500-fce8-small/0", "coolpix-4500-fce8-turned-small/0",
    ),
    "full": (
        "onevr-d70-small/0", "onevr-d70-turned-small/0",
        "coolpix-4500-fce8-small/0", "coolpix-4500-fce8-turned-small/0",
        "onevr-d70-small/1", "onevr-d70-turned-small/1",
        "coolpix-4500-fce8-small/1", "coolpix-4500-fce8-turned-small/1",
        "onevr-d70-small/2", "onevr-d70-turned-small/2",
        "coolpix-4500-fce8-small/2", "coolpix-4500-fce8-turned-small/2",
    ),
}  # fmt: skip


def field_trial(condition, rng):
    """Return the share of a camera's field that a rendered set calibrates.

    In degrees for the mirror: how much of the horizon, and of the vertical plane
    through the middle of the base grid. In shares for the fisheye: of its pixels, and
    of its solid angle. A pixel counts if at least one grid is decoded there.
    """
    folder = rendered_set(condition["rig"], condition["seed"])
    camera = true_camera(folder)
    masks = np.array([found.mask for _, found in decoded_grids(folder)])
    count = masks.sum(axis=0)
    v, u = np.indices(count.shape)
    rays = camera.rays(np.column_stack([u.ravel(), v.ravel()]).astype(float))
    some = _shares(camera, rays, count.ravel() > 0)
    if condition["camera"] == OMNI:
        base = next(iter(true_poses(folder).values()))
        towards = base[:3, 2]
        some |= _angles(rays, count.ravel() > 0, towards)
    return some


def _shares(camera, rays, seen):
    """Return shares of the pixels that have a ray, and of their solid angle."""
    good = rays.valid
    solid = _solid_angle(camera, rays)
    return {
        "share": float(seen[good].mean()),
        "solid": float(solid[good & seen].sum() / np.nansum(solid[good])),
    }


def _solid_angle(camera, rays):
    """Solid angle (N,) of each pixel, from its neighbours' directions; 0 at rims."""
    shape = camera.height, camera.width, 3
    d = rays.directions.reshape(shape)
    solid = np.full(shape[:2], np.nan)
    across, down = d[:, 1:] - d[:, :-1], d[1:] - d[:-1]
    solid[:-1, :-1] = np.linalg.norm(np.cross(across[:-1], down[:, :-1]), axis=2)
    return np.nan_to_num(solid.ravel())


def _angles(rays, seen, towards):
    """Return calibrated degrees of azimuth at the horizon and of elevation ahead."""
    x, y, z = rays.directions.T
    azimuth = np.degrees(np.arctan2(y, x) - np.arctan2(towards[1], towards[0]))
    azimuth = (azimuth + 180) % 360 - 180
    elevation = np.degrees(np.arcsin(np.clip(z, -1, 1)))
    good = rays.valid & seen
    with np.errstate(invalid="ignore"):
        level = good & (np.abs(elevation) < BAND_DEG)
        ahead = good & (np.abs(azimuth) < BAND_DEG)
    return {
        "horizontal_deg": float(len(np.unique(np.rint(azimuth[level])))),
        "vertical_deg": float(len(np.unique(np.rint(elevation[ahead])))),
    }


def turned_trial(condition, rng):
    """Return calibrations of a camera inverted for grids 2 and 3, and upright.

    Both sets have the same poses. The lens shift is measured from the displacement of
    each pixel's decoded point, in px of the full-size camera.
    """
    rig, seed = condition["rig"], condition["seed"]
    upright = rendered_set(f"{rig}-small", seed)
    turned = rendered_set(f"{rig}-turned-small", seed)
    camera = true_camera(upright)
    shape = camera.height, camera.width, 2
    points = {
        name: first_points(f) for name, f in (("upright", upright), ("turned", turned))
    }
    shifts = [
        BINNED * shift_between(a.reshape(shape), b.reshape(shape))
        for a, b in zip(points["upright"], points["turned"], strict=True)
    ]
    out = {f"shift_{n}_px": float(np.hypot(*s)) for n, s in enumerate(shifts, 1)}
    for name, seen in points.items():
        rays = shared_rays(seen, camera.width, rng)
        true = true_grids_of_set(upright, rays.pixels)
        found = calibrated(rays.points, true, centrality=False)
        out[name] = found | {"left_out": rays.left_out}
    return out


def shift_between(points, moved):
    """Return the image shift (2,), px: median over pixels.

    points, moved: (H, W, 2), points of the pixels before and after, or NaN.
    """
    r = REACH_PX
    inner = np.s_[r:-r, r:-r]
    along = (points[r:-r, 2 * r :] - points[r:-r, : -2 * r]) / (2 * r)
    down = (points[2 * r :, r:-r] - points[: -2 * r, r:-r]) / (2 * r)
    by_pixel = np.stack([along, down], axis=-1)
    off = (moved - points)[inner]
    good = np.isfinite(by_pixel).all(axis=(2, 3)) & np.isfinite(off).all(axis=2)
    found = -np.linalg.solve(by_pixel[good], off[good][..., None])[..., 0]
    return np.median(found, axis=0)


def turned_conditions(effort):
    """Return a condition for each camera and run."""
    return [
        {"camera": camera, "rig": RIGS[camera], "seed": seed}
        for camera in (OMNI, FISH)
        for seed in RUNS[effort]
    ]
