"""Fields of results: each name has its own value."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.generic.central_test import CentralTest
from raxel.cameras import PerspectiveCamera
from raxel.cli import mirror
from raxel.cli.active_grids import _summary
from raxel.cli.findings import agreement_warnings
from raxel.cli.image_sets import _pattern_lines
from raxel.cli.models import Fitted, _terms
from raxel.evaluation.board_corners import BoardCorners, WrongCorners
from raxel.evaluation.comparison import BackProjection
from raxel.evaluation.cross_validation import Evaluation, ImageScore
from raxel.evaluation.json_fields import camera_fields, central_fields
from raxel.evaluation.split_half import Division, SplitHalf
from raxel.features.active_grid.errors import Noise
from raxel.sets.model import BOARDS, ActiveGrid, Pattern

NAN = float("nan")


@pytest.fixture
def score():
    by_px, by_angle = 2.0 * np.eye(4), 3.0 * np.eye(4)
    residuals = np.full((5, 2), NAN)
    return ImageScore("one", 50, 7, 0.4, 0.3, 0.2, by_px, by_angle, residuals, "why")


def test_evaluation_fields_have_their_own_values(score):
    result = Evaluation([score], 0.5, 0.6, NAN, 0.86, {}).fields()
    (image,) = result.pop("images")
    assert result == {
        "rms_px": 0.5, "median_px": 0.6, "mean_deg": None, "share_with_ray": 0.86,
    }  # fmt: skip
    for name in ("T_camera_grid", "T_camera_grid_by_angle"):
        np.testing.assert_array_equal(image.pop(name), getattr(score, name))
    assert image == {
        "file": "one", "n_corners": 50, "n_without_ray": 7, "reason": "why",
        "rms_px": 0.4, "median_px": 0.3, "mean_deg": 0.2,
    }  # fmt: skip


def test_back_projection_fields_have_pose_mean_and_rms(score):
    """Their errors have a mean: an RMS is no standard deviation about it."""
    errors = np.array([[3.0, 4.0], [NAN, NAN], [6.0, 8.0]])
    projected = [BackProjection("one", 4.0 * np.eye(4), errors)]
    evaluation = Evaluation([score], 0.5, 0.6, 0.7, 0.86, {})
    result = mirror._scores(evaluation, projected)
    (image,) = result["images"]
    np.testing.assert_array_equal(image["T_camera_grid_by_rays"], 4.0 * np.eye(4))
    errors = {"mean": 7.5, "rms": pytest.approx(62.5**0.5), "corners": 2}
    assert image["back_projection_mm"] == result["back_projection_mm"] == errors


def test_wrong_points_are_a_share_of_scored_points():
    whole = SimpleNamespace(n_scored=60)
    found = WrongCorners(whole, [], None, [("b", 3, 1.5), ("a", 7, 2.5)])
    fields = found.fields([{"file": "b", "corner": 4, "distance_px": 9.0}])
    assert fields["share_of_wrong_points"] == pytest.approx(3 / 60)
    assert fields["wrong_points_of"] == {"a": 1, "b": 2}
    points = [tuple(entry.values()) for entry in fields["wrong_points"]]
    assert points == [("a", 7, 2.5), ("b", 3, 1.5), ("b", 4, 9.0)]


def test_worst_corner_is_named_by_column_and_row():
    offsets = np.zeros((12, 3))
    offsets[6] = [0.0, 0.0, 0.5]  # of four columns: the third in the second row
    found = BoardCorners(offsets, np.full((12, 3), 0.02), 1e-9, 0.3, 4)
    fitted = Fitted(None, {})
    (warning,) = agreement_warnings(found, None, fitted, "mm", BOARDS)
    assert "column 2, row 1 by 0.5 +- 0.02 mm (rays: 0.3 px RMS, p = 1e-09)" in warning
    assert found.fields()["offsets"][6] == [0.0, 0.0, 0.5]
    assert found.fields()["held_out_px"] == {"nominal": None, "displaced": None}
    used = found._replace(held_out_px=(0.25, 0.125), halves_px=(0.5, 0.4))
    (warning,) = agreement_warnings(used, None, fitted, "mm", BOARDS)
    assert "(other half: RMS 0.125 px, 0.25 px without)" in warning
    assert used.fields()["halves_px"] == {"nominal": 0.5, "displaced": 0.4}
    assert [used.used, used._replace(halves_px=(0.4, 0.5)).used] == [True, False]


def test_split_half_fields_have_difference_and_expectation():
    halves = [("a", "b"), ("c", "d")]
    worst = Division("near and far", halves, 0.9, 0.2, 0.5, 1e-7, np.zeros((0, 2)))
    found = SplitHalf([worst], np.zeros((0, 2)), 1e-6, False, 2.5, True)
    result = found.fields()
    (division,) = result["divisions"]
    assert division.pop("p_value") == 1e-7
    numbers = {
        "divided_by": "near and far", "disagreement_px": 0.9, "scatter_px": 0.2,
        "allowed_px": 0.5,
    }  # fmt: skip
    assert division == numbers
    assert {name: result[name] for name in numbers} == numbers
    assert result["p_value"] == 1e-6
    assert result["photographs_over_scatter"] == 2.5
    assert result["halves"] == [["a", "b"], ["c", "d"]]


def test_central_fields_have_lower_and_upper_bounds():
    test = CentralTest(0.2, 0.5, 0.25, 0.75, 0.1, 1.5, 90, np.zeros(3))
    assert central_fields(test) == {
        "central": True, "p_value": 0.2, "distance": 0.5, "at_least": 0.25,
        "at_most": 0.75, "noise_over_stated": 1.5, "rays": 90,
    }  # fmt: skip
    # Correlated errors have a small p-value too, but no distance.
    assert not central_fields(test._replace(p_value=1e-9))["central"]
    assert central_fields(test._replace(p_value=1e-9, at_least_mm=0.0))["central"]


def test_terms_have_standard_deviations():
    found = SimpleNamespace(
        covariance=np.diag([4.0, 0.25]),
        formula=SimpleNamespace(names=("fx", "k1")),
        values=np.array([300.0, 0.1]),
        error_factor=1.25,
    )
    assert _terms(found) == {
        "terms": {"fx": {"value": 300.0, "sd": 2.0}, "k1": {"value": 0.1, "sd": 0.5}},
        "sd_over_independent": 1.25,
    }


def test_coverage_counts_each_pixel_once():
    def covered(width, height):
        return np.tile(np.arange(width) < width // 4, (height, 1)).astype(np.uint8)

    camera = PerspectiveCamera([[100.0, 0, 19.5], [0, 100, 9.5], [0, 0, 1]], [], 40, 20)
    fields = camera_fields(camera, 3 * [SimpleNamespace(covered=covered)])
    assert fields["share_of_image_under_boards"] == 0.25


def test_check_prints_periods_in_pixels_of_their_axis():
    grid = ActiveGrid((1600, 900))
    views = [
        SimpleNamespace(
            patterns=[
                Pattern(f"{axis}{k}", axis, "phase", 4, step=k, periods=10.0)
                for axis in "xy"
                for k in range(4)
            ],
            name="one",
            white=None,
            black=None,
        )
    ]
    (line,) = _pattern_lines(SimpleNamespace(views=views, target=grid))
    assert "x phase 4 of 4 steps (10 periods of 160 px)" in line
    assert "y phase 4 of 4 steps (10 periods of 90 px)" in line


def test_median_sigma_lists_x_before_y():
    sigma = np.full((4, 5, 2), 0.1)
    sigma[..., 1], sigma[0, 0] = 0.3, NAN
    decoded = SimpleNamespace(
        sigma=sigma, unit="mm", noise=Noise(1.0), blur_px=None, margin_px=3,
        response=[], counts=lambda: {"decoded": 19, "dark": 1, "edge": 0},
    )  # fmt: skip
    found = SimpleNamespace(
        decoded=decoded, step_errors=(), noise_factors=(), as_in_a_mirror=False
    )
    result = _summary("one", found)
    assert result["median_sigma"] == [0.1, 0.3]
    assert result["pixels"] == {"decoded": 19, "dark": 1}
