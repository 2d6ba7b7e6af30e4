"""The general camera (2.3): interpolation, its exact inverse, holes, both kinds."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.cameras import (
    FisheyeCamera,
    GeneralCamera,
    PerspectiveCamera,
    QuadricMirrorCamera,
    pixel_grid,
)
from raxel.cameras.tables.bounds import BoundPyramid
from raxel.errors import InputError
from raxel.geometry import pluecker_matrix_of_rays
from tests.camera_checks import assert_points_come_back

WIDTH, HEIGHT = 80, 60
FISHEYE = FisheyeCamera("equidistance", 20, (40.3, 29.1), WIDTH, HEIGHT, 1.95)
PINHOLE = PerspectiveCamera(
    [[90, 1, 40], [0, 80, 30], [0, 0, 1]], [-0.2], WIDTH, HEIGHT
)


def surface_origins(directions):
    """Anchor points on a bulged surface, tens of mm wide: far from central."""
    return 30 * directions * (1 + 0.2 * directions[..., :1]) + [5, -3, 20]


def table(camera, central, hole_share=0.0, noise_px=0.0, seed=0):
    rng = np.random.default_rng(seed)
    _, directions, valid = camera.rays(pixel_grid(WIDTH, HEIGHT))
    directions = np.where(valid[:, None], directions, 1.0).reshape(HEIGHT, WIDTH, 3)
    origins = np.array([1.0, 2, 3]) if central else surface_origins(directions)
    directions = directions + rng.normal(0, noise_px / 80, directions.shape)
    mask = valid.reshape(HEIGHT, WIDTH) & (rng.random((HEIGHT, WIDTH)) >= hole_share)
    return GeneralCamera(directions, mask, origins)


TABLES = {
    f"{name} {'central' if central else 'non-central'} {holes}": table(
        camera, central, holes
    )
    for name, camera in (("fisheye", FISHEYE), ("pinhole", PINHOLE))
    for central in (True, False)
    for holes in (0.0, 0.05, 0.6)
}


def test_table_from_camera_contains_all_rays():
    camera = FisheyeCamera("equidistance", 60, (150.0, 120.0), 300, 250, 1.95)
    table = GeneralCamera.from_camera(camera)
    rays = camera.rays(pixel_grid(300, 250))
    np.testing.assert_array_equal(table.mask.ravel(), rays.valid)
    np.testing.assert_allclose(
        table.directions[table.mask], rays.directions[rays.valid], atol=1e-15
    )


@pytest.mark.parametrize("name", TABLES)
def test_points_on_ray_project_to_its_position(name):
    camera = TABLES[name]
    rng = np.random.default_rng(1)
    anywhere = rng.uniform(0, [WIDTH - 1, HEIGHT - 1], (3000, 2))
    on_rows = anywhere[:500] * [1, 0] + np.floor(anywhere[:500]) * [0, 1]
    on_columns = anywhere[:500] * [0, 1] + np.floor(anywhere[:500]) * [1, 0]
    centres = pixel_grid(WIDTH, HEIGHT)
    pixels = np.vstack([anywhere, on_rows, on_columns, centres])
    depth = 10 ** rng.uniform(1, 5, (len(pixels), 1))
    rays = assert_points_come_back(camera, pixels, depth)
    np.testing.assert_array_equal(rays.valid[-len(centres) :], camera.mask.ravel())


def brute_force_sees(camera, points):
    """Whether the corners of some whole cell of a central table surround each point."""
    m = camera.mask
    v, u = np.nonzero(m[:-1, :-1] & m[1:, :-1] & m[:-1, 1:] & m[1:, 1:])
    d = camera.directions
    ring = [d[v, u], d[v, u + 1], d[v + 1, u + 1], d[v + 1, u]]
    far = points - camera.origins
    sides = [np.cross(ring[k], ring[(k + 1) % 4]) @ far.T for k in range(4)]
    one_side = np.all(np.array(sides) > 0, axis=0) | np.all(np.array(sides) < 0, axis=0)
    return np.any(one_side & (sum(ring) @ far.T > 0), axis=0)


@pytest.mark.parametrize("name", [n for n in TABLES if " central" in n])
def test_table_projects_points_inside_cells_only(name):
    camera = TABLES[name]
    points = np.random.default_rng(2).normal(0, 100, (700, 3))
    seen = brute_force_sees(camera, points)
    np.testing.assert_array_equal(camera.project(points).valid, seen)
    assert 0 < seen.mean() < 0.9


@given(st.booleans(), st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_noisy_table_finds_ray_for_each_point(central, seed):
    camera = table(FISHEYE, central, hole_share=0.03, noise_px=0.6, seed=seed)
    rng = np.random.default_rng(seed)
    rays = camera.rays(rng.uniform(0, [WIDTH - 1, HEIGHT - 1], (500, 2)))
    depth = 10 ** rng.uniform(1, 5, (500, 1))
    points = (rays.origins + depth * rays.directions)[rays.valid]
    pixels, valid = camera.project(points)
    assert valid.all()
    # Noise folds the table: another pixel may be found, but its ray must do.
    found = camera.rays(pixels)
    miss = np.cross(points - found.origins, found.directions)
    distance = np.linalg.norm(points - found.origins, axis=1)
    assert np.max(np.linalg.norm(miss, axis=1) / distance) < 1e-10
    assert np.all(np.sum((points - found.origins) * found.directions, axis=1) > 0)


def test_points_behind_ray_origin_are_invalid():
    camera = TABLES["pinhole non-central 0.0"]
    rays = camera.rays(np.array([[40.2, 30.7], [10, 10]]))
    assert camera.project(rays.origins + 5 * rays.directions).valid.all()
    assert not camera.project(rays.origins - 5 * rays.directions).valid.any()
    assert not TABLES["pinhole central 0.0"].project(np.array([[1.0, 2, 3]])).valid


def test_table_equals_camera_at_pixel_centres():
    camera = GeneralCamera.from_camera(FISHEYE)
    pixels = pixel_grid(WIDTH, HEIGHT)
    ours, theirs = camera.rays(pixels), FISHEYE.rays(pixels)
    np.testing.assert_array_equal(ours.valid, theirs.valid)
    np.testing.assert_allclose(ours.directions, theirs.directions, atol=2e-16)
    assert camera.central
    assert camera.share_with_ray == theirs.valid.mean()
    again = GeneralCamera.from_camera(TABLES["fisheye non-central 0.05"])
    assert not again.central
    np.testing.assert_array_equal(
        again.origins, TABLES["fisheye non-central 0.05"].origins
    )


def test_central_mirror_table_has_common_origin():
    viewer = PerspectiveCamera([[100, 0, 40], [0, 100, 30], [0, 0, 1]], [], 81, 61)
    mirror = QuadricMirrorCamera.aligned(viewer, "hyperboloid", (30, 20), 20)
    table = GeneralCamera.from_camera(mirror)
    assert table.central
    np.testing.assert_allclose(table.origins, mirror.centre, atol=1e-9)
    pixels = pixel_grid(81, 61)
    rays = mirror.rays(pixels)
    seen = table.project((rays.origins + 150 * rays.directions)[rays.valid])
    np.testing.assert_allclose(seen.pixels, pixels[rays.valid], atol=1e-6)


def test_interpolation_needs_weighted_pixels_only():
    directions = np.dstack([*np.mgrid[:4, :4][::-1] / 10, np.ones((4, 4))])
    mask = np.ones((4, 4), bool)
    mask[1, 1] = False
    camera = GeneralCamera(directions, mask)
    positions = {
        (0, 0): True, (1, 0): True, (1, 1): False, (0.5, 0): True, (1.5, 0): True,
        (0.5, 1): False, (1, 0.5): False, (0.5, 0.5): False, (2.5, 2.5): True,
        (3, 3): True, (3, 2.5): True, (3.0001, 2): False, (-0.0001, 2): False,
        (np.nan, 1): False, (np.inf, 1): False,
    }  # fmt: skip
    rays = camera.rays(np.array(list(positions)))
    assert rays.valid.tolist() == list(positions.values())
    back = camera.project(9 * rays.directions[rays.valid])
    expected = np.array(list(positions))[rays.valid]
    np.testing.assert_allclose(back.pixels, expected, rtol=0, atol=1e-9)


def test_single_pixel_and_full_circle_tables():
    mask = np.zeros((3, 3), bool)
    mask[2, 2] = True
    lone = GeneralCamera(np.ones((3, 3, 3)), mask)
    pixels, valid = lone.project(np.array([[5.0, 5, 5], [5, 5, 5.001], [-5, -5, -5]]))
    assert valid.tolist() == [True, False, False]
    assert pixels[0].tolist() == [2, 2]
    whole = FisheyeCamera("equisolid", 14, (30, 30), 61, 61)
    camera = GeneralCamera.from_camera(whole)
    points = np.random.default_rng(4).normal(size=(2000, 3))
    backwards = points[:, 2] < -0.8 * np.linalg.norm(points, axis=1)
    seen = camera.project(points)
    assert seen.valid[~backwards].all()
    gap = np.linalg.norm(seen.pixels - whole.project(points).pixels, axis=1)
    assert gap[~backwards].max() < 0.1


def test_pluecker_table_on_demand():
    camera = TABLES["fisheye non-central 0.05"]
    M = camera.pluecker(slice(20, 23))
    assert M.shape == (3, WIDTH, 4, 4)
    np.testing.assert_array_equal(np.isfinite(M).all(axis=(2, 3)), camera.mask[20:23])
    v, u = np.argwhere(camera.mask[20:23])[7]
    expected = pluecker_matrix_of_rays(
        camera.origins[20 + v, u], camera.directions[20 + v, u]
    )
    np.testing.assert_array_equal(M[v, u], expected)
    assert TABLES["fisheye central 0.0"].pluecker().shape == (HEIGHT, WIDTH, 4, 4)


GOOD = np.ones((3, 4, 3))
MASK = np.ones((3, 4), bool)


@pytest.mark.parametrize(
    ("field", "arguments"),
    [
        ("directions", (np.ones((3, 4)), MASK)),
        ("directions", (np.ones((1, 4, 3)), np.ones((1, 4), bool))),
        ("directions", (0 * GOOD, MASK)),
        ("directions", (np.nan * GOOD, MASK)),
        ("mask", (GOOD, MASK.T)),
        ("mask", (GOOD, MASK.astype(float))),
        ("origins", (GOOD, MASK, [0, 0])),
        ("origins", (GOOD, MASK, [0, 0, math.inf])),
        ("origins", (GOOD, MASK, np.nan * GOOD)),
        ("units", (GOOD, MASK, [0, 0, 0], "inch")),
    ],
)
def test_impossible_tables_are_rejected_by_name(field, arguments):
    with pytest.raises(InputError, match=f"^field '{field}': "):
        GeneralCamera(*arguments)


def test_cell_wider_than_half_space_is_searched():
    """Its corners look 100 degrees off the axis, each another way, and its middle
    straight back, which no cone about the rays of its neighbours holds."""
    polar, around = np.full((5, 5), 0.1), np.linspace(0, 1, 25).reshape(5, 5)
    polar[3:, 3:] = np.radians(100)
    around[3:, 3:] = np.radians([[0, 90], [270, 180]])
    level = np.sin(polar)
    directions = np.stack(
        [level * np.cos(around), level * np.sin(around), np.cos(polar)], axis=-1
    )
    camera = GeneralCamera(directions, np.ones((5, 5), bool), np.zeros(3))
    back = camera.rays(np.array([[3.5, 3.5]])).directions
    np.testing.assert_allclose(back, [[0, 0, -1]], atol=1e-12)
    _, u, v = BoundPyramid(camera._table).cells(100 * back)
    assert (3, 3) in set(zip(u.tolist(), v.tolist(), strict=True))


@pytest.mark.parametrize("side", ["above", "below", "left", "right"])
def test_border_pixel_line_sees_its_points(side):
    place, axis = {"above": (0, 1), "below": (5, 1), "left": (0, 0), "right": (7, 0)}[
        side
    ]
    rays = PINHOLE.rays(5 * pixel_grid(8, 6) + [20, 15])
    kept = pixel_grid(8, 6)[:, axis] == place
    camera = GeneralCamera(
        rays.directions.reshape(6, 8, 3), kept.reshape(6, 8), np.zeros(3)
    )
    pixels = np.full((9, 2), float(place))
    pixels[:, 1 - axis] = np.arange(9) * 0.6 + 0.1
    seen = camera.rays(pixels)
    assert seen.valid.all()
    np.testing.assert_allclose(
        camera.project(300 * seen.directions).pixels, pixels, atol=1e-9
    )
