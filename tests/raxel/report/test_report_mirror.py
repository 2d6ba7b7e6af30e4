"""The report of a mirror set: positions of residuals and heights."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.mirror.bundle import bundle_stages
from raxel.cameras import SplineMirrorCamera
from raxel.report.mirror import _counted, heights, shape_figure
from tests.mirror_scenes import spline_camera
from tests.raxel.calibration.test_bundle_stages import noisy, own_space, shaken


def test_residuals_of_a_partial_board_are_at_its_corners():
    """Missing corners, and those outside the knots, have none."""
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


@pytest.fixture(scope="module")
def stages():
    """A flat mirror, the same one hundredth of the way nearer, and a bent one."""
    first = spline_camera(deflection=0.0)
    nearer = SplineMirrorCamera.on_grid(
        first.viewer, first.grid, first.coefficients.ravel("F") / 0.99
    )
    return SimpleNamespace(cameras=[first, nearer, spline_camera(deflection=10.0)])


def test_heights_are_above_the_first_mirror_towards_the_camera(stages):
    first = stages.cameras[0]
    middle = np.array([[first.width / 2, first.height / 2]])
    pixels = middle + np.random.default_rng(0).uniform(-200, 200, (200, 2))
    S = first.rays(pixels).origins
    normal = np.linalg.svd(S - S.mean(axis=0))[2][2]
    np.testing.assert_allclose(heights(stages, 0, pixels), 0, atol=1e-6)
    found = heights(stages, 1, pixels)
    np.testing.assert_allclose(found, 0.01 * np.abs(S @ normal), rtol=1e-3)


def test_shape_figure_has_contours_at_their_heights(stages):
    stages.bundle = SimpleNamespace(corners=[[], [], np.zeros((0, 2))])
    size = stages.cameras[0].height, stages.cameras[0].width
    axes = shape_figure(np.zeros(size, np.uint8), stages, 2).axes[0]
    (lines,) = axes.collections
    for level, path in zip(lines.levels, lines.get_paths(), strict=True):
        some = path.vertices[:: max(1, len(path.vertices) // 50)]
        # Half a pixel of the image is 0.008 mm.
        np.testing.assert_allclose(heights(stages, 2, some), level, atol=4e-3)
