"""Every central kind of section 2.2: rays and pixels go round, files, bad values."""

import numpy as np
import pytest

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
    UnifiedSphereCamera,
    camera_from,
)
from raxel.cameras.lenses.perspective import distortion_warp
from tests.camera_checks import assert_same_from_file
from tests.camera_zoo import (
    CENTRE,
    CUBIC,
    PARAMETERS,
    SHAH,
    SIZE,
    ZOO,
    K,
    angle_between,
    assert_pixels_come_back,
    unit,
)
from tests.raised import raises_line


@pytest.mark.parametrize("name", ZOO)
def test_points_on_pixel_ray_project_to_it(name):
    camera = ZOO[name]
    rng = np.random.default_rng(0)
    pixels = np.vstack([rng.uniform(-0.5, [639.5, 479.5], (3000, 2)), [CENTRE]])
    assert assert_pixels_come_back(camera, pixels, rng).mean() > 0.15


@pytest.mark.parametrize("name", ZOO)
def test_ray_of_projected_pixel_meets_point(name):
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
def test_non_finite_values_have_no_ray_and_no_pixel(name):
    camera = ZOO[name]
    bad = np.array([[np.nan, 1, 1], [1, np.inf, 1], [1, 1, -np.inf], [0, 0, 0]])
    assert not camera.project(bad).valid.any()
    assert not camera.rays(bad[:2, :2]).valid.any()
    assert not camera.rays(np.array([[np.inf, np.inf], [1e300, -1e300]])).valid.any()
    assert camera.rays(np.zeros((0, 2))).valid.shape == (0,)
    assert camera.project(np.zeros((0, 3))).valid.shape == (0,)


@pytest.mark.parametrize("name", ZOO)
def test_camera_file_roundtrip(name, tmp_path):
    camera = ZOO[name]
    pixels = np.random.default_rng(2).uniform(0, SIZE, (100, 2))
    again = assert_same_from_file(camera, pixels, tmp_path)
    assert again.parameters == PARAMETERS[name]
    assert CAMERAS[camera.kind] is type(camera)
    assert camera.projects
    assert camera.central


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("term", "fold"), [(0, 6), (1, 6), (2, 2), (3, 2)])
def test_single_off_axis_term_folds_plane(term, fold, sign):
    """Of p1, p2, s1, s2: the fold comes first where the term slopes most."""
    size = 0.05 * sign
    terms = np.where(np.arange(4) == term, size, 0.0)
    warp = distortion_warp(np.zeros(0), terms[:2], terms[2:])(np.inf)
    assert warp.limit == pytest.approx(1 / (fold * abs(size)), rel=1e-3)
    x, y = p = np.array([0.3, -0.2])
    moved = [2 * x * y, 3 * y**2 + x**2], [3 * x**2 + y**2, 2 * x * y]
    moved += [x**2 + y**2, 0], [0, x**2 + y**2]
    np.testing.assert_allclose(warp.value(p[None])[0], p + size * np.array(moved[term]))


def test_parameters_of_older_kinds():
    assert PerspectiveCamera(K, [0.1, 0.2], *SIZE).parameters == 7
    assert FisheyeCamera("equisolid", 100, CENTRE, *SIZE).parameters == 3
    seen = np.arange(12).reshape(3, 4) > 2
    directions = np.ones((3, 4, 3))
    assert GeneralCamera(directions, seen).parameters == 2 * 9
    assert GeneralCamera(directions, seen, 0 * directions).parameters == 4 * 9


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
    "decentred twice": (
        lambda: KannalaBrandtCamera(
            [1, 0], (1, 1), CENTRE, *SIZE, *([1, 0, 0], [1, 0, 0, 0]), prism=(1, 0)
        ),
        "'prism'",
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
    with raises_line(field):
        make()


def test_cameras_are_created_by_name():
    fields = {"xi": 0.9, "K": K.tolist(), "width": 640, "height": 480}
    assert camera_from("unified sphere", fields).xi == 0.9
    cases = [
        ("unified spere", fields, r"did you mean unified sphere\?"),
        ("unified sphere", fields | {"radal": []}, r"'radal'.*did you mean radial\?"),
        ("unified sphere", {"K": K}, "'xi': missing; give the fields of kind"),
        ("axial", {}, "missing; give the fields of kind 'axial': projection"),
        ("unified sphere", fields | {"K": [[1, 2], [3]]}, "'K': .*unequal"),
        ("unified sphere", fields | {"xi": None}, "'xi'|wrong type"),
    ]
    for kind, given_fields, text in cases:
        with raises_line(text):
            camera_from(kind, given_fields)
