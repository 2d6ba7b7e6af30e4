"""The report of a mirror set: each residual stands at its own corner."""

import numpy as np

from raxel.calibration.mirror.bundle import bundle_stages
from raxel.report.mirror import _counted
from tests.test_calibration_bundle_stages import noisy, own_space, shaken


def test_residuals_of_a_board_seen_in_part_stand_at_its_corners():
    """Some corners are not found, others lie beyond the knots: neither has one."""
    cameras, clamp, views = own_space()
    starts, T = shaken(cameras)
    views = noisy(views, 2)
    pixels = views[2].view.pixels.copy()
    seen = np.flatnonzero(np.isfinite(pixels[:, 0]))
    pixels[seen[3]] = [2.0, 2.0]
    views[2] = views[2]._replace(view=views[2].view._replace(pixels=pixels))
    found = bundle_stages(starts, views, T, clamp=clamp)
    kept = pixels[np.delete(seen, 3)]
    assert 50 < len(kept) < len(pixels)
    assert len(found.residuals[2]) == len(kept)
    np.testing.assert_array_equal(_counted(found.cameras[1], pixels), kept)
