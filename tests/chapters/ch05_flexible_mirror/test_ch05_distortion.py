"""Section 5.3.4: claims about circle and face can fail, on completed runs."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_4_distortion import claims, experiment, report
from chapters.shared.mirror.levels import BENCHES, SWEPT
from chapters.shared.mirror.rigs import mirror_rig
from raxel.errors import InputError
from raxel.geometry.homography import apply_homography
from raxel.multiview.plane_points import circle_outline, points_on_plane
from tests.judged_claims import assert_verdicts, of_rejected, verdicts
from tests.made_results import of_levels

SEEDS, LOST = 40, 5
ANGLES = 2 * np.pi * np.arange(experiment.PLACES) / experiment.PLACES


def profile(stage, common):
    """Residuals around the circle: waves of a stage's own, or the same at all."""
    return 0.2 * np.sin((3 if common else 3 + stage) * ANGLES)


TRUE = {"radius_mm": 87.0, "residual_mm": 0.2, "angle_deg": 0.2}
FACE = {"raw_px": 20.0, "corrected_px": 2.0}


def of_bench(bench, seeds, other, lost=0):
    """Columns of a bench: true of all claims but for {(stage, name): value}; lost:
    seeds that were rejected at the last stage."""
    rng = np.random.default_rng(5)
    out = {f"{bench}.refused": ["stage 3"] * lost + [None] * (seeds - lost)}

    def near(value):
        return value * (1 + 1e-5 * rng.standard_normal(seeds))

    for stage in report.STAGES:
        gone = lost if stage == report.LAST else 0
        columns = {n: near(other.get((stage, n), v)) for n, v in TRUE.items()}
        columns["profile"] = [profile(stage, "common" in other)] * seeds
        for name, column in columns.items():
            out[f"{bench}.published.stage{stage}.{name}"] = [None] * gone + list(
                column[gone:]
            )
        conic = other.get((stage, "conic_px"), 2.0 + stage)
        for name in ("conic_px", "conic_no_lens_px"):
            out[f"{bench}.picture.stage{stage}.{name}"] = near(conic)
    for camera in ("calibrated", "true"):
        for name, value in FACE.items():
            out[f"{bench}.face.{camera}.{name}"] = near(other.get(name, value))
    return out


def made(other=None, swept=None, lost=0, swept_lost=0):
    """The results of both experiments; other, swept: changed values of all levels, and
    of those of the sweep."""
    other = other or {}
    return of_levels(
        (report.RUNS, BENCHES, lambda level: of_bench(level, SEEDS, other, lost)),
        (
            report.SWEPT_RUNS,
            SWEPT,
            lambda level: of_bench(level, 4, swept or other, swept_lost),
        ),
    )


FALSE = {
    claims.judge_radius: [{(2, "radius_mm"): 88.6}, {(0, "radius_mm"): 85.8}],
    claims.judge_conic: [{(2, "conic_px"): 2.9}],
    claims.judge_system: [{"common": True}],
    claims.judge_face: [{"corrected_px": 4.2}],
    claims.judge_growth: [{(3, "residual_mm"): 0.23}],
}


@pytest.fixture(autouse=True)
def flat_mirror(monkeypatch):
    monkeypatch.setattr(claims, "conic_of_flat_mirror", lambda: 1e-10)


@pytest.mark.parametrize("judge", FALSE, ids=lambda judge: judge.__name__)
def test_distortion_claim_holds_fails_and_is_undecided(judge):
    turned = (made({}, other) for other in FALSE[judge])
    assert_verdicts(judge, made(), map(made, FALSE[judge]), turned)


def test_rejected_runs_are_excluded_and_reported():
    results = made(lost=LOST)
    for judge, missed in (
        (claims.judge_radius, "undecided"),
        (claims.judge_system, "undecided"),
        (claims.judge_growth, "reproduced"),
    ):
        assert of_rejected(judge, results) == {("reproduced", "5 of 40", missed)}
    assert np.isnan(report.alike(report.CircleRuns(results))).sum() == LOST


def test_sweep_end_without_runs_leaves_the_claim_undecided():
    for judge in (claims.judge_growth, claims.judge_radius):
        found = verdicts(judge, made(swept_lost=4))
        assert found == ("undecided", {"reproduced"})


def test_table_5_6_is_complete_without_runs():
    results = made(lost=SEEDS)
    table = report.table_5_6(results).columns
    last = [s == report.LAST for s in table["Stage"]].index(True)
    assert (table["Runs"][last], table["Radius (mm)"][last]) == (0, None)
    numbers = report.numbers_of_table_5_6(results)
    assert numbers["t5_6_s3_radius"].value == "nothing"
    assert "40 of 40 runs" in numbers["t5_6_s3_radius"].reason
    assert numbers["t5_6_s0_radius"].value == pytest.approx(87.0, abs=0.01)
    blind = report.ext_circle_blind(made(lost=LOST)).data
    assert set(blind["mirror"]) == {"true mirror", "stage by stage"}


def test_conic_claim_fails_if_a_flat_mirror_bends_conics(monkeypatch):
    monkeypatch.setattr(claims, "conic_of_flat_mirror", lambda: 1e-3)
    assert verdicts(claims.judge_conic, made()) == ("differs", {"differs"})


def test_ring_is_outlined_by_its_inner_and_outer_edge():
    rig = mirror_rig("A")
    camera, T = rig.camera(10.0, 21.0, 3), experiment.held(rig, 10.0, 3)
    ring = experiment.ring_on(rig.board)
    outlines = experiment.ring_outlines(rig, camera, T, 24)
    edges = []
    for radius, (pixels, normals, scale) in zip(ring.edges, outlines, strict=True):
        apart, farther = (
            np.linalg.norm(points_on_plane(camera, p, T).points - ring.centre, axis=1)
            for p in (pixels, pixels + 0.5 * normals)
        )
        seen = np.isfinite(apart) & np.isfinite(farther)
        assert seen.sum() > 18
        np.testing.assert_allclose(apart[seen], radius, atol=1e-6)
        outwards = (farther - apart)[seen] * scale[seen]
        np.testing.assert_allclose(outwards, 0.5, rtol=0.02)
        edges.append(pixels)
    # The middle between both edges, of the image and of the board, is the circle.
    both = experiment.RingEdges(np.array(edges), None)
    in_image = points_on_plane(camera, np.mean(edges, axis=0), T).points
    for points, most in (
        (experiment.middle_of_line(camera, both, T), 1e-6),
        (in_image, 0.03),
    ):
        off = np.linalg.norm(points - ring.centre, axis=1) - experiment.RADIUS_MM
        assert np.nanmax(np.abs(off)) < most


def exact_sight(rig, camera, deflection):
    """The RingSight of stage `deflection` without any error."""
    T = experiment.held(rig, deflection, 3)
    corners, seen = rig.corners(camera, T)
    corners = np.where(
        (seen & experiment.off_ring(rig.board))[:, None], corners, np.nan
    )
    centre = experiment.ring_on(rig.board).centre
    line = circle_outline(camera, T, centre, experiment.RADIUS_MM, experiment.PLACES)[0]
    return experiment.RingSight(T, corners, line)


def test_exact_rays_give_an_exact_circle_and_wrong_rays_do_not():
    rig = mirror_rig("A")
    true, other = rig.camera(5.0, 21.0, 3), rig.camera(6.0, 21.0, 3)
    sight = exact_sight(rig, true, 5.0)
    found = experiment.scored(rig, true, true, sight)
    assert abs(found["radius_mm"] - experiment.RADIUS_MM) < 1e-6
    assert max(found["residual_mm"], found["pose_mm"]) < 1e-6
    wrong = experiment.scored(rig, other, true, sight)
    assert wrong["angle_deg"] > 0.3
    assert wrong["pose_mm"] > 1
    assert wrong["residual_mm"] > 0.01
    # The pose that is found makes up for most of it.
    own, placed = wrong["radius_mm"], wrong["true_pose_radius_mm"]
    assert abs(own - experiment.RADIUS_MM) < 0.5 * abs(placed - experiment.RADIUS_MM)


def test_circle_with_few_visible_points_is_rejected():
    rig = mirror_rig("A")
    camera = rig.camera(0.0)
    sight = exact_sight(rig, camera, 0.0)
    line = sight.line.copy()
    line[10:] = np.nan
    with pytest.raises(InputError, match="10 of 90 points"):
        experiment.on_board(rig, camera, sight._replace(line=line))


def test_wider_pixels_have_the_same_rays():
    rig = mirror_rig("A")
    camera = rig.camera(5.0)
    coarse = experiment.with_wider_pixels(rig, 4).camera(5.0)
    assert (coarse.width, coarse.height) == (camera.width // 4, camera.height // 4)
    pixels = np.array([[300.0, 200.0], [420.0, 350.0]])
    fine, wide = camera.rays(4 * pixels + 1.5), coarse.rays(pixels)
    assert fine.valid.all()
    np.testing.assert_allclose(wide.origins, fine.origins, atol=1e-9)
    np.testing.assert_allclose(wide.directions, fine.directions, atol=1e-12)


def test_homography_is_not_measured_as_distortion():
    places = np.random.default_rng(2).uniform(0, 100, (20, 2))
    H = np.array([[1.1, 0.1, 3], [-0.1, 0.9, 5], [1e-3, 2e-3, 1]])
    assert experiment.off_homography(places, apply_homography(H, places)) < 1e-6
    bent = places + 1e-3 * (places - 50) ** 2 * [1, 0]
    assert experiment.off_homography(places, bent) > 0.1


def test_exact_circle_stays_a_conic_in_a_flat_mirror(monkeypatch):
    monkeypatch.setattr(report, "STAGES_MM", (15.0,))
    report.exact_radii.cache_clear()
    assert claims.judge_exact({}).verdict == "reproduced"
    report.exact_radii.cache_clear()
    assert report.conic_of_flat_mirror() < claims.EXACT_PX
