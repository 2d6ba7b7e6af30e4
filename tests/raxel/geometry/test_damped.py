"""Damped least squares: a curved valley, units, and an invalid start."""

import numpy as np

from raxel.geometry.least_squares import damped_step, descend, gauss_newton
from tests.raised import raises_code

STOP = {"iterations": 200, "tolerance": 1e-15, "rounding": 1e-28}


def rosenbrock(state):
    x, y = state
    return gauss_newton(
        np.array([10 * (y - x * x), 1 - x]),
        lambda: np.array([[-20 * x, 10.0], [-1.0, 0.0]]),
    )


def test_descent_follows_curved_valley():
    found, costs, converged = descend(rosenbrock, np.add, np.array([-1.2, 1.0]), **STOP)
    np.testing.assert_allclose(found, 1, atol=1e-12)
    assert converged
    assert np.all(np.diff(costs) < 0)


def test_damped_step_is_independent_of_units():
    jacobian = np.random.default_rng(5).normal(size=(9, 3))
    residuals, units = np.arange(9.0), np.array([1.0, 1e-3, 1e3])
    _, plain = gauss_newton(residuals, lambda: jacobian)
    _, scaled = gauss_newton(residuals, lambda: jacobian * units)
    np.testing.assert_allclose(
        damped_step(*scaled(), 0.1) * units, damped_step(*plain(), 0.1), rtol=1e-12
    )


def test_non_finite_start_is_rejected():
    with raises_code("not-finite"):
        descend(rosenbrock, np.add, np.array([np.nan, 1.0]), **STOP)


def test_large_constant_residual_does_not_stop_descent():
    """An angle falls to zero next to a residual of 100; the undamped step climbs."""
    found, *_ = descend(
        lambda x: gauss_newton(
            np.array([np.arctan(x[0]), 100.0]),
            lambda: np.array([[1 / (1 + x[0] ** 2)], [0]]),
        ),
        np.add,
        np.array([3.0]),
        **STOP,
    )
    assert abs(found[0]) < 1e-4
