"""Models are compared on the same corners, with cameras fitted to other boards."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.views.correspondence import BoardView
from raxel.cameras import GeneralCamera, PerspectiveCamera
from raxel.errors import CalibrationError
from raxel.evaluation.comparison import ModelComparison, compare_models
from raxel.sets import Chessboard
from tests.image_sets import COLUMNS, FOCAL, HEIGHT, ROWS, WIDTH, boards
from tests.raised import raises_code

K = np.array([[FOCAL, 0, (WIDTH - 1) / 2], [0, FOCAL, (HEIGHT - 1) / 2], [0, 0, 1]])


@pytest.fixture(scope="module")
def views():
    points = Chessboard(COLUMNS, ROWS).points()
    return [
        BoardView(board.corners(), points, COLUMNS, ROWS, f"view{i}")
        for i, board in enumerate(boards())
    ]


def lens(views):
    """About the lens that drew the boards (its bend undone to first order)."""
    return PerspectiveCamera(K, [-0.33, 0.22], WIDTH, HEIGHT)


def half_table(views):
    """A poorer lens, with rays in the left two thirds only."""
    whole = GeneralCamera.from_camera(PerspectiveCamera(K, [-0.2], WIDTH, HEIGHT))
    mask = whole.mask.copy()
    mask[:, 2 * WIDTH // 3 :] = False
    return GeneralCamera(whole.directions, mask)


def compared(errors):
    own = {name: SimpleNamespace(n_scored=9, left_out={}) for name in errors}
    return ModelComparison(own, {}, {}, errors)


def test_choice_is_the_simplest_of_the_best_models():
    model, why = compared({"simple": 0.3, "middle": 0.1, "rich": 0.2}).choice()
    assert model == "middle"
    assert "smallest error on held-out points, 0.1 px" in why
    model, why = compared({"simple": 0.1019, "middle": 0.1, "rich": 0.2}).choice()
    assert model == "simple"
    assert "as good as middle (0.102 and 0.1 px RMS), and simpler" in why


def test_counted_error_of_missing_rays_is_five_px(views):
    comparison = compare_models({"lens": lens, "table": half_table}, views, 3)
    table, corners = comparison.own["table"], len(views) * COLUMNS * ROWS
    missed = corners - table.n_scored
    assert missed > 0
    squares = table.n_scored * table.rms_px**2 + missed * 25
    assert comparison.errors_px["table"] == pytest.approx(np.sqrt(squares / corners))
    assert comparison.errors_px["lens"] == pytest.approx(comparison.own["lens"].rms_px)
    wild = compare_models({"wild": lambda views: BAD}, views, 3)
    assert wild.own["wild"].rms_px > wild.errors_px["wild"]
    assert wild.errors_px["wild"] < 5


def test_common_scores_use_shared_corners(views):
    comparison = compare_models({"lens": lens, "table": half_table}, views, 3)
    assert comparison.failed == {}
    assert comparison.own["lens"].share_with_ray == 1
    assert comparison.own["table"].share_with_ray < 0.8
    for model in ("lens", "table"):
        assert comparison.common[model].share_with_ray == 1
    answered = {
        model: [score.n_corners for score in evaluation.images]
        for model, evaluation in comparison.common.items()
    }
    assert answered["lens"] == answered["table"]
    assert sum(answered["lens"]) < len(views) * COLUMNS * ROWS
    assert comparison.best() == "lens"


def test_failed_models_have_a_reason(views):
    def fail(views):
        raise CalibrationError("boards do not overlap")

    comparison = compare_models({"lens": lens, "none": fail}, views, 3)
    assert list(comparison.own) == ["lens"]
    assert "boards do not overlap" in comparison.failed["none"]
    assert comparison.best() == "lens"
    with raises_code("no-camera"):
        compare_models({"none": fail}, views, 3).best()


def test_cameras_are_built_once_without_their_part(views):
    built = []

    def remember(views):
        built.append([view.name for view in views])
        return lens(views)

    compare_models({"a": remember, "table": half_table}, views, 3)
    assert built == [
        [f"view{i}" for i in range(6) if i % 3 != part] for part in range(3)
    ]


def answering(camera, keep):
    """A builder of a table with the rays of `camera` where keep(u, v) says so."""
    whole = GeneralCamera.from_camera(camera)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    table = GeneralCamera(whole.directions, whole.mask & keep(u, v))
    return lambda views: table


GOOD = PerspectiveCamera(K, [-0.33, 0.22], WIDTH, HEIGHT)
BAD = PerspectiveCamera(K, [0.6, 0.2], WIDTH, HEIGHT)


def never(u, v):
    return np.zeros(u.shape, bool)


def fails_once(views):
    if views[0].name == "view1":
        raise CalibrationError("boards do not overlap")
    return GOOD


def test_parts_without_camera_give_a_diagnosis(views):
    comparison = compare_models({"lens": lens, "some": fails_once}, views, 3)
    (warning,) = comparison.diagnoses()
    assert warning == (
        "some: 1 parts of the cross-validation gave no camera: boards do not overlap"
    )


def test_models_without_rays_are_rejected(views):
    builders = {"none": answering(GOOD, never), "lens": lens}
    assert compare_models(builders, views, 3).choice() == (
        "lens",
        "no other model answers for a held-out view",
    )
    alone = compare_models({"none": builders["none"]}, views, 3)
    with raises_code("no-overlap"):
        alone.choice()


def test_near_copies_are_held_out_together(views):
    built, moved = [], views[0]._replace(pixels=views[0].pixels + 0.1, name="moved")

    def remember(views):
        built.append([view.name for view in views])
        return lens(views)

    compare_models({"a": remember}, [views[0], moved, *views[1:3]], 4)
    own = ["view0", "moved"]
    assert built == [["view1", "view2"], [*own, "view2"], [*own, "view1"]]


def test_common_scores_exclude_parts_without_camera(views):
    comparison = compare_models({"lens": lens, "some": fails_once}, views, 3)
    for found in comparison.common.values():
        assert [score.name for score in found.images] == [
            "view1",
            "view4",
            "view2",
            "view5",
        ]
        assert not found.left_out
