"""A step of a bent mirror's camera: matched rays, and the motion found from them."""

import numpy as np

from chapters.shared.rigs import rig_named
from raxel.cameras import FlexibleMirrorCamera
from raxel.geometry.line_motion import (
    generalised_essential,
    other_order,
    pluecker_of_rays,
)
from raxel.geometry.poses import angle_between_rotations, pose, transform
from raxel.multiview.generalised_linear import generalised_pose
from raxel.multiview.generalised_robust import generalised_pose_ransac
from raxel.multiview.motion_information import motion_information
from raxel.multiview.noisy_rays import rays_of_pixels
from raxel.multiview.ray_bundle import bundle_rays
from raxel.multiview.ray_points import RayView

RIG = "flexible-mirror-a"
DEFLECTIONS_MM = (1.0, 2.0, 5.0, 10.0, 15.0)
STEP_MM, NOISE_PX = 25.0, 0.2
PAIRS, WRONG = 200, 0.3
# From the mirror to the points, mm, and how many standard deviations a pair may be off.
NEAR_MM, FAR_MM, THRESHOLD = 300.0, 600.0, 3.5
RIM_PX = 5.0


def bent(deflection_mm):
    """The rig's camera with its mirror bent so far."""
    fields = rig_named(RIG).camera.arguments() | {"deflections": deflection_mm}
    return FlexibleMirrorCamera(**fields)


def products(rays_1, rays_2, T_2_1):
    """L_2^T G L_1 (N,), mm: in the thesis's order, and with its G for the other one."""
    L_1, L_2 = (pluecker_of_rays(r.origins, r.directions) for r in (rays_1, rays_2))
    G = generalised_essential(T_2_1)
    right = np.einsum("ni,ij,nj->n", L_2, G, L_1)
    mixed = np.einsum("ni,ij,nj->n", other_order(L_2), G, other_order(L_1))
    return right, mixed


def motion_of_pixels(camera, pixels_1, pixels_2, rng):
    """Motion between two pictures of a calibrated camera, from matched pixels."""
    rays = [rays_of_pixels(camera, pixels, NOISE_PX) for pixels in (pixels_1, pixels_2)]
    found = generalised_pose_ransac(*rays, rng, THRESHOLD)
    views = [RayView(one.of(found.inliers)) for one in rays]
    # A length that the rays do not tell would run away.
    held = None if found.scale_told else 1
    return found, bundle_rays(views, [np.eye(4), found.T_2_1], held=held)


def step_trial(condition, rng):
    """A step aside before points in the mirror: foretold and found errors."""
    camera = bent(condition["deflection_mm"])
    T, true_1, true_2 = _sighted(camera, rng)
    pixels_1, pixels_2 = (
        x + NOISE_PX * rng.normal(size=x.shape) for x in (true_1, true_2)
    )
    wrong = np.arange(PAIRS) < WRONG * PAIRS
    pixels_2[wrong] = np.roll(pixels_2[wrong], 1, axis=0)
    exact = [rays_of_pixels(camera, x, NOISE_PX) for x in (true_1, true_2)]
    right, mixed = products(*exact, T)
    told = motion_information(T, *(one.of(~wrong) for one in exact))
    rays = [rays_of_pixels(camera, x, NOISE_PX) for x in (pixels_1, pixels_2)]
    linear = generalised_pose(*(one.of(~wrong) for one in rays))
    found, together = motion_of_pixels(camera, pixels_1, pixels_2, rng)
    held = generalised_pose_ransac(*rays, rng, THRESHOLD, length=told.baseline)
    return {
        "spread_mm": told.spread,
        "product_mm": np.abs(right).max(),
        "mixed_mm": np.abs(mixed).max(),
        "told": _told(told),
        "linear": _errors(linear.T_2_1, T, told.centre),
        "robust": _errors(found.T_2_1, T, told.centre),
        "together": _errors(together.T_view_world[1], T, told.centre),
        "held": _errors(held.T_2_1, T, told.centre),
        "kept": np.mean(found.inliers[~wrong]),
        "let_in": np.mean(found.inliers[wrong]),
    }


def _told(told):
    return {
        "turn_deg": np.degrees(told.rotation_sd),
        "aside_deg": np.degrees(told.direction_sd),
        "length_percent": 100 * told.scale_sd,
        "turn_with_length_deg": np.degrees(told.with_length[0]),
    }


def _errors(T_2_1, T, centre):
    """Rotation, direction, and length as a share of the one found: noise shifts one
    over the length alike, whatever it is, and one without end is 100 % off."""
    u, v = (P[:3, 3] - centre + P[:3, :3] @ centre for P in (T_2_1, T))
    lengths = np.linalg.norm(u), np.linalg.norm(v)
    return {
        "turn_deg": np.degrees(angle_between_rotations(T_2_1[:3, :3], T[:3, :3])),
        "aside_deg": np.degrees(np.arccos(np.clip(u @ v / np.prod(lengths), -1, 1))),
        "length_percent": 100 * (1 - lengths[1] / lengths[0]),
    }


def _sighted(camera, rng):
    """T_2_1 of a step aside, and pixels (PAIRS, 2) of points before and after it."""
    size = np.array([camera.width, camera.height]) - 1.0
    pixels = rng.uniform(0, size, (8 * PAIRS, 2))
    rays = camera.rays(pixels)
    ahead = np.nanmean(rays.directions, axis=0)
    aside = np.cross(ahead, [0.0, 1.0, 0.0])
    T = pose(np.eye(3), STEP_MM * aside / np.linalg.norm(aside))
    depth = rng.uniform(NEAR_MM, FAR_MM, (len(pixels), 1))
    points = rays.origins + depth * rays.directions
    after = camera.project(transform(T, points))
    seen = rays.valid & after.valid
    for places in (pixels, after.pixels):
        seen &= _within(camera, places, size)
    keep = np.flatnonzero(seen)[:PAIRS]
    return T, pixels[keep], after.pixels[keep]


def _within(camera, pixels, size):
    """Whether pixels (N, 2) are on the picture of the mirror, and not at its rim."""
    corners = RIM_PX * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1.0]])
    around = camera.rays((pixels + corners[:, None]).reshape(-1, 2)).valid
    inside = np.all((pixels > RIM_PX) & (pixels < size - RIM_PX), axis=1)
    return inside & around.reshape(len(corners), -1).all(axis=0)
