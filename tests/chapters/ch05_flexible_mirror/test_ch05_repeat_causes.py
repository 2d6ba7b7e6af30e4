"""Section 5.3.3, there and back: why errors grow or do not, and claims about it."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_3_repeatability import claims, experiment
from chapters.ch05_flexible_mirror.s3_3_repeatability.report import PANELS, LoopRuns
from chapters.shared.mirror.levels import BENCHES, SWEPT
from chapters.shared.mirror.rigs import mirror_rig
from raxel.geometry import transform
from raxel.geometry.planes import on_plane
from tests.judged_claims import assert_verdicts, of_rejected, verdicts
from tests.made_results import of_columns, of_levels

SEEDS = 40
# Half of them: the claim reads the vectors of all loops once for each loop.
LOOPS = 20


def vectors(level, edge, lost, worse):
    """Columns of loops whose vectors are 1 mm long, and `edge` mm next to the clamp;
    twice that in the panels `worse`; lost: runs without the single step."""
    board = mirror_rig("A").board.points()
    near = claims.next_to_clamp(board, np.ones(len(board), bool), claims.way_to_clamp())
    values = {
        "board_mm": [board] * LOOPS,
        "refused": [None] * LOOPS,
        "single_refused": ["no"] * lost + [None] * (LOOPS - lost),
    }
    for place in PANELS:
        own = np.tile([0.0, 1.0], (len(board), 1))
        own[near, 1] = 2 * edge if place in worse else edge
        gone = lost if place == "single" else 0
        values[f"{place}.back_mm"] = [np.nan] * gone + [1.0] * (LOOPS - gone)
        values[f"{place}.own"] = [None] * gone + [own] * (LOOPS - gone)
    return {f"{level}.{name}": column for name, column in values.items()}


def loops(edge=0.5, lost=0, worse=(), at=()):
    """at: the panels that are worse at the ends of the sweep."""
    return of_levels(
        ("table_5_5_runs", BENCHES, lambda level: vectors(level, edge, lost, worse)),
        (
            "table_5_5_swept",
            SWEPT,
            lambda level: vectors(level, edge, lost, at or worse),
        ),
    )


def test_clamp_edge_claim_uses_all_panels():
    judge = claims.judge_fixed_edge
    turned = loops(edge=0.6, at=("start",))
    assert_verdicts(judge, loops(), [loops(edge=1.1)], [turned])
    assert verdicts(judge, loops(edge=0.6, worse=("step3",)))[0] == "differs"
    found = of_rejected(judge, loops(lost=6))
    assert found == {("reproduced", "6 of 20", "differs")}


def test_clamp_edge_is_the_outermost_visible_corner_of_each_row():
    board = mirror_rig("A").board.points()
    seen = np.ones(len(board), bool)
    columns = np.unique(board[:, 0])
    seen[board[:, 0] == columns[0]] = False
    edge = claims.next_to_clamp(board, seen, -1)
    assert len(edge) == len(np.unique(board[:, 1]))
    np.testing.assert_allclose(board[edge, 0], columns[1])
    runs = LoopRuns(loops())
    share = len(edge) / len(board)
    np.testing.assert_allclose(
        claims.edge_ratios(runs, "start"), 0.5 / (1 - share + 0.5 * share)
    )


def test_clamp_edge_is_nearest_to_the_clamp_in_the_image():
    rig = mirror_rig("A")
    T = rig.board_pose(np.random.default_rng(5), 400.0, (15.0,))
    camera, board = rig.camera(15.0), rig.board.points()
    pixels, seen = rig.corners(camera, T)
    edge = claims.next_to_clamp(board, seen, claims.way_to_clamp())
    clamp = rig.clamp_pixels(camera).mean(axis=0)
    far = np.linalg.norm(pixels - clamp, axis=1)
    assert far[edge].mean() < 0.6 * far[seen].mean()


def seen_made(covered=1.2, reciprocal=2.0, lost=0, swinging=0, at=None):
    """Both experiments: steps back over steps out; at: {level: another ratio}; lost,
    swinging: runs that ended before step 4, or have a swinging end there."""
    rng = np.random.default_rng(3)

    def columns(level):
        values = {}
        for step in range(1, 7):
            swings = step == 4 and np.arange(SEEDS) < swinging
            values[f"{level}.step{step}.swing_deg"] = np.full(SEEDS, 5.0 * swings)
            back = step > 3
            gone = np.arange(SEEDS) < lost * back
            for what, size, more in (
                ("covered", 0.6, (at or {}).get(level, covered)),
                ("reciprocal", 0.02, reciprocal),
            ):
                trials = size * more**back * (1 + 0.01 * rng.standard_normal(SEEDS))
                values[f"{level}.step{step}.{what}"] = np.where(gone, np.nan, trials)
        return values

    plans = zip(claims.CONDITIONED, (BENCHES, SWEPT), strict=True)
    return of_levels(*((name, levels, columns) for name, levels in plans))


def test_conditioning_claim_needs_coverage_and_condition():
    judge = claims.judge_conditioning
    false = (seen_made(covered=0.9), seen_made(reciprocal=0.9))
    turned = seen_made(at={"twice the factor": 0.8})
    assert_verdicts(judge, seen_made(), false, [turned])
    expected = ("reproduced", "20 of 40", "differs")
    assert of_rejected(judge, seen_made(lost=20)) == {expected}
    # Those with swinging ends are rejected in that reading alone.
    assert of_rejected(judge, seen_made(swinging=20)) == {expected, expected[:1]}


def grown(without=0.3, with_metric=0.1, lost=0, spread=0.05, both=False):
    """Back-projection errors that grow by so much with each step."""
    rng = np.random.default_rng(4)
    values = {}
    for arm, rate in (("metric", with_metric), ("without", without)):
        slopes = rate + spread * rng.standard_normal(SEEDS)
        for step in range(1, 7):
            for name in ("back_mm", "angle_deg"):
                trials = 1 + slopes * step
                if (both or arm == "without") and step > 2:
                    trials[:lost] = np.nan
                values[f"{arm}.step{step}.{name}"] = trials
        gone = lost if arm == "without" else 0
        values[f"{arm}.refused"] = ["step 3: no"] * gone + [None] * (SEEDS - gone)
    return {claims.METRIC: of_columns(({"geometry": "A"}, values))}


@pytest.mark.parametrize(
    ("made", "verdict"),
    [
        ({}, "reproduced"),
        ({"without": 0.1, "with_metric": 0.3}, "differs"),
        ({"without": 0.11, "spread": 0.1}, "undecided"),
        ({"lost": 30}, "reproduced"),
    ],
)
def test_metric_claim_compares_growth_of_both_arms(made, verdict):
    reading = claims.judge_metric(grown(**made))
    assert reading.verdict == verdict
    lost = made.get("lost", 0)
    assert f"without the metric {lost}, with it 0" in reading.reason


def test_run_rejected_by_both_arms_is_excluded():
    result = grown(lost=30, both=True)
    assert np.isnan(claims.without_less_metric(result[claims.METRIC])[:30]).all()
    found = of_rejected(claims.judge_metric, result)
    assert found == {("reproduced", "30 of 40", "differs")}


def test_growth_rate_is_the_slope_and_rejection_the_worst():
    errors = 2 + 0.25 * np.arange(6)[:, None] + np.zeros((6, 2))
    np.testing.assert_allclose(claims.rates(errors), 0.25)
    result = grown(lost=3)[claims.METRIC]
    found = claims.without_less_metric(result)
    assert np.isposinf(found[:3]).all()
    assert np.isfinite(found[3:]).all()
    both = claims.while_both_go_on(result)
    np.testing.assert_allclose(both[3:], found[3:])
    np.testing.assert_allclose(both, 0.2, atol=0.4)


def test_corners_stay_on_their_rays_without_the_metric():
    rig = mirror_rig("A")
    camera, board = rig.camera(5.0), rig.board.points()
    T = rig.board_pose(np.random.default_rng(6), deflections=(5.0,))
    pixels, seen = rig.corners(camera, T)
    pixels[~seen] = np.nan
    off = pixels + np.random.default_rng(7).normal(0, 5.0, pixels.shape)
    true = transform(T, on_plane(board))
    for arm in experiment.ARMS:
        found = experiment.scene_points(camera, pixels, board, arm)
        np.testing.assert_allclose(found[seen], true[seen], atol=1e-5)
        assert np.isnan(found[~seen]).all()
    rays = camera.rays(off)
    bent = experiment.scene_points(camera, off, board, "without")
    known = np.isfinite(bent[:, 0])
    way = (bent - rays.origins)[known]
    along = np.sum(way * rays.directions[known], axis=1)
    np.testing.assert_allclose(np.linalg.norm(way, axis=1), along, rtol=1e-9)
    stiff = experiment.scene_points(camera, off, board, "metric")[known]
    pairs = np.linalg.norm(np.diff(stiff, axis=0), axis=1)
    np.testing.assert_allclose(
        pairs, np.linalg.norm(np.diff(board[known], axis=0), axis=1), rtol=1e-9
    )


def test_covered_share_is_that_of_the_sheet():
    rig = mirror_rig("A")
    camera = rig.camera(5.0)
    outline = np.array([[0.25, -0.5], [0.75, -0.5], [0.75, 0.5], [0.25, 0.5]])
    mirror = camera.mirror
    x, y = (outline * [mirror.end, mirror.half_width]).T
    points = np.column_stack([x, y, mirror.height(x, y)[0]])
    pixels = camera.viewer.project(transform(camera.T_viewer_mirror, points)).pixels
    assert experiment.covered_share(camera, pixels) == pytest.approx(0.25, rel=1e-3)
