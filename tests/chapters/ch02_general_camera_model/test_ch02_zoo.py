"""The camera zoo of section 2.2: complete, counted, and as central as it says."""

import numpy as np
import pytest

from chapters.ch02_general_camera_model.s2_camera_models import exercises, report
from chapters.shared.general.zoo import SIZE_PX, ZOO, K_of, camera, made
from raxel.cameras import CAMERAS, centrality

# Kinds of the library that section 2.2 does not name, or shows by another one.
ELSEWHERE = {
    "orthographic",
    "ray spline",
    "flexible mirror",
    "moving pupil",
    "spline mirror",
}
STEPS = np.arange(5.0, SIZE_PX, 11)
PIXELS = np.stack(np.meshgrid(STEPS, STEPS), axis=2).reshape(-1, 2)


def test_zoo_contains_every_camera_kind():
    shown = {camera(name).kind for name in ZOO}
    assert shown == set(CAMERAS) - ELSEWHERE


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("radial", 7),
        ("division", 6),
        ("rational cubic", 38),
        ("lifted rational", 17),
        ("Kannala-Brandt, complete", 23),
        # xi, K, three radial and two tangential terms (Mei and Rives).
        ("unified sphere with distortion", 11),
        ("X-slits", 10),
    ],
)
def test_parameter_counts_match_the_page(name, count):
    assert camera(name).parameters == count


def test_cubic_coefficients_are_counted():
    assert report.free_of_cubics(3) == 4 * 20 - 2
    assert report.free_of_cubics(2) == camera("rational cubic").parameters


@pytest.mark.parametrize("name", ZOO)
def test_zoo_camera_projects_back_and_has_its_centrality(name):
    model = camera(name)
    assert model.width == model.height == SIZE_PX
    rays = model.rays(PIXELS)
    seen = type(rays)(*(part[rays.valid] for part in rays))
    assert model.central == (centrality(seen) < 1e-9)
    # A point seen in two plane mirrors has two pixels.
    if model.kind != "planar mirrors":
        back = model.project(seen.origins + 2000.0 * seen.directions).pixels
        np.testing.assert_allclose(back, PIXELS[rays.valid], atol=1e-9)


@pytest.mark.parametrize("name", ["division", "field of view", "radial"])
def test_plane_models_have_no_ray_at_90_degrees(name):
    point = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, -1e-3]])
    assert not camera(name).project(point).valid.any()


def test_negative_first_coefficient_looks_backwards():
    there = made("scaramuzza", coefficients=[62, -6.6e-3], centre=[99, 99])()
    back = made("scaramuzza", coefficients=[-62, 6.6e-3], centre=[99, 99])()
    ahead, behind = there.rays(PIXELS).directions, back.rays(PIXELS).directions
    np.testing.assert_allclose(behind, ahead * [1, 1, -1], atol=1e-12)


def test_unified_sphere_equals_hyperboloid_with_reversed_z():
    mirror = camera("hyperboloid mirror")
    xi = exercises.sphere_of_hyperboloid()
    # The radius at 90 degrees is f / xi for the sphere, and sets the focal length.
    rays = mirror.rays(PIXELS)
    ahead = rays.directions[rays.valid] * [1, 1, -1]
    unit = made("unified sphere", xi=xi, K=K_of(1.0))()
    seen = unit.project(ahead).pixels - (SIZE_PX - 1) / 2
    off = PIXELS[rays.valid] - (SIZE_PX - 1) / 2
    focal = np.sum(seen * off) / np.sum(seen * seen)
    np.testing.assert_allclose(focal * seen, off, atol=1e-9)


def test_division_model_ends_at_zero_denominator():
    model = camera("division")
    edge = exercises.divided_edge()
    row = model.K[0, 2] + np.array([[edge - 1e-6], [edge + 1e-6]])
    seen = model.rays(np.hstack([row, np.full((2, 1), model.K[1, 2])]))
    assert seen.valid.tolist() == [True, False]
    assert seen.directions[0, 2] == pytest.approx(0, abs=1e-6)


def test_division_model_without_terms_is_a_pinhole():
    pinhole = made("perspective", K=K_of(130), radial=[])()
    plain = made("division", K=K_of(130), coefficients=[0.0])()
    np.testing.assert_allclose(
        plain.rays(PIXELS).directions, pinhole.rays(PIXELS).directions, atol=1e-12
    )
