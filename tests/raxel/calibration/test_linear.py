"""Table 2.1 and the linear stage, in both variants."""

import numpy as np
import pytest

from raxel.calibration.linear.standard import (
    bilinear_products,
    coefficient_vectors,
    linear_as_printed,
    linear_well_conditioned,
    solve_coefficients,
    table_2_1,
)
from raxel.errors import CalibrationError
from raxel.geometry.poses import angle_between_rotations, pose, rotation_from_vector
from tests.calibration_scenes import meet_grids, scene
from tests.raised import raises_code


def assert_recovered(solution, centre, T_base_grid, length=1e-6, angle=1e-8):
    assert np.linalg.norm(solution.centre - centre) < length
    assert np.abs(solution.T_base_grid[:, :3, 3] - T_base_grid[:, :3, 3]).max() < length
    turns = angle_between_rotations(
        solution.T_base_grid[:, :3, :3], T_base_grid[:, :3, :3]
    )
    assert turns.max() < angle


@pytest.mark.parametrize("seed", range(3))
def test_table_2_1_vanishes_with_corrected_row_3(seed):
    centre, T, _, points = scene(seed)
    rows = table_2_1(centre, T[1], T[2])
    printed = table_2_1(centre, T[1], T[2], row_3="printed")
    for row, k in zip(range(4), (1, 1, 2, 2), strict=True):
        products = bilinear_products(points[0], points[k])
        size = np.abs(products * rows[row]).max()
        assert np.abs(products @ rows[row]).max() < 1e-13 * size
        if row in (1, 3):
            assert np.abs(products @ printed[row]).max() > 1e-3 * size
    # Rows V and M have no entry i = 3: nothing to misprint.
    assert np.array_equal(printed[[0, 2]], rows[[0, 2]])


def test_solved_coefficients_match_table_up_to_scale():
    centre, T, _, points = scene(4)
    for k in (1, 2):
        *solved, noise = solve_coefficients(points[0], points[k])
        assert noise < 1e-9
        true = coefficient_vectors(centre, T[k])
        for s, t in zip(solved, true, strict=True):
            t = t / np.linalg.norm(t)
            assert np.abs(s - t * np.sign(s @ t)).max() < 1e-9


CENTRES = [(10.0, -20.0, 600.0), (0.0, 0.0, 600.0), (60.0, 50.0, -300.0)]


@pytest.mark.parametrize("centre", CENTRES)
@pytest.mark.parametrize("seed", range(4))
def test_well_conditioned_is_exact_on_exact_data(centre, seed):
    centre, T, _, points = scene(seed, centre)
    solution = linear_well_conditioned(points, side=np.sign(centre[2]))
    assert_recovered(solution, centre, T)
    assert solution.degeneracy > 1e-3


@pytest.mark.parametrize("centre", CENTRES)
@pytest.mark.parametrize("seed", range(4))
def test_as_printed_is_exact_on_exact_data(centre, seed):
    centre, T, _, points = scene(seed, centre)
    side = np.sign(centre[2])
    assert_recovered(linear_as_printed(*points, side=side, tz="corrected"), centre, T)
    if centre[1] != 0:
        assert_recovered(linear_as_printed(*points, side=side), centre, T)


def test_as_printed_reports_division_by_c_y():
    _, _, _, points = scene(0, (0.0, 0.0, 600.0))
    with raises_code("zero-division"):
        linear_as_printed(*points, side=1)


def test_as_printed_reports_vanishing_ratio():
    centre = np.array([10.0, -20.0, 600.0])
    _, T, directions, _ = scene(1)
    T[1] = pose(rotation_from_vector([0.4, 0.0, 0.0]), [20.0, 10.0, -30.0])
    points, _ = meet_grids(centre, directions, T)
    with raises_code("zero-division"):
        linear_as_printed(*points, side=1)
    assert_recovered(linear_well_conditioned(points, side=1), centre, T)


def test_as_printed_reports_negative_square():
    messages = []
    for seed in range(30):
        _, _, _, points = scene(seed)
        noise = np.random.default_rng(seed).normal(size=points.shape)
        try:
            linear_as_printed(*(points + 3.0 * noise), side=1, tz="corrected")
        except CalibrationError as error:
            messages.append(str(error))
    assert any("C_z^2" in m and "negative" in m for m in messages)


def test_linear_stage_accepts_missing_rays():
    centre, T, _, points = scene(7, grids=6, count=500)
    seen = np.random.default_rng(7).random(points.shape[:2]) < 0.5
    seen[0] = True
    solution = linear_well_conditioned(
        np.where(seen[..., None], points, np.nan), side=1
    )
    assert_recovered(solution, centre, T)


def test_other_side_is_reflection_in_base_plane():
    centre, T, _, points = scene(2)
    mirrored = linear_well_conditioned(points, side=-1)
    flip = np.array([1.0, 1.0, -1.0])
    assert np.abs(mirrored.centre - flip * centre).max() < 1e-6
    assert np.abs(mirrored.T_base_grid[:, :3, 3] - flip * T[:, :3, 3]).max() < 1e-6
    assert np.allclose(np.linalg.det(mirrored.T_base_grid[:, :3, :3]), 1.0)


@pytest.mark.parametrize("noise", [0.0, 0.05])
@pytest.mark.parametrize(
    "vectors",
    [
        ([0, 0, 0], [0.3, 0.2, 0.1]),  # grid 2 parallel to the base
        ([0, 0, 0.5], [0.3, 0.2, 0.1]),  # the same, turned in its plane
        ([0.3, 0.2, 0.1], [0.3, 0.2, 0.1]),  # grids parallel to each other
    ],
)
def test_parallel_grids_are_rejected(vectors, noise):
    centre = np.array([10.0, -20.0, 600.0])
    _, T, directions, _ = scene(3)
    T[1:] = pose(
        rotation_from_vector(np.array(vectors, float)),
        np.array([[20.0, 30.0, -60.0], [-30.0, 10.0, 90.0]]),
    )
    points, _ = meet_grids(centre, directions, T)
    points += noise * np.random.default_rng(0).normal(size=points.shape)
    with raises_code("not-determined"):
        linear_well_conditioned(points, side=1)


def test_too_few_grids_or_rays_are_rejected():
    _, _, _, points = scene(0)
    line = points.copy()
    line[..., 1] = 2 * line[..., 0]
    for code, wrong in (
        ("too-few-grids", points[:2]),
        ("too-few-rays", points[:, :5]),
        ("degenerate-points", line),
    ):
        with raises_code(code):
            linear_well_conditioned(wrong, side=1)


def test_duplicate_points_do_not_count_as_rays():
    """N points determine five parameters; their residuals estimate the noise."""
    points = scene(0)[3][:2, :8]
    points = points + np.random.default_rng(2).normal(0, 0.1, points.shape)
    once, twice = (
        solve_coefficients(*np.tile(points, (1, times, 1)))[2] for times in (1, 2)
    )
    assert twice / once == pytest.approx(np.sqrt((8 - 5) / (16 - 5)))
