"""A sheet clamped and bent: profiles, the surface, and the camera before it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from raxel.cameras import (
    BeamProfile,
    ElasticaProfile,
    FlexibleMirrorCamera,
    PerspectiveCamera,
    PlanarMirrorsCamera,
    camera_from,
)
from raxel.cameras.mirrors.flexible import ClampedMirror
from raxel.cameras.mirrors.sheet_surface import Unevenness
from raxel.errors import InputError
from raxel.geometry import inverse_pose, rotate, transform
from tests.camera_checks import assert_points_come_back, assert_same_from_file

K = [[1600, 0, 319.5], [0, 1600, 239.5], [0, 0, 1]]
VIEWER = PerspectiveCamera(K, [-0.2, 0.1], 640, 480)
SIZE = (160.0, 100.0)
# 180 degrees about this axis puts the clamp to the right and slants the sheet.
HALF_TURN = np.pi * np.array([np.sin(np.pi / 12), 0, np.cos(np.pi / 12)])
SHEET = {
    "viewer": VIEWER,
    "size": SIZE,
    "loads": 150.0,
    "deflections": 15.0,
    "offset": (60, 0, 370),
    "rotation": HALF_TURN,
}
ROUGH = {"aberration": 0.03, "strain": 0.02, "rulings": 0.06, "holder": 4.0}
FLAT = Unevenness(np.array(SIZE), 0.0, (45, 110), 0, 0.0, 5.0)


def flexible(**changes):
    return FlexibleMirrorCamera(**SHEET | changes)


def pixels_of(seed, count=600):
    return np.random.default_rng(seed).uniform(0, [639, 479], (count, 2))


def sheet(profile, rulings=0.0, unevenness=FLAT, holder=0.0):
    return ClampedMirror(profile, SIZE, rulings, unevenness, holder)


def test_beam_shape_equals_equation_5_1():
    x = np.linspace(0, 150, 31)
    beam = BeamProfile(150.0, 2e-6)
    np.testing.assert_allclose(beam.at(x)[0], 2e-6 * x**2 / 6 * (450 - x), rtol=1e-13)
    beyond, slope, bend = beam.at(np.array([150.0, 170.0]))
    assert np.diff(beyond) / 20 == pytest.approx(slope[0], rel=1e-13)
    np.testing.assert_allclose([*np.diff(slope), *bend], 0, atol=1e-15)


def test_elastica_solves_its_equation():
    """theta'' = -q cos(theta) along the sheet; theta(0) = 0, no moment at the load."""
    made = ElasticaProfile.deflected(100.0, 60.0)
    q, X = made.forces[0], made.places[0]

    def along(_, state):
        x, _, theta = state
        return [np.cos(theta), np.sin(theta), q * (X - x)]

    end = solve_ivp(along, (0, 100), [0, 0, 0], rtol=1e-12, atol=1e-12).y[:, -1]
    slope = made.at(np.array([X]))[1][0]
    np.testing.assert_allclose(end, [X, 60, np.arctan(slope)], atol=1e-8)
    small = ElasticaProfile(150.0, 1e-12).at(np.array([150.0]))[0]
    assert small == pytest.approx(1e-12 * 150**3 / 3, rel=1e-12)


def rough(amplitude=0.03, strain=0.02):
    return Unevenness(np.array(SIZE), amplitude, (45, 110), 3, strain, 5.0)


@pytest.mark.parametrize("deflection", [15.0, 1e-3])
def test_derivatives_of_sheet_agree_with_differences(deflection):
    profile = ElasticaProfile.deflected([70, 150], [deflection / 3, deflection])
    mirror = sheet(profile, 0.06, rough())
    rng = np.random.default_rng(1)
    x, y = rng.uniform(2, 65, 40), rng.uniform(-45, 45, 40)
    step = 1e-4
    found = mirror.height(x, y)
    by_x = (mirror.height(x + step, y) - mirror.height(x - step, y)) / (2 * step)
    by_y = (mirror.height(x, y + step) - mirror.height(x, y - step)) / (2 * step)
    np.testing.assert_allclose(found[[1, 3, 4]], by_x[[0, 1, 2]], atol=1e-9)
    np.testing.assert_allclose(found[[2, 4, 5]], by_y[[0, 1, 2]], atol=1e-9)


@pytest.mark.parametrize("rulings", [0.0, 1e-7, 0.06])
def test_flexible_sheet_keeps_lengths(rulings):
    """Lengths on the bent sheet are those on the flat one, in every direction."""
    mirror = sheet(ElasticaProfile.deflected([70, 150], [2, 15]), rulings)
    rng = np.random.default_rng(2)
    x, y = rng.uniform(1, 150, 60), rng.uniform(-50, 50, 60)
    slope = mirror.height(x, y)[1:3]
    step = 1e-4
    columns = []
    for dx, dy in ((step, 0), (0, step)):
        up, down = mirror.flat(x + dx, y + dy), mirror.flat(x - dx, y - dy)
        columns.append(np.subtract(up, down) / (2 * step))
    (a, c), (b, d) = columns
    metric = [a * a + c * c, a * b + c * d, b * b + d * d]
    true = [1 + slope[0] ** 2, slope[0] * slope[1], 1 + slope[1] ** 2]
    np.testing.assert_allclose(metric, true, atol=1e-8)
    edge = mirror.flat(np.zeros(5), np.linspace(-50, 50, 5))
    np.testing.assert_allclose(edge, [np.zeros(5), np.linspace(-50, 50, 5)], atol=1e-12)


def test_flexible_sheet_ends_at_length_and_holder():
    mirror = sheet(ElasticaProfile.deflected(150.0, 40.0), holder=6.0)
    assert mirror.end < 160 - 5
    x = np.array([5.9, 6.1, mirror.end - 1e-6, mirror.end + 1e-6])
    z = mirror.height(x, np.zeros(4))[0]
    carried = mirror.carries(np.column_stack([x, np.zeros(4), z]))
    np.testing.assert_array_equal(carried, [False, True, True, False])
    assert not mirror.carries(np.array([[80.0, 50.1, 5.0]]))[0]


def test_ray_from_beyond_sheet_misses_it():
    mirror = sheet(ElasticaProfile.deflected(150.0, 20.0))
    x, y = np.array([[30.0, 80.0, 120.0], [-20.0, 5.0, 30.0]])
    points = np.column_stack([x, y, mirror.height(x, y)[0]])
    ways = np.array([[0.1, 0.2, 1.0], [-0.2, 0.0, 1.0], [0.0, 0.1, 1.0]])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    found = mirror.reflect(points - 9 * ways, ways)
    np.testing.assert_allclose(found.points, points, atol=1e-9)
    assert not mirror.reflect(points + 9 * ways, ways).valid.any()


def test_unevenness_has_given_height_and_reach():
    x, y = np.meshgrid(np.linspace(0, 160, 801), np.linspace(-50, 50, 501))
    height = rough(0.03, 0.0).at(x.ravel(), y.ravel())[0]
    assert np.sqrt(np.mean(height**2)) == pytest.approx(0.03, rel=0.02)
    strained = Unevenness(np.array(SIZE), 0.0, (45, 110), 0, 0.02, 5.0)
    middle, end, side = strained.at(np.array([80, 160, 80.0]), np.array([0, 0, 50.0]))[
        0
    ]
    assert middle < 1e-4
    np.testing.assert_allclose([end, side], 0.02, rtol=1e-4)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"deflections": 0.0} | ROUGH,
        {"deflections": 15.0} | ROUGH,
        {"deflections": -6.0, "law": "beam"},
        {"loads": (60, 150), "deflections": (3, 14)},
        {"deflections": 2e-3, "aberration": 1e-4},
    ],
)
def test_points_on_ray_project_to_its_pixel(changes):
    camera, pixels = flexible(**changes), pixels_of(4)
    depth = np.random.default_rng(5).uniform(50, 600, (len(pixels), 1))
    assert assert_points_come_back(camera, pixels, depth).valid.mean() > 0.5


def test_concave_sheet_projects_points_beyond_focus():
    """It may show them several times: the pixel's ray passes through the point."""
    camera, rng = flexible(deflections=-30.0), np.random.default_rng(5)
    rays = camera.rays(pixels_of(4, 200))
    depth = rng.uniform(400, 1500, (200, 1))
    points = (rays.origins + depth * rays.directions)[rays.valid]
    back = camera.project(points)
    assert back.valid.all()
    there = camera.rays(back.pixels)
    reach = points - there.origins
    assert np.linalg.norm(np.cross(reach, there.directions), axis=1).max() < 1e-6


def test_rays_obey_law_of_reflection():
    camera, pixels = flexible(**ROUGH), pixels_of(6)
    rays = camera.rays(pixels)
    seen = VIEWER.rays(pixels).directions
    T = inverse_pose(camera.T_viewer_mirror)
    M = transform(T, rays.origins[rays.valid])
    out, into = (rotate(T, d[rays.valid]) for d in (rays.directions, seen))
    on, J, _ = camera.mirror.point(camera.mirror.chart(M))
    np.testing.assert_allclose(on, M, atol=1e-9)
    assert np.abs(np.einsum("nik,ni->nk", J, out - into)).max() < 1e-11 * 94


def test_undeflected_sheet_is_plane_mirror():
    camera = flexible(deflections=0.0)
    outline = np.array([[0, -50], [160, -50], [160, 50], [0, 50.0]])
    plane = PlanarMirrorsCamera(VIEWER, [camera.T_viewer_mirror], [outline])
    ours, theirs = camera.rays(pixels_of(7)), plane.rays(pixels_of(7))
    np.testing.assert_array_equal(ours.valid, theirs.valid)
    np.testing.assert_allclose(
        ours.directions[ours.valid], theirs.directions[ours.valid], atol=1e-12
    )


def test_camera_roundtrips_through_file_and_fields(tmp_path):
    fields = SHEET | ROUGH | {"loads": (60, 150), "deflections": (5, 8), "seed": 2}
    camera = camera_from("flexible mirror", fields)
    again = assert_same_from_file(camera, pixels_of(7), tmp_path)
    assert again.parameters == VIEWER.parameters + 6 + 2 + 1 + 18


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"size": (0, 100)}, "field 'size'"),
        ({"loads": (150, 60), "deflections": (1, 2)}, "field 'loads'"),
        ({"loads": 170}, "field 'loads': .* 170 mm .* 160 mm"),
        ({"deflections": (1, 2)}, "field 'deflections'"),
        ({"deflections": 151}, "field 'deflections': .*151.0"),
        ({"deflections": 100}, "field 'deflections': .* 64 degrees"),
        ({"law": "spline"}, "field 'law': found 'spline'"),
        ({"rulings": 1.0}, "field 'rulings': 57.3 degrees"),
        ({"holder": 160}, "field 'holder': found 160 mm"),
        ({"wavelengths": (110, 45)}, "field 'wavelengths'"),
        ({"aberration": -1}, "field 'aberration': found -1"),
        ({"seed": 0.5}, "field 'seed': found 0.5"),
        ({"offset": (60, 0, -370)}, "field 'T_viewer_mirror'"),
        ({"offset": (0, 0, 8)}, "field 'T_viewer_mirror': .* 10 mm"),
        (
            {"rotation": (0, np.radians(87), 0), "offset": (0, 0, 200)},
            "field 'T_viewer_mirror': .* 2.9 degrees",
        ),
    ],
)
def test_impossible_cameras_are_rejected(change, words):
    with pytest.raises(InputError, match=words):
        camera_from("flexible mirror", SHEET | change)


def test_clamped_edge_keeps_position_and_slope():
    mirror = sheet(ElasticaProfile.deflected(150.0, 15.0), 0.06, rough())
    height, by_x, by_y, *_ = mirror.height(np.zeros(11), np.linspace(-50, 50, 11))
    np.testing.assert_array_equal([height, by_x, by_y], 0)
