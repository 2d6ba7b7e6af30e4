"""Errors a user can act on; their text is one line: where, what, and what to do."""

import difflib


class InputError(Exception):
    """Bad data from outside: names file and field, what was found, what to do.

    `code` names the kind of problem for programs (`parallel-grids`); the message is for
    people and may change.
    """

    code = "bad-input"

    def __init__(self, message: str, *, code: str | None = None):
        super().__init__(message)
        if code is not None:
            self.code = code


class CalibrationError(InputError):
    """Well-formed data that cannot determine the camera; the message says why."""

    code = "not-determined"


def did_you_mean(name, known):
    """'did you mean x?' where one of the known names is close, else ''."""
    near = difflib.get_close_matches(str(name), list(known), n=1)
    return f"did you mean {near[0]}?" if near else ""
