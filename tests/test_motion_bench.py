"""The bench of motions without a centre: its rows, and PoseLib where it is not."""

import sys

import numpy as np
import pytest

from raxel.multiview.generalised_robust import generalised_pose_ransac
from raxel.multiview.motion_information import motion_information
from tests.bench.motions import (
    ALL_THREE,
    NO_POSELIB,
    THRESHOLD,
    bench_motions,
    contenders,
    motions_table,
    scene,
)
from tests.ray_scenes import off


@pytest.fixture(autouse=True)
def no_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "poselib", None)


@pytest.mark.parametrize("kind", ["rig", "mirror"])
def test_all_contenders_find_the_motion_and_the_table_says_who_is_missing(kind):
    rows = bench_motions(kind, scenes=1, repeats=1)
    assert [row.name for row in rows] == [*contenders(kind), ALL_THREE]
    for row in rows[1:]:
        assert row.lost == 0
        assert max(row.errors) < 4
    assert rows[-1].ms == pytest.approx(sum(row.ms for row in rows[:-1]))
    lines = motions_table(rows)
    assert lines[-1] == NO_POSELIB
    assert "     200" in lines[4]


@pytest.mark.parametrize("seed", [4, 11])
def test_a_wrong_pair_that_meets_before_the_mirror_moves_nothing(seed):
    """Next to its ray's pivot a pair has a lever that a small gap does not show."""
    A, B, wrong, T = scene("mirror", seed)
    found = generalised_pose_ransac(A, B, np.random.default_rng(0), THRESHOLD)
    told = motion_information(T, A.of(~wrong), B.of(~wrong))
    turn, _, length = off(found.T_2_1, T, told.centre)
    assert turn < 4 * told.rotation_sd
    assert abs(np.log(length)) < 4 * told.scale_sd


def test_scenes_differ_and_repeat():
    A, B, wrong, T = scene("mirror", 1)
    again, other = scene("mirror", 1), scene("mirror", 2)
    np.testing.assert_array_equal(A.origins, again[0].origins)
    assert np.abs(T - other[3]).max() > 0.01
    assert wrong.mean() == pytest.approx(0.3)
    assert len(A.origins) == len(B.origins) == 200
