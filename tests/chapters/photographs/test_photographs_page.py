"""The page of an image set: correct for a drawn camera, complete for any set."""

import json
import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from chapters.photographs.set import experiment, report
from chapters.photographs.set.exercises import (
    exercise_camera,
    exercise_corner,
    field_of_view_deg,
    field_of_view_task,
    residual_of,
    residual_task,
)
from chapters.shared.images import notes
from chapters.shared.images.reading import (
    PEER,
    Image,
    Row,
    Score,
    Study,
    paired,
    pooled_rms,
    share_with_ray,
)
from raxel.cameras import PerspectiveCamera
from raxel.errors import CalibrationError
from raxel.sets import load_set
from repro.page.exercise import check
from repro.page.style import check_axes, save_drawing
from repro.run import jobs
from repro.run.results import Result
from tests.image_sets import (
    BEND,
    FOCAL,
    HEIGHT,
    TILTS_DEG,
    WIDTH,
    description,
    write_description,
    write_drawn_set,
)

ROOT = Path(__file__).resolve().parents[3]
NAME = "photograph_study@drawn"
FIGURES = (
    report.ext_corners,
    report.ext_residuals,
    report.ext_cross_validation,
    report.ext_undistorted,
)
TABLES = (report.ext_every_corner, report.ext_models)
CALIBRATIONS = sorted(
    name for name in vars(experiment) if name.startswith("calibrate_")
)
SENTENCES = (
    notes.title,
    report.about,
    notes.origin,
    report.found,
    report.zhang,
    report.general,
    report.held_out,
    report.coverage,
    report.comparison,
    report.exercise,
    report.peer,
)


def run(folder, out, shards=1):
    """The study of the set in `folder` at quick size, as the workflow runs it."""
    experiment.board_in.cache_clear()
    order = jobs.Order(NAME, "quick", None, str(folder), folder)
    parts = [out / f"{shard}-of-{shards}.json" for shard in range(shards)]
    for shard, part in enumerate(parts):
        out.mkdir(parents=True, exist_ok=True)
        jobs.run(ROOT, order, shard, shards, part)
    path = out / "results" / f"{NAME}.json"
    jobs.gather(ROOT, order, "key", {}, parts, path)
    return Result(path)


def produce(result):
    """Draw and fill everything the page shows; return captions and sentences."""
    results = {"photograph_study": result}
    made = [figure(results) for figure in FIGURES]
    for drawing in made:
        check_axes(drawing.figure, drawing.caption)
    filled = [table(results) for table in TABLES]
    assert all(len({len(c) for c in t.columns.values()}) == 1 for t in filled)
    texts = [sentence(Study(result)) for sentence in SENTENCES]
    for text in texts:
        assert "nan" not in text.lower().split()
        assert text[-1] in ".*" or text == texts[0]
    return [m.caption for m in made + filled], texts


@pytest.fixture(scope="module", autouse=True)
def small_and_on_one_thread():
    """Small images; and OpenCV on one thread, as in the workflow.

    With several it adds in the order in which they finish, and the last digits differ.
    """
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(experiment.SIZES, "quick", experiment.Size(8, 3, 3, 80, 80))
        yield
    cv2.setNumThreads(before)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """A set of six boards, one of them only for evaluation, and its study."""
    base = tmp_path_factory.mktemp("drawn")
    views = [{"image": f"view{i}.png"} for i in range(6)]
    views[5]["use"] = "evaluate"
    write_drawn_set(base / "drawn", views=views, camera="drawn, with a bend")
    return base / "drawn", run(base / "drawn", base / "out", shards=3)


def test_study_recovers_the_drawn_camera(drawn):
    _, result = drawn
    seen = Study(result)
    # Five boards of 35 corners found to about 0.05 px: 1 % and 2 px are loose bounds.
    focal, centre = (
        [seen.fit(f"zhang.{name}_px") for name in names]
        for names in (("fx", "fy"), ("u0", "v0"))
    )
    assert focal == pytest.approx([FOCAL] * 2, rel=0.01)
    assert centre == pytest.approx([(WIDTH - 1) / 2, (HEIGHT - 1) / 2], abs=2)
    # The bend straightens by 1 + k r^2 of the bent radius: k1 begins with -k.
    half_diagonal = np.hypot(WIDTH, HEIGHT) / 2
    k1 = -BEND * (FOCAL / half_diagonal) ** 2
    assert seen.fit("zhang.k1") == pytest.approx(k1, rel=0.15)
    assert pooled_rms(seen.in_sample, "own", "zhang") < 0.1
    assert seen.fit("undistorted.zhang.distortion_px") < 0.1
    assert seen.fit("undistorted.taken.distortion_px") > 0.3
    assert seen.fit("undistorted.general.distortion_px") < 0.1
    # A ray comes from a few boards only, so it is noisier than a model of six numbers.
    assert pooled_rms(seen.held_out, "own", "general") < 0.3


def test_corners_count_alike_in_every_image():
    def row(corners, rms_px):
        score = Score(corners, rms_px, 0.0, "", np.zeros((corners, 2)))
        image = Image(0, "", "calibrate", True, "", np.zeros((48, 2)), 8, None)
        return Row(image, 48, {"zhang": score}, {})

    rows = [row(10, 1.0), row(30, 3.0), Row(None, 24, {}, {})]
    assert pooled_rms(rows, "own", "zhang") == pytest.approx(np.sqrt(280 / 40))
    assert share_with_ray(rows, "zhang") == pytest.approx(40 / (48 + 48 + 24))
    assert np.isnan(pooled_rms(rows, "own", "general"))


def test_held_out_images_are_not_calibrated_from(drawn, monkeypatch):
    folder, _ = drawn
    calibrated_from = []

    def noted(views, *_, **__):
        calibrated_from.append({view.name for view in views})
        raise CalibrationError("only noted")

    for name in CALIBRATIONS:
        monkeypatch.setattr(experiment, name, noted)
    scored = []
    monkeypatch.setattr(
        experiment, "scores", lambda cameras, view: scored.append(view.name) or {}
    )
    image_set = load_set(folder)
    boards = experiment.boards_of(str(folder), experiment.SIZES["quick"])
    kept = []
    for fold in range(3):
        calibrated_from.clear()
        scored.clear()
        experiment.fold_part(image_set, boards, fold, 3, np.random.default_rng(0))
        assert scored
        assert len(calibrated_from) == len(CALIBRATIONS) + 1  # two are of lenses
        assert all(names.isdisjoint(scored) for names in calibrated_from)
        assert all("view5.png" not in names for names in calibrated_from)
        assert calibrated_from[0] | {*scored} == {f"view{i}.png" for i in range(5)}
        kept += scored
    assert sorted(kept) == [f"view{i}.png" for i in range(5)]


def test_every_image_is_scored_once(drawn):
    seen = Study(drawn[1])
    names = [f"view{i}.png" for i in range(6)]
    assert [row.image.name for row in seen.held_out] == names
    assert [row.image.name for row in seen.in_sample] == names[:5]
    for row in seen.held_out:
        zhang = row.own["zhang"]
        assert zhang.corners == 35
        lengths = np.linalg.norm(zhang.residuals_px, axis=1)
        assert zhang.rms_px == pytest.approx(np.sqrt(np.mean(lengths**2)))


def test_both_models_are_scored_on_the_same_corners(drawn):
    seen = Study(drawn[1])
    zhangs, generals = paired(seen.held_out, "rms_px")
    assert len(zhangs) == len(generals) > 0
    for row in seen.held_out:
        if row.same:
            known = {m: np.isfinite(s.residuals_px[:, 0]) for m, s in row.same.items()}
            assert np.array_equal(known["zhang"], known["general"])
            assert np.all(known["zhang"] >= known[PEER])
            assert row.same["general"].corners <= row.own["general"].corners


def test_numbers_are_independent_of_the_shards(drawn, tmp_path):
    folder, result = drawn
    order = jobs.Order(NAME, "quick", None, str(folder), folder)
    whole = json.loads(result.path.read_text("utf-8"))["trials"]
    seen = set()
    # Image 0, and fold 0, each alone in a process.
    for shard in (0, 5):
        experiment.board_in.cache_clear()
        jobs.run(ROOT, order, shard, 7, tmp_path / "part.json")
        part = json.loads((tmp_path / "part.json").read_text("utf-8"))
        (record,) = part["records"]
        seen.add(result.conditions[record["condition"]]["part"])
        before = [r for r in whole if r["condition"] == record["condition"]]
        assert [r["values"] for r in before] == [record["values"]]
        with (
            np.load(tmp_path / "part.npz") as redone,
            np.load(result.path.with_suffix(".npz")) as stored,
        ):
            assert redone.files
            for name in redone.files:
                assert np.array_equal(redone[name], stored[name], equal_nan=True)
    assert seen == {"image", "fold"}


def test_figure_is_saved_completely(drawn, tmp_path):
    drawing = report.ext_residuals({"photograph_study": drawn[1]})
    save_drawing(drawing, tmp_path / "residuals")
    written = (tmp_path / "residuals.csv").read_text("utf-8")
    assert written.count("\n") == 1 + 6 * 35 * 3
    assert (tmp_path / "residuals.svg").stat().st_size > 10_000


def test_page_describes_a_successful_set(drawn):
    captions, texts = produce(drawn[1])
    assert "6 of 6 images" in captions[0]
    assert texts[0] == "drawn: drawn"
    assert "pitch of 20 mm" in texts[1]


def test_failed_generic_method_leaves_the_rest(drawn, tmp_path, monkeypatch):
    def fails(*_, **__):
        raise CalibrationError("no board overlaps two others", code="no-overlap")

    # All methods but the two that the page compares fail.
    for name in {*CALIBRATIONS} - {"calibrate_zhang", "calibrate_opencv_fisheye"}:
        monkeypatch.setattr(experiment, name, fails)
    result = run(drawn[0], tmp_path)
    captions, texts = produce(result)
    assert "no-overlap" in captions[-1]
    assert "gives no general camera (no-overlap)" in texts[5]
    assert "cannot be compared" in texts[8]
    assert len([row for row in Study(result).held_out if row.own]) == 6


def test_markup_in_names_is_escaped(drawn, tmp_path):
    """In sentences and captions as Markdown; in figures no formula is read in them."""
    shutil.copytree(drawn[1].path.parent, tmp_path / "results")
    path = tmp_path / "results" / drawn[1].path.name
    content = json.loads(path.read_text("utf-8"))
    odd = "<svg onload=x> $\\frac$ `{eval-rst}`x` [a](javascript:x) |"
    content["settings"] |= {"set": odd, "camera": odd, "source": odd, "licence": odd}
    content["settings"]["images"] = [f"{i} {odd}" for i in range(6)]
    for trial in content["trials"][:1]:
        trial["values"] |= {"reason": odd, "zhang.reason": odd}
    fit = next(i for i, c in enumerate(content["conditions"]) if c["part"] == "fit")
    content["trials"][fit]["values"]["general.reason"] = f"{odd} 7"
    path.write_text(json.dumps(content), "utf-8")
    result = Result(path)
    captions, texts = produce(result)
    for text in [*captions, *texts]:
        text = re.sub(r"\*\*.*\*\*", "", text)
        assert not re.search(r"(?<!\\)[<$`\[|{]", text), text
    assert odd.replace("<", "\\<").split()[0] in texts[0]
    for draw in (report.ext_corners, report.ext_cross_validation):
        draw({"photograph_study": result}).figure.draw_without_rendering()


def test_missing_corners_leave_the_rest_of_the_page(tmp_path, monkeypatch):
    detect = experiment.detect_boards

    def without_some(*arguments):
        boards = detect(*arguments)
        for board in boards:
            board.detection.corners[[0, 17, -1]] = np.nan
        return boards

    monkeypatch.setattr(experiment, "detect_boards", without_some)
    write_drawn_set(tmp_path / "drawn", tilts=TILTS_DEG[:3])
    result = run(tmp_path / "drawn", tmp_path / "out")
    experiment.board_in.cache_clear()
    produce(result)
    seen = Study(result)
    assert len(seen.held_out) == 3
    for row in seen.held_out:
        assert row.corners == row.own["zhang"].corners == 35 - 3
    task = residual_task(exercise_camera(seen), exercise_corner(seen))
    assert np.linalg.norm(task["expected"]()) < 0.5


@pytest.mark.parametrize("found", [0, 1])
def test_few_boards_give_reasons(drawn, tmp_path, found):
    folder = tmp_path / "drawn"
    shutil.copytree(drawn[0], folder)
    write_description(folder, description(6))
    for index in range(found, 6):
        blank = np.full((HEIGHT, WIDTH), 128, np.uint8)
        cv2.imwrite(str(folder / f"view{index}.png"), blank)
    result = run(folder, tmp_path / "out")
    seen = Study(result)
    assert len(seen.found) == found
    assert all(i.reason for i in seen.images if not i.found)
    assert seen.failure("general")
    assert seen.failure("zhang")
    captions, texts = produce(result)
    assert f"{found} of 6 images" in captions[0]
    assert texts[6].startswith("No image is held out")


def test_undistortion_is_the_identity_without_distortion(drawn):
    folder, _ = drawn
    image_set = load_set(folder)
    K = [[FOCAL, 0, (WIDTH - 1) / 2], [0, FOCAL, (HEIGHT - 1) / 2], [0, 0, 1]]
    pinhole = PerspectiveCamera(np.array(K), [], WIDTH, HEIGHT)
    boards = experiment.boards_of(str(folder), experiment.SIZES["quick"])
    # The widest corners need no smaller view here, so the image stays as it is.
    result = experiment.undistorted(image_set, {"zhang": pinhole}, boards, WIDTH)
    assert result["zoom"] == 1
    difference = result["zhang"]["picture"].astype(int) - result["original"]
    # Interpolated at twice the size and averaged again: edges soften by a few levels.
    assert np.abs(difference).mean() < 2
    assert np.allclose(result["zhang"]["corners"], result["corners"], atol=1e-6)


def test_undistorted_corners_match_the_undistorted_image(tmp_path):
    folder = tmp_path / "one"
    write_drawn_set(folder, tilts=[(20, 10)])
    image_set = load_set(folder)
    # Its axis is far from mid-image, where the view looks.
    K = [[FOCAL, 0, WIDTH * 0.8], [0, FOCAL, HEIGHT * 0.2], [0, 0, 1]]
    aside = PerspectiveCamera(np.array(K), [], WIDTH, HEIGHT)
    boards = experiment.boards_of(str(folder), experiment.SIZES["quick"])
    seen = experiment.undistorted(image_set, {"zhang": aside}, boards, WIDTH)["zhang"]
    until = (cv2.TERM_CRITERIA_COUNT, 50, 0)
    start = np.array(seen["corners"][:, None], np.float32)
    found = cv2.cornerSubPix(seen["picture"], start.copy(), (4, 4), (-1, -1), until)
    assert np.median(np.linalg.norm(found - start, axis=2)) < 0.1


def test_exercise_answers_are_judged_correctly(drawn):
    seen = Study(drawn[1])
    camera, corner = exercise_camera(seen), exercise_corner(seen)
    angle = 2 * np.degrees(np.arctan(WIDTH / 2 / FOCAL))
    assert field_of_view_deg(camera) == pytest.approx(angle, rel=0.01)
    assert check(None, **field_of_view_task(camera)).right is None
    assert check(field_of_view_deg(camera), **field_of_view_task(camera)).right
    # A reader's own solution, from 2.2 and 2.4.
    x, y = corner["point"]
    p = corner["T_camera_grid"] @ [x, y, 0, 1]
    p = p[:2] / p[2]
    p = p * (1 + camera["k1"] * (p @ p) + camera["k2"] * (p @ p) ** 2)
    f, c = (np.array([camera[a], camera[b]]) for a, b in (("fx", "fy"), ("u0", "v0")))
    answer = corner["found"] - (f * p + c)
    assert np.linalg.norm(answer) < 0.5
    task = residual_task(camera, corner)
    assert check(answer, **task).right
    assert "minus detected" in check(-answer, **task).text
    straight = residual_of(camera | {"k1": 0.0, "k2": 0.0}, corner)
    assert "radial" in check(straight, **task).text


def test_exercises_have_a_camera_if_calibration_failed(tmp_path):
    folder = tmp_path / "drawn"
    write_drawn_set(folder, tilts=[(0, 0)])
    seen = Study(run(folder, tmp_path / "out"))
    camera, corner = exercise_camera(seen), exercise_corner(seen)
    assert 0 < field_of_view_deg(camera) < 180
    assert np.allclose(residual_of(camera, corner), [0.21, -0.13], atol=0.01)


def test_results_are_plain_json_without_times(drawn):
    content = json.loads(drawn[1].path.read_text("utf-8"))
    names = {name for trial in content["trials"] for name in trial["values"]}
    assert not [n for n in names if "second" in n or "time" in n]
    assert str(drawn[0]) not in drawn[1].path.read_text("utf-8")
