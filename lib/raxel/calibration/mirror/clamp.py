"""The clamped edge: what of a mirror's shape no bending changes (5.1.3).

At the clamp a mirror keeps its place and, what the thesis says of the beam (5.1) but
does not use, its slope. Both are linear in the coefficients of a spline, so the clamp
is kept exactly: coefficients are c_P + C_B Phi (5.21), in the linear stage and in the
refinement. Points along a line give as many equations as the spline has functions along
it when the line runs along an axis of the knots; of a slanted one some equations barely
stand alone, and those are left out. A line that only stands in for a hidden clamp moves
a little: its equations then count with their standard deviations.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.clamp_line import FixedLine
from raxel.calibration.mirror.prior import PriorRows
from raxel.errors import CalibrationError

# Of the largest singular value: equations below it are what noise makes of others.
TRUNCATION = 1e-2
OUTSIDE = "clamp: some of its points lie outside the knots; let the knots span them"


class Clamp(NamedTuple):
    """Places of the picture whose mirror points stay where they are.

    points: (M, 2) normalised image coordinates. values: (M,) of the quantity there,
    mm or 1 / mm. slopes: (M, 2), its derivatives by the points' two coordinates, or
    None where only the position is held.
    """

    points: np.ndarray
    values: np.ndarray
    slopes: np.ndarray | None = None


class Subspace(NamedTuple):
    """Coefficients `particular` + `directions` @ Phi: (K,), (K, F); F may be K."""

    particular: np.ndarray
    directions: np.ndarray

    def coefficients(self, free):
        """(K,) from the free unknowns Phi (F,)."""
        return self.particular + self.directions @ free

    def free(self, coefficients):
        """Phi (F,) of the coefficients nearest to those given (K,)."""
        return self.directions.T @ (coefficients - self.particular)


def clamp_of_camera(camera, pixels, *, slope=True):
    """The Clamp that a calibrated SplineMirrorCamera has at pixels (M, 2) of its edge.

    Read it once, from the primary calibration: read anew at every stage it would
    drift. Raises CalibrationError where a pixel lies outside the knots.
    """
    seen = camera.viewer.rays(np.asarray(pixels, float)).directions
    points = seen[:, :2] / seen[:, 2:]
    inside = camera.grid.inside(points)
    if len(points) == 0 or not inside.all():
        raise CalibrationError(
            f"clamp: {np.count_nonzero(~inside)} of {len(points)} pixels lie outside "
            "the knots of the camera; give pixels of the edge that the mirror's "
            "picture holds",
            code="outside-knots",
        )
    b, b_x, b_y = camera.grid.rows(points)
    c = camera.coefficients.ravel("F")
    slopes = np.column_stack([b_x @ c, b_y @ c]) if slope else None
    return Clamp(points, b @ c, slopes)


def clamped(grid, clamp, truncation=TRUNCATION):
    """The Subspace of a SplineGrid's coefficients that keep a Clamp (5.19-5.21).

    clamp: Clamp or FixedLine, or None for the whole space. truncation: of the largest
    singular value; combinations of equations below it are left out. Raises
    CalibrationError for points of the clamp outside the knots.
    """
    if clamp is None:
        return Subspace(np.zeros(grid.size), np.eye(grid.size))
    rows, values = _equations(grid, clamp)
    if not np.isfinite(rows).all():
        raise CalibrationError(OUTSIDE, code="outside-knots")
    U, size, Vt = np.linalg.svd(rows)
    rank = np.count_nonzero(size > truncation * size[0])
    particular = Vt[:rank].T @ ((U[:, :rank].T @ values) / size[:rank])
    return Subspace(particular, Vt[rank:].T)


def soft_clamp(grid, clamp):
    """PriorRows of a FixedLine, with its own deviations; None for a firm Clamp.

    Values, and slopes at right angles to the line unless `slopes` is None.
    """
    if not isinstance(clamp, FixedLine):
        return None
    b, b_x, b_y = grid.rows(clamp.points)
    if not np.isfinite(b).all():
        raise CalibrationError(OUTSIDE, code="outside-knots")
    if clamp.slopes is None:
        return PriorRows(b, clamp.values, clamp.value_sd)
    u = clamp.u
    rows = np.vstack([b, u[0] * b_x + u[1] * b_y])
    values = np.concatenate([clamp.values, clamp.slopes @ u])
    return PriorRows(rows, values, np.concatenate([clamp.value_sd, clamp.slope_sd]))


def _equations(grid, clamp):
    """Rows (m, K) and values (m,); slopes times the width of a knot interval, so that
    they count as positions do."""
    b, b_x, b_y = grid.rows(clamp.points)
    if clamp.slopes is None:
        return b, clamp.values
    width = min(np.diff(breaks).min() for breaks in grid.breaks)
    rows = np.vstack([b, width * b_x, width * b_y])
    return rows, np.concatenate([clamp.values, *(width * clamp.slopes.T)])
