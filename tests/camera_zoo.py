"""One camera of each central kind of section 2.2, for the tests of their models."""

import numpy as np

from raxel.cameras import (
    BrownCamera,
    DivisionCamera,
    FieldOfViewCamera,
    KannalaBrandtCamera,
    LiftedRationalCamera,
    MicusikPajdlaCamera,
    RationalCubicCamera,
    RaySplineCamera,
    ScaramuzzaCamera,
    ShahAggarwalCamera,
    TardifCamera,
    UnifiedSphereCamera,
)

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
    "kannala-brandt, decentred": KannalaBrandtCamera(
        KB_K, (170, 160), CENTRE, *SIZE, tangential=(0.002, -0.003), prism=(0.004, 0.01)
    ),
    "sphere, decentred": UnifiedSphereCamera(
        0.9, K, *SIZE, radial=[-0.1, 0.02], tangential=(0.001, 0), prism=(0.02, -0.01)
    ),
    "mei-rives": UnifiedSphereCamera(
        0.9, K, *SIZE, radial=[-0.1, 0.02, -0.001], tangential=[0.001, -0.002]
    ),
}
PARAMETERS = dict(
    zip(
        ZOO,
        [9, 7, 8, 6, 8, 6, 15, 6, 8, 38, 17, 17, 6, 9, 23]
        + [4, 4, 4, 9, 8, 8, 6, 6, 6, 6, 13, 12, 11],
        strict=True,
    )
)
SPLINE = np.random.default_rng(8).uniform(-4, 4, (11, 14, 2))
ZOO["ray spline"] = RaySplineCamera(ZOO["kannala-brandt 9"], 60, SPLINE, *SIZE)
PARAMETERS["ray spline"] = 9 + SPLINE.size


def radii_of(camera, angles):
    """Image radius in pixels at angles (N,) from the axis, rows along u; NaN unseen."""
    angles = np.asarray(angles, float)
    # The first is the axis.
    angles = np.concatenate([[0.0], angles])
    points = np.column_stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)])
    pixels = camera.project(points).pixels
    return np.hypot(*(pixels[1:] - pixels[0]).T)


def unit(points):
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def angle_between(a, b):
    return 2 * np.arcsin(np.linalg.norm(a - b, axis=1) / 2)


def assert_pixels_come_back(camera, pixels, rng):
    """A point at any distance on a pixel's ray is projected to it; else all is NaN.

    Returns which pixels have a ray, (N,) bool.
    """
    origins, directions, valid = camera.rays(pixels)
    np.testing.assert_array_equal(origins[valid], 0)
    length = np.linalg.norm(directions[valid], axis=1)
    np.testing.assert_allclose(length, 1, atol=1e-15)
    depth = 10 ** rng.uniform(-3, 6, (len(pixels), 1))
    back = camera.project(depth * directions)
    np.testing.assert_array_equal(back.valid, valid)
    assert np.abs(back.pixels - pixels)[valid].max() < 1e-9
    for values in (origins, directions, back.pixels):
        np.testing.assert_array_equal(np.isnan(values).any(axis=1), ~valid)
    return valid
