"""Rendered images against truth: corners of every camera, areas, sums, refusals."""

import importlib

import numpy as np
import pytest

from lab_cameras import EVERY, H, W
from raxel.cameras import CAMERAS, FisheyeCamera, OrthographicCamera, PerspectiveCamera
from raxel.features.detector import refine
from raxel.geometry import pose, rotation_from_vector, transform
from raxel.lab import (
    Laboratory,
    Plain,
    Rectangle,
    Sensor,
    TexturedScene,
    board_scene,
    render,
    trace,
)
from raxel.lab import render as render_function
from raxel.lab.optics import Crop, Optics, Raster, Sight
from raxel.lab.rendering import PixelMeans, lattice
from raxel.lab.textures import ChessboardTexture, Panels, Texture, Tiles
from raxel.sets import Chessboard
from tests.corner_check import board_before, fitted_corners
from tests.raised import raises_line

HERE = np.eye(4)
# Looks along z; the pixel (u, v) sees the square around (u, v) mm.
ORTHO = OrthographicCamera(1, (0, 0), 12, 10)


class Slope(Texture):
    """Radiance that rises linearly: its mean over a pixel is its middle's."""

    def radiance(self, uv, cosine):
        """A thousandth per mm."""
        return 0.5 + 0.001 * uv[:, 0]


def flat(texture, rectangle=(40, 40, (-20, -20)), background=0.0):
    """A texture in the plane z = 100 before the orthographic camera."""
    T = pose(np.eye(3), [0, 0, 100])
    return TexturedScene(((Rectangle(T, *rectangle), texture),), background)


def test_every_camera_kind_renders():
    assert {camera.kind for camera, _ in EVERY.values()} == set(CAMERAS)


@pytest.mark.parametrize("name", EVERY)
def test_rendered_corners_match_projections(name):
    """Well within the required 0.02 px: the fit itself leaves a few thousandths."""
    camera, positions = EVERY[name]
    for middle in positions:
        board, T = board_before(camera, middle)
        image = render(camera, HERE, board_scene(board, T))
        corners = np.column_stack([board.points(), np.zeros(len(board.points()))])
        pixels = camera.project(transform(T, corners)).pixels
        found, misfit = fitted_corners(image, pixels)
        assert np.linalg.norm(found - pixels, axis=1).max() < 0.01
        assert misfit.max() < 0.005


def test_rendered_corners_are_detected():
    """cornerSubPix is biased by sharp edges, so the board is softened by 1 px here."""
    import cv2

    camera = PerspectiveCamera(
        [[500, 0, 199.5], [0, 500, 149.5], [0, 0, 1]], [], 400, 300
    )
    board = Chessboard(7, 5, 10.0)
    R = rotation_from_vector([0.2, -0.2, 0.1])
    T = pose(R, [0, 0, 130] - R @ [30, 20, 0])
    image = cv2.GaussianBlur(render(camera, HERE, board_scene(board, T)), (0, 0), 1.0)
    truth = camera.project(transform(T, np.insert(board.points(), 2, 0, axis=1))).pixels
    error = refine((60000 * image).astype(np.uint16), truth + 0.3, 7, 5) - truth
    assert np.median(np.linalg.norm(error, axis=1)) < 0.02
    assert np.abs(error.mean(axis=0)).max() < 0.01


@pytest.mark.parametrize("x", [0.0, 0.137, 0.4999, -0.32])
def test_edge_pixel_value_is_covered_area(x):
    board = ChessboardTexture(3, 3, 4.0, 4.0, black=0.0, white=1.0)
    scene = TexturedScene(
        ((Rectangle(pose(np.eye(3), [x, 0, 100]), 40, 40, (-20, -20)), board),)
    )
    image = render(ORTHO, HERE, scene)
    # The edge at u = 0 + x; the pixel at (0, 1) holds black (left is white here).
    assert image[1, 0] == pytest.approx(0.5 - x, abs=1e-6)
    # The saddle lies at (x, 0): quarters of the pixel (0, 0).
    black = 0.5 * (0.5 + x) + 0.5 * (0.5 - x)
    assert image[0, 0] == pytest.approx(1 - black, abs=1 / 64)
    many = render(ORTHO, HERE, scene, samples=4096)
    assert many[0, 0] == pytest.approx(1 - black, abs=1e-3)


@pytest.mark.parametrize("angle", [0.0, 0.2, 0.7, np.pi / 4, 1.1])
def test_oblique_edge_coverage_is_exact(angle):
    T = pose(rotation_from_vector([0, 0, angle]), [3.21, 4.37, 100])
    half = Panels(0.0, [(0, -1e3, 1e3, 1e3, 1.0)])
    scene = TexturedScene(((Rectangle(T, 2e3, 2e3, (-1e3, -1e3)), half),))
    image = render(ORTHO, HERE, scene)
    fine = (np.arange(400) + 0.5) / 400 - 0.5
    v, u = np.mgrid[:10, :12]
    for row, column in zip(*np.nonzero((image > 0) & (image < 1)), strict=True):
        y, x = np.meshgrid(row + fine - 4.37, column + fine - 3.21, indexing="ij")
        share = np.mean(np.cos(angle) * x + np.sin(angle) * y > 0)
        assert image[row, column] == pytest.approx(share, abs=2e-3)
    assert set(np.unique(image[(np.abs(u - 3.21) + np.abs(v - 4.37)) > 99])) <= {0, 1}


def test_surface_border_is_unbiased():
    scene = flat(Plain(1.0), (6.4, 5.3, (1.27, 2.18)))
    image = render(ORTHO, HERE, scene)
    # One part in twice the number of samples on each side, whatever its place.
    assert image.sum() == pytest.approx(6.4 * 5.3, abs=24 / 128)
    many = render(ORTHO, HERE, scene, samples=4096)
    assert many.sum() == pytest.approx(6.4 * 5.3, abs=24 / 8192)


def test_image_sum_is_independent_of_edge_position():
    board = ChessboardTexture(5, 4, 1.0, 1.0, black=0.0, white=1.0)
    corner, size = board.extent
    sums = []
    for shift in ([0, 0], [0.2, 0.7], [-0.41, 0.13]):
        camera = OrthographicCamera(5, [30 + shift[0], 30 + shift[1]], 80, 70)
        scene = TexturedScene(((Rectangle(HERE, *size, corner), board),))
        sums.append(render(camera, pose(np.eye(3), [0, 0, -50]), scene).sum())
    black = 15 * 25
    assert np.ptp(sums) < 2
    assert sums[0] == pytest.approx(25 * size.prod() - black, rel=2e-3)


def test_diffuse_radiance_is_albedo():
    camera = FisheyeCamera("equidistance", 60, (79.5, 59.5), 160, 120, 1.5)
    T = pose(rotation_from_vector([0.6, 0.3, 0]), [0, 0, 10])
    scene = TexturedScene(((Rectangle(T, 1e4, 1e4, (-5e3, -5e3)), Plain(0.37)),))
    image = render(camera, HERE, scene)
    assert set(np.unique(image)) >= {np.float32(0.37)}
    assert image.max() == np.float32(0.37)


def test_pixels_without_ray_are_black():
    camera = FisheyeCamera("equisolid", 20, (31.5, 23.5), 64, 48, 1.0)
    tiles = Tiles((7, 5), [(0.9, 0.2, 0.1), (0.2, 0.3, 0.8)], 0.5, 0.4, shift=0.5)
    T = pose(np.eye(3), [-60, -60, 40])
    scene = TexturedScene(((Rectangle(T, 120, 100), tiles),), (0.3, 0.6, 0.9))
    colour = render(camera, HERE, scene, colour=True)
    grey = render(camera, HERE, scene)
    assert colour.shape == (48, 64, 3)
    assert grey.shape == (48, 64)
    assert (grey[0, :3] == 0).all()
    np.testing.assert_allclose(grey, colour @ [0.2126, 0.7152, 0.0722], atol=1e-6)


def test_row_blocks_do_not_change_image(monkeypatch):
    camera, positions = EVERY["stereographic"]
    board, T = board_before(camera, positions[0])
    scene = board_scene(board, T)
    whole = render(camera, HERE, scene)
    module = importlib.import_module("raxel.lab.rendering")
    monkeypatch.setattr(module, "RAYS_PER_BLOCK", 7 * W)
    np.testing.assert_array_equal(render(camera, HERE, scene), whole)
    assert whole.shape == (H, W)


def test_image_exceeding_memory_is_rejected():
    huge = PerspectiveCamera([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [], 10**6, 10**6)
    for function in (render_function, trace):
        with raises_line("1000000 x 1000000 px"):
            function(huge, HERE, flat(Plain(0.5)))


def test_renderings_are_independent():
    camera, positions = EVERY["equidistance"]
    board, T = board_before(camera, positions[0])
    scene = board_scene(board, T)
    optics = Optics(blur_sd_px=(0.5, 1.0), chromatic_scale=(1.002, 1, 0.998))
    one = Laboratory(camera, Sensor(1e4, 1.2e4), optics)
    one.render(scene, pose(np.eye(3), [5, 0, 0]), np.random.default_rng(0))
    again = one.render(scene, HERE, np.random.default_rng(1))
    other = Laboratory(camera, Sensor(1e4, 1.2e4), optics)
    assert np.array_equal(again, other.render(scene, HERE, np.random.default_rng(1)))


def test_grid_cells_match_binary_search():
    rng = np.random.default_rng(2)
    patches = [
        (*low, *(low + rng.uniform(1, 9, 2)), 0.5) for low in rng.normal(0, 9, (4, 2))
    ]
    for texture in (ChessboardTexture(5, 4, 3.0, 1.0), Panels(0.1, patches)):
        uv = np.append(
            rng.normal(0, 9, (3000, 2)), [[np.nan, 0.0], [1e300, -1e300]], axis=0
        )
        uv = np.append(uv, [[texture.lines[0][1], texture.lines[1][2]]], axis=0)
        column, row = (
            np.searchsorted(lines, position, side="right")
            for lines, position in zip(texture.lines, uv.T, strict=True)
        )
        known = np.isfinite(uv).all(axis=1)
        cells = row * (len(texture.lines[0]) + 1) + column
        np.testing.assert_array_equal(texture.label(uv)[known], cells[known])


class Bent:
    """Sees uv = (u^2, v^2) at (u, v), on one part."""

    scene = TexturedScene((), 0.0)

    def look(self, pixels):
        no_rays = np.zeros(len(pixels))
        return Sight(no_rays.astype(np.int16), pixels**2, no_rays + 1)


class Middle(Texture):
    """Its mean over a footprint is taken for the place of the footprint's middle."""

    averages = True

    def radiance(self, uv, cosine):
        return uv[:, 0]

    def average(self, uv, across, down, cosine):
        return uv[:, 0]


def test_pixel_mean_on_curved_map_is_exact():
    pixels = np.array([[50.0, 70.0], [90.0, 60.0]])
    ring = pixels[:, None] + 0.5 * np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]])
    corners = Bent().look(ring.reshape(-1, 2)).reshaped(2, 4)
    means = PixelMeans(Bent(), lattice(16))
    found = means.mean_inside(pixels, corners, [Middle()], False)
    # The mean of u^2 over a pixel's side is that of its middle and 1 / 12.
    np.testing.assert_allclose(found, pixels[:, 0] ** 2 + 1 / 12, atol=1e-3)


def test_one_trace_shades_several_textures():
    traced = trace(ORTHO, HERE, flat(Plain(0.0)))
    u = np.arange(12) * np.ones((10, 1))
    np.testing.assert_allclose(traced.shade({0: Slope()}), 0.5 + 0.001 * u, atol=1e-6)
    board = ChessboardTexture(3, 3, 1.7, 1.0)
    np.testing.assert_array_equal(
        traced.shade({0: board}), render(ORTHO, HERE, flat(board))
    )
    assert (traced.shade() == 0).all()


@pytest.mark.parametrize("window", [None, Crop(3, 11, 8, 6, 40, 30)])
@pytest.mark.parametrize("fineness", [1, 2, 3])
def test_subpixels_are_centred(fineness, window):
    """Their middles are those of equal parts of it, and their mean is its own."""
    camera = PerspectiveCamera([[50.0, 0, 17], [0, 60.0, 12], [0, 0, 1]], [], 40, 30)
    raster = Raster(camera, fineness, window)
    first = [0, 0] if window is None else [window.u, window.v]
    parts = (np.arange(fineness) + 0.5) / fineness - 0.5
    u, v = np.meshgrid(2 + parts, 1 + parts)
    here = np.column_stack([u.ravel(), v.ravel()])
    fine = [np.arange(n * fineness, (n + 1) * fineness) for n in (2, 1)]
    across, down = np.meshgrid(*fine)
    pixels = np.column_stack([across.ravel(), down.ravel()]).astype(float)
    wanted = camera.rays(here + first).directions
    for found in (raster.rays(pixels), raster.grid(*(f.astype(float) for f in fine))):
        np.testing.assert_allclose(found.directions, wanted, atol=1e-7)
    assert raster.width == fineness * (40 if window is None else 8)
    assert raster.height == fineness * (30 if window is None else 6)
