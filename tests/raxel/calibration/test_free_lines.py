"""Lines of pixels: which there are, and how they follow the poses of the grids."""

from types import SimpleNamespace

import numpy as np

from raxel.calibration import adjust_consistent, relax_centrality
from raxel.calibration.adjust.free_lines import (
    _chosen,
    _determined,
    _moved,
    _normal_equations,
)
from raxel.geometry import intersect_rays_plane, pose, rotation_from_vector
from tests.calibration_scenes import scene


def test_line_offsets_follow_poses():
    centre, T, _, points = scene(3, grids=4, count=20)
    points = points + np.random.default_rng(3).normal(0, 0.01, points.shape)
    central = adjust_consistent(points, None, centre, T, sigma=0.01)
    lines = relax_centrality(points, central, tolerance=1e-9)

    def offsets(step):
        again = _chosen(points, central, lines.used)
        for _ in range(6):
            _normal_equations(again, _moved(lines.T_base_grid, step))
        return again.unknowns[:, :2]

    step = 1e-5 * np.random.default_rng(5).standard_normal(18)
    due = (offsets(step) - offsets(-step)) / 2
    reported = lines.offset_of_poses[lines.used] @ step
    np.testing.assert_allclose(reported, due, atol=1e-3 * np.abs(due).max())


def test_crossing_grids_determine_no_line():
    """Three grids that have the line y = 0 in common, 500 mm ahead of the centre."""
    T = np.stack(
        [pose(rotation_from_vector([a, 0, 0]), [0, 0, 500.0]) for a in (-0.5, 0, 0.5)]
    )
    y = np.array([-80.0, -40, -2, 0.5, 3, 40, 80])
    rays = np.column_stack([np.linspace(-60, 60, 7), y, np.full(7, 500.0)])
    points = intersect_rays_plane(np.zeros(3), rays, T).points
    central = SimpleNamespace(T_base_grid=T, centre=np.zeros(3))
    known = _determined(points, np.ones((3, 7), bool), central)
    np.testing.assert_array_equal(known, np.abs(y) > 30)
