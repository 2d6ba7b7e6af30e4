"""The least squares of `raxel.calibration.mirror.bundle`: residuals, normal matrix."""

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.ray_points import RayPoints
from raxel.calibration.pose.three_point import (
    motion_of_points,
    moved_pose,
    placed_points,
)
from raxel.errors import CalibrationError

# Of the largest eigenvalue of the scaled normal matrix: below it, nothing is known.
OPEN = 1e-13


class State(NamedTuple):
    """free: unknowns (F,) of each stage, those of a fixed one empty; T: poses."""

    free: list[np.ndarray]
    T: np.ndarray


class SeenCorners(NamedTuple):
    """One view: stage, grid, its RayPoints, points (N, 2) of the grid, sd (N,) in
    normalised units, scale (N,) px for one."""

    stage: int
    grid: int
    rays: RayPoints
    points: np.ndarray
    sd: np.ndarray
    scale: np.ndarray
    unknown_sd: bool


class BundleProblem(NamedTuple):
    """The least squares of one round. whiten: (N, 2, 3) of each view, which takes
    ray-point vectors to residuals."""

    seen: list[SeenCorners]
    spaces: list
    further: list
    whiten: list[np.ndarray]

    @property
    def count(self):
        """Number of equations."""
        own = sum(len(rows) for rows, _ in self.further)
        return own + 2 * sum(len(view.points) for view in self.seen)

    def coefficients(self, state):
        return [
            space.coefficients(free)
            for space, free in zip(self.spaces, state.free, strict=True)
        ]

    def residuals(self, state):
        """Of the views, (N, 2) each, and of the further rows of each stage."""
        c = self.coefficients(state)
        views = []
        for view, whiten in zip(self.seen, self.whiten, strict=True):
            placed = placed_points(view.points, state.T[view.grid])
            off = view.rays.residuals(c[view.stage], placed)
            views.append((whiten @ off[:, :, None])[:, :, 0])
        rows = [
            rows @ one - values
            for one, (rows, values) in zip(c, self.further, strict=True)
        ]
        return views, rows

    def evaluate(self, state):
        c = self.coefficients(state)
        if not all(view.rays.in_front(c[view.stage]) for view in self.seen):
            return np.inf, None
        views, rows = self.residuals(state)
        cost = sum(np.sum(part**2) for part in [*views, *rows])
        return cost, lambda: self.equations(state, views, rows)

    def equations(self, state, views, rows):
        """Normal matrix (P, P) and half the gradient (P,): stages first, then poses."""
        starts, size = self.layout(state)
        normal, gradient = np.zeros((size, size)), np.zeros(size)
        for view, whiten, off in zip(self.seen, self.whiten, views, strict=True):
            by_shape, by_pose = self.jacobians(view, whiten, state)
            shape = slice(*starts[view.stage : view.stage + 2])
            k = starts[-1] + 6 * view.grid
            pose = slice(k, k + 6)
            both = by_shape.T @ by_pose
            normal[shape, shape] += by_shape.T @ by_shape
            normal[pose, pose] += by_pose.T @ by_pose
            normal[shape, pose] += both
            normal[pose, shape] += both.T
            gradient[shape] += by_shape.T @ off.ravel()
            gradient[pose] += by_pose.T @ off.ravel()
        for stage, off in enumerate(rows):
            shape = slice(*starts[stage : stage + 2])
            own = self.further[stage][0] @ self.spaces[stage].directions
            normal[shape, shape] += own.T @ own
            gradient[shape] += own.T @ off
        return normal, gradient

    def jacobians(self, view, whiten, state):
        """(2N, F) by its stage's unknowns, (2N, 6) by (w, s) of its grid's pose."""
        space, T = self.spaces[view.stage], state.T[view.grid]
        c = space.coefficients(state.free[view.stage])
        by_shape = np.zeros((2 * len(view.points), 0))
        if space.directions.shape[1]:
            change = view.rays.jacobian(c, placed_points(view.points, T))
            by_shape = (whiten @ change).reshape(-1, change.shape[2]) @ space.directions
        by_pose = whiten @ view.rays.across(c) @ motion_of_points(view.points, T)
        return by_shape, by_pose.reshape(-1, 6)

    def layout(self, state):
        """Where each stage's unknowns begin, and the poses'; the number of all."""
        starts = np.concatenate([[0], np.cumsum([len(f) for f in state.free])])
        return starts, starts[-1] + 6 * len(state.T)


def moved(state, step):
    """The State after a step: free unknowns of all stages, then six for each pose."""
    free, start = [], 0
    for own in state.free:
        free.append(own + step[start : start + len(own)])
        start += len(own)
    steps = step[start:].reshape(-1, 6)
    return State(
        free, np.stack([moved_pose(T, s) for T, s in zip(state.T, steps, strict=True)])
    )


def inverse_of(normal):
    """Inverse of a normal matrix (K, K); CalibrationError where unknowns are open."""
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    values, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    if not values[0] > OPEN * values[-1]:
        raise CalibrationError(
            f"bundle: the corners leave {np.sum(values <= OPEN * values[-1])} of "
            f"{len(values)} unknowns open; let each stage show a grid in all knot "
            "intervals, and each grid be seen in two stages, or give a prior",
            code="open-coefficients",
        )
    return (vectors / values) @ vectors.T / np.outer(scale, scale)
