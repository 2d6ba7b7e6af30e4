"""Checks of small images, with as many windows as they hold."""

import pytest

from raxel.features.active_grid.checks import redundancy


@pytest.fixture(autouse=True, scope="module")
def few_windows():
    """Images of 200 x 150 px hold about 200 groups of windows side by side; the 800 of
    a large image would overlap."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(redundancy, "N_WINDOWS", 200)
        yield
