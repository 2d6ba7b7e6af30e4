"""Texts of diagnoses and of the summary: length, form and values."""

import json

import numpy as np
import pytest

from raxel.cli.findings import agreement_warnings, warnings_of
from raxel.cli.models import Fitted
from raxel.evaluation.coverage import BeyondBoards
from raxel.evaluation.diagnoses import (
    DIAGNOSES,
    SUMMARY,
    TEXT,
    Diagnosis,
    diagnosis,
    line,
    points_line,
    pupil_line,
    strongest_first,
    summary,
)
from raxel.evaluation.misfit import FocalLengths
from raxel.evaluation.split_half import Division, OutlierImage, SplitHalf
from raxel.sets.model import BOARDS, GRIDS

TEXTS = {
    "file": "IMG_1234.jpg", "original": "IMG_1233.jpg", "files": "IMG_1234.jpg",
    "mirrored": "IMG_1234.jpg", "upright": "IMG_1235.jpg", "model": "kannala-brandt",
    "reason": "no chessboard of 9 x 6 corners found", "unit": "mm",
    "divided_by": "near and far", "points": "corners", "subject": "zhang does not fit",
    "shape": "bent by up to 2.1 mm", "bent": "bent board", "scope": "", "more": "",
    "untried": "add overlapping views, ",
}  # fmt: skip


class Usual(dict):
    """Usual values of the fields of a template."""

    def __missing__(self, name):
        if name in ("count", "n_views", "column", "row", "number", "needed"):
            return 12
        return 1.2e-7 if name == "p_value" else 12.3 if "percent" in name else 1.23


def usual(code):
    fields = {
        name.partition("[")[0]
        for part in DIAGNOSES[code]
        for _, name, _, _ in TEXT.parse(part)
        if name
    }
    values = Usual(TEXTS)
    return {name: values[name] for name in fields - set(BOARDS._fields)}


@pytest.mark.parametrize("code", DIAGNOSES)
def test_diagnosis_is_short_and_has_two_parts(code):
    found = diagnosis(code, **usual(code))
    assert len(found) <= 160, len(found)
    assert found == "; ".join(filter(None, (found.problem, found.what_to_do)))
    assert ";" not in found.problem + found.what_to_do
    assert json.loads(json.dumps(found.fields())).items() >= {
        "code": code, "text": found.problem, "what_to_do": found.what_to_do,
    }.items()  # fmt: skip


def test_diagnosis_fields_have_values_and_null_for_unknown():
    values = {"rms_px": 3.25, "scatter_px": np.nan, "stated_sd_px": np.float64(0.5)}
    found = diagnosis("outlier-residuals", GRIDS, files="a", subject="x", **values)
    assert found == (
        "a: worse than the other grids: total RMS 3.25 px (point scatter unknown, "
        "predicted 0.5 px); check their points (if right: x)"
    )
    fields = found.fields()
    assert [fields[name] for name in values] == [3.25, None, 0.5]
    assert (fields["files"], "subject" in fields) == ("a", False)


def test_reported_text_is_split_at_the_advice():
    found = Diagnosis.reported("decoding", "a: blurred; refocus", file="a")
    assert found.fields() == {
        "code": "decoding", "text": "a: blurred", "what_to_do": "refocus", "file": "a",
    }  # fmt: skip
    assert Diagnosis.reported("decoding", "a: blurred").what_to_do == ""


def halves(**more):
    fields = np.zeros((0, 2))
    worst = Division("near and far", (("a",), ("b",)), 0.9, 0.2, 0.5, 1e-7, fields)
    return SplitHalf([worst], fields, 1e-6, True, 2.5, True)._replace(**more)


FOCAL = FocalLengths(0.008, 6.1, 1e-9, ("a", "b"), ("c",))
OUTLIER = OutlierImage("d", 7.5, 1e-8, 0.75)


@pytest.mark.parametrize(
    ("found", "code", "text"),
    [
        (halves(), None, ""),
        (halves(same_camera=False), "inconsistent-halves", "rays differ by 0.9 px RMS"),
        (
            halves(focal=FOCAL),
            "focal-length-varies",
            "SD 0.8 %, 6.1 times the expected",
        ),
        (halves(focal=FOCAL), "focal-length-varies", "check for two cameras (c)"),
        (halves(outlier=OUTLIER), "outlier-image", "d: inconsistent with the other"),
        (
            halves(same_camera=False, outlier=OUTLIER._replace(p_value=1e-5)),
            "inconsistent-halves",
            "(p = 1e-06)",
        ),
        (halves(same_camera=False, outlier=OUTLIER), "outlier-image", "0.75 px RMS"),
        (halves(steady=False), "inconsistent-images", "2.5 times as much as corner"),
        (halves(beyond=BeyondBoards(0.4, 0.09, 9.0, 0.1)), None, ""),
        (
            halves(beyond=BeyondBoards(0.4, 0.1, 9.0, 0.1)),
            "extrapolated-area",
            "40 % of the image is outside all boards: SD of rays up to 9 px (0.1 px in",
        ),
    ],
)
def test_split_half_gives_one_diagnosis(found, code, text):
    warnings = list(agreement_warnings(None, found, Fitted(None, {}), "mm", BOARDS))
    assert [one.code for one in warnings] == [code] * bool(code)
    assert all(text in one for one in warnings)


def test_cause_that_moves_rays_too_little_does_not_explain_a_misfit():
    large = {"rms_px": 5.0, "scatter_px": 0.3}
    misfit = Diagnosis.reported("camera-misfit", "a", **large)
    causes = [
        Diagnosis.reported("outlier-image", "c", rays_px=px, p_value=p_value)
        for px, p_value in ((1.0, 1e-30), (3.0, 1e-7), (3.0, 1e-9))
    ]
    weak, strong, stronger = causes
    other = Diagnosis.reported("decoding", "d")
    found = strongest_first([other, *causes, misfit])
    assert [id(each) for each in found] == [
        id(each) for each in (stronger, strong, misfit, weak, other)
    ]
    assert strongest_first([strong, weak]) == [weak, strong]


def test_outlier_points_name_the_worst_rounded_up():
    wrong = [
        {"file": name, "corner": n, "distance_px": px}
        for name, n, px in (("a", 7, 2.5), ("b", 3, 9.04), ("b", 4, 1.5))
    ]
    result = {"wrong_points": wrong, "wrong_points_of": {"a": 1, "b": 2}}
    result["share_of_wrong_points"] = 0.05
    (warning,) = warnings_of(result, 0.125, GRIDS)
    assert warning == (
        "3 points (5.0 %) excluded as outliers: b (2), a (1); check the worst, number "
        "3 of b (9.1 px, others 0.12 px RMS)"
    )


@pytest.mark.parametrize(
    ("used", "text"),
    [
        ((), None),
        (("stretch",), "is stretched by 0.4 % (x/y), the fit"),
        (("bend_x", "bend_y", "twist"), "is bent by up to 2.1 mm, the fit"),
        (
            ("bend_x", "bend_y", "twist", "stretch"),
            "bent by up to 2.1 mm, stretched by 0.4 % (x/y), the fit estimates this "
            "(held-out RMS 0.1 px, 0.9 px without)",
        ),
    ],
)
def test_board_shape_diagnosis_has_the_used_terms(used, text):
    terms = {"bend_x": 1.5, "bend_y": -2.1, "twist": 0.1, "stretch": 0.004}
    shape = {
        name: {"value": value, "sd": 0.01, "used": name in used}
        for name, value in terms.items()
    }
    shape |= {"flat_px": 0.9, "shaped_px": 0.1}
    result = {"wrong_points": [], "unit": "mm", "board_shape": shape}
    warnings = list(warnings_of(result, 0.1, BOARDS))
    assert [text in one for one in warnings] == [True] * bool(used)


PUPIL = {
    "p_value": 1e-5, "central_px": 0.5, "moving_px": 0.25, "chance": 0.125,
    "shift": 2.0, "shift_sd": 0.1, "verdict": "moves", "against": None, "moves": True,
}  # fmt: skip
SHIFT = "2 +- 0.1 mm over the field of view"
GAIN = "held-out boards: RMS 0.5 px without it, 0.25 px with it"


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({}, f"shifts by {SHIFT}, so rays have no common point; {GAIN}"),
        (
            {"moves": False, "verdict": "undecided"},
            f"undecided, taken as fixed (possible shift {SHIFT}); {GAIN} (p = 0.12)",
        ),
        (
            {"moves": False, "verdict": "rests"},
            "fixed: a shift fits better (p = 1e-05), but not held-out boards (RMS 0.25 "
            "px with it, 0.5 px without)",
        ),
    ],
)
def test_pupil_line_has_errors_with_and_without_a_shift(changed, text):
    assert pupil_line(PUPIL | changed, "mm", BOARDS) == ("entrance pupil", text)


@pytest.mark.parametrize(
    ("as_stated", "text"),
    [
        (True, "no significant deviation from the nominal positions (p = 0.0002)"),
        (
            False,
            "corner 1 (row by row, from 0) deviates by 0.13 mm, all by 0.092 mm RMS; "
            "this moves rays by 0.3 px RMS (p = 0.0002); used: RMS of boards predicted "
            "by the other half of the images 0.25 px, 0.125 px with it, rays of halves "
            "differ by 0.5 px, 0.4 px with it",
        ),
    ],
)
def test_corner_positions_have_units(as_stated, text):
    offsets = [[0.0, 0.0, 0.0], [0.03, 0.04, 0.12]]
    found = {"as_stated": as_stated, "p_value": 2e-4, "worst": 1, "offsets": offsets}
    found |= {"used": True, "halves_px": {"nominal": 0.5, "displaced": 0.4}}
    found["held_out_px"] = {"nominal": 0.25, "displaced": 0.125}
    lengths = {"unit": "mm"}
    row = points_line(found | {"rays_px": 0.3}, BOARDS, lengths)
    assert row == ("corner positions", text)


def test_summary_has_all_tests():
    result = {
        "unit": "mm", "misfit": {"scatter_px": 0.1, "stated_sd_px": None},
        "board_shape": None, "board_corners": None, "one_centre": None,
        "stability": halves().fields(),
    }  # fmt: skip
    rows = dict(summary(result, BOARDS, 6))
    assert rows["corner noise"] == "scatter 0.100 px, predicted unknown"
    assert rows["board shape"].startswith(
        "taken as specified; estimating it requires 6 "
    )
    assert rows["central camera"].startswith("not tested (too few pixels with three bo")
    assert rows["corner positions"].endswith("a test requires 6 chessboards")
    assert rows["split-half test"] == (
        "worst of 1 divisions, 'near and far': rays differ by 0.9 px RMS; expected 0.2 "
        "px from corner scatter, 0.5 px from differences between images (p = 1e-06)"
    )
    untested = dict(summary(result | {"stability": None}, BOARDS, 6))
    assert untested["split-half test"].startswith("not tested; it requires 6 boards")


def test_table_lines_have_shares_in_per_cent():
    camera = {"share_of_image_with_ray": 0.125, "units": "mm"}
    assert line("table", BOARDS, camera) == (
        "rays",
        "for 12.5 % of the image, through one centre (the origin), lengths in mm",
    )
    assert set(SUMMARY) & set(DIAGNOSES) == set()
