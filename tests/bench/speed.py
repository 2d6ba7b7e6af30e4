"""Times of the library's algorithms beside their peers: `make bench`.

Every group runs on one core but for what its name says. Without fringes its decoder is
left out.
"""

import os

import cv2
import numpy as np
import pytest

from raxel.calibration import (
    MirrorSettings,
    adjust_consistent,
    clamp_of_camera,
    linear_cgsp,
    linear_well_conditioned,
    update_mirror,
)
from raxel.features import DETECTORS
from raxel.features.active_grid import decode
from raxel.features.active_grid.errors import estimate_noise
from raxel.geometry import (
    intersect_rays_plane,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from tests.active_grids import drawn
from tests.bench import peers
from tests.bent_mirror_scenes import (
    GRID,
    bent,
    edge_pixels,
    grid_pose,
    seen,
    spline_like,
    visible_pixels,
)
from tests.drawn_images import Board, Lens, Photo, gaussian
from tests.drawn_images import drawn as photographed

RAYS, START = 200_000, 20_000  # of a camera; of the linear stage
CENTRE_MM = np.array([0.0, 0.0, 600.0])
HALF_MM, NOISE_MM = 500.0, 0.3
CORES = len(os.sched_getaffinity(0))
BOARD = 9, 6


def timed(benchmark, group, run):
    """Give one run to the benchmark after another has compiled its loops."""
    cv2.setNumThreads(1)
    benchmark.group = group
    return benchmark.pedantic(run, rounds=5, warmup_rounds=1)


@pytest.fixture(scope="module")
def grid():
    """A tilted monitor that fills an image of 3 megapixels."""
    return drawn(
        size=(2000, 1500),
        monitor=(1920, 1440),
        noise=3.0,
        blur=1.0,
        tilt=0.3,
        share=1.4,
    )


@pytest.mark.parametrize("threads", dict.fromkeys((1, CORES)))
def test_decoder(benchmark, grid, threads):
    images, patterns = grid.images, grid.patterns
    timed(
        benchmark,
        "decoder, 3 megapixels",
        lambda: decode(images, patterns, grid.grid, threads=threads),
    )


def test_decoder_of_plain_opencv(benchmark, grid):
    axes = peers.read_plan(grid.patterns, grid.grid.monitor_px)
    sines = [k for k, p in enumerate(grid.patterns) if p.kind == "phase"]
    floor = estimate_noise([grid.images[k] for k in sines[:8]], 255).floor
    noise = float(np.sqrt(floor))
    timed(
        benchmark,
        "decoder, 3 megapixels",
        lambda: peers.with_opencv(grid.images, axes, noise),
    )


def test_decoder_of_fringes(benchmark, grid):
    pytest.importorskip("fringes")
    package = peers.fringes_decoder(len(grid.images), grid.images[0].shape[::-1])
    timed(benchmark, "decoder, 3 megapixels", lambda: package(CORES))


@pytest.fixture(scope="module")
def board():
    """An image of a tilted chessboard in a barrel lens."""
    R = rotation_from_vector([0.2, -0.3, 0.1])
    middle = np.append((np.array(BOARD) - 1) / 2, 0)
    placed = Board(*BOARD, R, np.array([0, 0, 12.0]) - R @ middle)
    photo = Photo(gaussian(0.8), noise=2.0)
    lens = Lens("barrel", 380.0)
    return photographed(lens, placed, photo, np.random.default_rng(0))[0]


@pytest.mark.parametrize("detector", DETECTORS)
def test_detector(benchmark, board, detector):
    assert timed(
        benchmark, "detector, 640 x 480", lambda: DETECTORS[detector](board, *BOARD)
    ).found


@pytest.fixture(scope="module")
def points():
    """Points (3, RAYS, 2) of rays on three tilted grids, with noise; mm."""
    rng = np.random.default_rng(0)
    tilts = rotation_from_vector(
        np.radians([[0, 0, 0], [20, -10, 5], [-15, -25, 30.0]])
    )
    grids = pose(tilts, [[0, 0, 0], [30.0, -20, -60], [-40, 50, 70]])
    rays = on_plane(rng.uniform(-HALF_MM, HALF_MM, (RAYS, 2))) - CENTRE_MM
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    hits = np.stack([intersect_rays_plane(CENTRE_MM, rays, T).points for T in grids])
    return hits + NOISE_MM * rng.normal(size=hits.shape)


def opencv_homography(source, target):
    return cv2.findHomography(source, target)[0]


LINEAR = {
    "raxel": lambda points: linear_cgsp(points, side=1).centre,
    "raxel, weighted": lambda points: (
        linear_cgsp(points, side=1, weights="image noise").centre
    ),
    "numpy": lambda points: peers.centre_by(peers.plain_homography, points),
    "opencv": lambda points: peers.centre_by(opencv_homography, points),
}


@pytest.mark.parametrize("method", LINEAR)
def test_linear_stage(benchmark, points, method):
    centre = timed(benchmark, "CGSP, 200 000 rays", lambda: LINEAR[method](points))
    assert np.linalg.norm(centre - CENTRE_MM) < 1


ADJUSTED = {
    "raxel": lambda *given: adjust_consistent(*given).centre,
    "numpy": lambda *given: peers.plainly_adjusted(*given)[0],
}


@pytest.mark.parametrize("method", ADJUSTED)
def test_bundle_adjustment(benchmark, points, method):
    linear = linear_well_conditioned(points[:, :START], side=1)
    start = points, np.ones(points.shape[:2], bool), linear.centre, linear.T_base_grid
    centre = timed(
        benchmark, "bundle adjustment, 200 000 rays", lambda: ADJUSTED[method](*start)
    )
    assert np.linalg.norm(centre - CENTRE_MM) < 1


@pytest.mark.parametrize("method", ["raxel", "scipy"])
def test_mirror_update(benchmark, method):
    rng, T = np.random.default_rng(0), grid_pose()
    flat = spline_like(bent(0.0), 0.0)
    clamp = clamp_of_camera(flat, edge_pixels())
    before, after = seen(bent(0.0), T, rng), seen(bent(5.0), T, rng)
    outline = visible_pixels(5.0, 2, 2)
    settings = MirrorSettings(prior_sd=0.1)

    def update():
        return update_mirror(
            flat, before, after, GRID, clamp, settings, outline=outline
        )

    found = update()
    placed = transform(found.pose.T_camera_grid, on_plane(GRID))
    runs = {
        "raxel": update,
        "scipy": lambda: peers.plain_shape(found.linear, after, placed, clamp),
    }
    timed(benchmark, "mirror update, one deflection", runs[method])
