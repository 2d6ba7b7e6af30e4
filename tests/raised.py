"""Errors of the library are matched by their code; their sentences may change."""

import pytest

from raxel.errors import InputError


def raises_code(code):
    """Require an InputError with this code, in one line."""
    return pytest.raises(
        InputError, check=lambda e: e.code == code and str(e).isprintable()
    )


def raises_line(match):
    """Require an InputError whose message matches and is one line."""
    return pytest.raises(InputError, match=match, check=lambda e: str(e).isprintable())
