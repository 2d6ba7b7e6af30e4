"""AprilTag grids and grids of circles: order, accuracy, parts, wrong targets, sets."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from raxel.calibration import board_views
from raxel.cli import main
from raxel.errors import InputError
from raxel.features import april_grid
from raxel.features.april_grid import find_april_grid
from raxel.features.boards import detect_boards
from raxel.features.circle_grid import find_circle_grid
from raxel.sets import AprilGrid, CircleGrid, ImageSet, View, load_set, write_set
from tests.printed_targets import FOCAL, HEIGHT, POSES, WIDTH, target_image

TAGS = AprilGrid(10, 8, 26.0, 20.0, first_id=7)
STAGGERED, SQUARE = CircleGrid(4, 11, 20.0, staggered=True), CircleGrid(9, 7, 20.0)
N_VIEWS = 4
OFFSETS = (
    (0, 0),
    (30, 15),
    (-30, 15),
    (30, -15),
    (-30, -15),
    (0, 20),
    (9, -9),
    (-9, 0),
)


def drawn_set(folder, target, count):
    """An ImageSet of rendered views of a target."""
    for k in range(count):
        image, _ = target_image(target, POSES[k], 0.7, offset=OFFSETS[k], seed=k)
        cv2.imwrite(str(folder / f"{k}.png"), image)
    return written_set(folder, target, count)


def written_set(folder, target, count):
    """The ImageSet of `count` images of a folder."""
    views = tuple(View(image=f"{k}.png") for k in range(count))
    write_set(ImageSet("drawn", WIDTH, HEIGHT, target, views, folder))
    return load_set(folder)


@pytest.mark.parametrize(("pose", "border"), [(POSES[2], 1), (POSES[3], 2)])
def test_april_grid_corners_have_order_and_sd(pose, border):
    image, truth = target_image(TAGS, pose, border=border)
    found = find_april_grid(image, TAGS)
    assert found.missing <= 12
    errors = found.corners - truth
    assert np.sqrt(np.nanmean(errors**2)) < 0.05
    assert 0.7 < np.sqrt(np.nanmean((errors / found.sd[:, None]) ** 2)) < 2


def test_april_grid_is_read_whatever_the_orientation_of_codes(monkeypatch):
    """Generators of tags differ by the corner with which a code begins."""
    image, truth = target_image(TAGS, POSES[0])
    detect = april_grid._detect_tags

    def turned(*options):
        numbers, tags, border = detect(*options)
        return numbers, np.roll(tags, 2, axis=1), border

    monkeypatch.setattr(april_grid, "_detect_tags", turned)
    errors = find_april_grid(image, TAGS).corners - truth
    assert np.nanmax(np.abs(errors)) < 0.2


def test_april_grid_may_be_cut_and_occluded():
    image, truth = target_image(TAGS, POSES[0], fill=1.0, offset=(150, 60))
    image[150:230, 250:330] = 120
    found = find_april_grid(image, TAGS)
    known = np.isfinite(found.corners[:, 0])
    assert 16 <= known.sum() <= 60
    assert np.abs(found.corners - truth)[known].max() < 0.2


@pytest.mark.parametrize(
    ("change", "advice"),
    [
        ({"columns": 12}, "set target.columns: 5, and rows"),
        ({"first_id": 30}, "set target.rows and first_id"),
        ({"family": "25h9"}, "set target.family: 36h11"),
    ],
)
def test_other_april_grid_is_named(change, advice):
    image, _ = target_image(TAGS, POSES[1])
    found = find_april_grid(image, replace(TAGS, **change))
    assert advice in found.reason
    assert found.other_target


@pytest.mark.parametrize("pose", POSES[2:4])
@pytest.mark.parametrize("inverse", [False, True])
@pytest.mark.parametrize("target", [STAGGERED, SQUARE])
def test_circle_centres_have_order_and_sd(target, pose, inverse):
    """A square grid looks the same rotated by 180 degrees."""
    image, truth = target_image(target, pose)
    found = find_circle_grid(255 - image if inverse else image, target)
    orders = [truth] if target.staggered else [truth, truth[::-1]]
    errors = min((found.corners - one for one in orders), key=np.linalg.norm)
    assert np.sqrt(np.mean(errors**2)) < 0.02
    assert 0.7 < np.sqrt(np.mean((errors / found.sd[:, None]) ** 2)) < 2


@pytest.mark.parametrize(
    ("target", "change", "advice"),
    [
        (STAGGERED, {"rows": 10}, "44 circles detected, but no grid of 4 x 10"),
        (SQUARE, {"columns": 8}, "63 circles detected, but no grid of 8 x 7"),
        (STAGGERED, {"staggered": False}, "set target.staggered: true"),
        (
            STAGGERED,
            {"columns": 11, "rows": 4},
            "set target.columns: 4, target.rows: 11",
        ),
    ],
)
def test_other_circle_grid_is_named(target, change, advice):
    image, _ = target_image(target, POSES[1])
    assert advice in find_circle_grid(image, replace(target, **change)).reason


@pytest.mark.parametrize("target", [TAGS, STAGGERED])
def test_camera_is_recovered_from_printed_target(tmp_path, target):
    image_set = drawn_set(tmp_path, target, N_VIEWS)
    assert image_set.target == target
    views = board_views(image_set, detect_boards(image_set))
    assert len(views) == N_VIEWS
    known = [np.isfinite(view.pixels[:, 0]) for view in views]
    solid = np.column_stack([target.points(), np.zeros(len(target.points()))])
    flags = cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST
    rms, K, *_, sd, _, _ = cv2.calibrateCameraExtended(
        [solid[k].astype(np.float32) for k in known],
        [v.pixels[k].astype(np.float32) for v, k in zip(views, known, strict=True)],
        *((WIDTH, HEIGHT), None, None),
        flags=flags,
    )
    assert rms < 0.05
    assert abs(K[0, 0] - FOCAL) < 3 * sd[0, 0]
    assert abs(K[1, 1] - FOCAL) < 3 * sd[1, 0]


def test_corners_name_another_target(tmp_path, capsys):
    drawn_set(tmp_path, TAGS, 1)
    text = (tmp_path / "set.yaml").read_text("utf-8")
    changed = text[: text.index("target:")] + "target: {kind: circles, columns: 4, "
    changed += "rows: 11}\n" + text[text.index("views:") :]
    (tmp_path / "set.yaml").write_text(changed, "utf-8")
    assert main(["corners", str(tmp_path)]) == 2
    printed = capsys.readouterr()
    assert "set target.kind: aprilgrid" in printed.out
    assert "correct the target as stated for the images" in printed.err


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"tag_mm": 26.0}, "target.tag_mm: 26 mm is not below pitch_mm"),
        ({"first_id": 577}, "target.first_id: the last tag is 596, but 36h11 has 587"),
    ],
)
def test_april_grid_faults_are_named(tmp_path, change, fault):
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((HEIGHT, WIDTH), np.uint8))
    with pytest.raises(InputError, match=fault):
        written_set(tmp_path, replace(TAGS, **change), 1)
