"""Errors a user can act on; their text is one line: where, what, and what to do."""


class InputError(Exception):
    """Bad data from outside: names file and field, what was found, what to do."""


class CalibrationError(InputError):
    """Well-formed data that cannot determine the camera; the message says why."""
