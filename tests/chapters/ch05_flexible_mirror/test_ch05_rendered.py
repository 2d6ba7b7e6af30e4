"""Section 5.3.3 from images: what is read out of them, and what the table counts."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_3_deflections import report
from chapters.ch05_flexible_mirror.s3_3_deflections.experiment import (
    MirrorRun,
    lit_outline,
    scored,
    scoring_boards,
)
from chapters.shared.mirror.levels import BENCHES, FIRST, LABORATORY, LEVEL_NAMES
from chapters.shared.mirror.rigs import mirror_rig
from chapters.shared.mirror.runs import lattice, outline
from raxel.calibration.mirror.observations import normalised
from raxel.cameras import SplineMirrorCamera
from raxel.geometry.spline_grids import spline_grid
from tests.made_results import as_planned, of_columns


@pytest.fixture(scope="module")
def run():
    rig = mirror_rig("A", small=True)
    places = rig.monitor_poses(np.random.default_rng(0))
    T = rig.board_pose(np.random.default_rng(1), deflections=(0.0, 5.0))
    return MirrorRun(rig, BENCHES["laboratory"], rig.stages(), places, [T])


def spline_of(rig, true):
    """The spline nearest to a true mirror, with more knots than are calibrated."""
    grid = spline_grid(normalised(rig.viewer, outline(true)), (12, 5), (3, 3))
    points = true.rays(lattice(true, 12)).origins
    return SplineMirrorCamera.fitted(rig.viewer, grid, points)


def test_scores_separate_correct_and_stale_cameras(run):
    held_out = scoring_boards(run, np.random.default_rng(2))
    stale, right = (spline_of(run.rig, camera) for camera in run.cameras[:2])
    near = scored(run, 1, [stale, right], held_out)
    assert near["angle_deg"] < 0.05
    assert near["back_true_mm"] < 0.2
    assert near["deflection_mm"] == pytest.approx(5, abs=0.02)
    off = scored(run, 1, [stale, stale], held_out)
    assert off["back_true_mm"] > off["back_mm"] > 1
    assert off["deflection_mm"] == pytest.approx(0, abs=0.1)


def test_lit_outline_surrounds_black_squares():
    v, u = np.mgrid[0:200, 0:300]
    inside = (u > 40) & (u < 260) & (v > 30) & (v < 170)
    squares = (u // 30 + v // 30) % 2
    image = np.where(inside, 70 + 150 * squares, 0).astype(np.uint8)
    image[5:8, 5:8] = 200
    around = lit_outline(image)
    np.testing.assert_allclose(around.min(axis=0), [40, 30], atol=3)
    np.testing.assert_allclose(around.max(axis=0), [260, 170], atol=3)


def test_rendered_table_compares_with_redrawn_runs():
    def of_run(condition):
        ended = condition["geometry"] == "B"
        return {
            "published.stage1.angle_deg": 0.1 + 0.1 * condition["run"],
            "published.stage3.angle_deg": np.nan if ended else 0.5,
            "own.stage1.angle_deg": 0.05,
        }

    many = {
        f"{bench}.stage{k}.{name}": np.full(20, 0.3)
        for bench in BENCHES
        for k in report.DEFLECTED
        for name in ("angle_deg", "deflection_mm")
    }
    results = {report.RENDERED: as_planned(report.RENDERED, of_run)}
    for geometry, name in (("A", report.RUNS), ("B", report.OTHER)):
        results[name] = of_columns(({"geometry": geometry}, many))
    columns = report.rendered_table(results).columns
    heads = ("Rig", "Error level", "Method", "Stage")
    rows = list(zip(*(columns[head] for head in heads), strict=True))
    angles, redrawn = (
        dict(zip(rows, columns[f"Mean to true rays (°){more}"], strict=True))
        for more in ("", ", redrawn")
    )
    level, low = LEVEL_NAMES[FIRST], LEVEL_NAMES[LABORATORY]
    first = angles["A", level, "as published", 1]
    assert (first.value, first.low, first.high) == pytest.approx((0.2, 0.1, 0.3))
    assert angles["B", level, "as published", 3] is None
    assert redrawn["B", level, "as published", 3].value == pytest.approx(0.3)
    assert angles["A", low, "raxel calibrate", 1].value == 0.05
    assert redrawn["A", low, "raxel calibrate", 1] is None
