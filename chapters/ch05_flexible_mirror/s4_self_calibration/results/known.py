"""Errors over many steps of a mirror that moves back and forth."""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.trials.known import STEPS


def errors_of(result, way):
    """Mean ray angles (STEPS, seeds), degrees; nan from a rejected step on."""
    return np.array([result.column(f"{way}.step{k}") for k in range(1, STEPS + 1)])


def slopes(result, way):
    """Slopes (seeds,) of the error, % of its mean per step.

    The mean at each of both deflections is 100 %. A rejected run counts as the worst
    of the others.
    """
    errors = errors_of(result, way)
    relative = np.empty_like(errors)
    for place in (0, 1):
        mine = errors[place::2]
        relative[place::2] = 100 * mine / np.mean(mine, axis=0)
    step = np.arange(STEPS) - (STEPS - 1) / 2
    # Both deflections have equal means: only the order of the steps gives a slope.
    found = step @ relative / (step @ step)
    return np.where(np.isfinite(found), found, np.nanmax(found))
