"""Models are compared on the same corners, from cameras that never saw them."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.correspondence import BoardView
from raxel.cameras import GeneralCamera, PerspectiveCamera
from raxel.errors import CalibrationError
from raxel.evaluation.comparison import ModelComparison, compare_models
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


def test_the_corners_that_all_answer_for_choose_not_each_models_own():
    """A model that has rays only where boards are easy scores well on its own."""
    scored = 4 * [SimpleNamespace(n_corners=20, n_without_ray=0)]
    own, common = (
        {
            name: SimpleNamespace(mean_deg=angle, share_with_ray=1.0, images=scored)
            for name, angle in angles.items()
        }
        for angles in ({"easy": 0.1, "whole": 0.25}, {"easy": 0.1, "whole": 0.05})
    )
    assert ModelComparison(own, common, {}).best() == "whole"


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


def left(u, v):
    return u < WIDTH // 2


def right(u, v):
    return u >= WIDTH // 2


@pytest.mark.parametrize("bad", [answering(BAD, right), lambda views: BAD])
def test_a_model_that_fits_badly_is_not_chosen_for_its_many_rays(views, bad):
    builders = {"bad": bad, "good": answering(GOOD, lambda u, v: u < WIDTH // 2.5)}
    comparison = compare_models(builders, views, 3)
    own = comparison.own
    assert own["bad"].share_with_ray > own["good"].share_with_ray
    assert own["bad"].mean_deg > 3 * own["good"].mean_deg
    model, why = comparison.choice()
    assert model == "good"
    assert "mean angle" in why


def test_without_common_corners_there_are_no_common_scores_and_that_is_told(views):
    """No corner at all is no reason to say 100 %, nor a number that is none."""
    builders = {"left": answering(GOOD, left), "right": answering(GOOD, right)}
    comparison = compare_models(builders, views, 3)
    assert comparison.common == {}
    own = comparison.own
    more = max(own, key=lambda model: own[model].share_with_ray)
    assert comparison.choice() == (
        more,
        "rays for the most kept-out points; too few are common to all models",
    )
    (doubt,) = comparison.doubts()
    assert doubt.startswith("all models answer for no common point: too few")


def test_few_common_corners_do_not_decide_and_are_counted(views):
    middle = slice(WIDTH // 2 - 12, WIDTH // 2 + 32)
    builders = {
        "left": answering(GOOD, lambda u, v: u < middle.stop),
        "right": answering(GOOD, lambda u, v: u >= middle.start),
    }
    comparison = compare_models(builders, views, 3)
    corners, boards = comparison.common_counts()
    assert 0 < corners < 50
    for evaluation in comparison.common.values():
        assert evaluation.share_with_ray == 1
    (doubt,) = comparison.doubts()
    assert f"for {corners} common points of {boards} views kept out" in doubt


def test_parts_that_gave_no_camera_are_told(views):
    def fails_once(views):
        if views[0].name == "view1":
            raise CalibrationError("boards do not overlap")
        return GOOD

    comparison = compare_models({"lens": lens, "some": fails_once}, views, 3)
    (doubt,) = comparison.doubts()
    assert doubt.startswith("some: 1 of the cross-validation's parts left out")
    assert doubt.endswith("boards do not overlap")


def test_models_that_answer_for_nothing_are_refused(views):
    builders = {"none": answering(GOOD, never), "lens": lens}
    assert compare_models(builders, views, 3).choice() == (
        "lens",
        "no other model answers for a view kept out",
    )
    alone = compare_models({"none": builders["none"]}, views, 3)
    with pytest.raises(CalibrationError, match="no model answers for six points"):
        alone.choice()
