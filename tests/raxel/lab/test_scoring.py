"""Scores against truth: exact answers score zero, every kind of error as it is."""

import json
import shutil

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from raxel.cameras import (
    FisheyeCamera,
    GeneralCamera,
    PerspectiveCamera,
    QuadricMirrorCamera,
    load_camera,
    pixel_grid,
)
from raxel.cli import main
from raxel.errors import InputError
from raxel.evaluation.benchmark import score_camera, score_corners
from raxel.features.boards import Board
from raxel.features.detector import Detection, rejected
from raxel.geometry import rotation_from_vector
from raxel.sets import load_set
from tests.raised import raises_line
from tests.raxel.lab.test_rig import changed, leaf


@pytest.fixture(scope="module")
def board_set(tmp_path_factory):
    folder = tmp_path_factory.mktemp("board")
    rig = changed(folder / "rig.yaml", poses__count=leaf(3, "1"))
    assert main(["render", str(rig), "--out", str(folder / "set")]) == 0
    return load_set(folder / "set")


def true_boards(image_set):
    path = image_set.folder / "truth" / "corners.json"
    images = json.loads(path.read_text())["images"]
    size = image_set.target.columns, image_set.target.rows
    return [
        Board(view, Detection(True, np.array(images[view.label]["corners"]), *size), 0)
        for view in image_set.views
    ]


def with_corners(board, change):
    lattice = board.detection.corners.reshape(
        board.detection.rows, board.detection.columns, 2
    )
    corners = change(lattice).reshape(-1, 2)
    return board._replace(detection=board.detection._replace(corners=corners))


@pytest.mark.parametrize(
    "order",
    [
        lambda lattice: lattice,
        lambda lattice: lattice[::-1, ::-1],
        lambda lattice: lattice[:, ::-1],
    ],
    ids=["as it is", "rotated by 180 degrees", "mirrored"],
)
def test_true_corners_have_zero_error_in_every_symmetry(board_set, order):
    boards = [with_corners(board, order) for board in true_boards(board_set)]
    scored = score_corners(board_set, boards)
    assert (scored["views"], scored["found"], scored["right"]) == (3, 3, 3)
    assert scored["wrong"] == []
    assert scored["rms_px"] == scored["median_px"] == scored["max_px"] == 0


def test_exchanged_counts_are_same_board(board_set):
    first, *others = true_boards(board_set)
    rotated = with_corners(first, lambda lattice: lattice.transpose(1, 0, 2))
    detection = rotated.detection._replace(columns=3, rows=4)
    scored = score_corners(board_set, [rotated._replace(detection=detection), *others])
    assert (scored["right"], scored["max_px"]) == (3, 0)


def test_shifted_corners_have_error_of_shift(board_set):
    shifted = [
        with_corners(b, lambda c: c + [0.3, 0.4]) for b in true_boards(board_set)
    ]
    scored = score_corners(board_set, shifted)
    assert scored["right"] == 3
    for name in ("rms_px", "median_px", "max_px"):
        assert scored[name] == pytest.approx(0.5, abs=1e-9)


def test_swapped_corners_make_wrong_board(board_set):
    def swap(lattice):
        lattice = lattice.copy()
        lattice[0, [0, 1]] = lattice[0, [1, 0]]
        return lattice

    first, second, third = true_boards(board_set)
    missing = third._replace(detection=rejected(None, None, "none"))
    scored = score_corners(board_set, [with_corners(first, swap), second, missing])
    assert (scored["found"], scored["right"]) == (2, 1)
    assert (scored["wrong"], scored["max_px"]) == ([first.view.label], 0)
    assert [image["right"] for image in scored["images"]] == [False, True, False]
    assert scored["images"][0]["max_px"] > 1
    assert scored["images"][2]["max_px"] is None


def test_error_is_none_without_correct_board(board_set):
    boards = [b._replace(detection=rejected(4, 3, "")) for b in true_boards(board_set)]
    scored = score_corners(board_set, boards)
    assert scored["right"] == 0
    assert scored["rms_px"] is None


def table_of(camera, turn=(0.0, 0.0, 0.0), columns=None):
    """A general camera with the rays of another, turned, in the first columns."""
    rays = camera.rays(pixel_grid(camera.width, camera.height))
    directions = np.where(rays.valid[:, None], rays.directions, [0, 0, 1.0])
    directions = directions @ rotation_from_vector(np.array(turn)).T
    mask = rays.valid.reshape(camera.height, camera.width).copy()
    mask[:, columns or camera.width :] = False
    return GeneralCamera(directions.reshape(*mask.shape, 3), mask)


def test_true_camera_has_zero_error_in_any_frame(board_set):
    true = load_camera(board_set.folder / "truth" / "camera.npz")
    for camera in (true, table_of(true, (0.3, -1.0, 0.4))):
        scored = score_camera(board_set, camera)
        assert scored["share_with_ray"] == 1
        assert scored["max_deg"] < 1e-6
        assert scored["max_px"] < 1e-6


def test_pixels_without_ray_only_reduce_share(board_set):
    true = load_camera(board_set.folder / "truth" / "camera.npz")
    scored = score_camera(board_set, table_of(true, columns=true.width // 2))
    pixels = pixel_grid(true.width, true.height)
    has = true.rays(pixels).valid
    share = np.mean(pixels[has, 0] < true.width // 2)
    assert scored["share_with_ray"] == pytest.approx(share)
    assert scored["pixels"] == has.sum()
    assert scored["max_px"] < 1e-6


def test_focal_length_error_gives_angles(board_set):
    """Equidistance: r = f theta, so each angle is 1 % too small; no turn helps."""
    true = load_camera(board_set.folder / "truth" / "camera.npz")
    middle = true.principal_point
    size = true.width, true.height
    camera = FisheyeCamera("equidistance", 101, middle, *size, true.max_angle)
    scored = score_camera(board_set, camera)
    rays = true.rays(pixel_grid(*size))
    away = np.degrees(np.arccos(np.clip(rays.directions[rays.valid, 2], -1, 1)))
    assert scored["median_deg"] == pytest.approx(np.median(away) / 101, rel=1e-3)
    assert scored["max_deg"] == pytest.approx(away.max() / 101, rel=1e-3)
    radius = np.radians(away) * 100
    assert scored["max_px"] == pytest.approx(radius.max() / 101, rel=1e-3)


def test_mirror_directions_start_at_its_centre(board_set, tmp_path):
    shutil.copytree(board_set.folder, tmp_path / "set")
    size = {"width": board_set.width, "height": board_set.height}
    middle = [(size["width"] - 1) / 2, (size["height"] - 1) / 2]
    K = [[300, 0, middle[0]], [0, 300, middle[1]], [0, 0, 1]]
    viewer = PerspectiveCamera(K, [], **size)
    true = QuadricMirrorCamera.aligned(viewer, "hyperboloid", (30, 20), 25)
    true.save(tmp_path / "set" / "truth" / "camera.npz")
    pixels = pixel_grid(true.width, true.height)
    rays = true.rays(pixels)
    directions = np.where(rays.valid[:, None], rays.directions, [0, 0, 1.0])
    noisy = directions + np.random.default_rng(1).normal(0, 0.01, directions.shape)
    shape = true.height, true.width
    camera = GeneralCamera(noisy.reshape(*shape, 3), rays.valid.reshape(shape))
    scored = score_camera(load_set(tmp_path / "set"), camera)
    detected = camera.rays(pixels).directions[rays.valid]
    turn, _ = Rotation.align_vectors(directions[rays.valid], detected)
    back = true.project(true.centre + 1e7 * turn.apply(detected))
    distance = np.linalg.norm(back.pixels - pixels[rays.valid], axis=1)[back.valid]
    assert scored["rms_px"] == pytest.approx(np.sqrt(np.mean(distance**2)), rel=1e-4)
    assert scored["max_px"] == pytest.approx(distance.max(), rel=1e-4)


def test_truth_with_missing_corner_is_rejected(board_set, tmp_path):
    shutil.copytree(board_set.folder, tmp_path / "set")
    path = tmp_path / "set" / "truth" / "corners.json"
    truth = json.loads(path.read_text())
    first = next(iter(truth["images"]))
    truth["images"][first]["corners"] = [None] * 12
    path.write_text(json.dumps(truth))
    found = f"images.{first}.corners: "
    with raises_line(found):
        score_corners(load_set(tmp_path / "set"), true_boards(board_set))


def test_camera_of_other_size_is_rejected(board_set):
    other = FisheyeCamera("equidistance", 100, [50, 40], 100, 80, 1.4)
    with pytest.raises(InputError, match="100 x 80"):
        score_camera(board_set, other)
