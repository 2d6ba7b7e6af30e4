"""A rendered mirror set, true to its rig, and what the commands make of it."""

import re
import shutil
from dataclasses import replace
from html import escape
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from chapters.shared.mirror.rigs import mirror_rig
from chapters.shared.mirror.scores import ray_angles
from raxel.calibration.mirror.images import _platter, _steps, mirror_views
from raxel.cameras import load_camera
from raxel.cli import main
from raxel.cli.mirror import _primary
from raxel.errors import InputError
from raxel.evaluation.comparison import MEDIAN_OVER_RMS
from raxel.features import find_board
from raxel.geometry import transform
from raxel.geometry.planes import on_plane
from raxel.io.files import read_json
from raxel.sets import PatternPlan, load_mirror_set
from raxel.show.cameras import mirrors
from tests import mirror_sets, rendered_mirror_sets
from tests.rendered_mirror_sets import STEP_BOARD

PIXELS = np.stack(np.meshgrid(np.arange(0, 768, 12.0), np.arange(0, 576, 12.0)), -1)
PIXELS = PIXELS.reshape(-1, 2)
PATTERNS = PatternPlan(gray_bits=(2, 2), phase_steps=4, phase_periods=(4.0, 4.0))


@pytest.fixture(scope="module")
def rig():
    """Twelve images of the monitor for each view."""
    rig = mirror_rig("A", small=True)
    return replace(rig, monitor=replace(rig.monitor, patterns=PATTERNS))


@pytest.fixture(scope="module")
def folder(rig, tmp_path_factory):
    folder = tmp_path_factory.mktemp("mirror") / "set"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rendered_mirror_sets, "VIEWER_VIEWS", 5)
        rendered_mirror_sets.write_mirror_set(rig, folder, 3, (0.0, 5.0), holder_mm=3.0)
    return folder


def test_mirror_set_describes_its_steps(folder):
    written = load_mirror_set(folder)
    assert written.size == (768, 576)
    (step,) = written.steps
    assert step.deflection_mm == 5.0
    assert written.clamp.hidden_mm == 3.0
    assert [view.label for view in written.grids.views] == ["near", "far"]
    assert len(written.plate.views) == 2


def test_clamp_points_lie_on_the_first_visible_line(rig, folder):
    camera = load_camera(folder / "truth" / "stage-0.npz")
    line = rig.clamp_pixels(camera, 5)
    gap = np.linalg.norm(np.array(load_mirror_set(folder).clamp.points) - line, axis=1)
    assert 0 < gap.max() < 2


def test_boards_are_detected_at_their_true_positions(folder):
    written = load_mirror_set(folder)
    poses = read_json(folder / "truth" / "poses.json")["T_camera_target"]
    (step,) = written.steps
    for name, stage in ((step.before, 0), (step.after, 1)):
        camera = load_camera(folder / "truth" / f"stage-{stage}.npz")
        points = transform(np.array(poses[name]), on_plane(STEP_BOARD.points()))
        true = camera.project(points).pixels
        image = cv2.imread(str(written.stages.folder / name), cv2.IMREAD_GRAYSCALE)
        found = find_board(image, STEP_BOARD.columns, STEP_BOARD.rows)
        assert found.found
        gap = np.linalg.norm(found.corners[:, None] - true, axis=2).min(axis=1)
        assert np.median(gap) < 0.05


@pytest.fixture(scope="module")
def calibrated(folder):
    """(folder of the results, lines that were printed)"""
    results = folder.parent / "results"
    results.mkdir()
    out, fit = results / "mirror.npz", results / "fit.json"
    report = folder.parent / "report"
    files = ["--out", out, "--json", fit, "--report", report]
    assert main(["calibrate", str(folder), *map(str, files)]) == 0
    return results


def stage_angles(folder, calibrated, stage):
    """Angles, degrees, between found and true rays of a stage, nan without a ray."""
    found = load_camera(calibrated / f"mirror-{stage}.npz")
    true = load_camera(folder / "truth" / f"stage-{stage}.npz")
    return ray_angles(found, true, PIXELS)


def test_mirror_cameras_are_accurate(rig, folder, calibrated):
    names = sorted(path.name for path in calibrated.iterdir())
    assert names == ["fit.json", "mirror-0.npz", "mirror-1.npz", "mirror.npz"]
    for stage in range(2):
        found = load_camera(calibrated / f"mirror-{stage}.npz")
        true = load_camera(folder / "truth" / f"stage-{stage}.npz")
        angles = stage_angles(folder, calibrated, stage)
        assert np.isfinite(angles).sum() > 800
        assert np.nanmean(angles) < 0.1
    last = load_camera(calibrated / "mirror.npz")
    np.testing.assert_array_equal(last.coefficients, found.coefficients)
    clamped, away = true.T_viewer_mirror[:3, 3], rig.deflection_direction()
    ours, theirs = (
        (camera.rays(PIXELS).origins - clamped) @ away for camera in (found, true)
    )
    bent = np.isfinite(ours) & (theirs > 2.5)
    assert bent.sum() > 50
    assert np.mean(ours[bent]) == pytest.approx(np.mean(theirs[bent]), rel=0.04)


def test_mirror_result_has_uncertainties(calibrated):
    fit = read_json(calibrated / "fit.json")
    (motion,) = fit["primary"]["grids"]
    assert motion["distance_mm"] == pytest.approx(100, abs=4 * motion["distance_sd_mm"])
    assert motion["distance_sd_mm"] < 0.5
    first, second = fit["stages"]
    assert "deflection_mm" not in first
    assert second["deflection_mm"] == 5.0
    assert sum(second["support"]["along_u"]) == second["corners"] == 140
    assert 0 < second["residual_mm"]["mean"] < 0.2
    sure = second["predicted_ray_error_deg"]
    assert 0.003 < sure["median"] < sure["largest"] < 0.5
    assert np.array(second["T_camera_grid"]).shape == (4, 4)
    assert fit["viewer_error_counted"] is True


def test_median_ray_error_is_as_predicted(folder, calibrated):
    stages = read_json(calibrated / "fit.json")["stages"]
    for stage, about in enumerate(stages):
        angles = stage_angles(folder, calibrated, stage)
        predicted = about["predicted_ray_error_deg"]["median"]
        assert 0.4 < np.nanmedian(angles) / predicted < 2.5


def test_rays_of_each_stage_have_the_predicted_errors(calibrated):
    stages = read_json(calibrated / "fit.json")["stages"]
    for stage, about in enumerate(stages):
        camera = load_camera(calibrated / f"mirror-{stage}.npz")
        u, v = np.meshgrid(
            *(np.linspace(0, n - 1, 40) for n in (camera.width, camera.height))
        )
        rays = camera.rays(np.column_stack([u.ravel(), v.ravel()]), covariance=True)
        squares = np.trace(rays.covariance, axis1=1, axis2=2)
        median_deg = np.degrees(np.sqrt(np.nanmedian(squares))) * MEDIAN_OVER_RMS
        expected = about["predicted_ray_error_deg"]["median"]
        assert median_deg == pytest.approx(expected, rel=0.15)


def written_primary():
    """JSON of a first shape whose rays meet within 1, 2 and 6 mm."""
    motion = SimpleNamespace(
        distance=100.0, distance_sd=0.2, angle=np.pi / 6, angle_sd=np.pi / 360
    )
    found = SimpleNamespace(
        primary=SimpleNamespace(
            motions=[motion],
            mirror=SimpleNamespace(misses=np.array([1.0, 2, 6, np.nan])),
            residuals=np.ones(3),
        ),
        poses=SimpleNamespace(rms_px=0.1),
    )
    views = SimpleNamespace(grids=[SimpleNamespace(name=name) for name in "ab"])
    return _primary(views, found)


def test_points_from_rays_is_the_mean_over_points():
    assert written_primary()["points_from_rays_mm"] == pytest.approx(3)


def test_monitor_rotations_are_in_degrees():
    (written,) = written_primary()["grids"]
    assert written == {
        "first": "a",
        "second": "b",
        "distance_mm": 100.0,
        "distance_sd_mm": 0.2,
        "angle_deg": pytest.approx(30),
        "angle_sd_deg": pytest.approx(0.5),
    }


def test_mirror_report_shows_shapes_residuals_and_warnings(folder, calibrated):
    report, fit = folder.parent / "report", read_json(calibrated / "fit.json")
    page = (report / "index.html").read_text("utf-8")
    names = {path.name for path in report.iterdir()} - {"index.html"}
    shapes = {"profiles.png", "shape-000.jpg", "shape-001.jpg"}
    assert names == shapes | {"residuals-001.jpg", "residuals-002.jpg"}
    for name in names:
        assert f'src="{name}"' in page
        assert cv2.imread(str(report / name)) is not None
    for text in fit["warnings"]:
        assert escape(text) in page
    stage = fit["stages"][1]
    counts = ", ".join(map(str, stage["support"]["along_u"]))
    assert f"Corners per knot interval: {counts} along" in page
    assert f"{stage['residual_mm']['mean']:.3f}" in page
    # Corners end some 128 mm from the clamp, where a beam moves by 3.9 of the 5 mm.
    row = page.split("<td>1</td>")[1].split("</tr>")[0]
    moved = float(re.findall(r'number">([-\d.]+)<', row)[1])
    assert 3.7 < abs(moved) < 4.2


def test_evaluate_scores_the_stage_of_the_camera(folder, calibrated, capsys):
    camera, scores = str(calibrated / "mirror-1.npz"), str(calibrated / "scores.json")
    assert main(["evaluate", camera, str(folder), "--json", scores]) == 0
    assert "stage 1 (by the name of mirror-1.npz)" in capsys.readouterr().out
    found = read_json(scores)
    (image,) = found["images"]
    assert image["file"] == "s1-else.png"
    assert found["stage"] == 1
    assert 0.01 < found["back_projection_mm"]["rms"] < 1.0
    assert image["back_projection_mm"]["corners"] >= 100
    assert found["rms_px"] < 1.0
    for arguments, fault in (
        ([str(calibrated / "mirror-0.npz")], "no image to score stage 0"),
        ([camera, "--stage", "2"], "no stage 2 (by --stage)"),
        ([camera, "--corners", "c.json"], "--corners: not for a mirror set"),
    ):
        assert main(["evaluate", arguments[0], str(folder), *arguments[1:]]) == 2
        assert fault in capsys.readouterr().err.splitlines()[-1]


def test_mirror_surface_is_drawn_at_its_position(calibrated):
    camera = load_camera(calibrated / "mirror-1.npz")
    (surface,) = mirrors(camera)
    points = np.asarray(surface.points).reshape(-1, 3)
    p = points[:, :2] / points[:, 2:]
    assert np.isfinite(points).all()
    np.testing.assert_allclose(camera.mirror.points(p), points, atol=1e-6)


def test_calibrate_rejects_wrong_options_of_mirror_sets(folder, tmp_path, capsys):
    out = str(tmp_path / "mirror.npz")
    own = str(folder / "mirror.yaml")
    for arguments, fault in (
        (["--out", out, "--model", "zhang"], "--model: found zhang, but"),
        (["--out", out, "--report", str(folder / "r")], "sets are only read"),
        (["--out", out, "--report", str(tmp_path)], "whose place the report takes"),
        (["--out", out, "--report", str(folder.parent / "results")], "other files"),
        (["--out", own], "is a file; give a folder, or"),
        (
            ["--out", out, "--json", str(tmp_path / "mirror-1.npz")],
            "--json names the file of",
        ),
    ):
        assert main(["calibrate", str(folder), *arguments]) == 2
        assert fault in capsys.readouterr().err.splitlines()[-1]
    assert main(["show", str(folder), "--out", str(tmp_path / "m.html")]) == 2
    assert "run raxel calibrate" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", ["corners", "points", "detector"])
def test_calibrate_rejects_board_options_of_mirror_sets(tmp_path, capsys, option):
    mirror_sets.write_mirror_set(tmp_path / "set")
    out, value = str(tmp_path / "mirror.npz"), {"detector": "celect"}.get(option, "a")
    order = ["calibrate", str(tmp_path / "set"), f"--{option}", value, "--out", out]
    assert main(order) == 2
    assert (
        f"--{option}: not for a mirror set" in capsys.readouterr().err.splitlines()[-1]
    )


def test_mirror_images_without_boards_are_rejected_by_name(tmp_path):
    mirror_sets.write_mirror_set(tmp_path)
    grey = load_mirror_set(tmp_path)
    for read, fault in (
        (mirror_views, r"viewer.* 0 of 4 "),
        (lambda grey: _steps(grey, None), r"stages.*view0\.png"),
    ):
        with pytest.raises(InputError, match=fault):
            read(grey)


def test_flat_mirror_without_grid_is_rejected_by_name(folder, tmp_path):
    changed = shutil.copytree(folder, tmp_path / "changed")
    dark = np.full((576, 768), 90, np.uint8)
    for path in (changed / "platter" / "far").glob("*.png"):
        cv2.imwrite(str(path), dark)
    with pytest.raises(InputError, match=r"platter.*far"):
        _platter(load_mirror_set(changed), mirror_rig("A", small=True).viewer, None)
    cv2.imwrite(str(changed / "plate" / "near.png"), dark)
    with pytest.raises(InputError, match=r"plate.*near\.png"):
        _platter(load_mirror_set(changed), mirror_rig("A", small=True).viewer, None)
