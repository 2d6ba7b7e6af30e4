"""Between corners: bent cells are followed, and only where the corners can tell."""

import numpy as np
import pytest

from raxel.calibration import calibrate_generic
from raxel.calibration.views.correspondence import (
    BoardView,
    board_cells,
    locate_pixels,
    pixels_on_board,
)
from raxel.calibration.views.interpolation import (
    corner_variance,
    interpolated_view,
    refined_lattice,
)
from raxel.cameras import (
    FieldOfViewCamera,
    FisheyeCamera,
    PerspectiveCamera,
    UnifiedSphereCamera,
    pixel_grid,
)
from raxel.geometry import apply_homography, nearest_rotation, on_plane, transform
from tests.board_scenes import HEIGHT, PITCH, WIDTH, board_poses

K = np.array([[100, 0.5, 122], [0, 95, 88], [0, 0, 1.0]])
WIDE = np.array([[140, 0.5, 122], [0, 133, 88], [0, 0, 1.0]])
BENT = {
    "fisheye of 180 degrees": FisheyeCamera(
        "equidistance", 75.0, [122.0, 88.0], WIDTH, HEIGHT, np.pi / 2
    ),
    "hyperboloid mirror": UnifiedSphereCamera(0.8, WIDE, WIDTH, HEIGHT),
    "bent lens": FieldOfViewCamera(1.2, K, WIDTH, HEIGHT),
}
PINHOLE = PerspectiveCamera(K, [], WIDTH, HEIGHT)


def lattice(columns, rows):
    """Board points (N, 2) in mm of a board as large as that of `board_scenes`."""
    pitch = 12 * PITCH / (columns - 1)
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    return pitch * np.column_stack([x.ravel(), y.ravel()])


def poses_of(seed, count):
    return board_poses(seed, count, tilt=0.35)


def views_of(camera, size=(9, 6), seed=1, count=6, noise=0.0):
    rng = np.random.default_rng(seed)
    points = lattice(*size)
    flat = on_plane(points)
    views = []
    for T in poses_of(seed, count):
        pixels = camera.project(transform(T, flat)).pixels
        pixels = pixels + noise * rng.normal(size=pixels.shape)
        views.append(BoardView(pixels, points, *size, "a.png"))
    return views


def calibrated(views, *interpolation):
    options = dict(zip(["interpolation"], interpolation, strict=False))
    rng = np.random.default_rng(0)
    return calibrate_generic(views, WIDTH, HEIGHT, rng=rng, **options)


def gap_px(view, camera, T_camera_board, step=1):
    """Distances in px of whole pixels from where their points on the board are seen."""
    pixels, points = pixels_on_board(view, WIDTH, HEIGHT, step)
    seen = camera.project(transform(T_camera_board, on_plane(points))).pixels
    return np.linalg.norm(seen - pixels, axis=1)


def ray_errors_px(found, camera):
    """Distances in px of the table's rays, turned as fits best, from the true ones."""
    pixels = pixel_grid(WIDTH, HEIGHT)[found.camera.mask.ravel()]
    rays, true = found.camera.rays(pixels).directions, camera.rays(pixels).directions
    turned = rays @ nearest_rotation(true.T @ rays).T
    return np.linalg.norm(camera.project(turned).pixels - pixels, axis=1)


# -------------------------------------------------------------------------- the surface


def test_refined_lattice_reproduces_cubic():
    y, x = np.meshgrid(np.arange(6.0), np.arange(9.0), indexing="ij")

    def cubic(x, y):
        return np.stack([x**3 - x * y**2 + 2, y**3 + x**2 * y - x], axis=-1)

    fine = refined_lattice(cubic(x, y), 5)
    y, x = np.meshgrid(np.arange(26) / 5, np.arange(41) / 5, indexing="ij")
    assert np.abs(fine - cubic(x, y)).max() < 1e-11
    given = np.random.default_rng(0).normal(size=(7, 5, 2))
    assert np.array_equal(refined_lattice(given, 3)[::3, ::3], given)


def test_refined_lattice_is_c1():
    given = np.random.default_rng(1).normal(size=(6, 8))
    for axis in (0, 1):
        bends = [
            np.abs(np.diff(refined_lattice(given, factor), 2, axis=axis)).max()
            for factor in (50, 100)
        ]
        # Half the step leaves a quarter of a curve's second difference, half a kink's.
        assert bends[1] < 0.27 * bends[0]


def test_refined_lattice_hole_removes_its_cells_only():
    given = np.random.default_rng(2).normal(size=(6, 9))
    whole = refined_lattice(given, 4)
    given[2, 3] = np.nan
    fine = refined_lattice(given, 4)
    gone = np.isnan(fine)
    assert gone[5:12, 9:16].all()
    gone[5:12, 9:16] = False
    assert not gone.any()
    # Slopes look two corners ahead at most, or four where the hole shortens a line.
    assert np.array_equal(fine[:, 32:], whole[:, 32:])


# ------------------------------------------------------------------------- on one board


def test_both_interpolations_are_exact_for_pinhole():
    view = views_of(PINHOLE)[0]
    truth = np.random.default_rng(4).uniform(0, 60, (500, 2))
    H = np.linalg.inv(board_cells(view).board_from_pixel[0])
    for name in ("homographic", "smooth"):
        points, inside = locate_pixels(
            apply_homography(H, truth), interpolated_view(view, name)[0]
        )
        assert inside.all()
        assert np.abs(points - truth).max() < 1e-8
    assert interpolated_view(view, "by need")[1] == "homographic"


@pytest.mark.parametrize("name", BENT)
@pytest.mark.parametrize("size", [(9, 6), (15, 15)])
def test_smooth_interpolation_follows_bent_cells(name, size):
    camera, gaps = BENT[name], {}
    T, view = poses_of(1, 6)[2], views_of(camera, size)[2]
    for way in ("homographic", "by need"):
        filled, taken = interpolated_view(view, way)
        assert taken == {"by need": "smooth"}.get(way, way)
        gaps[way] = gap_px(filled, camera, T).max()
    # The finer lattice's own cells may bend by 0.02 px.
    assert gaps["by need"] < max(gaps["homographic"] / 6, 0.025)
    points, inside = locate_pixels(view.pixels, filled)
    assert inside.all()
    assert np.abs(points - view.points).max() < 1e-9


@pytest.mark.parametrize("size", [(9, 6), (15, 15)])
def test_corner_variance_estimates_noise(size):
    for camera in (PINHOLE, *BENT.values()):
        views = views_of(camera, size, count=10, noise=0.2)
        found = np.sqrt(np.median([corner_variance(view) for view in views]))
        assert found == pytest.approx(0.2, rel=0.15)


def test_unknown_interpolation_is_rejected():
    with pytest.raises(ValueError, match="'homographic', 'smooth', 'by need'"):
        interpolated_view(views_of(PINHOLE)[0], "linear")


# ------------------------------------------------------------------ whole calibrations


@pytest.mark.parametrize("name", BENT)
def test_interpolation_gives_rays_of_bent_camera(name):
    camera = BENT[name]
    found = calibrated(views_of(camera, count=4))
    assert found.interpolation == ("smooth",) * 4
    # By homographies: RMS 0.10 to 0.28 px, largest 0.26 to 0.58 px.
    errors = ray_errors_px(found, camera)
    assert np.sqrt(np.mean(np.square(errors))) < 0.03
    assert errors.max() < 0.05


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.3])
def test_noise_does_not_select_smooth_interpolation(noise):
    for size in ((9, 6), (15, 15), (5, 7)):
        for view in views_of(PINHOLE, size, count=10, noise=noise):
            assert interpolated_view(view, "by need")[1] == "homographic"


def test_interpolation_accepts_missing_corners():
    camera = BENT["hyperboloid mirror"]
    views = views_of(camera, count=4)
    views[0].pixels[[0, 22]] = np.nan
    views[3].pixels[[53, 30, 31]] = np.nan
    found = calibrated(views)
    assert sorted(found.used) == list(range(4))
    assert found.interpolation == ("smooth",) * 4
    assert ray_errors_px(found, camera).max() < 0.1


def test_corner_variance_of_few_corners_is_not_too_small():
    """The least of several estimates runs low, by a fifth of the variance here."""
    views = views_of(PINHOLE, (6, 5), count=40, noise=0.2)
    found = [corner_variance(view) for view in views]
    assert np.mean(found) == pytest.approx(0.04, rel=0.12)
