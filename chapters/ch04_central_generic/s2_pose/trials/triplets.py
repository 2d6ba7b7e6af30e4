"""Three points and four: what the smallest samples give, and how surely."""

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.estimators import errors_of
from chapters.ch04_central_generic.s2_pose.trials.simulated import (
    moved,
    rays_and_points,
)
from chapters.shared.wide_angle import (
    CENTRE_MM,
    SETTINGS,
    SIZE_PX,
    draw_scene,
    radial_lens,
)
from raxel.calibration.pose.grid_pose import (
    facing_plane_normal,
    linear_grid_pose,
    synthetic_plane_normal,
)
from raxel.calibration.pose.three_point import pose_of_triples
from raxel.errors import CalibrationError
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

NOISE_PX = 0.5
SCENES = {"quick": 5, "full": 100}
DRAWS = 100  # samples of every kind in one scene
MEASURES = ("rotation_deg", "translation_mm")
# Distance of every pair in the image, shares of the width of the view.
APART = {
    "any three points": (0.0, np.inf),
    "close together": (0.0, 0.1),
    "far apart": (0.5, np.inf),
}


def draw_triples(pixels, kind, rng):
    """Indices (DRAWS, 3) of points whose pixels are so far apart."""
    low, high = (share * SIZE_PX for share in APART[kind])
    found = np.empty((0, 3), int)
    while len(found) < DRAWS:
        first = rng.integers(0, len(pixels), 200)
        gap = np.linalg.norm(pixels[first, None] - pixels, axis=2)
        near = (gap >= low) & (gap <= high) & (gap > 0)
        # Two more of those that are as far from the first as is asked for.
        chance = np.where(near, rng.random(gap.shape), -1.0)
        others = np.argsort(-chance, axis=1)[:, :2]
        picks = np.column_stack([first, others])
        between = np.linalg.norm(pixels[others[:, 0]] - pixels[others[:, 1]], axis=1)
        enough = np.take_along_axis(near, others, axis=1).all(axis=1)
        good = enough & (between >= low) & (between <= high)
        found = np.concatenate([found, picks[good]])
    return found[:DRAWS]


def further_grid(rng):
    """Rays, points, true pose and pixels of one noisy scene."""
    scene = draw_scene(radial_lens(), NOISE_PX, rng, grids=2)
    rays, points = rays_and_points(scene, "measured on the base grid")
    return rays, points, moved(scene.T_base_grid[1], -CENTRE_MM), scene.pixels


def count_trial(condition, rng):
    """How many triples of every kind have no pose, in one scene."""
    rays, points, _, pixels = further_grid(rng)
    out = {}
    for kind in APART:
        picks = draw_triples(pixels, kind, rng)
        _, triple = pose_of_triples(rays[picks], points[picks])
        out[kind] = {"without": int(DRAWS - len(np.unique(triple)))}
    return out


def error_trial(condition, rng):
    """Errors of the poses of triples of every kind, medians in one scene.

    Of a triple's solutions the least of either error; triples without a
    solution count as the worst.
    """
    rays, points, true, pixels = further_grid(rng)
    out = {}
    for kind in APART:
        picks = draw_triples(pixels, kind, rng)
        poses, triple = pose_of_triples(rays[picks], points[picks])
        best = {name: np.full(DRAWS, np.inf) for name in MEASURES}
        for T, k in zip(poses, triple, strict=True):
            for name, error in errors_of(T, true).items():
                best[name][k] = min(best[name][k], error)
        out[kind] = {name: np.median(found) for name, found in best.items()}
    return out


def four_trial(condition, rng):
    """Samples of four points of one scene: how many give a finite pose.

    On the plane of (4.24), and on one that all four rays meet; with the
    medians of the latter's errors.
    """
    rays, points, true, _ = further_grid(rng)
    planes = {"of_4_24": synthetic_plane_normal, "facing": facing_plane_normal}
    finite = dict.fromkeys(planes, 0)
    errors = {name: [] for name in MEASURES}
    for _ in range(DRAWS):
        picks = rng.choice(len(points), 4, replace=False)
        for name, normal in planes.items():
            try:
                found = linear_grid_pose(
                    rays[picks], points[picks], normal=normal(rays[picks])
                )
            except CalibrationError:
                continue
            finite[name] += bool(np.isfinite(found.T_camera_grid).all())
            if name == "facing":
                for measure, error in errors_of(found.T_camera_grid, true).items():
                    errors[measure].append(error)
    return {"finite": finite} | {name: np.median(e) for name, e in errors.items()}


SETTINGS_HERE = SETTINGS | {
    "noise_px": NOISE_PX,
    "samples_per_scene": DRAWS,
    "close_share": APART["close together"][1],
    "far_share": APART["far apart"][0],
}


@experiment("exp_c4_3pt_sensitive", artefact="sec_4_2")
def sensitive(effort):
    """Errors of three points near to each other, and far apart."""
    return Plan(error_trial, [{}], SCENES[effort], SETTINGS_HERE)


@experiment("exp_c4_3pt_no_solution", artefact="sec_4_2")
def no_solution(effort):
    """How often three noisy points have no pose at all."""
    return Plan(count_trial, [{}], SCENES[effort], SETTINGS_HERE)


@experiment("exp_c4_linear_always", artefact="sec_4_2")
def linear_always(effort):
    """How often four noisy points have a linear pose."""
    return Plan(four_trial, [{}], SCENES[effort], SETTINGS_HERE)
