"""Section 5.3.3: what a deflection is off by at its tip, and how rays turn there."""

from typing import NamedTuple

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_3_deflections import claims, experiment, report
from chapters.shared.mirror.levels import BENCHES, SWEPT
from chapters.shared.mirror.rigs import STAGES_MM, mirror_rig
from tests.judged_claims import readings_of, verdicts
from tests.made_results import of_levels

SEEDS, FEWER = 100, 20


def of_bench(bench, seeds, times, refused=0):
    """Columns of a bench whose tip scatters so many times as much as the rest."""
    rng = np.random.default_rng(6)
    at_load = times * 0.02 * rng.standard_normal(seeds)
    among = 0.02 * rng.standard_normal((seeds, 400))
    found = {
        "tip_mm": at_load,
        "mean_mm": among.mean(axis=1),
        "square_mm2": np.mean(among**2, axis=1),
    }
    found |= {f"surface.{name}": value for name, value in found.items()}
    found["beyond_mm"] = np.full(seeds, 12.0)
    return {
        f"{bench}.{name}": np.where(np.arange(seeds) < refused, np.nan, value)
        for name, value in found.items()
    }


def made(times, swept=None, refused=0):
    swept = times if swept is None else swept
    return of_levels(
        (claims.TIPS, BENCHES, lambda level: of_bench(level, SEEDS, times, refused)),
        (
            claims.TIPS_SWEPT,
            SWEPT,
            lambda level: of_bench(level, FEWER, swept, refused),
        ),
    )


@pytest.mark.parametrize(
    ("times", "verdict"), [(4.0, "reproduced"), (2.0, "undecided"), (1.0, "differs")]
)
def test_tip_claim_needs_twice_the_scatter_of_the_rest(times, verdict):
    found = readings_of(claims.judge_tip, made(times))
    assert [r.verdict for r in found] == [verdict] * 3
    assert found[0].regenerated == pytest.approx(times, rel=0.2)


def test_sweep_that_contradicts_leaves_the_primary_undecided():
    for results in (made(4.0, swept=1.0), made(4.0, swept=np.nan)):
        assert verdicts(claims.judge_tip, results) == ("undecided", {"reproduced"})
    assert verdicts(claims.judge_tip, made(4.0, refused=SEEDS))[0] == "undecided"


def test_rejected_runs_are_counted():
    (first, *_) = readings_of(claims.judge_tip, made(4.0, refused=7))
    assert "7 of 100 runs rejected" in first.reason


def test_pooled_moments_give_the_scatter_of_all_positions():
    errors = np.random.default_rng(1).normal(0.3, 0.1, (30, 50))
    found = claims.among_sd(errors.mean(axis=1), np.mean(errors**2, axis=1))
    assert found == pytest.approx(errors.std())


class Shifted(NamedTuple):
    """A found camera whose mirror is the true one's tangent plane moved along z."""

    mirror: object


def test_mirror_moved_along_the_push_has_that_offset():
    rig = mirror_rig("A")
    true = rig.camera(5.0)
    along = rig.deflection_direction()
    places = np.array([[40.0, -20.0], [100.0, 0.0], [150.0, 30.0]])
    points = experiment.on_mirror(true, places)
    n = along + np.array([0.1, 0.0, 0.0])

    class Plane:
        """The plane through a point at right angles to n."""

        def points(self, p):
            ways = np.column_stack([p, np.ones(len(p))])
            return ways * ((n @ (points[1] + 0.7 * along)) / (ways @ n))[:, None]

        def normals(self, at):
            return np.broadcast_to(n, at.shape)

    found = experiment.beyond(rig, Shifted(Plane()), points)
    assert found[1] == pytest.approx(0.7)
    np.testing.assert_allclose(
        (points + found[:, None] * along) @ n, n @ (points[1] + 0.7 * along)
    )


def test_positions_lie_between_the_corners():
    corners = np.array([[20.0, -30.0], [120.0, -30.0], [120.0, 30.0], [20.0, 30.0]])
    found = experiment.places_among(corners, mirror_rig("A").camera(5.0))
    assert len(found) > 50
    assert found[:, 0].min() >= 20
    assert found[:, 0].max() <= 120
    assert np.abs(found[:, 1]).max() <= 30


def test_curvature_claim_holds_and_fails(monkeypatch):
    (found,) = readings_of(claims.judge_curvature, {})
    assert found.verdict == "reproduced"
    assert found.regenerated < 5
    turns = claims.ray_turns(mirror_rig("A").camera(15.0))
    np.testing.assert_allclose(turns.over_twice(turns.mirror), 1, atol=1e-3)
    monkeypatch.setattr(
        claims, "ray_turns", lambda camera: turns._replace(mirror=1.1 * turns.mirror)
    )
    (other,) = readings_of(claims.judge_curvature, {})
    assert other.verdict == "differs"


def test_flat_mirror_does_not_turn_rays():
    turns = claims.ray_turns(mirror_rig("A").camera(0.0))
    assert np.abs(turns.mirror).max() < 1e-9 < turns.whole.min()


def test_deflections_are_multiples_of_the_resolution():
    steps = np.array(STAGES_MM) / report.RESOLUTION_MM
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9)
