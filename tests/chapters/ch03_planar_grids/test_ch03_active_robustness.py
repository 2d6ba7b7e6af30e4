"""3.3.3: degraded images, residuals measured, claims that can fail."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from chapters.ch03_planar_grids.s3_3_active_grid_robustness import experiment, report
from chapters.shared.rigs import rig_named
from raxel.features.active_grid import decode
from raxel.features.active_grid.positions import pixels_of
from raxel.geometry.homography import apply_homography
from raxel.lab.sensor import Sensor
from repro.run.outcomes import Plan
from tests.judged_claims import readings_of
from tests.made_results import written

H = np.array([[0.5, 0.03, 12.0], [-0.02, 0.55, 7.0], [2e-4, -1e-4, 1.0]])
SQUARE = np.stack(np.meshgrid(np.arange(15.0), np.arange(15.0)), axis=-1)
POINTS = 4 * SQUARE.reshape(-1, 2)


def second_grid(noise=0.0):
    """A second grid (90, 120, 2) mm that a pinhole sees."""
    v, u = np.indices((90, 120))
    points = apply_homography(H, np.column_stack([u.ravel(), v.ravel()]) * 1.0)
    points += np.random.default_rng(0).normal(0, noise, points.shape)
    return points.reshape(90, 120, 2)


def test_residual_is_the_rms_after_a_homography():
    corners = 15 + POINTS
    assert experiment.residual_mm(corners, second_grid(), POINTS) < 1e-3
    off = corners + np.random.default_rng(1).normal(0, 0.1, corners.shape)
    left = experiment.residual_mm(off, second_grid(), POINTS)
    # Both axes, less the eight numbers of the homography; a px is a mm here.
    assert left == pytest.approx(0.1 * np.sqrt(2 - 8 / 225), rel=0.12)
    own = experiment.residual_mm(corners, second_grid(noise=0.05), POINTS)
    assert own > 0.03
    off[:112] = np.nan
    assert experiment.residual_mm(off, second_grid(), POINTS) == pytest.approx(
        left, rel=0.2
    )
    off[112] = np.nan
    assert np.isnan(experiment.residual_mm(off, second_grid(), POINTS))


def test_window_follows_the_smallest_square():
    assert experiment.min_step(POINTS) == pytest.approx(4)
    for step, window in ((60, 29), (36, 17), (20, 9), (4, 5)):
        assert experiment.window_of(step / 4 * POINTS) == window


def test_noise_is_shared_by_exposures_and_added_after_blur():
    flat = np.full((1, 80, 80), 100, np.uint8)
    asked = {"blur_px": 0, "noise_grey": 4}
    rng = np.random.default_rng(0)
    one, other = experiment.degraded([flat, flat + 50], asked, rng)
    np.testing.assert_array_equal(other.astype(int) - one, 50)
    assert one.std() == pytest.approx(np.sqrt(16 + 1 / 12), rel=0.05)
    edge = np.zeros((1, 80, 80), np.uint8)
    edge[..., 40:] = 200
    soft = experiment.degraded([edge], {"blur_px": 3, "noise_grey": 0}, rng)[0][0]
    slope = np.diff(soft[40].astype(float))
    spread = np.average((np.arange(79) - 39) ** 2, weights=slope)
    assert np.sqrt(spread) == pytest.approx(3, rel=0.05)
    assert edge[0, 0, 39] == 0


def test_brighter_image_equals_more_light():
    """As the sensor itself would have made it, overflow along columns included."""
    rng = np.random.default_rng(0)
    light = rng.uniform(0.05, 0.6, (60, 40))
    light[20:25, 10:15] = 0.95
    sensor = Sensor(9e6, 1e7, blooming=0.5, gamma=2.2)
    more = replace(sensor, white_e=9e6 * experiment.GAIN)
    taken = sensor.expose(light, rng)
    made = experiment.brighter(taken, sensor).astype(int)
    assert np.abs(made - more.expose(light, rng)).max() <= 3
    dry = experiment.brighter(taken, replace(sensor, blooming=0))
    assert (made > dry)[[19, 25], 10:15].all()
    np.testing.assert_array_equal(made[:, 20], dry[:, 20])


def test_overflow_does_not_lose_corners():
    """At the edges of the Gray code they are taken for no blur, which would widen the
    margin that the decoder chooses by more than a square: the outermost corners stay.
    """
    rig = rig_named("monitor-d200-small")
    poses = rig.draw_poses(np.random.default_rng(0), len(rig.poses.names))
    patterns, images = experiment.patterns_taken(rig, poses[0], [0])
    bright = [experiment.brighter(image, rig.sensor) for image in images]
    points = rig.target.chessboard_points()
    found = pixels_of(experiment.location_of(bright, patterns, rig.target), points)
    assert np.isfinite(found).all()
    chosen = decode(np.asarray(bright, np.uint16), patterns, rig.target)
    assert chosen.margin_px == experiment.MARGIN_PX
    # Those that overflow are clipped, and left out as such.
    kept = np.isfinite(pixels_of(chosen.location, points)[:, 0])
    assert kept.mean() > 0.5


@cache
def swept(residual, floor=(0.5, 0.5, 0.5)):
    """A result of the sweeps: residual(sweep, level, method) in every reading.

    floor: what true corners leave in each of the three sets.
    """

    def trial(condition, rng):
        at = condition["sweep"], condition["level"]
        methods = {method: residual(*at, method) for method in experiment.METHODS}
        true = floor[int(condition["set"][-1])]
        known = dict.fromkeys(
            experiment.SECOND_GRIDS, methods | {experiment.TRUE: true}
        )
        known |= {"off_px": methods | {experiment.TRUE: 0.0}}
        known |= {"lost": dict.fromkeys(experiment.METHODS, 2)}
        return dict.fromkeys(
            experiment.EXPOSURES, dict.fromkeys(experiment.WINDOWS, known)
        )

    return written(Plan(trial, experiment.conditions("full"), 1, experiment.SETTINGS))


def judged(judge, residual, **options):
    readings = readings_of(judge, {"fig_3_15_sweeps": swept(residual, **options)})
    return {reading.verdict for reading in readings}


def by_measure(judge, residual, **options):
    """Verdicts by the measure of corner errors."""
    readings = readings_of(judge, {"fig_3_15_sweeps": swept(residual, **options)})
    found = {measure: set() for measure in (report.BY_GRID, report.BY_TRUTH)}
    for one in readings:
        found[one.reading["corner_measure"]].add(one.verdict)
    return found[report.BY_GRID], found[report.BY_TRUTH]


def failed(sweep, level, method):
    return np.nan


def behind(sweep, level, method):
    return -ahead(sweep, level, method)


def ahead(sweep, level, method):
    return 1.0 if method == experiment.ACTIVE else 1.1


def behind_in_noise(sweep, level, method):
    return ahead(sweep, level, method) + (
        sweep == "noise" and method == experiment.ACTIVE
    )


def test_active_grid_claims_hold_and_fail():
    judges = report.judge_active_distance, report.judge_active_orientation
    for judge in (*judges, report.judge_active_noise, report.judge_active_best):
        assert judged(judge, ahead) == {"reproduced"}
        assert judged(judge, behind) == {"differs"}
        assert judged(judge, failed) == {"differs"}
    # Five levels of noise of 22 conditions: best in 77 %.
    assert judged(report.judge_active_best, behind_in_noise) == {"differs"}
    assert judged(report.judge_active_noise, behind_in_noise) == {"differs"}
    assert judged(report.judge_active_distance, behind_in_noise) == {"reproduced"}


NARROW, WIDE = (0.5, 0.5, 0.59), (0.5, 0.61, 0.52)


def beaten(sweep, level, method):
    return 1.0 if method == experiment.ACTIVE else 0.9


def blurred(active, other, sharp=1):
    """Residuals that rise by so much at the largest blur."""

    def residual(sweep, level, method):
        grown = sweep == "blur" and level == 4
        return sharp + grown * (active if method == experiment.ACTIVE else other)

    return residual


@pytest.mark.parametrize(
    ("judge", "residual"),
    [
        (report.judge_active_best, beaten),
        (report.judge_active_distance, beaten),
        (report.judge_active_orientation, beaten),
        (report.judge_active_noise, beaten),
        # A tie of ratios is the floor's spread over the sharp residual.
        (report.judge_active_blur, blurred(0.3, 0.2, sharp=2)),
    ],
)
def test_difference_below_the_spread_of_the_floor_is_a_tie(judge, residual):
    """True corners have no floor, and no tie."""
    for floor, verdict in ((NARROW, "differs"), (WIDE, "reproduced")):
        found = by_measure(judge, residual, floor=floor)
        assert found == ({verdict}, {"differs"})


def steep(sweep, level, method):
    return 1 + (sweep == "blur") * (0.6 if method == experiment.ACTIVE else 3)


@pytest.mark.parametrize(
    ("residual", "verdict"),
    [
        (blurred(0.2, 0.3), "reproduced"),
        (steep, "differs"),
        (blurred(-0.2, -0.3, sharp=2), "differs"),
        (ahead, "reproduced"),
    ],
)
def test_blur_is_judged_by_ratios(residual, verdict):
    assert judged(report.judge_active_blur, residual) == {verdict}


def test_rotated_monitor_has_less_area_and_larger_angles():
    rig = rig_named(experiment.RIG)
    size = rig.target.monitor_mm
    straight, turned = (
        experiment.turned_monitor(turn, size, np.random.default_rng(0))
        for turn in (0, 60)
    )
    area = experiment.visible_areas(rig, straight)
    # All of it is in the image, but for pixels on its edge, 1 mm wide.
    assert 0.97 < area.sum() / (size[0] * size[1]) < 1
    assert experiment.visible_areas(rig, turned).sum() < area.sum()
    assert experiment.farthest_angle(rig, straight) == pytest.approx(47, abs=2)
    assert experiment.farthest_angle(rig, turned) > 70
    assert experiment.shared(area, area > 0) == 1
