"""What a viewer's own error may be: its scatter, or nothing where nobody tells it."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.parametric.zhang import calibrate_zhang
from raxel.cli import mirror
from raxel.evaluation.mirror_errors import viewers_aside
from tests.test_evaluation_stability import CAMERA, COUNT, SIZE, views_of


def numbers(camera):
    return np.array([*np.diag(camera.K)[:2], *camera.K[:2, 2], *camera.radial])


def test_viewers_aside_scatter_as_calibrations_do():
    found = []
    for seed in range(12):
        views = views_of(COUNT * [CAMERA], seed)
        found.append((calibrate_zhang(views, *SIZE).camera, views))
    off = np.array([numbers(camera) - numbers(CAMERA) for camera, _ in found])
    stated = []
    for camera, views in found[:4]:
        aside = viewers_aside(camera, views)
        assert len(aside) == 6
        steps = np.array([numbers(one) - numbers(camera) for one in aside])
        stated.append(np.sqrt(np.sum(steps**2, axis=0)))
    happened = np.sqrt(np.mean(off**2, axis=0))
    # Twelve draws tell a deviation to a fifth, and terms of a lens hang together.
    assert np.log(happened / np.median(stated, axis=0)) == pytest.approx(0, abs=0.6)


def test_a_viewer_from_a_file_has_an_error_that_nobody_states():
    given = SimpleNamespace(viewer="camera.npz")
    assert mirror._viewers_aside(given, None, None) == []
    stage = {"residual_mm": {"mean": 0.1, "sd": 0.1}}
    stage["predicted_ray_error_deg"] = {"median": 0.02, "largest": 0.03}
    primary = {"grids": [], "points_from_rays_mm": 0.1}
    result = {"primary": primary, "stages": [stage], "viewer_error_counted": False}
    *_, line = mirror._lines(SimpleNamespace(name="set"), result)
    assert line.endswith(
        "0.030 at most, without the viewer's own error, which nobody states"
    )
