"""Models are compared on the same corners, from cameras that never saw them."""

import numpy as np
import pytest

from raxel.calibration.correspondence import BoardView
from raxel.cameras import GeneralCamera, PerspectiveCamera
from raxel.errors import CalibrationError
from raxel.evaluation.comparison import compare_models
from raxel.sets import Chessboard
from tests.image_sets import COLUMNS, FOCAL, HEIGHT, ROWS, WIDTH, boards

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


def test_both_are_scored_on_what_both_can_answer_for(views):
    comparison = compare_models({"lens": lens, "table": half_table}, views, 3)
    assert comparison.refused == {}
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


def test_a_model_that_fails_is_named_and_the_other_taken(views):
    def refuse(views):
        raise CalibrationError("boards do not overlap")

    comparison = compare_models({"lens": lens, "none": refuse}, views, 3)
    assert list(comparison.own) == ["lens"]
    assert "boards do not overlap" in comparison.refused["none"]
    assert comparison.best() == "lens"
    with pytest.raises(CalibrationError, match="do not overlap"):
        compare_models({"none": refuse}, views, 3).best()


def corner_table(views):
    """Rays in one corner of the image only, where no board is."""
    whole = GeneralCamera.from_camera(PerspectiveCamera(K, [], WIDTH, HEIGHT))
    mask = np.zeros_like(whole.mask)
    mask[-3:, :3] = True
    return GeneralCamera(whole.directions, mask)


def test_without_common_corners_the_model_with_more_rays_is_taken(views):
    comparison = compare_models({"table": corner_table, "lens": lens}, views, 3)
    assert comparison.best() == "lens"


def test_each_camera_is_built_once_and_never_sees_its_part(views):
    built = []

    def remember(views):
        built.append([view.name for view in views])
        return lens(views)

    compare_models({"a": remember, "table": half_table}, views, 3)
    assert built == [
        [f"view{i}" for i in range(6) if i % 3 != part] for part in range(3)
    ]
