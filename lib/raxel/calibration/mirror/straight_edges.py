"""Shape of a bent mirror from straight edges of a scene that nobody knows (6.3.3).

An edge is a row of pixels. Seen from the mirror its rays leave the plane of a straight
line by some angle, and the shape is moved until these are least:

    n = e_1 x e_2,   e_i = u_i + rho_i (O - S),   r = V_r . n / |n|

with u_i the directions of two points of the line from a point O of the mirror, rho_i
one over their distances, and S, V_r a ray. With rho = 0 that is the thesis's wording,
the non-planarity of the scene rays; with rho free and the rays of the picture before
beside those after, it is one line in space for each edge. What edges leave open stays
where the linear stage had it, by a weak tie.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.clamp import clamped
from raxel.calibration.mirror.prior import bending_prior, plane_through
from raxel.calibration.mirror.ray_points import RayPoints
from raxel.calibration.mirror.refine import camera_of_shape, stacked
from raxel.calibration.mirror.sightings import normalised
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry.damped import descend, gauss_newton

ITERATIONS, AT_REST = 40, 1e-6
LEAST_PIXELS = 4  # of an edge: two lie on a line whatever the mirror
# Standard deviations of the weak ties: of a coefficient, mm, and of rho, 1/mm.
TIE_MM, TIE_NEARNESS = 5.0, 1 / 500
STEP = 1e-6  # of what is differenced, in its tie's standard deviation


class EdgeUpdate(NamedTuple):
    """camera: SplineMirrorCamera after; start_rms, rms: angles by which rays leave the
    planes of their edges, before and after the fit, standard deviations; edges: how
    many counted; converged."""

    camera: SplineMirrorCamera
    start_rms: float
    rms: float
    edges: int
    converged: bool


def straight_edges_update(start, edges, clamp, *, noise, prior_sd, before=None):
    """EdgeUpdate of a camera from the straight edges that its picture shows.

    start: SplineMirrorCamera after, as the linear stage left it; edges: list of pixels
    (n, 2), one array for each edge; clamp: as `update_mirror` takes it; noise: standard
    deviation of a ray's direction across its edge, radians; prior_sd: of
    `bending_prior`, mm. before: (camera, edges) of the picture before, whose mirror
    stays as it is, each edge in the same place of its list; without it rays after alone
    count, as 6.3.3 words it. Edges of fewer than four pixels in the mirror do not
    count. Raises CalibrationError where none is left, for arrays of another shape, and
    for edges before that are not as many.
    """
    edges = _checked_edges(edges)
    if not (0 < noise < np.inf and 0 < prior_sd < np.inf):
        raise CalibrationError(
            f"straight edges: noise {noise} and prior_sd {prior_sd} must be above zero",
            code="bad-setting",
        )
    if before is not None:
        before = before[0], _checked_edges(before[1])
        if len(before[1]) != len(edges):
            raise CalibrationError(
                f"straight edges: {len(before[1])} before and {len(edges)} after; give "
                "each in the same place of both lists",
                code="unmatched-features",
            )
    after = [_inside(start, pixels) for pixels in edges]
    counts = [len(p) >= LEAST_PIXELS for p in after]
    known = None
    if before is not None:
        known = [before[0].rays(pixels) for pixels in before[1]]
        counts = [
            enough and np.count_nonzero(rays.valid) >= LEAST_PIXELS
            for enough, rays in zip(counts, known, strict=True)
        ]
    if not any(counts):
        raise CalibrationError(
            f"straight edges: none of {len(edges)} has {LEAST_PIXELS} pixels in the "
            "mirror; give longer ones",
            code="too-few-features",
        )
    kept = np.flatnonzero(counts)
    system = _EdgeSystem(
        start, [after[k] for k in kept], known and [known[k] for k in kept], noise
    )
    return system.settled(clamp, prior_sd)


def _checked_edges(edges):
    """Pixels (n, 2) of each edge, each place once."""
    checked = []
    for k, pixels in enumerate(edges):
        pixels = np.asarray(pixels, float)
        if pixels.size == 0:
            pixels = pixels.reshape(0, 2)
        if pixels.ndim != 2 or pixels.shape[1] != 2:
            raise CalibrationError(
                f"straight edges: edge {k} is {pixels.shape}; give pixels (n, 2)",
                code="wrong-shape",
            )
        few = len(np.unique(pixels[np.isfinite(pixels).all(axis=1)], axis=0))
        checked.append(pixels if few >= LEAST_PIXELS else pixels[:0])
    return checked


def _inside(camera, pixels):
    """p (n, 2) of the pixels that lie in the camera's knots."""
    p = normalised(camera.viewer, np.asarray(pixels, float))
    p = p[np.isfinite(p).all(axis=1)]
    return p[camera.grid.inside(p)]


class _EdgeSystem:
    """Coefficients and lines: residuals of rays, the lines' four numbers for each."""

    def __init__(self, start, after, known, noise):
        self.start, self.noise, self.in_space = start, noise, known is not None
        self.grid, self.quantity = start.grid, start.quantity
        self.rays = RayPoints(np.vstack(after), self.grid, self.quantity)
        edge = np.repeat(np.arange(len(after)), [len(p) for p in after])
        self.o = np.zeros((0, 3))
        self.d = np.zeros((0, 3))
        if self.in_space:
            self.o, self.d = (
                np.vstack([getattr(rays, name)[rays.valid] for rays in known])
                for name in ("origins", "directions")
            )
            seen = [np.count_nonzero(rays.valid) for rays in known]
            edge = np.append(edge, np.repeat(np.arange(len(known)), seen))
        self.edge, self.count = edge, len(after)
        c = start.coefficients.ravel(order="F")
        S, V = self._all(c)
        self.middle = S.mean(axis=0)
        self._frames(V)

    def _all(self, c):
        """Origins and directions of all rays, those after first."""
        S, V = self.rays.surface(c)
        return np.vstack([S, self.o]), np.vstack([V, self.d])

    def _frames(self, V):
        """Of each edge two directions at its ends, and the way across (E, 3)."""
        ends, across = [], []
        for k in range(self.count):
            mine = V[self.edge == k]
            normal = np.linalg.svd(mine, full_matrices=False)[2][2]
            middle = mine.mean(axis=0)
            along = mine @ np.cross(normal, middle)
            two = mine[[np.argmin(along), np.argmax(along)]]
            ends.append(two - (two @ normal)[:, None] * normal)
            across.append(normal)
        self.ends, self.across = np.array(ends), np.array(across)

    def angles(self, c, lines):
        """(R,), radians over noise, by which rays leave the planes of their lines.

        lines: (E, 4): both ends' shifts across, radians, and one over their distances.
        """
        S, V = self._all(c)
        e = self.ends + lines[:, :2, None] * self.across[:, None]
        gap = self.middle - S
        e_1, e_2 = (
            e[self.edge, i] + lines[self.edge, 2 + i, None] * gap for i in (0, 1)
        )
        n = np.cross(e_1, e_2)
        n /= np.linalg.norm(n, axis=1, keepdims=True)
        return np.sum(n * V, axis=1) / self.noise

    def settled(self, clamp, prior_sd):
        """The EdgeUpdate at the least sum of squares."""
        space = clamped(self.grid, clamp)
        first = space.free(self.start.coefficients.ravel(order="F"))
        S, _ = self._all(space.coefficients(first))
        plane = plane_through(S[: len(self.rays.p)])
        prior = bending_prior(self.grid, self.quantity, plane, prior_sd)
        rows, values = stacked([prior], self.grid.size)
        tie_sd = TIE_MM / prior.mm
        open_lines = 4 if self.in_space else 2
        line_sd = np.array([1.0, 1.0, TIE_NEARNESS, TIE_NEARNESS])[:open_lines]

        def parts(state):
            lines = np.zeros((self.count, 4))
            lines[:, :open_lines] = state[len(first) :].reshape(self.count, -1)
            return space.coefficients(state[: len(first)]), lines

        def residuals(state):
            c, lines = parts(state)
            tied = (state[: len(first)] - first) / tie_sd
            off = lines[:, :open_lines] / line_sd
            near = off[:, 2:].ravel()
            return np.concatenate(
                [self.angles(c, lines), rows @ c - values, tied, near]
            )

        def jacobian(state):
            here = residuals(state)
            J = np.zeros((len(here), len(state)))
            for k in range(len(first)):
                step = np.zeros(len(state))
                step[k] = STEP * tie_sd
                J[:, k] = (residuals(state + step) - here) / step[k]
            for k in range(open_lines):
                step = np.zeros(len(state))
                columns = len(first) + open_lines * np.arange(self.count) + k
                step[columns] = STEP * line_sd[k]
                change = (residuals(state + step) - here) / (STEP * line_sd[k])
                of_rays = np.arange(len(self.edge))
                J[of_rays, columns[self.edge]] = change[of_rays]
                if k >= 2:
                    near = len(here) - 2 * self.count + 2 * np.arange(self.count)
                    J[near + k - 2, columns] = 1 / line_sd[k]
            return J

        def evaluate(state):
            if not self.rays.in_front(parts(state)[0]):
                return np.inf, None
            return gauss_newton(residuals(state), lambda: jacobian(state))

        state = np.append(first, np.zeros(open_lines * self.count))
        start_rms = _rms(self.angles(*parts(state)))
        state, _, converged = descend(
            evaluate, lambda state, step: state + step, state,
            iterations=ITERATIONS, tolerance=AT_REST,
        )  # fmt: skip
        c, lines = parts(state)
        camera = camera_of_shape(self.start.viewer, self.grid, c, self.quantity)
        rms = _rms(self.angles(c, lines))
        return EdgeUpdate(camera, start_rms, rms, self.count, converged)


def _rms(values):
    return float(np.sqrt(np.mean(values**2)))
