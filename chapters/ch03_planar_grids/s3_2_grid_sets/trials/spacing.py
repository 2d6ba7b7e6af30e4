"""Distances between neighbouring corners of the grids of section 3.3.2."""

from itertools import product

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.trials.pictures import (
    IMAGES,
    POSE,
    stream,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import SEEDS
from chapters.shared.grid_rigs import RIGS, rig_of
from raxel.geometry import on_plane, transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

FOUR_SETS = ("spherical", "hyperboloidal", "fisheye", "flexible-mirror")


def spacing_trial(condition, rng):
    """Return the smallest distance (px) of two neighbouring corners of an image's grid.

    Nothing is rendered: the true corners follow from the pose, which is drawn with
    the image's seed. `rng` is not used.
    """
    set_name, image, seed, poses = (
        condition[k] for k in ("set", "image", "seed", "poses")
    )
    rig = rig_of(set_name, image, poses)
    pose = rig.draw_poses(stream(set_name, image, seed, POSE), 1)[0]
    points = transform(pose, on_plane(rig.target.points()))
    corners = rig.camera.project(points).pixels
    lattice = corners.reshape(rig.target.rows, rig.target.columns, 2)
    return {"least_px": min_spacing(lattice)}


def min_spacing(lattice):
    """Return the smallest distance (px) of neighbours in (rows, columns, 2)."""
    steps = (np.linalg.norm(np.diff(lattice, axis=k), axis=2) for k in (0, 1))
    return float(min(step.min() for step in steps))


@experiment("exp_c3_same_after_loc", artefact="table_3_4", inputs=RIGS)
def spacings(effort):
    """The grids of all images of the four tables."""
    images = 1 if effort == "quick" else IMAGES
    conditions = [
        {"set": set_name, "poses": poses, "image": image, "seed": seed}
        for set_name, (poses, seeds) in product(FOUR_SETS, SEEDS.items())
        for seed in (seeds[:1] if effort == "quick" else seeds)
        for image in range(images)
    ]
    return Plan(spacing_trial, conditions, 1)
