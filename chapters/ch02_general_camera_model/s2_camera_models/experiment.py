"""Trials of this page, their conditions and constants."""

import numpy as np

from chapters.shared.general import camera as zoo_camera
from raxel.cameras import FisheyeCamera
from raxel.geometry import rotation_from_vector
from repro.run import Plan, crossed, experiment

# Existence of a plane in front of all rays of a bundle: section 2.2.2.


FOVS_DEG = (30, 90, 150, 170, 179, 180, 181, 190, 220, 270, 360)
TRIALS = {"quick": 2, "full": 20}
RIM, INNER = 90, 300
MIN_COSINE = 1e-9
SIZE_PX = 400


def rays_of_fov(fov_deg, rng):
    """Return directions (N, 3) of an equidistance fisheye, including its edge.

    The edge has every ray together with its mirror image about the axis. The
    bundle is rotated at random, so that no plane is preferred.
    """
    half, middle = np.radians(fov_deg) / 2, (SIZE_PX - 1) / 2
    camera = FisheyeCamera(
        "equidistance", middle / half, (middle, middle), SIZE_PX, SIZE_PX, half
    )
    angle = np.concatenate(
        [np.arange(RIM) * 2 * np.pi / RIM, rng.uniform(0, 2 * np.pi, INNER)]
    )
    # The ray straight back, at 360 degrees, has no direction to its pixel.
    radius = middle * np.sqrt(rng.uniform(0, 1, RIM + INNER))
    radius[:RIM] = middle * (1 if fov_deg < 360 else 1 - 1e-9)
    pixels = middle + radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    rays = camera.rays(pixels)
    R = rotation_from_vector(rng.uniform(-np.pi, np.pi, 3))
    return rays.directions[rays.valid] @ R.T, int(rays.valid[:RIM].sum())


def plane_trial(condition, rng):
    """Search for a plane normal n with n . r_i >= eps for every ray.

    The linear programme maximises eps for n in the cube |n_k| <= 1. A plane in
    front of all rays exists exactly if eps is positive.
    """
    from scipy.optimize import linprog

    directions, on_rim = rays_of_fov(condition["fov_deg"], rng)
    found = linprog(
        [0, 0, 0, -1.0],
        A_ub=np.column_stack([-directions, np.ones(len(directions))]),
        b_ub=np.zeros(len(directions)),
        bounds=[(-1, 1)] * 3 + [(None, 1)],
        method="highs",
    )
    if found.status != 0:
        return {"failed": found.message, "rim": on_rim}
    return {
        "cosine": float(found.x[3]),
        "feasible": bool(found.x[3] >= MIN_COSINE),
        "rim": on_rim,
    }


@experiment("exp_c2_fov180", artefact="sec_2_2")
def planes(effort):
    """The linear programme n . r_i >= eps over fields of view."""
    settings = {
        "rays": {"on the rim": RIM, "within": INNER},
        "eps": MIN_COSINE,
        "bundle": "equidistance fisheye, turned at random",
    }
    return Plan(plane_trial, crossed(fov_deg=FOVS_DEG), TRIALS[effort], settings)


# One room rendered by eight cameras of the collection.


# Viewing directions: ahead, up into a mirror, away from plane mirrors.
AHEAD = np.eye(3)
UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
BACK = np.diag([-1.0, 1.0, -1.0])
ROOM = {
    "radial": AHEAD,
    "field of view": AHEAD,
    "equidistance": AHEAD,
    "stereographic": AHEAD,
    "hyperboloid mirror": UP,
    "two plane mirrors": BACK,
    "X-slits": AHEAD,
    "pushbroom": AHEAD,
}


def room_trial(condition, rng):
    """Render the room with one camera: image (h, w, 3) uint8."""
    from raxel.geometry import pose
    from raxel.lab import render, room

    model = zoo_camera(condition["model"])
    T_world_camera = pose(ROOM[condition["model"]], np.zeros(3))
    radiance = render(
        model, T_world_camera, room(), colour=True, samples=condition["samples"]
    )
    # Display response of an ordinary screen.
    shown = 255 * np.clip(radiance / 1.1, 0, 1) ** (1 / 2.2)
    return {
        "picture": np.round(shown).astype(np.uint8),
        "mean": float(radiance.mean()),
        "seen": float(np.mean(radiance.max(axis=2) > 0)),
    }
