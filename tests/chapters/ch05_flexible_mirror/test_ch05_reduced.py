"""Section 5.3.2: the plane of the reduced model, the errors, and how it is judged."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_2_reduced_model import experiment, report
from chapters.shared.mirror.levels import BENCHES
from chapters.shared.mirror.levels import SWEPT as ENDS
from chapters.shared.mirror.rigs import mirror_rig
from raxel.calibration.mirror.reduced import DistanceCurve, HeightCurve
from tests.judged_claims import of_rejected, readings_of
from tests.made_results import as_planned, of_levels

SEEDS = 40
ANGLE = 0.02


@pytest.fixture(scope="module")
def cylinder():
    """A rig whose rulings are level with the image, its camera, and its u axis."""
    rig = mirror_rig("A")
    fields = rig.rig.camera.arguments() | {"deflections": 7.98, "rulings": 0.0}
    turned = [[0.5, 0.0, np.sqrt(0.75)], [0.0, -1.0, 0.0], [np.sqrt(0.75), 0.0, -0.5]]
    axes = experiment._axes(ANGLE)
    fields["rotation"] = axes.T @ (np.array(turned) * [-1, 1, 1])
    return rig, type(rig.rig.camera)(**fields)


def heights_of(rig, camera):
    """The HeightCurve next to the true mirror of a camera."""
    seen = experiment.scan_of(rig, camera, ANGLE)
    T = camera.T_viewer_mirror
    foot, along = (experiment.in_plane(v, ANGLE) for v in (T[:3, 3], T[:3, 0]))
    across = np.array([-along[1], along[0]])
    x, z = ((seen.points - foot) @ axis for axis in (along, across))
    powers = np.vander(x / 160.0, 4, increasing=True)
    return HeightCurve(np.linalg.lstsq(powers, z, rcond=None)[0], foot, along, 160.0)


def test_reduced_model_is_exact_for_a_cylinder(cylinder):
    rig, camera = cylinder
    found = experiment.ReducedCamera(camera.viewer, ANGLE, heights_of(rig, camera))
    pixels = experiment.lattice(camera, 300)
    true, rays = camera.rays(pixels), found.rays(pixels)
    np.testing.assert_allclose(rays.origins, true.origins, atol=0.05)
    np.testing.assert_allclose(rays.directions, true.directions, atol=2e-3)
    assert len(pixels) > 20


def test_plane_rays_are_projected_space_rays():
    curve = DistanceCurve(np.array([400.0, 60.0, 5.0, 1.0]), (0.2, -0.1))
    camera = experiment.ReducedCamera(mirror_rig("A").viewer, ANGLE, curve)
    pixels = np.array([[1300.0, 900.0], [1900.0, 1500.0], [np.nan, np.nan]])
    flat = experiment.in_plane(camera.rays(pixels).directions, ANGLE)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    np.testing.assert_allclose(camera.plane_rays(camera.u(pixels)), flat, atol=1e-12)
    assert list(camera.rays(pixels).valid) == [True, True, False]


def exact(curve, u, v):
    """Mirror points and normals in the plane, of the rays of a curve in space."""
    camera = experiment.ReducedCamera(None, 0.0, curve)
    view = np.column_stack([u, v, np.ones_like(u)])
    view /= np.linalg.norm(view, axis=1, keepdims=True)
    tangents = curve.tangents(u)
    n = np.column_stack([-tangents[:, 1], 0 * u, tangents[:, 0]])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    away = view - 2 * np.sum(view * n, axis=1, keepdims=True) * n
    return camera.curve.points(u), experiment.plane_normals(view, away, 0.0)


@pytest.mark.parametrize("shaped_by", ["normals", "points"])
def test_exact_rays_recover_the_distance_curve(shaped_by):
    true = DistanceCurve(np.array([400.0, 60.0, 5.0, 1.0]), (0.2, -0.1))
    u = np.linspace(0.19, -0.09, 30)
    points, normals = exact(true, u, 0.1 * np.sin(40 * u))
    given = normals if shaped_by == "normals" else None
    found = experiment.distances_next_to(points, true.span, given)
    np.testing.assert_allclose(found.coefficients, true.coefficients, atol=1e-6)


def test_exact_rays_recover_the_height_curve():
    along = np.array([-np.sin(1.0), np.cos(1.0)])
    true = HeightCurve(
        np.array([0.0, 0.0, 0.3, -0.1]), np.array([60.0, 370.0]), along, 160.0
    )
    points = np.array([60.0, 370.0]) + np.outer(np.linspace(0, 160, 30), along)
    u = points[:, 0] / points[:, 1]
    points, normals = exact(true, u, 0.1 * np.sin(40 * u))
    found = experiment.heights_next_to(points, u[0], u[-1], normals)
    np.testing.assert_allclose(found.points(u), true.points(u), atol=1e-3)


def test_scan_alignment_removes_a_motion():
    rig = mirror_rig("A")
    scans = [
        experiment.scan_of(rig, rig.camera(mm), ANGLE)
        for mm in experiment.DEFLECTIONS_MM
    ]
    for one in scans:
        np.testing.assert_allclose(np.linalg.norm(one.normals, axis=1), 1)
    assert abs(scans[1].x[scans[1].at_load] - 150) < 2
    centre = scans[0].points.mean(axis=0)
    across = scans[0].normals[50]
    motion = np.array([*(0.7 * across), 0.004])
    off = [one.moved(centre) @ motion for one in scans]
    shared = experiment.aligned(scans, off)
    np.testing.assert_allclose(shared[0], 0, atol=1e-9)
    np.testing.assert_allclose(shared[1], 0, atol=1e-2)
    np.testing.assert_allclose(experiment.alone(scans[1], off[1]), 0, atol=1e-2)
    # A bend is no motion.
    bend = (scans[0].x / 160) ** 2
    assert np.mean(np.abs(experiment.alone(scans[0], bend))) > 0.03


def test_offset_of_a_deeper_mirror_is_positive_at_the_load():
    rig = mirror_rig("A")
    before, after = (
        experiment.scan_of(rig, rig.camera(mm), ANGLE)
        for mm in experiment.DEFLECTIONS_MM
    )

    class Curve:
        def points(self, u):
            order = np.argsort(after.points[:, 0] / after.points[:, 1])
            rays = after.points[order, 0] / after.points[order, 1]
            z = np.interp(u, rays, after.points[order, 1])
            return np.column_stack([u * z, z])

    off = before.off(Curve())
    assert 6 < off[before.at_load] < 9
    assert abs(off[0]) < 0.01


def columns(**errors):
    """Columns of seeds: stage -> mean error, mm, alike in every way and frame."""
    rng = np.random.default_rng(2)
    return {
        f"{way}.{stage}.{frame}": np.array(error) * (1 + 0.01 * rng.random(SEEDS))
        for way in experiment.WAYS
        for stage, error in errors.items()
        for frame in report.FRAMES["scan_frame"].values()
    }


def made(usual, **other):
    """The results of both experiments; other: what is otherwise at a level."""

    def of(level):
        values = columns(**(usual | other.get(level, {})))
        return {f"{level}.{key}": value for key, value in values.items()}

    return of_levels((report.RUNS, BENCHES, of), (report.SWEPT, ENDS, of))


def judged(judge, usual, **other):
    return readings_of(judge, made(usual, **other))


TRUE = {"before": 0.1, "linear": 1.8, "final": 0.12}
CLAIMS = {
    report.judge_final_good: ({"final": 1.0},),
    report.judge_primary_limits: ({"final": 0.25}, {"final": 0.04}),
}


@pytest.mark.parametrize("judge", CLAIMS, ids=lambda judge: judge.__name__)
def test_reduced_model_claim_holds_and_fails(judge):
    true = judged(judge, TRUE)
    assert {r.verdict for r in true} == {"reproduced"}
    # Three levels, each with one other option of three questions, and two of the frame.
    assert len(true) == 18
    for wrong in CLAIMS[judge]:
        assert {r.verdict for r in judged(judge, TRUE | wrong)} == {"differs"}


@pytest.mark.parametrize("judge", CLAIMS, ids=lambda judge: judge.__name__)
def test_sweep_that_contradicts_leaves_the_primary_undecided(judge):
    (wrong, *_) = CLAIMS[judge]
    found = judged(judge, TRUE, **{"twice the factor": wrong})
    assert [r.verdict for r in found[:1]] == ["undecided"]
    assert {r.verdict for r in found[1:]} == {"reproduced"}
    assert "twice the factor" in found[0].reason


@pytest.mark.parametrize("judge", CLAIMS, ids=lambda judge: judge.__name__)
def test_rejected_runs_are_excluded_and_reported(judge):
    missing = np.where(np.arange(SEEDS) < 12, np.nan, TRUE["final"])
    found = of_rejected(judge, made(TRUE | {"final": missing}))
    assert found == {("reproduced", "12 of 40", "differs")}
    assert {r.reason for r in judged(judge, TRUE | {"final": np.nan})} == {
        "all 40 runs were rejected"
    }


def grown(slope, refused=0, floor_mm=0.01):
    """Results in which the final error grows so with the error put in."""
    count = 30
    factors = 1 + 0.2 * np.random.default_rng(4).standard_normal(count)

    def of(condition):
        injected = np.array(experiment.INJECTED_MM)
        levels = floor_mm + slope * factors[:, None] * injected
        levels[:refused, 1:] = np.nan
        return {"final_mm": list(levels), "before_mm": [injected] * count}

    return {"exp_c5_primary_sensitivity": as_planned("exp_c5_primary_sensitivity", of)}


@pytest.mark.parametrize(
    ("slope", "verdict"),
    [(1.0, "reproduced"), (0.7, "reproduced"), (0.5, "undecided"), (0.3, "differs")],
)
def test_sensitivity_claim_needs_half_of_the_initial_error(slope, verdict):
    (found,) = readings_of(report.judge_primary_sensitivity, grown(slope))
    assert found.verdict == verdict
    assert found.regenerated == pytest.approx(slope, rel=0.15)
    # One refused seed in ten is the worst at its level, and turns nothing.
    (few,) = readings_of(report.judge_primary_sensitivity, grown(slope, refused=3))
    assert few.verdict in (verdict, "undecided")


def test_injected_error_has_its_size():
    condition = {"geometry": "A", "kind": "all"}
    found = experiment.sensitivity_trial(condition, np.random.default_rng(2))
    sizes = np.array(experiment.INJECTED_MM)
    # The curve next to the mirror is itself a little off, of a higher order.
    assert 0 < found["before_mm"][0] < 0.01
    np.testing.assert_allclose(found["before_mm"][1:], sizes[1:], rtol=0.02)
    assert 0 < found["final_mm"][0] < 0.05
    assert found["final_mm"][-1] > 5 * found["final_mm"][0]
