"""Simulated runs of Table 2.2: numbers, settings, and runs with other corners."""

from functools import partial

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.trials.scores import scores
from chapters.ch02_general_camera_model.s5_2_real_data.trials.shots import (
    STAGE_IMAGES,
    STEP_MM,
    Counts,
    draw_poses,
    noisier,
    redrawn,
    true_shape,
)
from chapters.ch02_general_camera_model.s5_2_real_data.trials.true_centre import (
    SCENE,
    centre_trial,
    homography_trial,
)
from chapters.shared.zoom_readings import IN_PAIRS, NOISE_PX, READINGS
from chapters.shared.zoom_rigs import STAGE_ZOOM, ZOOM_RIGS, ZOOMS, camera_of
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

COUNTS = {"quick": Counts(5, 1), "full": Counts(14, 4)}
READ = {"quick": 1, "full": 12}
PAIRED = {"quick": 1, "full": 50}
SMALL = {"quick": 4, "full": 50}
EXACT = {"quick": 1, "full": 4}
SETS = crossed(zoom=ZOOMS)


def settings(effort):
    """Return the settings that a reader needs to repeat the run."""
    return {
        "rigs": list(ZOOM_RIGS),
        "calibration_images": COUNTS[effort].calibration,
        "held_out_images": COUNTS[effort].held_out,
        "stage_images": STAGE_IMAGES,
        "step_mm": STEP_MM,
        "field_of_view_deg": round(np.degrees(2 * camera_of(ZOOMS[-1]).max_angle), 6),
        "detector": "findChessboardCorners, refined",
    }


def redrawn_trial(condition, rng, counts, errors):
    """Score a redrawn run: new poses with the corner errors of rendered boards."""
    zoom = condition["zoom"]
    poses = draw_poses(zoom, counts, rng)
    boards = {
        use: redrawn(zoom, of_use, errors[zoom], rng) for use, of_use in poses.items()
    }
    return scores(zoom, boards, rng)[0]


def errors_in(results):
    """Return the errors (boards, corners, 2) of the rendered runs, by zoom."""
    rendered = results["table_2_2_rendered"]
    return {
        zoom: np.concatenate(rendered.arrays("errors", zoom=zoom)) for zoom in ZOOMS
    }


def read_trial(condition, rng, counts, errors):
    """Score a run with other corner noise or another interpolation."""
    zoom = condition["zoom"]
    poses = draw_poses(zoom, counts, rng)
    noise = NOISE_PX[condition["corner_noise"]]
    boards = {
        use: noisier(redrawn(zoom, of_use, errors[zoom], rng), noise, rng)
        for use, of_use in poses.items()
    }
    methods = ["parametric", "generic_as_printed"]
    if noise == 0:
        methods.append("opencv_fisheye")
    return scores(zoom, boards, rng, methods, condition["interpolation"])[0]


@experiment(
    "table_2_2_readings",
    artefact="table_2_2",
    shards={"full": 4},
    inputs=ZOOM_RIGS,
    needs=("table_2_2_rendered",),
)
def read_seeds(effort, results):
    """Runs with other corner noise or interpolation."""
    trial = partial(read_trial, counts=COUNTS[effort], errors=errors_in(results))
    return Plan(trial, READINGS, READ[effort], settings(effort))


@experiment(
    "fig_2_7_smooth",
    artefact="table_2_2",
    shards={"full": 3},
    inputs=ZOOM_RIGS,
    needs=("table_2_2_rendered",),
)
def smooth_seeds(effort, results):
    """Runs with a smooth surface, enough for the paired test of 2.5.3."""
    trial = partial(read_trial, counts=COUNTS[effort], errors=errors_in(results))
    return Plan(trial, IN_PAIRS, PAIRED[effort], settings(effort))


@experiment(
    "ext_table_2_2_exact", artefact="table_2_2", shards={"full": 2}, inputs=ZOOM_RIGS
)
def exact_seeds(effort):
    """Set 3 with exact corners: residuals that the detector does not cause."""
    none = {STAGE_ZOOM: np.zeros((1, *true_shape(STAGE_ZOOM)))}
    trial = partial(redrawn_trial, counts=COUNTS[effort], errors=none)
    return Plan(trial, [{"zoom": STAGE_ZOOM}], EXACT[effort], settings(effort))


@experiment("fig_2_5_true_centre", artefact="fig_2_5")
def true_centres(effort):
    """Simulated runs with the true centre in place of the estimated one."""
    return Plan(centre_trial, [{}], SMALL[effort], {"scene": SCENE})


@experiment("exp_c2_homography_harmless", artefact="fig_2_5")
def homographies(effort):
    """Perspective and distorted points after a homography."""
    return Plan(homography_trial, [{}], SMALL[effort], {})
