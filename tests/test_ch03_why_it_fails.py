"""The page on CELECT's failures: its boards, and the naming of the stage that lost."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chapters.ch03_planar_grids.ext_why_it_fails.exercises import (
    largest_radius,
    least_square,
    widest_arc,
)
from chapters.ch03_planar_grids.ext_why_it_fails.results import TRACED
from chapters.ch03_planar_grids.ext_why_it_fails.tables import ext_why_stages
from chapters.ch03_planar_grids.ext_why_it_fails.trials import stages
from chapters.ch03_planar_grids.ext_why_it_fails.trials.cases import (
    BOARD,
    CASES,
    levels_of,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.ordering import (
    lattice_at,
    ordering_trial,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.runs import (
    merged_ratio,
    wrong_first_line,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.sector_board import (
    SectorBoard,
    clicked_from,
)
from raxel.features.celect import CelectResult, ContourTrace, along_contour
from tests.made_results import as_planned

ORDINARY = SectorBoard(**BOARD)
HALF_RING = {"columns": 9, "rows": 5, "radius_px": 470.0, "depth_px": 250.0}


@given(
    arc=st.floats(2, 170),
    growth=st.floats(0.2, 8),
    bow=st.floats(-5, 5),
    turn=st.floats(0, 360),
)
def test_a_place_of_the_sector_leads_back_to_its_lattice_point(arc, growth, bow, turn):
    board = SectorBoard(arc_deg=arc, growth=growth, bow_deg=bow, turn_deg=turn)
    points = np.array([[0, 0], [8, 5], [3.3, 2.2], [-0.4, 1.7], [8.2, 4.9]])
    np.testing.assert_allclose(board.lattice_of(board.place(points)), points, atol=1e-7)


def test_rows_of_the_sector_are_arcs_and_growth_is_the_ratio_of_its_squares():
    board = SectorBoard(growth=4.0, rows=7)
    steps = np.linalg.norm(np.diff(board.lattice[:, 3], axis=0), axis=1)
    assert steps[-1] / steps[0] == pytest.approx(4)
    assert steps.sum() == pytest.approx(board.depth_px)
    chord = np.linalg.norm(board.lattice[0, -1] - board.lattice[0, 0])
    assert chord == pytest.approx(2 * 450 * np.sin(np.radians(30)))


def test_the_picture_has_the_colours_of_its_squares_and_its_surround():
    picture = ORDINARY.image(0.7, 0.0, np.random.default_rng(0))
    y, x = np.mgrid[-1:6, -1:8] + 0.5
    points = np.column_stack((x.ravel(), y.ravel()))
    u, v = np.rint(ORDINARY.place(points)).astype(int).T
    black = (np.floor(points).sum(axis=1) % 2) == 0
    np.testing.assert_array_equal(picture[v, u], np.where(black, 0, 255))
    assert picture[2, 2] == 127


def test_edge_pixels_hold_the_share_that_they_see():
    picture = ORDINARY._drawn()
    u, v = np.rint(ORDINARY.place(np.array([[3.0, 2.5]]))[0]).astype(int)
    inside = (np.arange(64) + 0.5) / 64 - 0.5
    for du in (-1, 0, 1):
        places = [(u + du + a, v + b) for a in inside for b in inside]
        x, y = np.floor(ORDINARY.lattice_of(np.array(places))).T
        share = 255 * np.mean((x + y) % 2)
        # 4 x 4 places in a pixel: one row of them is a quarter.
        assert picture[v, u + du] == pytest.approx(share, abs=255 / 8)


@pytest.mark.parametrize("start", range(4))
def test_clicks_begin_at_any_corner_and_go_either_way_round(start):
    lattice = ORDINARY.lattice
    around = lattice[[0, 0, -1, -1], [0, -1, -1, 0]]
    for clockwise, step in ((True, 1), (False, -1)):
        seen = clicked_from(lattice, start, clockwise)
        outer = seen[[0, 0, -1, -1], [0, -1, -1, 0]]
        np.testing.assert_array_equal(outer, around[(start + step * np.arange(4)) % 4])


def found(change=None):
    """A CelectResult as if all went well, its contours changed by `change(trace)`."""
    lattice = ORDINARY.lattice
    rows, columns = lattice.shape[:2]
    names = [f"side {i}" for i in range(1, 5)]
    names += [f"column {k}" for k in range(2, columns)]
    contours = []
    for name in names:
        truth = along_contour(name, lattice)
        stops = along_contour(name, ORDINARY.coordinates)
        anchors = ORDINARY.place(stages.between(stops)[::8])
        empty = np.empty(0)
        trace = ContourTrace(name, anchors, empty, 30.0, truth, truth, truth)
        contours.append(change(trace) if change else trace)
    outer = lattice[[0, 0, -1, -1], [0, -1, -1, 0]]
    corners = lattice if change is None else np.full_like(lattice, np.nan)
    done = change is None
    return CelectResult(done, corners, columns, rows, outer, (), tuple(contours))


def lost(result):
    return stages.lost_at(result, ORDINARY.coordinates, ORDINARY.place)


def on(name, **fields):
    """A change of one contour: fields as functions of what they were."""

    def change(trace):
        if trace.name != name:
            return trace
        new = {key: make(getattr(trace, key)) for key, make in fields.items()}
        return trace._replace(**new)

    return change


def without(index):
    return lambda points: np.delete(points, index, axis=0)


def test_nothing_is_lost_when_every_corner_is_in_its_place():
    assert lost(found()).stage == stages.DONE


def test_a_click_on_another_corner_is_named():
    result = found(on("side 1"))
    result.outer_corners[2] = ORDINARY.lattice[-1, -2]
    assert lost(result)[:2] == (stages.CLICK, "corner 3")
    result.outer_corners[1] = np.nan
    assert lost(result)[:2] == (stages.CLICK, "corner 2")


@pytest.mark.parametrize(
    ("stage", "fields"),
    [
        (stages.MISSED, ("candidates", "inliers", "merged")),
        (stages.THROWN_OUT, ("inliers", "merged")),
        (stages.MERGED, ("merged",)),
    ],
)
def test_the_first_stage_without_a_corner_lost_it(stage, fields):
    change = on("column 4", **dict.fromkeys(fields, without(2)))
    told = lost(found(change))
    assert told[:2] == (stage, "column 4")
    np.testing.assert_allclose(told.where, ORDINARY.lattice[2, 3])


def test_a_corner_too_many_and_its_place_are_named():
    extra = ORDINARY.place(np.array([[7.0, 2.4]]))
    change = on("side 2", merged=lambda points: np.vstack((points, extra)))
    told = lost(found(change))
    assert told[:2] == (stages.FALSE, "side 2")
    np.testing.assert_allclose(told.where, extra[0])


def test_a_trace_that_leaves_its_contour_is_told_from_one_that_stops():
    away = on(
        "side 3",
        anchors=lambda a: np.vstack((a[:6], a[5] + [[30, 30], [60, 60]])),
        merged=lambda _: np.empty((0, 2)),
    )
    nothing = {"merged": lambda _: np.empty((0, 2))}
    stops = on("side 3", anchors=lambda a: a[:6], radii=lambda _: np.ones(6), **nothing)
    tires = on("side 3", anchors=lambda a: a[:6], radii=lambda _: np.ones(5), **nothing)
    assert lost(found(away))[:2] == (stages.WRONG_EDGE, "side 3")
    assert lost(found(stops))[:2] == (stages.NO_EDGE, "side 3")
    assert lost(found(tires))[:2] == (stages.TOO_LONG, "side 3")


@pytest.mark.parametrize(("arc", "foretold"), [(147, False), (153, True)])
def test_an_arc_of_150_deg_on_side_4_breaks_the_condition_on_the_first_corner(
    arc, foretold
):
    board = SectorBoard(arc_deg=float(arc), **HALF_RING)
    from_arc = clicked_from(board.coordinates, 1, True)
    assert wrong_first_line(from_arc, board.place) is foretold
    assert not wrong_first_line(board.coordinates, board.place)
    assert widest_arc() == pytest.approx(150)


def test_the_smallest_square_over_t8_is_that_of_the_exercise():
    board = SectorBoard(rows=9, columns=5, depth_px=400.0, growth=6.0)
    least = np.linalg.norm(np.diff(board.lattice[:2, 0], axis=0))
    assert merged_ratio(board.lattice) == pytest.approx(least / least_square(400, 9))


def test_an_arc_leaves_its_tangent_by_t5_at_the_radius_of_the_exercise():
    radius = largest_radius(470)
    assert 470 * (1 - np.cos(np.arcsin(radius / 470))) == pytest.approx(
        0.1 * radius, rel=0.02
    )


def test_both_orderings_are_right_on_a_flat_board_and_wrong_on_a_bent_one():
    rng = np.random.default_rng(1)
    flat = ordering_trial({"family": "arc", "bend_deg": 1}, rng)
    bent = ordering_trial({"family": "arc", "bend_deg": 60}, rng)
    assert flat["line"]
    assert flat["homography"]
    assert flat["margin"] > 0
    assert not bent["line"]
    assert not bent["homography"]
    assert bent["margin"] < 0
    assert lattice_at({"family": "fov", "bend_deg": 60}, rng).shape == (9, 9, 2)


def test_drawn_levels_are_levels_and_a_quick_build_has_them_all():
    for case, content in CASES.items():
        drawn = set(content["drawn"].values())
        assert drawn <= set(content["levels"])
        assert set(levels_of(case, "quick")) == drawn


def test_clicks_of_every_case_lie_in_its_picture_however_the_board_is_turned():
    for case in CASES:
        for level in levels_of(case, "full").values():
            fields = dict(level["board"])
            fields["arc_deg"] = fields.get("arc_deg", 60.0) * 1.03
            for turn in range(0, 180, 15):
                board = SectorBoard(**fields, turn_deg=float(turn))
                corners = board.lattice.reshape(-1, 2)
                assert corners.min() > 3
                assert corners.max() < board.size_px - 4


def test_every_board_of_a_row_of_the_table_stands_in_one_of_its_columns():
    names = [stages.DONE, stages.CLICK, *TRACED, stages.MISSED, stages.FALSE]
    results = {
        f"ext_why_{case}": as_planned(
            f"ext_why_{case}",
            {f"{level}.stage": names for level in levels_of(case, "full")}
            | {f"{level}.silently_wrong": False for level in levels_of(case, "full")},
        )
        for case in CASES
    }
    columns = ext_why_stages(results).columns
    counted = [columns[name] for name in columns if name in {*names}]
    assert np.sum(counted, axis=0).tolist() == columns["trials"]
    assert "returned, but wrong" not in columns
