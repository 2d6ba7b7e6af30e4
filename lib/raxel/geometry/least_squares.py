"""Least squares by damped steps, for few parameters or after an elimination.

Levenberg-Marquardt, scaled by the diagonal of the normal equations: angles and lengths
are damped alike.
Source: Marquardt 1963, doi:10.1137/0111030.
"""

import numpy as np

from raxel.errors import CalibrationError

FIRST_DAMPING, MIN_DAMPING, MAX_DAMPING = 1e-6, 1e-12, 1e8


def descend(evaluate, move, state, *, iterations, tolerance, rounding=0.0):
    """Levenberg-Marquardt: the last state, its costs from the start on, convergence.

    evaluate: state -> cost, equations; equations() -> normal matrix, half the gradient,
    called only at the start of a step; move: (state, step) -> state. It ends when the
    cost decreases by less than the fraction `tolerance`, or is below `rounding`. Raises
    CalibrationError for an initial cost that is not finite.
    """
    cost, equations = evaluate(state)
    if not np.isfinite(cost):
        raise CalibrationError(
            "least squares: points and poses must be finite; remove NaN and infinity",
            code="not-finite",
        )
    costs, system = [cost], None
    damping = FIRST_DAMPING
    converged = cost <= rounding
    for _ in range(iterations):
        if converged:
            break
        system = system or equations()
        normal, gradient = system
        step = damped_step(normal, gradient, damping)
        trial = move(state, step)
        new, new_equations = evaluate(trial)
        if new < cost:
            converged = cost - new <= tolerance * cost or new <= rounding
            state, cost = trial, new
            equations, system = new_equations, None
            costs.append(cost)
            damping = max(damping / 10, MIN_DAMPING)
        else:
            # A step with a predicted decrease below rounding: at the minimum.
            converged = abs(step @ gradient) <= 1e-13 * cost
            damping *= 10
            if damping > MAX_DAMPING:
                break
    return state, np.array(costs), bool(converged)


def gauss_newton(residuals, jacobian):
    """Cost and equations, in the form that `descend` requires.

    residuals: (M,); jacobian: () -> (M, P).
    """

    def equations():
        J = jacobian()
        return J.T @ J, J.T @ residuals

    return residuals @ residuals, equations


def damped_step(normal, gradient, damping):
    """Marquardt step; the diagonal weighs angles against lengths."""
    diagonal = normal.diagonal()
    scale = np.sqrt(np.maximum(diagonal, 1e-12 * diagonal.max()))
    scaled = normal / (scale[:, None] * scale)
    scaled.flat[:: len(scale) + 1] += damping
    return -np.linalg.solve(scaled, gradient / scale) / scale
