"""Central models of section 2.2: their formulas, where they meet, where they end."""

import math

import cv2
import numpy as np
import pytest

from raxel.cameras import (
    BrownCamera,
    DivisionCamera,
    FieldOfViewCamera,
    FisheyeCamera,
    KannalaBrandtCamera,
    LiftedRationalCamera,
    MicusikPajdlaCamera,
    PerspectiveCamera,
    RationalCubicCamera,
    ScaramuzzaCamera,
    TardifCamera,
    UnifiedSphereCamera,
    load_camera,
)
from raxel.cameras.lenses.azimuthal import smallest_positive_root
from raxel.cameras.lenses.perspective import BrownMap
from tests.camera_zoo import (
    CENTRE,
    CUBIC,
    KB_K,
    KB_ODD,
    KB_TURN,
    SHAH,
    SIZE,
    ZOO,
    K,
    lifted_paraboloid,
    radii_of,
    unit,
)


@pytest.mark.parametrize(
    ("radial", "tangential"),
    [([], [0.01, -0.02]), ([-0.2, 0.05], [0.003, 0.002]), ([0.1, 0, 0.02], [0, -0.01])],
)
def test_brown_equals_opencv(radial, tangential):
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


def test_symmetric_kannala_brandt_equals_opencv_fisheye():
    camera = KannalaBrandtCamera(KB_K, (170, 160), CENTRE, *SIZE)
    points = np.random.default_rng(5).uniform([-3, -3, 0.2], [3, 3, 2], (500, 3))
    matrix = np.array([[170, 0, CENTRE[0]], [0, 160, CENTRE[1]], [0, 0, 1]])
    theirs, _ = cv2.fisheye.projectPoints(
        points[:, None], np.zeros(3), np.zeros(3), matrix, np.array(KB_K[1:])
    )
    np.testing.assert_allclose(camera.project(points).pixels, theirs[:, 0], atol=1e-9)


@pytest.mark.parametrize(("out", "around"), [(1, 1), (1, 0), (0, 1)])
def test_complete_kannala_brandt_equals_equation(out, around):
    """With both pairs of terms, and with each alone."""
    theta, phi = np.random.default_rng(6).uniform([0.01, -3.1], [3, 3.1], (300, 2)).T
    own = dict(zip(("radial_l", "radial_i"), KB_ODD, strict=True)) if out else {}
    if around:
        own |= dict(zip(("tangential_m", "tangential_j"), KB_TURN, strict=True))
    camera = KannalaBrandtCamera(KB_K, (170, 160), CENTRE, *SIZE, **own)
    odd = theta[:, None] ** np.arange(1, 11, 2)
    waves = np.column_stack(
        [np.cos(phi), np.sin(phi), np.cos(2 * phi), np.sin(2 * phi)]
    )
    r = odd @ KB_K + out * (odd[:, :3] @ KB_ODD[0]) * (waves @ KB_ODD[1])
    t = around * (odd[:, :3] @ KB_TURN[0]) * (waves @ KB_TURN[1])
    x = r * np.cos(phi) - t * np.sin(phi)
    y = r * np.sin(phi) + t * np.cos(phi)
    points = np.column_stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
    )
    pixels = camera.project(points).pixels
    np.testing.assert_allclose(
        pixels, np.column_stack([170 * x, 160 * y]) + CENTRE, atol=1e-10
    )


def test_division_camera_equals_equation():
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
def test_scaramuzza_equals_equation_2_10(name):
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


def test_tardif_camera_sees_behind():
    camera = ZOO["tardif"]
    p = np.random.default_rng(10).uniform(-220, 220, (300, 2))
    focal = np.polynomial.polynomial.polyval(np.hypot(*p.T), camera.coefficients)
    expected = unit(np.column_stack([p, focal]))
    np.testing.assert_allclose(camera.rays(p + CENTRE).directions, expected, atol=1e-14)
    assert math.degrees(camera.max_angle) == pytest.approx(125.9, abs=0.1)


def test_field_of_view_and_micusik_pajdla_equal_equations():
    theta = np.linspace(0.01, 1.4, 50)
    fov = radii_of(FieldOfViewCamera(1.2, np.diag([300.0, 300, 1]), *SIZE), theta)
    wanted = 300 / 1.2 * np.arctan(2 * np.tan(theta) * math.tan(0.6))
    np.testing.assert_allclose(fov, wanted, rtol=1e-13)
    r = radii_of(ZOO["micusik rational"], theta)
    np.testing.assert_allclose(0.006 * r / (1 + 2e-6 * r**2), theta, rtol=1e-13)
    sine = radii_of(ZOO["micusik sine"], theta)
    np.testing.assert_allclose(sine, 300 * np.sin(0.6 * theta), rtol=1e-13)


def test_shah_aggarwal_equals_polynomials():
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
    limit = smallest_positive_root(np.array([1.06, -0.48, -0.225, 0.188, -0.0315]))
    assert math.tan(camera.max_angle) == pytest.approx(limit, abs=1e-9)
    np.testing.assert_array_equal(valid, (points[:, 2] > 0) & (r <= limit))


def test_models_agree_at_special_parameters():
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


def test_rational_cubic_equals_ratios():
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


def test_mei_rives_equals_sphere_distortion():
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
def test_law_ends_at_first_turning_point(camera, degrees):
    assert math.degrees(camera.max_angle) == pytest.approx(degrees, abs=1e-6)
    limit = camera.max_angle
    angles = np.array([0.5, 0.999, 1.0005]) * limit
    seen = ~np.isnan(radii_of(camera, angles[angles < math.pi]))
    np.testing.assert_array_equal(seen, [True, True, False][: len(seen)])
    assert (np.diff(radii_of(camera, np.linspace(0, limit, 300)[:-1])) > 0).all()


def test_decentred_map_ends_at_first_fold():
    camera = ZOO["brown, folding"]
    warp = BrownMap(np.array([-0.3]), np.array([0.01, 0.02]), math.inf)
    assert math.tan(camera.max_angle) == pytest.approx(warp.limit)
    phi = np.linspace(0, 2 * math.pi, 3001)
    ring = warp.limit * np.column_stack([np.cos(phi), np.sin(phi)])
    assert warp.regular(0.999 * ring).all()
    assert not warp.regular(1.001 * ring).all()


@pytest.mark.parametrize("max_angle", [None, 0.9])
@pytest.mark.parametrize("name", ["brown", "kannala-brandt 9", "mei-rives"])
def test_saved_camera_keeps_given_angle_only(name, max_angle, tmp_path):
    fields = {**ZOO[name]._fields(), "width": 640, "height": 480}
    camera = type(ZOO[name])(**fields, max_angle=max_angle)
    camera.save(tmp_path / "camera.npz")
    assert load_camera(tmp_path / "camera.npz").max_angle == camera.max_angle
    with np.load(tmp_path / "camera.npz") as file:
        assert ("max_angle" in file) == (max_angle is not None)
