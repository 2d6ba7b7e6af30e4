"""The page of all image sets: levels of known lenses, and prose for any sets."""

import json
from pathlib import Path

import numpy as np
import pytest

from chapters.photographs.by_distortion import figures, tables
from chapters.photographs.by_distortion import results as comparison_prose
from chapters.photographs.by_distortion.exercises import (
    exercise_lens,
    level_task,
    photographs_task,
)
from chapters.shared.photographs.compared import compared_sets, twins
from chapters.shared.photographs.level import distortion_level, level_of
from chapters.shared.photographs.reading import PEER
from chapters.shared.photographs.undistort import corrected_errors
from raxel.calibration import BoardView
from raxel.cameras import FisheyeCamera, GeneralCamera, PerspectiveCamera
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from repro.page.exercise import check
from repro.page.style import check_axes
from repro.run.outcomes import Measured
from repro.run.results import Result

WIDTH, HEIGHT = 160, 120
OFF_MIDDLE = np.array([84.0, 57.0])
TURN = [0.05, -0.08, 0.3]


def table_of(camera):
    """The general camera with the rays of another one, turned about its centre."""
    v, u = np.indices((HEIGHT, WIDTH))
    rays = camera.rays(np.column_stack([u.ravel(), v.ravel()]).astype(float))
    directions = rays.directions @ rotation_from_vector(TURN).T
    return GeneralCamera(
        directions.reshape(HEIGHT, WIDTH, 3), rays.valid.reshape(HEIGHT, WIDTH)
    )


def fisheye(focal_px, max_angle):
    return FisheyeCamera(
        "equidistance", focal_px, OFF_MIDDLE, WIDTH, HEIGHT, max_angle=max_angle
    )


@pytest.mark.parametrize("widest_deg", [30, 60, 80])
def test_level_of_an_equidistant_lens(widest_deg):
    widest = np.radians(widest_deg)
    # The whole circle of rays lies in the image.
    found = distortion_level(table_of(fisheye(50 / widest, widest)))
    # The outermost pixel centre lies up to a pixel inside the circle.
    assert found["widest_deg"] == pytest.approx(widest_deg, rel=0.02)
    reached = np.radians(found["widest_deg"])
    assert found["level"] == pytest.approx(1 - reached / np.tan(reached), rel=1e-3)
    assert found["focal_px"] == pytest.approx(50 / widest, rel=1e-3)
    assert [found["u0_px"], found["v0_px"]] == pytest.approx(OFF_MIDDLE, abs=0.01)
    assert found["fit_px"] < 1e-3


def test_a_pinhole_off_the_middle_has_level_zero():
    K = [[150, 0, OFF_MIDDLE[0]], [0, 150, OFF_MIDDLE[1]], [0, 0, 1]]
    camera = table_of(PerspectiveCamera(np.array(K, float), [], WIDTH, HEIGHT))
    # tan(theta) cut off after four odd powers, up to 38 degrees.
    assert distortion_level(camera)["level"] < 2e-3


def test_rays_at_right_angles_have_level_one():
    found = distortion_level(table_of(fisheye(30.0, np.radians(95))))
    assert found["widest_deg"] > 90
    assert found["level"] == 1
    assert level_of([100.0, 0, 0, 0], np.radians(89.99)) == pytest.approx(1, abs=1e-3)


def test_too_few_rays_have_no_level():
    camera = table_of(fisheye(100.0, np.radians(2)))
    assert np.isnan(distortion_level(camera)["level"])


def test_the_corrected_view_of_the_right_camera_has_nothing_left():
    camera = fisheye(60.0, np.radians(85))
    points = np.stack(np.meshgrid(np.arange(6.0), np.arange(5.0)), -1).reshape(-1, 2)
    T = pose(rotation_from_vector([0.3, 0.2, 0.0]), [-2.0, -2.0, 4.0])
    pixels = camera.project(transform(T, on_plane(points))).pixels
    pinhole = PerspectiveCamera(
        np.array([[60, 0, OFF_MIDDLE[0]], [0, 60, OFF_MIDDLE[1]], [0, 0, 1.0]]),
        [],
        WIDTH,
        HEIGHT,
    )
    view = BoardView(pixels, points, 6, 5)
    left = corrected_errors({"general": camera, "zhang": pinhole}, view)
    assert left["general"] < 1e-6
    assert left["zhang"] > 0.1
    few = view._replace(pixels=np.where(np.arange(30)[:, None] < 9, pixels, np.nan))
    assert np.isnan(corrected_errors({"general": camera}, few)["general"])


def write_study(folder, name, *, level, ratio, photographs, seed, of_peer=0):
    """A result with the shape of the study's: one part keeps all photographs out.

    OpenCV's fisheye model answers in the first `of_peer`, with 0.5 px.
    """
    rng = np.random.default_rng(seed)
    count = max(photographs, 2)
    conditions = [
        {"part": "image", "view": i, "image": f"{i}.png"} for i in range(count)
    ]
    conditions += [{"part": "fit"}, {"part": "fold", "fold": 0}]
    arrays = {f"{i}/0/corners": rng.uniform(0, 100, (20, 2)) for i in range(count)}
    fold = {"kept_out": count}
    for i in range(photographs):
        general = rng.uniform(0.2, 0.25)
        fold |= {f"views.{i}.corners": 20}
        models = [("zhang", ratio * general), ("general", general)]
        models += [(PEER, 0.5)] * (i < of_peer)
        for model, px in models:
            for kind in ("own", "same"):
                stem = f"views.{i}.{model}.{kind}"
                fold |= {f"{stem}.corners": 18, f"{stem}.rms_px": px}
                fold |= {f"{stem}.mean_deg": px / 10, f"{stem}.reason": ""}
                arrays[f"{count + 1}/0/{stem}.residuals_px"] = np.full((20, 2), px)
            fold[f"views.{i}.{model}.same.corrected_px"] = 2 * px
    why = "" if photographs else "generic calibration: no board overlaps two others"
    fit = {"general.reason": why, "zhang.reason": ""}
    if photographs:
        distortion = {"level": level, "widest_deg": 50.0, "fit_px": 0.1}
        fit |= {f"general.distortion.{k}": x for k, x in distortion.items()}
        fit["general.image_with_ray"] = 0.75
    values = [{"found": True, "columns": 5, "reason": ""}] * count + [fit, fold]
    names = [f"{i}.png" for i in range(count)]
    content = {
        "experiment": f"photograph_study@{name}",
        "effort": "quick",
        "settings": {"images": names, "uses": ["calibrate"] * count},
        "conditions": conditions,
        "trials_per_condition": 1,
        "trials": [{"condition": i, "values": v} for i, v in enumerate(values)],
    }
    path = Path(folder) / f"{name}.json"
    path.write_text(json.dumps(content))
    np.savez(path.with_suffix(".npz"), **arrays)
    return Result(path)


@pytest.fixture
def sets(tmp_path):
    def study(name, **about):
        return name, write_study(tmp_path, name, **about)

    return dict(
        [
            study("strong", level=0.8, ratio=9, photographs=12, seed=1, of_peer=9),
            study("none", level=np.nan, ratio=1, photographs=0, seed=2),
            study("weak", level=0.1, ratio=0.7, photographs=12, seed=3),
            study("few", level=0.4, ratio=3, photographs=4, seed=4),
            study("again", level=0.8, ratio=9, photographs=12, seed=1),
        ]
    )


def produced(results):
    given = {"photograph_study": results}
    table = tables.ext_real_by_distortion(given)
    drawing = figures.ext_real_by_distortion_figure(given)
    check_axes(drawing.figure, drawing.caption)
    sets = compared_sets(results)
    texts = [comparison_prose.brought(results, sets)]
    texts += [
        getattr(comparison_prose, name)(sets)
        for name in ("axis", "trend", "winners", "corrected", "peer")
    ]
    for text in texts:
        assert text.endswith(".")
        assert "nan" not in text
    return table, drawing, texts


def test_sets_stand_by_distortion_and_the_same_photographs_count_once(sets):
    table, drawing, texts = produced(sets)
    assert table.columns["Set"] == ["weak", "few", "strong", "none"]
    assert table.columns["Better"] == [
        "Zhang",
        "too few photographs (4)",
        "General camera",
        "not compared: no board overlaps two others",
    ]
    assert table.columns["Level (1)"] == [0.1, 0.4, 0.8, None]
    assert table.columns["OpenCV fisheye (px)"][2] == Measured(0.5, 0.5, 0.5)
    assert table.columns["OpenCV fisheye (px)"][0] is None
    assert table.columns["OpenCV fisheye answers in"] == [0, 0, 9, 0]
    assert table.columns["of"] == [12, 4, 12, 0]
    assert table.columns["Picture with a ray (%)"] == [75, 75, 75, None]
    assert "no camera on weak and few" in texts[5]
    assert "less than Zhang" in texts[5]
    assert "strong (9 of 12 photographs)" in texts[5]
    assert "with Zhang on weak; with the general camera on few and strong" in texts[4]
    assert "again is left out: its photographs are those of strong" in table.caption
    assert twins(sets) == {"again": "strong"}
    assert drawing.data["set"] == ["weak", "few", "strong"]
    ratio = np.divide(
        drawing.data["zhang.rms_px.value"], drawing.data["general.rms_px.value"]
    )
    assert ratio == pytest.approx([0.7, 3, 9])
    assert "5 image sets: strong, none, weak, few and again" in texts[0]
    assert "to 9." in texts[2]
    assert "Zhang's model predicts better in 1 image set" in texts[3]


@pytest.mark.parametrize("names", [(), ("none",), ("weak",), ("weak", "none")])
def test_the_page_reads_well_with_few_sets(sets, names):
    results = {name: sets[name] for name in names}
    table, _, texts = produced(results)
    assert len(table.columns["Set"]) == len(names)
    assert ("weak" in names) == ("One set cannot show a trend" in texts[2])
    lens = exercise_lens(compared_sets(results))
    assert check(None, **level_task(lens)).right is None
    angle = np.radians(lens["widest_deg"])
    assert check(1 - angle / np.tan(angle), **level_task(lens)).right


def test_seven_photographs_can_decide_at_one_per_cent():
    assert check(7, **photographs_task()).right
    assert "two-sided" in check(8, **photographs_task()).text
    assert "0.05" in check(5, **photographs_task()).text
