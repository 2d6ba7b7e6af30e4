"""The synthetic chessboard of 3.3.1 shows its corners where it says."""

import numpy as np
import pytest

from chapters.shared.grids.synthetic_board import SyntheticBoard, clicks
from tests.corner_check import fitted_corner


@pytest.mark.parametrize(
    "board", [SyntheticBoard(), SyntheticBoard(50.0), SyntheticBoard(yaw_deg=40.0)]
)
def test_image_corners_are_the_true_ones(board):
    image = board.image(blur_px=0.0).astype(float) / 255
    lattice = board.corners.reshape(board.rows, board.columns, 2)
    along = np.gradient(lattice, axis=1)
    down = np.gradient(lattice, axis=0)
    middle = board.rows // 2
    for row, column in ((middle, middle), (middle, 1), (1, 1)):
        angles = [
            np.arctan2(-a[row, column, 0], a[row, column, 1]) for a in (along, down)
        ]
        corner, _ = fitted_corner(image, lattice[row, column] + [0.2, -0.1], angles)
        # Rounding to 8 bits and bent edges leave a few hundredths of a pixel.
        assert np.linalg.norm(corner - lattice[row, column]) < 0.03


def test_flat_board_diagonal_spans_the_field_of_view():
    assert 2 * np.arctan(500 * np.sqrt(2) / SyntheticBoard().focal_px) == pytest.approx(
        np.radians(134)
    )


def test_board_plane_reaches_the_camera_at_the_limiting_yaw():
    limit = np.degrees(np.arcsin(SyntheticBoard().focal_px / 400))
    assert not np.isnan(SyntheticBoard(yaw_deg=limit - 0.1).corners).any()
    assert np.isnan(SyntheticBoard(yaw_deg=limit + 0.1).corners).any()


def test_yaw_keeps_the_symmetry_of_top_and_bottom():
    board = SyntheticBoard(yaw_deg=30.0)
    lattice = board.corners.reshape(board.rows, board.columns, 2)
    np.testing.assert_allclose(lattice[::-1, :, 1], 999 - lattice[:, :, 1], atol=1e-9)
    np.testing.assert_allclose(lattice[::-1, :, 0], lattice[:, :, 0], atol=1e-9)


def test_lattice_is_indexed_by_row_and_column():
    board = SyntheticBoard(50.0)
    row_by_row = board.corners[3 * board.columns + 5]
    np.testing.assert_array_equal(board.lattice[3, 5], row_by_row)
    points = board.coordinates.reshape(-1, 2)
    assert points[board.columns + 2].tolist() == [2, 1]
    np.testing.assert_allclose(board.place(points), board.corners, atol=1e-9)


def test_outer_corners_are_clockwise_from_upper_left():
    u, v = SyntheticBoard().outer_corners.T
    assert np.all(u[[0, 3]] < u[[1, 2]])
    assert np.all(v[[0, 1]] < v[[3, 2]])


def test_noise_has_its_sd_and_levels_are_kept():
    board = SyntheticBoard()
    clean = board.image(levels=(64.0, 191.0)).astype(float)
    noisy = board.image(
        noise_sd=10.0, rng=np.random.default_rng(1), levels=(64.0, 191.0)
    ).astype(float)
    assert (clean.min(), clean.max()) == (64, 191)
    # Rounding adds a variance of 1/12.
    assert (noisy - clean).std() == pytest.approx(np.hypot(10, 1 / 12**0.5), rel=0.01)


def test_clicks_scatter_within_the_cap():
    rng = np.random.default_rng(5)
    truth = SyntheticBoard().outer_corners
    offsets = np.array([clicks(truth, rng) - truth for _ in range(2000)])
    lengths = np.linalg.norm(offsets, axis=2)
    assert lengths.max() <= 4.0
    # Mean length of a Rayleigh law of 2 px cut off at 4 px.
    r = np.linspace(0, 4, 4001)
    density = r * np.exp(-(r**2) / 8)
    assert lengths.mean() == pytest.approx(
        (r * density).sum() / density.sum(), rel=0.02
    )
