"""Lens formulas: exact corners without a guess, outliers, tests, refusals."""

import numpy as np
import pytest

from raxel.calibration import calibrate_lens
from raxel.calibration.parametric.lens_bundle import LensFormula, imaged_points
from raxel.calibration.parametric.lens_fit import LAWS
from raxel.cli.models import CENTRAL_FITS
from raxel.errors import InputError
from raxel.evaluation import evaluate_camera
from tests.lens_scenes import CAMERAS, SIZE, boards

LAW_OF = {
    "fisheye of 183 degrees": ["kannala-brandt", "unified"],
    "mirror with a blind middle": ["unified"],
    "wide perspective": ["unified"],
    "decentred fisheye": ["kannala-brandt"],
    "decentred mirror": ["unified"],
    "moving pupil": ["kannala-brandt"],
}
CASES = [(name, law) for name, laws in LAW_OF.items() for law in laws]


@pytest.mark.parametrize("base", ["kannala-brandt", "unified", "perspective"])
def test_lens_derivatives_equal_differences(base):
    formula = LensFormula(base, 2, 4, 2)
    values = np.array(
        [300.0, 310, 320, 240]
        + [0.9] * (base == "unified")
        + [-0.02, 0.003, 0.001, -0.002, 0.003, 0.004, 3.0, -1.0]
    )
    rng = np.random.default_rng(0)
    points = rng.normal(size=(60, 3)) * [200, 200, 100] + [0, 0, 150]
    if base == "perspective":  # sees nothing at 90 degrees
        points[:, 2] = 150 + np.abs(points[:, 2])
    found = imaged_points(formula, values, points)

    def check(derivative, ahead, behind, step):
        difference = (ahead - behind) / (2 * step)
        size = np.nanmax(np.abs(difference))
        assert np.nanmax(np.abs(derivative - difference)) < 1e-7 * size

    for k, step in enumerate(1e-6 * np.maximum(1, np.abs(values))):
        shift = step * (np.arange(len(values)) == k)
        ahead, behind = (
            imaged_points(formula, values + s, points, False) for s in (shift, -shift)
        )
        check(found.by_values[:, :, k], ahead, behind, step)
    for k in range(3):
        shift = 1e-4 * (np.arange(3) == k)
        ahead, behind = (
            imaged_points(formula, values, points + s, False) for s in (shift, -shift)
        )
        check(found.by_points[:, :, k], ahead, behind, 1e-4)


@pytest.mark.parametrize(("name", "law"), CASES)
def test_exact_corners_are_predicted_on_held_out_boards(name, law):
    true, reach = CAMERAS[name]
    views = boards(true, 13, reach, seed=len(name))
    pupil = "by test" if law == "kannala-brandt" else "fixed"
    found = calibrate_lens(views[:9], *SIZE, law, pupil=pupil)
    assert found.rms_px < 0.02
    assert not found.wrong
    evaluation = evaluate_camera(found.camera, views[9:])
    assert evaluation.share_with_ray == 1
    assert evaluation.rms_px < 0.02
    if found.pupil:
        assert found.pupil.moves == (name == "moving pupil")


def test_noise_gives_covariance_and_no_pupil_shift():
    true, reach = CAMERAS["fisheye of 183 degrees"]
    terms = np.array([290.0, 289.0, 651.0, 470.0, *true.k[1:]])
    off = []
    for seed in range(5):
        views = boards(true, 8, reach, seed, noise=0.2)
        pupil = "by test" if seed < 2 else "fixed"
        found = calibrate_lens(views, *SIZE, "kannala-brandt", pupil=pupil)
        # 0.2 px in u and in v; 57 of 1600 numbers are used up by the parameters.
        assert found.rms_px == pytest.approx(0.2 * np.sqrt(2), rel=0.08)
        assert not (found.pupil and found.pupil.moves)
        if found.formula.names[4:] == ["k1", "k2", "k3"]:
            miss = found.values - terms
            off.append(miss @ np.linalg.solve(found.covariance, miss))
    # Chi squared of 7 degrees of freedom each; other terms have other values.
    assert len(off) >= 2
    assert 2 < np.mean(off) < 14


def test_pupil_shift_has_standard_deviation():
    true, reach = CAMERAS["moving pupil"]
    views = boards(true, 12, reach, seed=1, noise=0.1)
    test = calibrate_lens(views, *SIZE, "kannala-brandt").pupil
    assert test.moves
    assert test.p_value < 1e-6
    assert test.moving_px < 0.95 * test.central_px
    assert 0.1 < test.shift_sd < 2
    # Up to the largest angle that is seen, about 1.5 radians.
    assert test.shift == pytest.approx(4 * 1.5**2 + 1.5**4, abs=3 * test.shift_sd)


def test_central_fits_have_no_pupil_shift():
    """Of a moving pupil; the spline's ray field is central as its trend."""
    true, reach = CAMERAS["moving pupil"]
    views = boards(true, 4, reach, seed=1)
    for name in ("kannala-brandt", "spline"):
        found = CENTRAL_FITS[name](views, SIZE, "mm")
        assert found.camera.central
        assert found.details["pupil"] is None


def test_wrong_corners_are_listed_with_zero_weight():
    true, reach = CAMERAS["decentred fisheye"]
    views = boards(true, 10, reach, seed=2, noise=0.1)
    rng = np.random.default_rng(5)
    wrong = {(int(v), int(c)) for v, c in rng.integers([10, 100], size=(60, 2))}
    for view, corner in wrong:
        views[view].pixels[corner] += rng.choice([-1, 1], 2) * rng.uniform(4, 40, 2)
    views[3].pixels[[0, 1]] = np.nan
    found = calibrate_lens(views, *SIZE, "kannala-brandt", pupil="fixed")
    seen = {(view, corner) for view, corner in wrong if (view, corner) < (3, 0) or
            (view, corner) > (3, 1)}  # fmt: skip
    assert {(w.view, w.corner) for w in found.wrong} == seen
    assert {w.name for w in found.wrong} <= {view.name for view in views}
    assert evaluate_camera(found.camera, boards(true, 6, reach, seed=9)).rms_px < 0.05


def test_lens_rejects_degenerate_boards():
    true, _ = CAMERAS["wide perspective"]
    views = boards(true, 3, (0.0, 0.3), seed=6)
    with pytest.raises(InputError, match="1 view"):
        calibrate_lens(views[:1], *SIZE, "unified")
    with pytest.raises(ValueError, match="law: found 'brown'"):
        calibrate_lens(views, *SIZE, "brown")
    with pytest.raises(ValueError, match="pupil: found 'maybe'"):
        calibrate_lens(views, *SIZE, "unified", pupil="maybe")


@pytest.mark.parametrize("law", LAWS, ids=["equidistance", "pinhole"])
def test_start_laws_are_self_consistent(law):
    theta, step = np.linspace(0.05, 1.2, 24), 1e-6
    radius = law.radius(theta)
    np.testing.assert_allclose(law.angle(radius), theta, rtol=1e-12)
    slope = (law.radius(theta + step) - law.radius(theta - step)) / (2 * step)
    np.testing.assert_allclose(law.turned(radius), slope, rtol=1e-8)
    # Near the axis, where the next term of a tangent is 2 theta^4 / 15.
    near = theta[theta < 0.2]
    series = near * (1 + law.k1 * near**2)
    np.testing.assert_allclose(law.radius(near), series, rtol=0.14 * 0.2**4)


def test_unified_law_includes_perspective_lens():
    true, reach = CAMERAS["wide perspective"]
    views = boards(true, 10, reach, seed=3)
    found = calibrate_lens(views, *SIZE, "unified", pupil="fixed")
    assert found.camera.kind == "unified sphere"
    assert found.camera.xi == 0
    u, v = (np.linspace(0, side - 1, 21) for side in SIZE)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    seen = found.camera.project(true.rays(pixels).directions).pixels
    assert np.abs(seen - pixels).max() < 1e-3


def test_corner_is_wrong_beyond_six_sigmas():
    true, reach = CAMERAS["fisheye of 183 degrees"]
    views, sd = boards(true, 6, reach, seed=3), 0.1
    rng = np.random.default_rng(7)
    for view in views:
        view.pixels[:] += np.clip(sd * rng.normal(size=view.pixels.shape), -0.3, 0.3)
    exact = boards(true, 6, reach, seed=3)
    for k, off in enumerate((3.5, 8.5, -8.5)):
        views[k].pixels[40] = exact[k].pixels[40] + [off * sd, 0]
    found = calibrate_lens(views, *SIZE, "kannala-brandt", pupil="fixed", board="flat")
    assert {(w.view, w.corner) for w in found.wrong} == {(1, 40), (2, 40)}
    for wrong in found.wrong:
        assert wrong.distance_px == pytest.approx(8.5 * sd, abs=sd)
