"""Errors a user can act on. Their text is one line: where, what was found, what to do."""


class InputError(Exception):
    """Bad data from outside: the message names file, field, what was found, what to do."""


class CalibrationError(InputError):
    """Data that is well formed but cannot determine the camera; the message says why."""
