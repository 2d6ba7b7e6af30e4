"""Least squares by damped steps, for few parameters or for what elimination has left.

Levenberg-Marquardt with the scaling of the normal equations' diagonal: angles and
lengths are damped alike.
Source: Marquardt 1963, doi:10.1137/0111030.
"""

import numpy as np

from raxel.errors import CalibrationError

FIRST_DAMPING, MIN_DAMPING, MAX_DAMPING = 1e-6, 1e-12, 1e8


def descend(evaluate, move, state, *, iterations, tolerance, rounding=0.0):
    """Levenberg-Marquardt: the last state, its costs from the start on, convergence.

    evaluate: state -> cost, equations; equations() -> normal matrix, half the gradient,
    asked for only where a step begins; move: (state, step) -> state. It ends when the
    cost falls by less than the share `tolerance`, or below `rounding`, where it cannot
    fall any more. Raises CalibrationError for a start whose cost is not finite.
    """
    cost, equations = evaluate(state)
    if not np.isfinite(cost):
        raise CalibrationError(
            "least squares: the points or poses are not finite", code="not-finite"
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
            # A step that promised a decrease below rounding: already at the minimum.
            converged = abs(step @ gradient) <= 1e-13 * cost
            damping *= 10
            if damping > MAX_DAMPING:
                break
    return state, np.array(costs), bool(converged)


def gauss_newton(residuals, jacobian):
    """Cost and equations, as `descend` wants them.

    residuals: (M,); jacobian: () -> (M, P).
    """

    def equations():
        J = jacobian()
        return J.T @ J, J.T @ residuals

    return residuals @ residuals, equations


def damped_step(normal, gradient, damping):
    """Marquardt step; the diagonal weighs angles against lengths."""
    diagonal = np.diag(normal)
    scale = np.sqrt(np.maximum(diagonal, 1e-12 * np.max(diagonal)))
    scaled = normal / np.outer(scale, scale) + damping * np.eye(len(normal))
    return -np.linalg.solve(scaled, gradient / scale) / scale
