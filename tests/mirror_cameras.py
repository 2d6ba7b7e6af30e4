"""Mirror cameras of every shape, for the tests of all that they do."""

import numpy as np
import pytest

from raxel.cameras import OrthographicCamera, PerspectiveCamera, QuadricMirrorCamera

W, H = 640, 480
PINHOLE = PerspectiveCamera([[600, 0, 319.5], [0, 600, 239.5], [0, 0, 1]], [], W, H)
WIDE = PerspectiveCamera([[300, 0, 319.5], [0, 300, 239.5], [0, 0, 1]], [], W, H)
PARALLEL = OrthographicCamera(8, (319.5, 239.5), W, H)
HYPERBOLOID = ("hyperboloid", (30, 20), 25)
PARABOLOID = ("paraboloid", (10,), 25)
ELLIPSOID = ("ellipsoid", (60, 40), 25)
aligned, misaligned = QuadricMirrorCamera.aligned, QuadricMirrorCamera.misaligned
on_axis = QuadricMirrorCamera.on_axis
CENTRAL = {
    "hyperboloid": aligned(PINHOLE, *HYPERBOLOID),
    "hyperboloid inside": aligned(WIDE, "hyperboloid", (30, 40), 25, side="inside"),
    "paraboloid": aligned(PARALLEL, *PARABOLOID, hole_radius=2),
    "paraboloid inside": aligned(PARALLEL, "paraboloid", (10,), 15, side="inside"),
    "ellipsoid": aligned(PINHOLE, *ELLIPSOID),
}
CONVEX = {
    "sphere": on_axis(PINHOLE, "sphere", (30,), 25, 100),
    "sphere, parallel": on_axis(PARALLEL, "sphere", (30,), 25, 100),
    "hyperboloid off": misaligned(PINHOLE, *HYPERBOLOID, (3, -2, 10), (0.05, 0.02, 0)),
    "hyperboloid near": misaligned(PINHOLE, *HYPERBOLOID, (1e-3, 0, 0)),
    "paraboloid tilted": misaligned(PARALLEL, *PARABOLOID, (1, 2, 0), (0.05, -0.02, 0)),
    "paraboloid, pinhole": on_axis(PINHOLE, *PARABOLOID, 90),
}
CONCAVE = {
    "ellipsoid off": misaligned(PINHOLE, *ELLIPSOID, (2, 1, 5), (0.05, 0.02, 0)),
    "sphere inside": on_axis(PINHOLE, "sphere", (100,), 30, 150, side="inside"),
}
MIRRORS = CENTRAL | CONVEX | CONCAVE
EVERY = pytest.mark.parametrize("name", MIRRORS)


def random_pixels(seed, count=1500):
    return np.random.default_rng(seed).uniform(0, [W - 1, H - 1], (count, 2))
