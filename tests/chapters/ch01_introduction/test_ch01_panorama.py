"""Chapter 1: the panorama of Fig. 1.1 and the resolution of its rows."""

import numpy as np
import pytest

from chapters.ch01_introduction.s1_1_panorama import exercises, experiment, page, report
from raxel.multiview.views import source_pixels
from tests.made_results import of_columns, of_seed


@pytest.fixture(scope="module")
def rows():
    conditions = [{"mirror": name} for name in experiment.ECCENTRICITIES]
    return of_seed(page.resolution_trial, conditions)


@pytest.fixture(scope="module")
def image():
    return page.image_trial({"size": 0.25}, np.random.default_rng(0))


def closed_form(e, focal, radius_px, elevations):
    """Source px per unwrapped px along row and column, from the mirror's formula."""
    psi = np.pi / 2 + elevations
    q = (e - 1) / (e + 1)
    tangent = q * np.tan(psi / 2)
    phi = 2 * np.arctan(tangent)
    r = focal * np.tan(phi)
    per_psi = focal / np.cos(phi) ** 2 * q / np.cos(psi / 2) ** 2 / (1 + tangent**2)
    return r / radius_px, per_psi * np.cos(elevations) ** 2 / radius_px


def test_scales_match_the_closed_form():
    camera = experiment.simulator(1.0).camera
    view = experiment.view_of(camera)
    elevations = np.radians(np.linspace(-45, 45, 13))
    area, row, column = experiment.scales(camera, view, elevations)
    e = camera.mirror.eccentricity
    wanted = closed_form(e, camera.viewer.K[0, 0], view.radius, elevations)
    np.testing.assert_allclose([row, column], wanted, rtol=1e-4)
    np.testing.assert_allclose(area, row * column, rtol=1e-6)


def test_mirrors_have_the_same_edge_in_world_and_image():
    for name, e in experiment.ECCENTRICITIES.items():
        if e is None:
            continue
        camera = experiment.mirror_camera(name)
        assert camera.central
        assert camera.mirror.eccentricity == pytest.approx(e)
        inner, outer = np.array([-0.01, 0.01]) + experiment.RIM_PX
        pixels = np.array(experiment.MIDDLE) + [[inner, 0], [outer, 0]]
        rays = camera.rays(pixels)
        assert rays.valid.tolist() == [True, False]
        highest = np.degrees(np.arcsin(-rays.directions[0] @ experiment.DOWN))
        assert highest == pytest.approx(experiment.HIGHEST_DEG, abs=0.01)


def test_resolution_claim_holds_for_every_mirror_and_fails(rows):
    judge = report.judge_unwrap_resolution
    reading = judge({"fig_1_1_resolution": rows})
    assert reading.verdict == "reproduced"
    assert np.all(rows.select().column("ratio") > experiment.MIN_RATIO)
    assert np.isfinite(rows.select().column("band_deg")).all()
    even = of_columns(*((c, {"ratio": 1.4, "band_deg": 10.0}) for c in rows.conditions))
    reading = judge({"fig_1_1_resolution": even})
    assert reading.verdict == "differs"


def test_resolution_compares_the_top_and_the_bottom_row(rows):
    view = experiment.view_of(experiment.simulator(1.0).camera)
    ends = np.degrees(view.elevations([0, view.height - 1]))
    for mirror in experiment.ECCENTRICITIES:
        (elevations,) = rows.arrays("elevation_deg", mirror=mirror)
        assert len(elevations) == view.height
        np.testing.assert_allclose(elevations[[0, -1]], ends)


def test_reduced_image_shows_the_same_view():
    cameras = [experiment.simulator(size).camera for size in (1.0, 0.25)]
    np.testing.assert_allclose(cameras[0].centre, cameras[1].centre)
    corner = np.array([[200.0, 300.0]])
    smaller = (corner + 0.5) / 4 - 0.5
    one, two = (
        camera.rays(pixel).directions
        for camera, pixel in zip(cameras, (corner, smaller), strict=True)
    )
    np.testing.assert_allclose(one, two, atol=1e-12)


def test_unwrapped_image_has_straight_verticals(image):
    assert image["picture"].dtype == image["unwrapped"].dtype == np.uint8
    assert image["unwrapped"].shape[1:] == (320, 3)
    assert image["spread_px"] < 1e-6
    assert image["horizon_error_px"] < 1e-6
    for change, holds in (({}, True), ({"spread_px": 0.1}, False)):
        values = image | change
        taken = of_seed(lambda condition, rng, values=values: values)
        assert report.fig_1_1({"fig_1_1_picture": taken}).check.holds is holds


def test_panorama_is_centred_on_the_forward_direction():
    camera = experiment.simulator(0.25).camera
    view = experiment.view_of(camera)
    sources = source_pixels(camera, view)
    u, v = sources[int(view.horizon), view.width // 2]
    assert u == pytest.approx(camera.viewer.K[0, 2], abs=1.0)
    assert v < camera.viewer.K[1, 2] - 30
    # A mirror seen from below reverses the image.
    right = sources[int(view.horizon), view.width * 3 // 4]
    assert right[0] < camera.viewer.K[0, 2] - 30


def test_step_edge_is_located_and_thin_line_is_rejected():
    grey = np.zeros((10, 40))
    grey[:, 20:] = 100.0
    grey[:, 19] = 30.0
    rows = np.arange(10)
    found = experiment.steps_along(grey, 19.0, rows)
    # Brightness 0, 30, 100: 30 % of the step before 19, 70 % after it.
    np.testing.assert_allclose(found, 19.2, atol=1e-9)
    grey[:, 21:] = 0.0
    assert np.isnan(experiment.steps_along(grey, 19.0, rows)).all()
    assert np.isnan(experiment.steps_along(grey, 1.0, rows)).all()


def test_exercise_answers_are_correct():
    assert exercises.rows_above_horizon(1280, 45) == pytest.approx(1280 / (2 * np.pi))
    camera = experiment.simulator(1.0).camera
    up = np.radians(exercises.EYE_HIGH_DEG)
    ray = np.cos(up) * experiment.AHEAD - np.sin(up) * experiment.DOWN
    seen = camera.project((camera.centre + 1e4 * ray)[None]).pixels[0]
    radius = np.linalg.norm(seen - camera.viewer.K[:2, 2])
    assert exercises.radius_in_image() == pytest.approx(radius, abs=1e-3)
