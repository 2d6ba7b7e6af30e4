"""The trials, claims and drawings of section 3.1.2."""

from types import SimpleNamespace

import numpy as np
import pytest

from chapters.ch03_planar_grids.s1_2_celect import claims, experiment, page, report
from chapters.shared.grids.synthetic_board import SyntheticBoard, steps_between
from tests.judged_claims import readings


@pytest.fixture(scope="module")
def run():
    """One recorded run on a small fisheye image."""
    condition = {"camera": "fisheye", "size_px": 600, "least_px": 22, "views": 10}
    return experiment.drawn_run(condition, np.random.default_rng(5))


def test_board_views_are_complete_and_moderate():
    for name in experiment.CAMERAS:
        view = experiment.board_view(name, 600, 10, np.random.default_rng(2))
        sides = steps_between(view.lattice)
        assert view.image.shape == (600, 600)
        assert sides.min() >= 10
        assert sides.max() <= experiment.MAX_SIDE_RATIO * sides.min()
        assert view.lattice.shape == (7, 9, 2)
        assert (np.abs(view.lattice - 299.5) < 299.5).all()


def test_image_shows_corners_at_true_positions():
    """Fields opposite each other at a corner are alike, neighbouring ones are not."""
    view = experiment.board_view("bent sheet", 600, 10, np.random.default_rng(3))
    grid = view.lattice
    across = (grid[1:-1, 2:] - grid[1:-1, :-2]) / 2
    down = (grid[2:, 1:-1] - grid[:-2, 1:-1]) / 2

    def grey(a, b):
        at = grid[1:-1, 1:-1] + 0.3 * (a * across + b * down)
        u, v = np.rint(at).astype(int).reshape(-1, 2).T
        return view.image[v, u].astype(float)

    alike = np.abs(grey(1, 1) - grey(-1, -1))
    unlike = np.abs(grey(1, 1) - grey(1, -1))
    assert alike.max() < 40
    assert unlike.min() > 120


def test_recorded_run_is_complete(run):
    assert run["success"]
    assert run["grid"].shape == (7, 9, 2)
    contours = run["steps"][:, 0]
    assert set(contours) == set(range(11))
    assert (np.diff(contours) >= 0).all()
    for name in ("corners", "edges", "lines"):
        assert run[name][:, 0].max() < len(run["steps"])


def test_flowchart_contains_every_transition():
    counts = experiment.stage_trial({}, np.random.default_rng(0))
    ways = [tuple(k.split(" > ")) for k in counts if " > " in k]
    assert set(ways) <= set(report.ARROWS)
    assert {a for way in ways for a in way} - {"start", "end"} == set(report.BOXES)
    assert counts["process > window"] == counts["contours"] - 1


def test_constructed_corners_avoid_the_decision_boundaries():
    rng = np.random.default_rng(1)
    for _ in range(50):
        side_4, true, wrong = experiment.start_case(rng)
        near, nearer = experiment.predicted_wrong(side_4, true, wrong)
        moved = [
            experiment.predicted_wrong(side_4 + a, true + b, wrong + c)
            for a, b, c in ((1.5, 0, 0), (0, 1.5, 0), (0, 0, -1.5))
        ]
        assert all(m == (near, nearer) for m in moved)


def test_bent_corner_stays_and_bent_disc_moves():
    values = experiment.bias_trial(
        {"bend": 0.2, "radius": 20.0}, np.random.default_rng(0)
    )
    assert values["corner_px"] < 1e-9
    assert values["disc_px"] > 1e-3
    flat = experiment.centroid(lambda p: p + 3, 20.0)
    np.testing.assert_allclose(flat, [3, 3], atol=1e-12)


def test_broken_edges_fade_to_grey_only_there():
    board = SyntheticBoard(square_px=250.0, fov_deg=80.0)
    image, lattice = board.image(1.0), board.lattice
    rng = np.random.default_rng(0)
    broken = experiment.broken_edges(image, lattice, 1.0, 0.4, rng)
    middle = (lattice[0, 0] + lattice[0, 1]) / 2
    u, v = np.rint(middle).astype(int)
    assert abs(int(broken[v, u]) - 128) < 3
    np.testing.assert_array_equal(
        experiment.broken_edges(image, lattice, 0.0, 0.4, rng), image
    )


def test_cochran_armitage_matches_known_tables():
    assert claims.falling_trend([1, 2, 3], [5, 5, 5], [10] * 3) == 0.0
    assert claims.falling_trend([1, 2, 3], [0, 0, 0], [10] * 3) == 0.0
    # Two groups: the statistic is that of the two-proportion test.
    z = claims.falling_trend([0, 1], [8, 2], [10, 10])
    assert z == pytest.approx(-(0.6) / np.sqrt(0.25 * 0.2))
    assert claims.falling_trend([0, 1], [2, 8], [10, 10]) == pytest.approx(-z)


def test_border_loses_28_of_63_corners():
    assert (claims.interior((10, 8), 0), claims.interior((10, 8), 1)) == (63, 35)
    assert claims.judge_border_formula({}).verdict == "reproduced"


def test_shared_candidate_is_counted_once():
    side, column = [[10, 10], [40, 11]], [[10, 10], [10, 40]]
    contours = [SimpleNamespace(candidates=np.array(c)) for c in (side, column)]
    assert page.candidates_of(SimpleNamespace(contours=contours)) == 3
    assert page.candidates_of(SimpleNamespace(contours=())) == 0


def test_growth_claim_is_judged_per_kind_of_break():
    right = [*zip(experiment.BROKEN.values(), ((15, 2), (8, 6), (3, 10)), strict=True)]

    def values(condition):
        ((grown, fixed),) = (counts for one, counts in right if one == condition)
        return {
            "published.success": [k < grown for k in range(20)],
            "no growth.success": [k < fixed for k in range(20)],
        }

    found = readings(claims.judge_window_growth, "table_3_1_growth", values)
    assert [r.verdict for r in found] == ["reproduced", "undecided", "differs"]
