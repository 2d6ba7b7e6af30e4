"""The camera zoo of section 2.2: complete, counted, invertible, and fitted."""

import numpy as np
import pytest

from chapters.ch02_general_camera_model.s2_camera_models import exercises, page, results
from chapters.ch02_general_camera_model.s2_camera_models.page import (
    MIRRORS,
    census,
    fits,
)
from chapters.ch02_general_camera_model.s2_camera_models.results import fits_of
from chapters.ch02_general_camera_model.s2_camera_models.tables import ext_zoo
from chapters.ch02_general_camera_model.s2_camera_models.trials import zoo as trials
from chapters.ch02_general_camera_model.s2_camera_models.trials.zoo import CURVES
from chapters.shared.zoo import ELSEWHERE, SIZE_PX, ZOO, K_of, camera, made
from raxel.cameras import CAMERAS
from tests.made_results import as_planned, of_columns


def test_every_kind_of_camera_is_in_the_zoo_or_has_a_reason():
    shown = {camera(name).kind for name in ZOO}
    assert shown | set(ELSEWHERE) == set(CAMERAS)
    assert not shown & set(ELSEWHERE)
    assert all(len(reason) > 20 for reason in ELSEWHERE.values())


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
def test_parameters_are_counted_as_the_page_says(name, count):
    assert camera(name).parameters == count


def test_cubics_of_space_points_and_of_image_points():
    assert results.free_of_cubics(3) == 4 * 20 - 2
    assert results.free_of_cubics(2) == camera("rational cubic").parameters


@pytest.mark.parametrize("name", ZOO)
def test_each_camera_comes_back_and_is_as_central_as_it_says(name):
    found = page.census_trial({"model": name, "step": 11}, None)
    assert camera(name).width == camera(name).height == SIZE_PX
    assert found["returned"] == 1
    assert found["round_trip_px"] < 1e-9
    assert found["central"] == (found["centrality_mm"] < 1e-9)


@pytest.mark.parametrize("name", ["division", "field of view", "radial"])
def test_plane_models_have_no_ray_at_a_right_angle(name):
    point = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, -1e-3]])
    assert not camera(name).project(point).valid.any()
    assert trials.model_end(camera(name)) <= 90


def test_a_negative_first_coefficient_looks_back():
    there = made("scaramuzza", coefficients=[62, -6.6e-3], centre=[99, 99])()
    back = made("scaramuzza", coefficients=[-62, 6.6e-3], centre=[99, 99])()
    pixels = trials.grid_of(17)
    ahead, behind = there.rays(pixels).directions, back.rays(pixels).directions
    np.testing.assert_allclose(behind, ahead * [1, 1, -1], atol=1e-12)


@pytest.mark.parametrize("name", MIRRORS)
def test_the_sphere_is_each_central_mirror_with_z_reversed(name):
    found = trials.mirror_trial({"model": name}, None)
    assert found["rms_px"] < 1e-9


def test_xi_follows_from_the_eccentricity():
    e = np.hypot(30, 20) / 30
    xi = exercises.sphere_of_hyperboloid()
    assert xi == pytest.approx(2 * e / (1 + e * e), abs=1e-9)


def test_the_fov_model_holds_equidistance():
    assert exercises.omega_of_equidistance() == pytest.approx(
        np.degrees(2 * np.arctan(0.5)), abs=1e-6
    )


def test_the_division_model_ends_where_its_denominator_does():
    model = camera("division")
    edge = exercises.divided_edge()
    row = model.K[0, 2] + np.array([[edge - 1e-6], [edge + 1e-6]])
    seen = model.rays(np.hstack([row, np.full((2, 1), model.K[1, 2])]))
    assert seen.valid.tolist() == [True, False]
    assert seen.directions[0, 2] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("family", ["Kannala-Brandt", "unified sphere", "radial"])
def test_more_terms_never_fit_worse(family):
    _, terms, _ = trials.FAMILIES[family]
    rows = [
        page.fit_trial(
            {"lens": "FC-E8", "family": family, "extra": n, "angles": 25}, None
        )
        for n in terms
        if n < 3
    ]
    rms = [row["rms_px"] for row in rows]
    assert np.all(np.diff(rms) <= 1e-9)
    assert np.all(np.diff([row["free"] for row in rows]) == 1)
    assert all(row["rms_px"] <= row["largest_px"] for row in rows)


def test_an_ideal_law_fits_its_own_lens_exactly():
    condition = {"lens": "equidistance", "extra": 0, "angles": 20}
    own = page.fit_trial(condition | {"family": "equidistance"}, None)
    other = page.fit_trial(condition | {"family": "stereographic"}, None)
    assert own["rms_px"] < 1e-9 < 1 < other["rms_px"]


@pytest.mark.parametrize("name", CURVES)
def test_curves_rise_and_start_with_slope_one(name):
    found = trials.curve_trial({"model": name}, None)
    assert np.all(np.diff(found["theta"]) > 0)
    assert found["r"][1] == pytest.approx(found["theta"][1], rel=1e-3)


def test_the_caustic_of_the_slits_is_the_slits():
    found = trials.rays_trial({"model": "X-slits"}, None)
    back, front = found["caustic"][:, 0], found["caustic"][:, 1]
    np.testing.assert_allclose(back[:, 1:], 0, atol=1e-5)
    np.testing.assert_allclose(front[:, [0, 2]], [[0, 40]] * len(front), atol=1e-5)


def test_the_plans_cover_zoo_and_families():
    assert [c["model"] for c in census("quick").conditions] == list(ZOO)
    full = fits("full").conditions
    assert {c["family"] for c in full} == set(trials.FAMILIES)
    assert len(fits("quick").conditions) < len(full)


def test_fits_are_found_by_lens_and_family():
    rows = [
        {"lens": "FC-E8", "family": "radial", "extra": 0},
        {"lens": "FC-E8", "family": "radial", "extra": 1},
        {"lens": "equidistance", "family": "radial", "extra": 0},
    ]
    result = of_columns(
        *((c, {"free": c["extra"] + 1, "rms_px": c["extra"] + 0.5}) for c in rows)
    )
    free, rms = fits_of(result, "FC-E8", "radial")
    assert free.tolist() == [1, 2]
    assert rms.tolist() == [0.5, 1.5]


def zoo_check(**of_tardif):
    """The check of the table where one camera has other values than all others."""
    good = {"returned": 1.0, "round_trip_px": 0.0, "centrality_mm": 0.0}
    good |= {"central": True, "projects": True, "kind": "any", "parameters": 5}

    def values(condition):
        return good | (of_tardif if condition["model"] == "Tardif" else {})

    return ext_zoo({"exp_zoo": as_planned("exp_zoo", values)}).check


def test_the_table_says_when_a_camera_does_not_come_back():
    assert zoo_check().holds
    assert not zoo_check(round_trip_px=0.5).holds
    assert not zoo_check(central=False).holds


@pytest.mark.parametrize(("returned", "holds"), [(1.0, True), (0.5, False)])
def test_the_table_says_when_pixels_of_a_camera_are_lost(returned, holds):
    check = zoo_check(returned=returned)
    assert check.holds is holds
    assert check.text.startswith(f"{100 * returned:.0f} % of the pixels come back")


def test_a_pinhole_is_a_division_model_without_a_term():
    pinhole = made("perspective", K=K_of(130), radial=[])()
    plain = made("division", K=K_of(130), coefficients=[0.0])()
    pixels = trials.grid_of(23)
    np.testing.assert_allclose(
        plain.rays(pixels).directions, pinhole.rays(pixels).directions, atol=1e-12
    )
