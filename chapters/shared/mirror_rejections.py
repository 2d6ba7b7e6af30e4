"""Runs that end before their first stage."""

from functools import partial

from raxel.errors import CalibrationError


def by_code(run):
    """The run (rig, bench, errors, seed) of which nothing is left but the code of the
    error, `refused`, where its primary stage is rejected."""
    return partial(_by_code, run)


def _by_code(run, *given):
    try:
        return run(*given)
    except CalibrationError as refusal:
        return {"refused": refusal.code}
