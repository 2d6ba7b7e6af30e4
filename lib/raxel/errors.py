"""Errors a user can act on; their text is one line: where, what, and what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class InputError(Exception):
    """Report bad data from outside: file and field, what was found, what to do.

    Parameters
    ----------
    message : str
        One line for people. The text may change.
    code : str or None
        Kind of the problem for programs, such as ``parallel-grids``.

    Attributes
    ----------
    code : str
        Kind of the problem, ``bad-input`` by default.
    """

    code = "bad-input"

    def __init__(self, message: str, *, code: str | None = None) -> None:
        super().__init__(message)
        if code is not None:
            self.code = code


class CalibrationError(InputError):
    """Report well-formed data that do not determine the camera.

    The message states the reason.

    Attributes
    ----------
    code : str
        Kind of the problem, ``not-determined`` by default.
    """

    code = "not-determined"


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Return 'did you mean x?' for the closest known name, or ''.

    Parameters
    ----------
    name : object
        The name that was found.
    known : Iterable of str
        The valid names.

    Returns
    -------
    str
        The question, or '' where no known name is close.
    """
    near = difflib.get_close_matches(str(name), list(known), n=1)
    return f"did you mean {near[0]}?" if near else ""
