"""Central parametric models of section 2.2: formulas, inverses, limits, files, fits."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.cameras import (
    CAMERAS,
    BrownCamera,
    DivisionCamera,
    FieldOfViewCamera,
    FisheyeCamera,
    GeneralCamera,
    KannalaBrandtCamera,
    LiftedRationalCamera,
    MicusikPajdlaCamera,
    PerspectiveCamera,
    RationalCubicCamera,
    ScaramuzzaCamera,
    ShahAggarwalCamera,
    TardifCamera,
    UnifiedSphereCamera,
    camera_from,
    load_camera,
)
from raxel.cameras.brown import BrownMap
from raxel.cameras.fit import fit_camera, radii_of
from raxel.cameras.kannala_brandt import AsymmetricMap
from raxel.cameras.polar_polynomial import PolarMap
from raxel.cameras.rational import CubicMap, LiftedMap
from raxel.cameras.rising import invert_rising, smallest_positive_root
from raxel.errors import InputError

SIZE = (640, 480)
CENTRE = (330.0, 250.0)
K = np.array([[300, 1.5, 330], [0, 280, 250], [0, 0, 1.0]])
SHAH = [1.06, -0.24, -0.075, 0.047, -0.0063], [0.05, -0.1, 0.02, 0.01, -0.005]
KB_K = [1, -0.02, 0.003, -0.001, 0.0001]
KB_ODD = ([0.01, 0.002, -0.001], [1, -0.5, 0.3, 0.2])
KB_TURN = ([0.005, 0.002, -0.001], [0.4, -0.5, 0.3, -0.8])
CUBIC = np.zeros((4, 10))
CUBIC[0] = [330, 300, 1.5, 3, 2, -4, 10, -3, 12, 1]
CUBIC[1] = [1, 0, 0, 0.3, 0.02, 0.3, 0.01, 0, 0.02, -0.01]
CUBIC[2] = [250, 1, 280, -3, 2, 1, 2, 11, 3, 9]
CUBIC[3] = [1, 0, 0, 0.29, -0.02, 0.31, 0.01, 0.01, 0.02, 0.01]
NOISE = np.random.default_rng(7).normal(0, 1e-6, (3, 6))


def lifted_paraboloid(f):
    """Direction (x, y, (f^2 - r^2) / 2f) of a paraboloid's image, lifted."""
    a, b = CENTRE
    last = [-1, 0, -1, 2 * a, 2 * b, f * f - a * a - b * b]
    across = [[0, 0, 0, 1, 0, -a], [0, 0, 0, 0, 1, -b]]
    return np.array([*across, np.array(last) / (2 * f)])


ZOO = {
    "brown": BrownCamera(K, [-0.2, 0.03], [0.002, -0.003], *SIZE),
    "brown without distortion": BrownCamera(K, [], [0, 0], *SIZE),
    "brown, folding": BrownCamera(K, [-0.3], [0.01, 0.02], *SIZE),
    "division": DivisionCamera(K, [-0.2], *SIZE),
    "division, three terms": DivisionCamera(K, [-0.2, 0.05, -0.03], *SIZE),
    "division, pincushion": DivisionCamera(K, [0.2], *SIZE),
    "shah-aggarwal": ShahAggarwalCamera(K, *SHAH, *SIZE),
    "field of view": FieldOfViewCamera(1.2, K, *SIZE),
    "field of view, radial": FieldOfViewCamera(1.2, K, *SIZE, radial=[-0.05, 0.01]),
    "rational cubic": RationalCubicCamera(CUBIC, *SIZE),
    "lifted": LiftedRationalCamera(lifted_paraboloid(150) + NOISE, *SIZE),
    "lifted, mirror image": LiftedRationalCamera(
        np.diag([-1, 1, 1]) @ lifted_paraboloid(400), *SIZE
    ),
    "kannala-brandt 6": KannalaBrandtCamera([1, -0.05], (170, 160), CENTRE, *SIZE),
    "kannala-brandt 9": KannalaBrandtCamera(KB_K, (170, 160), CENTRE, *SIZE),
    "kannala-brandt 23": KannalaBrandtCamera(
        KB_K, (170, 160), CENTRE, *SIZE, *KB_ODD, *KB_TURN
    ),
    "micusik rational": MicusikPajdlaCamera("rational", 0.006, 2e-6, CENTRE, *SIZE),
    "micusik rational, b < 0": MicusikPajdlaCamera(
        "rational", 0.006, -2e-6, CENTRE, *SIZE
    ),
    "micusik sine": MicusikPajdlaCamera("sine", 180, 0.6, CENTRE, *SIZE),
    "scaramuzza": ScaramuzzaCamera(
        [150, -2e-3, 1e-7, -1e-9], CENTRE, *SIZE, affine=(1.01, 0.003, -0.002)
    ),
    "scaramuzza, looking back": ScaramuzzaCamera([-150, 2e-3, 1e-6], CENTRE, *SIZE),
    "tardif": TardifCamera([180, -0.1, -1e-3, 2e-7, -1e-9, 1e-12], CENTRE, *SIZE),
    "sphere, hyperboloid": UnifiedSphereCamera(0.8, K, *SIZE),
    "sphere, paraboloid": UnifiedSphereCamera(1, K, *SIZE),
    "sphere, beyond": UnifiedSphereCamera(1.4, K, *SIZE),
    "sphere, limited": UnifiedSphereCamera(1, K, *SIZE, max_angle=0.9),
    "mei-rives": UnifiedSphereCamera(
        0.9, K, *SIZE, radial=[-0.1, 0.02, -0.001], tangential=[0.001, -0.002]
    ),
}
PARAMETERS = dict(
    zip(
        ZOO,
        [9, 7, 8, 6, 8, 6, 15, 6, 8, 38, 17, 17, 6, 9, 23]
        + [4, 4, 4, 9, 8, 8, 6, 6, 6, 6, 11],
        strict=True,
    )
)


def unit(points):
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def angle_between(a, b):
    return 2 * np.arcsin(np.linalg.norm(a - b, axis=1) / 2)


@pytest.mark.parametrize("name", ZOO)
def test_points_on_the_ray_of_a_pixel_project_to_it(name):
    camera = ZOO[name]
    rng = np.random.default_rng(0)
    pixels = np.vstack([rng.uniform(-0.5, [639.5, 479.5], (3000, 2)), [CENTRE]])
    origins, directions, valid = camera.rays(pixels)
    assert valid.mean() > 0.15
    np.testing.assert_array_equal(origins[valid], 0)
    length = np.linalg.norm(directions[valid], axis=1)
    np.testing.assert_allclose(length, 1, atol=1e-15)
    back = camera.project(10 ** rng.uniform(-3, 6, (len(pixels), 1)) * directions)
    np.testing.assert_array_equal(back.valid, valid)
    assert np.abs(back.pixels - pixels)[valid].max() < 1e-9
    for values in (origins, directions, back.pixels):
        np.testing.assert_array_equal(np.isnan(values).any(axis=1), ~valid)


@pytest.mark.parametrize("name", ZOO)
def test_the_ray_of_a_points_pixel_passes_through_the_point(name):
    camera = ZOO[name]
    points = np.random.default_rng(1).normal(0, 100, (3000, 3))
    pixels, valid = camera.project(points)
    assert 0.1 < valid.mean() <= 1
    rays = camera.rays(pixels[valid])
    assert rays.valid.all()
    gap = angle_between(rays.directions, unit(points[valid]))
    # Next to a turning point a pixel determines its ray only to the root of rounding.
    assert gap.max() < 1e-7
    assert np.quantile(gap, 0.95) < 1e-12


@pytest.mark.parametrize("name", ZOO)
def test_what_is_not_finite_has_no_ray_and_no_pixel(name):
    camera = ZOO[name]
    bad = np.array([[np.nan, 1, 1], [1, np.inf, 1], [1, 1, -np.inf], [0, 0, 0]])
    assert not camera.project(bad).valid.any()
    assert not camera.rays(bad[:2, :2]).valid.any()
    assert not camera.rays(np.array([[np.inf, np.inf], [1e300, -1e300]])).valid.any()
    assert camera.rays(np.zeros((0, 2))).valid.shape == (0,)
    assert camera.project(np.zeros((0, 3))).valid.shape == (0,)


@pytest.mark.parametrize("name", ZOO)
def test_files_bring_back_the_same_camera(name, tmp_path):
    camera = ZOO[name]
    camera.save(tmp_path / "camera.npz")
    again = load_camera(tmp_path / "camera.npz")
    assert type(again) is type(camera)
    assert again.parameters == camera.parameters == PARAMETERS[name]
    pixels = np.random.default_rng(2).uniform(0, SIZE, (100, 2))
    np.testing.assert_array_equal(
        again.rays(pixels).directions, camera.rays(pixels).directions
    )
    assert CAMERAS[camera.kind] is type(camera)
    assert camera.projects
    assert camera.central


def test_parameters_of_the_older_kinds():
    assert PerspectiveCamera(K, [0.1, 0.2], *SIZE).parameters == 7
    assert FisheyeCamera("equisolid", 100, CENTRE, *SIZE).parameters == 3
    seen = np.arange(12).reshape(3, 4) > 2
    directions = np.ones((3, 4, 3))
    assert GeneralCamera(directions, seen).parameters == 2 * 9
    assert GeneralCamera(directions, seen, 0 * directions).parameters == 4 * 9


@pytest.mark.parametrize(
    ("radial", "tangential"),
    [([], [0.01, -0.02]), ([-0.2, 0.05], [0.003, 0.002]), ([0.1, 0, 0.02], [0, -0.01])],
)
def test_brown_is_opencvs_model(radial, tangential):
    points = np.random.default_rng(3).uniform([-1, -1, 2], [1, 1, 4], (500, 3))
    camera = BrownCamera(K, radial, tangential, *SIZE)
    k = [*radial, 0, 0, 0][:3]
    square = K * [[1, 0, 1], [1, 1, 1], [1, 1, 1]]
    theirs, _ = cv2.projectPoints(
        points, np.zeros(3), np.zeros(3), square, np.array([*k[:2], *tangential, k[2]])
    )
    straight = BrownCamera(square, radial, tangential, *SIZE)
    np.testing.assert_allclose(straight.project(points).pixels, theirs[:, 0], atol=1e-9)
    # Skew acts after the distortion.
    shear = (camera.project(points).pixels - straight.project(points).pixels)[:, 0]
    np.testing.assert_allclose(shear, 1.5 * (theirs[:, 0, 1] - 250) / 280, atol=1e-9)


def test_brown_without_decentring_is_the_perspective_camera():
    brown, old = (
        c(K, [-0.3, 0.02], *more, *SIZE)
        for c, more in ((BrownCamera, ([0, 0],)), (PerspectiveCamera, ()))
    )
    pixels = np.random.default_rng(4).uniform(-300, 900, (2000, 2))
    ours, theirs = brown.rays(pixels), old.rays(pixels)
    np.testing.assert_array_equal(ours.valid, theirs.valid)
    # Next to the turning point the ray is determined only to the root of rounding.
    np.testing.assert_allclose(ours.directions, theirs.directions, atol=1e-7)
    assert brown.max_angle == pytest.approx(math.atan(old.max_radius), abs=1e-9)


def test_symmetric_kannala_brandt_is_opencvs_fisheye():
    camera = KannalaBrandtCamera(KB_K, (170, 160), CENTRE, *SIZE)
    points = np.random.default_rng(5).uniform([-3, -3, 0.2], [3, 3, 2], (500, 3))
    matrix = np.array([[170, 0, CENTRE[0]], [0, 160, CENTRE[1]], [0, 0, 1]])
    theirs, _ = cv2.fisheye.projectPoints(
        points[:, None], np.zeros(3), np.zeros(3), matrix, np.array(KB_K[1:])
    )
    np.testing.assert_allclose(camera.project(points).pixels, theirs[:, 0], atol=1e-9)


def test_complete_kannala_brandt_is_its_formula():
    theta, phi = np.random.default_rng(6).uniform([0.01, -3.1], [3, 3.1], (300, 2)).T
    camera = ZOO["kannala-brandt 23"]
    odd = theta[:, None] ** np.arange(1, 11, 2)
    waves = np.column_stack(
        [np.cos(phi), np.sin(phi), np.cos(2 * phi), np.sin(2 * phi)]
    )
    r = odd @ KB_K + (odd[:, :3] @ KB_ODD[0]) * (waves @ KB_ODD[1])
    t = (odd[:, :3] @ KB_TURN[0]) * (waves @ KB_TURN[1])
    x = r * np.cos(phi) - t * np.sin(phi)
    y = r * np.sin(phi) + t * np.cos(phi)
    points = np.column_stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
    )
    pixels = camera.project(points).pixels
    np.testing.assert_allclose(
        pixels, np.column_stack([170 * x, 160 * y]) + CENTRE, atol=1e-10
    )


def test_division_undistorts_by_its_formula():
    camera = ZOO["division, three terms"]
    pixels = np.random.default_rng(8).uniform(0, SIZE, (300, 2))
    y = (pixels[:, 1] - 250) / 280
    x = (pixels[:, 0] - 330 - 1.5 * y) / 300
    s = x * x + y * y
    depth = 1 - 0.2 * s + 0.05 * s**2 - 0.03 * s**3
    d = camera.rays(pixels).directions
    np.testing.assert_allclose(d[:, 0] / d[:, 2], x / depth, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(d[:, 1] / d[:, 2], y / depth, rtol=1e-12, atol=1e-14)
    # 1 - 0.2 r^2 = 0 is the line at infinity: the plane ends at 90 degrees.
    one = ZOO["division"]
    assert one.max_angle == math.pi / 2
    assert one.max_radius == pytest.approx(math.sqrt(5), rel=1e-14)


@pytest.mark.parametrize("name", ["scaramuzza", "scaramuzza, looking back"])
def test_scaramuzza_is_equation_2_10(name):
    camera = ZOO[name]
    c, d, e = camera.affine
    p = np.random.default_rng(9).uniform(-200, 200, (300, 2))
    pixels = p @ np.array([[c, d], [e, 1]]).T + CENTRE
    r = np.hypot(*p.T)
    a0, *rest = camera.coefficients
    depth = a0 + sum(a * r**n for n, a in enumerate(rest, 2))
    expected = unit(np.column_stack([p, depth]))
    np.testing.assert_allclose(camera.rays(pixels).directions, expected, atol=1e-13)
    on_axis = camera.rays(np.array([CENTRE])).directions[0]
    np.testing.assert_array_equal(on_axis, [0, 0, np.sign(a0)])


def test_tardif_is_a_focal_length_for_each_radius_and_sees_behind():
    camera = ZOO["tardif"]
    p = np.random.default_rng(10).uniform(-220, 220, (300, 2))
    focal = np.polynomial.polynomial.polyval(np.hypot(*p.T), camera.coefficients)
    expected = unit(np.column_stack([p, focal]))
    rays = camera.rays(p + CENTRE)
    np.testing.assert_allclose(rays.directions, expected, atol=1e-14)
    assert math.degrees(camera.max_angle) == pytest.approx(125.9, abs=0.1)


def test_field_of_view_and_micusik_pajdla_are_their_formulas():
    theta = np.linspace(0.01, 1.4, 50)
    square = np.diag([300.0, 300, 1])
    fov = radii_of(FieldOfViewCamera(1.2, square, *SIZE), theta)
    wanted = 300 / 1.2 * np.arctan(2 * np.tan(theta) * math.tan(0.6))
    np.testing.assert_allclose(fov, wanted, rtol=1e-13)
    r = radii_of(ZOO["micusik rational"], theta)
    np.testing.assert_allclose(0.006 * r / (1 + 2e-6 * r**2), theta, rtol=1e-13)
    sine = radii_of(ZOO["micusik sine"], theta)
    np.testing.assert_allclose(sine, 300 * np.sin(0.6 * theta), rtol=1e-13)


def test_shah_aggarwal_is_two_polynomials_of_the_radius():
    camera = ZOO["shah-aggarwal"]
    points = np.random.default_rng(12).normal(0, 1, (400, 3)) + [0, 0, 2]
    pixels, valid = camera.project(points)
    assert valid.mean() > 0.8
    x, y = (points[:, :2] / points[:, 2:]).T
    r, phi = np.hypot(x, y), np.arctan2(y, x)
    a, b = (sum(c * r ** (k + 1) for k, c in enumerate(terms)) for terms in SHAH)
    q = np.column_stack([a * np.cos(phi + b), a * np.sin(phi + b)])
    expected = q @ K[:2, :2].T + K[:2, 2]
    np.testing.assert_allclose(pixels[valid], expected[valid], atol=1e-9)
    # The radius stops rising where its derivative vanishes.
    rise = np.array([1.06, -0.48, -0.225, 0.188, -0.0315])
    limit = smallest_positive_root(rise)
    assert math.tan(camera.max_angle) == pytest.approx(limit, abs=1e-9)
    np.testing.assert_array_equal(valid, (points[:, 2] > 0) & (r <= limit))


def test_a_twist_of_many_turns_is_undone():
    twist = [0.15, 0.2, -0.5, -0.14, 2]
    camera = ShahAggarwalCamera(K, [1, -0.24, 0.25, 0.13, 0.035], twist, *SIZE)
    r = np.linspace(0.01, 20, 300)
    directions = unit(np.column_stack([0.6 * r, -0.8 * r, 1 + 0 * r]))
    pixels, valid = camera.project(directions)
    assert valid.all()
    rays = camera.rays(pixels)
    assert rays.valid.all()
    # The last turn is of six million radians, known to the rounding of those.
    assert angle_between(rays.directions, directions).max() < 1e-8


def test_models_meet_where_they_must():
    points = np.random.default_rng(11).normal(0, 1, (500, 3))
    pinhole = PerspectiveCamera(K, [], *SIZE).project(points)
    lifted = [[0, 0, 0, 1 / 300, 0, -1.1], [0, 0, 0, 0, 1 / 280, -25 / 28]]
    plain = np.zeros((4, 10))
    plain[[1, 3], 0] = 1
    plain[0, :3], plain[2, :3] = [330, 300, 0], [250, 0, 280]
    straight = PerspectiveCamera(
        K * [[1, 0, 1], [1, 1, 1], [1, 1, 1]], [], *SIZE
    ).project(points)
    twins = [
        (UnifiedSphereCamera(0, K, *SIZE), pinhole),
        (DivisionCamera(K, [0], *SIZE), pinhole),
        (LiftedRationalCamera([*lifted, [0, 0, 0, 0, 0, 1]], *SIZE), straight),
        (RationalCubicCamera(plain, *SIZE), straight),
    ]
    stereographic = FisheyeCamera("stereographic", 150, CENTRE, *SIZE).project(points)
    equidistance = FisheyeCamera("equidistance", 150, CENTRE, *SIZE).project(points)
    equisolid = FisheyeCamera("equisolid", 150, CENTRE, *SIZE).project(points)
    matrix = [[300, 0, 330], [0, 300, 250], [0, 0, 1]]
    twins += [
        (UnifiedSphereCamera(1, matrix, *SIZE), stereographic),
        (LiftedRationalCamera(lifted_paraboloid(300), *SIZE), stereographic),
        (ScaramuzzaCamera([150, -1 / 600], CENTRE, *SIZE), stereographic),
        (TardifCamera([150, 0, -1 / 600], CENTRE, *SIZE), stereographic),
        (KannalaBrandtCamera([150, 0], (1, 1), CENTRE, *SIZE), equidistance),
        (MicusikPajdlaCamera("sine", 150, 0, CENTRE, *SIZE), equidistance),
        (MicusikPajdlaCamera("rational", 1 / 150, 0, CENTRE, *SIZE), equidistance),
        (MicusikPajdlaCamera("sine", 150, 0.5, CENTRE, *SIZE), equisolid),
    ]
    for camera, (pixels, valid) in twins:
        inside = valid & PerspectiveCamera(K, [], *SIZE).in_image(pixels)
        found = camera.project(points)
        assert inside.mean() > 0.1
        assert found.valid[inside].all(), camera.kind
        np.testing.assert_allclose(found.pixels[inside], pixels[inside], atol=2e-9)


def test_the_lifted_ray_is_a_chi():
    camera = ZOO["lifted"]
    u, v = np.random.default_rng(12).uniform(0, SIZE, (300, 2)).T
    chi = np.column_stack([u * u, u * v, v * v, u, v, np.ones(300)])
    d = camera.rays(np.column_stack([u, v])).directions
    np.testing.assert_allclose(d, unit(chi @ camera.A.T), atol=2e-13)


def test_the_rational_cubic_pixel_is_two_ratios():
    camera = ZOO["rational cubic"]
    x, y = np.random.default_rng(13).uniform(-0.6, 0.6, (2, 300))
    one = np.ones(300)
    monomials = [one, x, y, x * x, x * y, y * y, x**3, x * x * y, x * y * y, y**3]
    n_u, d_u, n_v, d_v = CUBIC @ np.array(monomials)
    pixels = camera.project(7 * np.column_stack([x, y, one])).pixels
    np.testing.assert_allclose(pixels, np.column_stack([n_u / d_u, n_v / d_v]))
    # A common factor of a ratio changes nothing: 40 coefficients, 38 parameters.
    scaled = RationalCubicCamera(CUBIC * [[-3], [-3], [5], [5]], *SIZE)
    np.testing.assert_allclose(scaled.coefficients, camera.coefficients, rtol=1e-14)


def test_mei_rives_distorts_the_plane_of_the_sphere_model():
    camera = ZOO["mei-rives"]
    points = unit(np.random.default_rng(14).normal(0, 1, (500, 3)) + [0, 0, 1.5])
    x, y = (points[:, :2] / (points[:, 2:] + 0.9)).T
    s = x * x + y * y
    factor = 1 - 0.1 * s + 0.02 * s**2 - 0.001 * s**3
    p1, p2 = 0.001, -0.002
    bent = [
        x * factor + 2 * p1 * x * y + p2 * (s + 2 * x * x),
        y * factor + p1 * (s + 2 * y * y) + 2 * p2 * x * y,
    ]
    pixels, valid = camera.project(points)
    expected = np.column_stack([*bent, np.ones(500)]) @ K[:2].T
    assert valid.mean() > 0.9
    np.testing.assert_allclose(pixels[valid], expected[valid], atol=1e-10)


@pytest.mark.parametrize(
    ("camera", "degrees"),
    [
        (ZOO["kannala-brandt 6"], math.degrees(math.sqrt(1 / 0.15))),
        (ZOO["micusik rational"], math.degrees(0.006 / (2 * math.sqrt(2e-6)))),
        (ZOO["micusik sine"], 150),
        (ZOO["sphere, hyperboloid"], math.degrees(math.acos(-0.8))),
        (ZOO["sphere, beyond"], math.degrees(math.acos(-1 / 1.4))),
        (ZOO["sphere, paraboloid"], 180),
        (ZOO["field of view"], 90),
        (ZOO["division, pincushion"], math.degrees(math.atan(math.sqrt(5) / 2))),
    ],
)
def test_each_law_ends_at_its_first_turning_point(camera, degrees):
    assert math.degrees(camera.max_angle) == pytest.approx(degrees, abs=1e-6)
    limit = camera.max_angle
    angles = np.array([0.5, 0.999, 1.0005]) * limit
    seen = ~np.isnan(radii_of(camera, angles[angles < math.pi]))
    np.testing.assert_array_equal(seen, [True, True, False][: len(seen)])
    radii = radii_of(camera, np.linspace(0, limit, 300)[:-1])
    assert (np.diff(radii) > 0).all()


def test_a_map_with_decentring_ends_at_its_first_folding_circle():
    camera = ZOO["brown, folding"]
    warp = BrownMap(np.array([-0.3]), np.array([0.01, 0.02]), math.inf)
    assert math.tan(camera.max_angle) == pytest.approx(warp.limit)
    phi = np.linspace(0, 2 * math.pi, 3001)
    ring = warp.limit * np.column_stack([np.cos(phi), np.sin(phi)])
    assert warp.regular(0.999 * ring).all()
    assert not warp.regular(1.001 * ring).all()


def test_a_narrow_fold_ends_the_field_of_view_too():
    """The slope of r falls below zero for 0.02 of r only: between two scanned rings."""
    radial = [-0.3, 0.04049]
    limit = PerspectiveCamera(K, radial, *SIZE).max_radius
    assert 1.4 < limit < 1.5
    for camera in (
        BrownCamera(K, radial, [0, 0], *SIZE),
        ShahAggarwalCamera(K, [1, 0, radial[0], 0, radial[1]], [0] * 5, *SIZE),
    ):
        assert math.tan(camera.max_angle) == pytest.approx(limit, rel=1e-9)
        r = np.linspace(limit - 0.05, limit + 0.05, 40)
        seen = camera.project(np.column_stack([r, 0 * r, 1 + 0 * r]))
        np.testing.assert_array_equal(seen.valid, r < limit)


MAPS = {
    "brown": BrownMap(np.array([-0.2, 0.03]), np.array([0.01, -0.02]), 1.0),
    "kannala-brandt": AsymmetricMap(*map(np.array, (KB_K, *KB_ODD, *KB_TURN)), 2.0),
    "cubic": CubicMap(CUBIC, 0.8),
    "shah-aggarwal": PolarMap(*SHAH, 1.0),
    "lifted": LiftedMap(np.random.default_rng(15).normal(0, 1, (3, 6)), 0.5),
}


@pytest.mark.parametrize("name", MAPS)
def test_jacobians_agree_with_differences(name):
    warp, h = MAPS[name], 1e-6
    p = np.random.default_rng(16).uniform(-0.4, 0.4, (100, 2))
    J = warp.jacobian(p)
    for k, step in enumerate(h * np.eye(2)):
        slope = (warp.value(p + step) - warp.value(p - step)) / (2 * h)
        np.testing.assert_allclose(
            J[:, :, k], slope, atol=1e-7 * np.abs(J).max(), rtol=1e-6
        )


coefficient = st.integers(-200, 200).map(lambda n: n / 1000)


@given(
    st.lists(coefficient, max_size=3),
    st.tuples(coefficient, coefficient).map(lambda p: np.array(p) / 10),
    st.integers(0, 2**32 - 1),
)
@settings(max_examples=25, deadline=None)
def test_any_brown_camera_goes_round(radial, tangential, seed):
    camera = BrownCamera(K, radial, tangential, *SIZE)
    points = np.random.default_rng(seed).normal(0, 1, (200, 3))
    pixels, valid = camera.project(points)
    rays = camera.rays(pixels[valid])
    assert rays.valid.all()
    again = camera.project(rays.directions)
    np.testing.assert_allclose(again.pixels, pixels[valid], rtol=1e-12, atol=1e-9)


@given(
    st.floats(-1, 3), st.floats(-0.5, 0.5), st.floats(0.1, 5), st.integers(0, 2**32 - 1)
)
@settings(max_examples=25, deadline=None)
def test_a_rising_cubic_is_inverted(cube, square, line, seed):
    slope = [line, 2 * square, 3 * cube]
    high = min(smallest_positive_root(slope), 10.0)
    x = np.random.default_rng(seed).uniform(0, 0.99 * high, 50)
    poly = np.polynomial.Polynomial([0, line, square, cube])
    found = invert_rising(poly, poly.deriv(), poly(x), high)
    np.testing.assert_allclose(poly(found), poly(x), rtol=1e-13, atol=1e-14)
    assert (found <= high).all()


@pytest.mark.parametrize("high", [3.0, np.inf])
def test_zero_comes_back_at_once_and_exactly(high):
    calls = []

    def slope(x):
        calls.append(x)
        return 1 + x**2

    found = invert_rising(lambda x: x + x**3 / 3, slope, np.zeros(2), high)
    assert np.array_equal(found, [0.0, 0.0])
    assert len(calls) <= 1


BAD = {
    "not even": (lambda: BrownCamera(-K, [], [0, 0], *SIZE), "'K'"),
    "decentring": (lambda: BrownCamera(K, [], [0, 0, 0], *SIZE), "'tangential'"),
    "no l1": (lambda: DivisionCamera(K, [], *SIZE), "'coefficients'"),
    "a1": (lambda: ShahAggarwalCamera(K, [0, 1, 0, 0, 0], [0] * 5, *SIZE), "'radial'"),
    "b5": (lambda: ShahAggarwalCamera(K, SHAH[0], [0] * 4, *SIZE), "'tangential'"),
    "omega": (lambda: FieldOfViewCamera(3.5, K, *SIZE), "'omega'"),
    "folds at once": (
        lambda: FieldOfViewCamera(1.2, K, *SIZE, radial=[-1], max_angle=1.5),
        "'max_angle'",
    ),
    "k1": (lambda: KannalaBrandtCamera([-1, 0], (1, 1), CENTRE, *SIZE), "'k'"),
    "k6": (lambda: KannalaBrandtCamera([1] * 6, (1, 1), CENTRE, *SIZE), "'k'"),
    "mu": (
        lambda: KannalaBrandtCamera([1, 0], (1, -1), CENTRE, *SIZE),
        "'pixels_per_unit'",
    ),
    "half a pair": (
        lambda: KannalaBrandtCamera([1, 0], (1, 1), CENTRE, *SIZE, radial_l=[1, 0, 0]),
        "'radial_i'",
    ),
    "beyond the turn": (
        lambda: KannalaBrandtCamera([1, -0.1], (1, 1), CENTRE, *SIZE, max_angle=2),
        "'max_angle'.*104.61 degrees",
    ),
    "law": (lambda: MicusikPajdlaCamera("cosine", 1, 1, CENTRE, *SIZE), "'law'"),
    "a": (lambda: MicusikPajdlaCamera("sine", -1, 1, CENTRE, *SIZE), "'a'"),
    "a0": (lambda: ScaramuzzaCamera([0, 1], CENTRE, *SIZE), "'coefficients'"),
    "affine": (
        lambda: ScaramuzzaCamera([9], CENTRE, *SIZE, affine=(1, 2, 1)),
        "'affine'",
    ),
    "xi": (lambda: UnifiedSphereCamera(-0.1, K, *SIZE), "'xi'"),
    "180 degrees of a plane": (
        lambda: BrownCamera(K, [], [0, 0], *SIZE, max_angle=1.6),
        "'max_angle'.*90.00 degrees",
    ),
    "lifted": (lambda: LiftedRationalCamera(np.zeros((3, 6)), *SIZE), "'A'"),
    "lifted fold": (lambda: LiftedRationalCamera(np.ones((3, 6)), *SIZE), "'A'"),
    "pole": (lambda: RationalCubicCamera(np.zeros((4, 10)), *SIZE), "D_u"),
    "mirrored": (
        lambda: RationalCubicCamera(CUBIC * [[-1], [1], [1], [1]], *SIZE),
        "folds at its centre",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_impossible_parameters_are_named_in_one_line(name):
    make, field = BAD[name]
    with pytest.raises(InputError, match=field) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_cameras_are_made_by_name():
    fields = {"xi": 0.9, "K": K.tolist(), "width": 640, "height": 480}
    assert camera_from("unified sphere", fields).xi == 0.9
    cases = [
        ("unified spere", fields, "did you mean 'unified sphere'"),
        ("unified sphere", fields | {"radal": []}, "'radal'.*did you mean 'radial'"),
        ("unified sphere", {"K": K}, "'xi': missing"),
        ("unified sphere", fields | {"K": [[1, 2], [3]]}, "wrong type"),
        ("unified sphere", fields | {"xi": None}, "'xi'|wrong type"),
    ]
    for kind, given_fields, text in cases:
        with pytest.raises(InputError, match=text) as caught:
            camera_from(kind, given_fields)
        assert "\n" not in str(caught.value)


FITS = [
    (ZOO["micusik rational"], {"a": 0.0063, "b": 1e-6}, 2),
    (ZOO["micusik sine"], {"a": 200, "b": 0.4}, 2),
    (ZOO["kannala-brandt 9"], {"k": [1.1, 0, 0, 0, 0]}, 5),
    (ZOO["tardif"], {"coefficients": [200, 0, -1e-3, 0, 0, 0]}, 6),
    (ZOO["division, three terms"], {"coefficients": [-0.1, 0, 0]}, 4),
    (ZOO["field of view, radial"], {"omega": 1.1, "radial": [0, 0]}, 4),
    (ZOO["sphere, beyond"], {"xi": 1.1}, 2),
]


@pytest.mark.parametrize(("truth", "start", "free"), FITS)
def test_a_radial_law_is_found_again_from_its_own_radii(truth, start, free):
    angles = np.linspace(0, 1.2, 60)
    fields = {k: v for k, v in truth._fields().items() if k != "max_angle"}
    for name in ("xi", "omega", "a", "b", "law"):
        if name in fields:
            fields[name] = fields[name].item()
    fields |= {"width": 640, "height": 480} | start
    found = fit_camera(type(truth)(**fields), angles, radii_of(truth, angles))
    assert found.free == free
    assert found.rms_px < 1e-6
    between = np.linspace(0.01, 1.19, 77)
    np.testing.assert_allclose(
        radii_of(found.camera, between), radii_of(truth, between), atol=1e-5
    )


def test_more_terms_never_fit_worse_even_where_the_plane_model_wants_to_fold():
    angles = np.radians(np.linspace(0, 70, 80))
    square = np.diag([300.0, 300, 1])
    rms = [
        fit_camera(PerspectiveCamera(square, [0.0] * n, *SIZE), angles, 300 * angles)
        for n in range(4)
    ]
    sizes = [fit.rms_px for fit in rms]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] > 10 * sizes[3]
    assert not np.isnan([fit.residuals_px for fit in rms]).any()


def test_fits_that_cannot_be_are_refused():
    angles = np.linspace(0, 1.2, 30)
    cases = [
        (ZOO["brown"], angles, "not radially symmetric"),
        (ZOO["kannala-brandt 23"], angles, "not radially symmetric"),
        (ZOO["rational cubic"], angles, "not radially symmetric"),
        (ZOO["division"], np.linspace(0, 1.6, 30), "does not see 1 of the angles"),
        (ZOO["tardif"], angles[:3], "at least 6"),
    ]
    for camera, given_angles, text in cases:
        with pytest.raises(InputError, match=text) as caught:
            fit_camera(camera, given_angles, 100 * given_angles)
        assert "\n" not in str(caught.value)
