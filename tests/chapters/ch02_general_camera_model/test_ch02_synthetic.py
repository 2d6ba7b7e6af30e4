"""The rig of section 2.5.1: exact without noise, independent noise, fair scoring."""

import numpy as np
import pytest

from chapters.ch02_general_camera_model.s4_generic_calibration import (
    experiment as coefficients,
)
from chapters.ch02_general_camera_model.s4_generic_calibration.report import (
    cell_text,
    judge_table_coefficients,
)
from chapters.ch02_general_camera_model.s5_1_synthetic_data import experiment, page
from chapters.shared import methods
from chapters.shared.general import three_planes
from raxel.geometry import apply_homography
from repro.run.marks import trial_rng
from tests.judged_claims import readings

BASE = {"law": "equidistance", "fov_deg": 90, "noise": 0.0, "domain": "px",
        "extent": "unbounded"}  # fmt: skip


def drawn(trial=0, **condition):
    case = BASE | condition
    return three_planes.measure(case, trial_rng("test", case, trial))[0]


def test_corrected_cells_of_table_2_1_are_bold():
    """Bold around a formula is nothing to what draws it."""
    assert cell_text(0, "W") == "$R_{31}^2$"
    assert cell_text(2, "W") == r"$\boldsymbol{-C_z + t_z^2}$"
    bold = [v for v in "VWMN" for row in range(9) if "bold" in cell_text(row, v)]
    assert bold == ["W", "N"]


@pytest.mark.parametrize("law", ["equidistance", "equisolid", "stereographic"])
@pytest.mark.parametrize("fov_deg", [30, 90, 150])
def test_fisheye_field_of_view_spans_the_image_diagonal(law, fov_deg):
    rays = three_planes.fisheye(law, fov_deg).rays(np.zeros((1, 2)))
    angle = np.degrees(np.arccos(rays.directions[0, 2]))
    assert angle == pytest.approx(fov_deg / 2, abs=1e-9)


def test_drawn_grids_are_tilted_and_face_the_camera():
    for trial in range(30):
        grids, least = three_planes.draw_grids(trial_rng("test", {}, trial))
        tilts = np.degrees(np.arccos(grids[:, 2, 2]))
        assert np.all((tilts >= 10 - 1e-9) & (tilts <= 30 + 1e-9))
        assert least >= 10
        assert np.all(grids[:, 2, 3] >= 450)


def test_finite_grids_limit_points_and_keep_their_number():
    case = BASE | {"fov_deg": 150, "extent": "finite"}
    data, draw = three_planes.measure(case, trial_rng("test", case, 0))
    assert data.points.shape == (3, 999, 2)
    assert np.abs(data.points).max() <= 600
    assert draw["accepted_share"] < 0.6
    # A corner of the nearest grid possible: 450 mm away, 150 mm off, tilted by 30.
    assert experiment.widest_angle_deg(data) < 69
    assert experiment.widest_angle_deg(drawn(fov_deg=150)) == pytest.approx(75, abs=2)


@pytest.mark.parametrize("domain", ["px", "mm"])
def test_noise_has_its_size_and_is_independent_between_grids(domain):
    data = drawn(noise=0.5, domain=domain)
    if domain == "px":
        errors = data.noisy_pixels - data.pixels
        fresh = data.fresh_pixels - data.pixels
    else:
        errors = data.noisy_points - data.points
        fresh = data.fresh_points - data.points[0]
    flat = np.vstack([errors.reshape(3, -1), fresh.reshape(1, -1)])
    # 1998 draws per grid: the SD of an SD is 1.6 %, of a correlation 0.022.
    assert flat.std(axis=1) == pytest.approx(0.5, rel=0.07)
    assert np.abs(np.corrcoef(flat)[np.triu_indices(4, 1)]).max() < 0.1


def test_generic_ray_has_four_thirds_of_the_variance_on_fresh_noise():
    """Exact rays leave the point's noise, generic ones 4/3 of its variance more."""
    data = drawn(fov_deg=60, noise=0.5)
    found = experiment.scores(data, methods.METHODS[2:] + ("opencv_fisheye",))
    source = {
        name: of["fresh"]["source"]["mean_px"]
        for name, of in found.items()
        if name != "exact"
    } | {"exact": found["exact"]["source"]["mean_px"]}
    # The mean of 999 lengths scatters by 1.7 %.
    noise = 0.5 * np.sqrt(np.pi / 2)
    assert source["exact"] == pytest.approx(noise, rel=0.06)
    assert source["opencv_fisheye"] == pytest.approx(source["exact"], rel=0.01)
    generic = source["generic_well_conditioned"] / source["exact"]
    assert generic == pytest.approx(np.sqrt(4 / 3), rel=0.04)
    same = found["generic_well_conditioned"]["noisy"]["source"]["mean_px"]
    assert same < source["exact"]


def test_noisy_points_lie_on_the_rays_of_noisy_pixels():
    data = drawn(noise=1.0)
    for pixels, points, T in zip(
        data.noisy_pixels, data.noisy_points, data.grids, strict=True
    ):
        flat = np.column_stack([points, np.zeros(len(points))])
        projected = data.camera.project(flat @ T[:3, :3].T + T[:3, 3])
        assert np.abs(projected.pixels - pixels).max() < 1e-6


@pytest.mark.parametrize("linear", ["as printed", "well conditioned"])
def test_generic_rays_are_exact_without_noise(linear):
    data = drawn(trial=1)
    directions = experiment.calibrate_generic(data, linear)
    true = data.camera.rays(data.pixels).directions
    to_camera = data.grids[0][:3, :3]
    assert np.abs(directions @ to_camera.T - true).max() < 1e-6


def test_parametric_method_is_exact_without_noise():
    data = drawn(law="lens", fov_deg=60)
    camera = experiment.calibrate_parametric(data)
    true = data.camera.rays(data.pixels).directions
    # OpenCV takes single precision only, so exactness ends near 1e-5.
    assert np.abs(camera.rays(data.pixels).directions - true).max() < 1e-4
    assert camera.radial == pytest.approx((-0.2, 0.05), abs=1e-3)


def test_residual_is_invariant_to_a_homography():
    data = drawn(noise=0.5)
    focal = three_planes.central_focal(data.camera)
    target = three_planes.targets(data, focal)["clean"]
    rng = np.random.default_rng(0)
    seen = target + rng.normal(0, 0.5, target.shape)
    H = np.array([[1.1, 0.02, 30], [-0.03, 0.9, -12], [1e-5, -2e-5, 1]])
    plain = three_planes.score(seen, target, data.camera, focal)
    moved = three_planes.score(apply_homography(H, seen), target, data.camera, focal)
    for scale in methods.SCALES:
        assert moved[scale] == pytest.approx(plain[scale], abs=1e-5)


def test_central_focal_equals_focal_length():
    assert three_planes.central_focal(three_planes.fisheye("equidistance", 120)) == (
        pytest.approx(three_planes.CORNER_RADIUS_PX / np.radians(60), rel=1e-6)
    )


@pytest.mark.parametrize("domain", ["px", "mm"])
def test_projection_laws_share_rays_and_noise(domain):
    case = {"fov_deg": 90, "noise": 0.5, "domain": domain, "extent": "unbounded"}
    measured = experiment.measure_laws(case, trial_rng("test", case, 0))
    assert list(measured) == list(experiment.LAWS)
    first = measured["equidistance"]
    rays = first.camera.rays(first.pixels).directions
    for law, data in measured.items():
        assert np.abs(data.camera.rays(data.pixels).directions - rays).max() < 1e-9
        if law != "equidistance":
            assert np.abs(data.pixels - first.pixels).max() > 1
        # The noise that is given shifts both by the same.
        if domain == "px":
            shifts = [d.noisy_pixels - d.pixels for d in (data, first)]
        else:
            shifts = [d.noisy_points - d.points for d in (data, first)]
        assert np.abs(shifts[0] - shifts[1]).max() < 1e-9
        # Half a pixel is the edge of the image about the last pixel centres.
        assert data.pixels.min() > -1
        assert data.pixels.max() < three_planes.SIZE_PX


def test_grazing_correlation_differs_between_scales():
    data = drawn(fov_deg=150, noise=0.5)
    generic = experiment.score_generic(data, 300.0, "well conditioned")["clean"]
    # The corrected view is stretched where rays graze, the source image is not:
    # exact rays seem to suffer there as generic ones do.
    for found in (generic, experiment.score_exact(data, 300.0)):
        corrected = found["corrected"]["grazing_spearman"]
        source = found["source"]["grazing_spearman"]
        assert corrected > source + 0.1


def test_failed_method_is_reported_and_others_continue(monkeypatch):
    from raxel.errors import CalibrationError

    def fails(*_, **__):
        raise CalibrationError("no real solution", code="no-real-solution")

    monkeypatch.setitem(experiment.STARTS, "as printed", fails)
    case = BASE | {"noise": 0.5}
    out = page.trial(case, trial_rng("test", case, 0))
    assert out["generic_as_printed"] == {"failed": "no-real-solution"}
    assert out["generic_well_conditioned"]["clean"]["source"]["mean_px"] < 1
    assert out["parametric"]["clean"]["source"]["mean_px"] < 1
    assert set(out["parametric"]) == {"ray_deg", *methods.SCORINGS}


def test_table_2_1_is_exact_only_as_corrected():
    for trial in range(20):
        names = coefficients.draw_scene(trial_rng("test", {}, trial))
        corrected = coefficients.substitute(names)
        printed = coefficients.substitute(names, printed=True)
        assert all(zero for zero, _ in corrected.values())
        assert [printed[v][0] for v in "VWMN"] == [True, False, True, False]


@pytest.mark.parametrize(
    ("change", "verdict"),
    [
        ({}, "reproduced"),
        ({"corrected.V.zero": [1.0, 0.0]}, "differs"),
        ({"corrected.M.relative": [0.0, 1e-6]}, "differs"),
        ({"printed.N.relative": [1e-4, 1e-5]}, "differs"),
    ],
)
def test_table_2_1_claim_holds_and_fails(change, verdict):
    values = {}
    for vector in coefficients.VECTORS:
        values[f"corrected.{vector}.zero"] = [1.0, 1.0]
        values[f"corrected.{vector}.relative"] = [0.0, 0.0]
        values[f"printed.{vector}.relative"] = [0.1, 1e-4]
    values |= change
    (reading,) = readings(judge_table_coefficients, "table_2_1_sums", values)
    assert reading.verdict == verdict
    few = sum(np.sum(np.array(values[f"printed.{v}.relative"]) <= 1e-3) for v in "WN")
    assert f"{few} of 4 are at most 1e-3" in reading.reason


def test_formulas_are_typeset_as_in_the_thesis():
    assert coefficients.as_maths("-C_y*R31_2 + C_z*R21_2") == (
        "$-C_y R_{31}^2 + C_z R_{21}^2$"
    )
    assert coefficients.formula(2, "W") == "-C_z + t_z_2"
    assert coefficients.formula(2, "W", printed=True) == "-C_z + t_z_1"
