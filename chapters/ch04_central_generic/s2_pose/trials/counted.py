"""How many systems of equations a pose takes, counted while they are solved."""

from contextlib import ExitStack, contextmanager
from unittest.mock import patch

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.estimators import by_distances
from chapters.ch04_central_generic.s2_pose.trials.simulated import threshold
from chapters.ch04_central_generic.s2_pose.trials.triplets import (
    NOISE_PX,
    SCENES,
    further_grid,
)
from chapters.shared.wide_angle import SETTINGS, radial_lens
from raxel.calibration.pose.grid_pose import linear_grid_pose
from raxel.calibration.pose.three_point import pose_three_point_ransac
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

POINTS = (100, 999)
SOLVERS = ("eigh", "eigvals", "inv", "lstsq", "qr", "solve", "svd")
METRIC = "ray-point"


@contextmanager
def counted():
    """A list that gets (solver, shape) of all that numpy solves in this context.

    The shape is that of the matrices: (rows, columns), or (stack, rows, columns).
    """
    solved = []

    def noting(name):
        solver = getattr(np.linalg, name)

        def solve(matrices, *given, **named):
            solved.append((name, np.shape(matrices)))
            return solver(matrices, *given, **named)

        return solve

    with ExitStack() as stack:
        for name in SOLVERS:
            stack.enter_context(patch.object(np.linalg, name, noting(name)))
        yield solved


def solves_trial(condition, rng):
    """What the linear pose and the standard one solve in one noisy scene.

    linear.calls: all calls of solvers; linear.systems: those on a matrix with a row for
    each point. three_points.polynomials: of RANSAC's samples. refined.systems: steps of
    the refinement, each of which solves the normal equations (6, 6) of all points.
    """
    count = condition["points"]
    rays, points, _, _ = further_grid(rng)
    given = rays[:count], points[:count]
    limit = threshold(radial_lens(), NOISE_PX, "px", "length")
    with counted() as linear:
        linear_grid_pose(*given)
    with counted() as sampled:
        found = pose_three_point_ransac(*given, rng, limit, metric=METRIC)
    with counted() as refined:
        by_distances(*given, found, limit, METRIC)
    return {
        "linear": {
            "calls": len(linear),
            "systems": sum(shape[-2] >= count for _, shape in linear),
        },
        "three_points": {
            "polynomials": sum(
                int(np.prod(shape[:-2])) for name, shape in sampled if name == "eigvals"
            )
        },
        "refined": {"systems": refined.count(("solve", (6, 6)))},
    }


@experiment("exp_c4_pose_linear_fast", artefact="sec_4_2")
def pose_solves(effort):
    """Systems that the linear pose and the standard one solve, few points and many."""
    conditions = [{"points": count} for count in POINTS]
    return Plan(
        solves_trial, conditions, SCENES[effort], SETTINGS | {"noise_px": NOISE_PX}
    )
