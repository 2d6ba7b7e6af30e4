"""Wrong corners are named and counted, and cause no other warning."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from raxel.cli import main
from raxel.evaluation.board_corners import _from_neighbours, without_wrong_corners
from raxel.evaluation.misfit import misfit
from tests.made_sets import COLUMNS, FISHEYE, PINHOLE, ROWS, boards_of, write_made_set
from tests.raxel.evaluation.test_split_half import CAMERA, COUNT, views_of


def spoilt(views, share, seed):
    """The views with a share of their corners 2 to 40 px aside, and which these are."""
    rng, wrong = np.random.default_rng(seed), set()
    for view in views:
        own = np.flatnonzero(rng.random(len(view.pixels)) < share)
        turn, off = rng.uniform(0, 2 * np.pi, len(own)), rng.uniform(2, 40, len(own))
        aside = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        view.pixels[own] += aside * off[:, None]
        wrong |= {(view.name, int(n)) for n in own if np.isfinite(view.pixels[n, 0])}
    return views, wrong


def test_only_isolated_wrong_corners_are_found():
    views, wrong = spoilt(views_of(COUNT * [CAMERA], 4), 0.05, 4)
    found = without_wrong_corners(CAMERA, views)
    named = {(name, n) for name, n, _ in found.wrong}
    assert named >= wrong
    assert len(named) <= 1.05 * len(wrong)
    assert found.whole.rms_px > 3
    assert found.evaluation.rms_px == pytest.approx(0.1 * np.sqrt(2), rel=0.05)
    assert not misfit(found.evaluation.images, found.views).large


def boards_off(rng, deviations, corners=63):
    """Scores and views of boards of 7 columns with independent residuals, px."""
    named = [(f"{k}", sd) for k, sd in enumerate(deviations)]
    scores = []
    for name, sd in named:
        off = sd * rng.standard_normal((corners, 2))
        rms = np.sqrt(np.mean(np.sum(off**2, axis=1)))
        scores.append(SimpleNamespace(name=name, residuals_px=off, rms_px=rms))
    view = SimpleNamespace(rows=corners // 7, columns=7, sd=np.full(corners, 0.2))
    return scores, len(named) * [view]


def test_scatter_of_independent_errors_is_their_size():
    found = misfit(*boards_off(np.random.default_rng(1), [0.3] * 30))
    assert found.rms_px == pytest.approx(0.3 * np.sqrt(2), rel=0.03)
    assert found.scatter_px == pytest.approx(found.rms_px, rel=0.03)
    assert found.sd_px == pytest.approx(0.2 * np.sqrt(2))


@pytest.mark.parametrize(
    ("deviations", "corners", "odd"),
    [
        ([0.1, 0.1, 0.1, 0.1, 0.6], 63, ("4",)),
        ([0.01, 0.01, 0.01, 0.01, 0.06], 63, ()),  # however odd, a good board
        ([0.1, 0.1, 0.1, 0.1, 0.6], 7, ()),  # too few corners to tell
        ([0.1, 0.1, 0.1, 0.6, 0.6], 63, ()),
        ([0.1, 0.1, 0.1, 0.1, 0.2], 63, ()),
    ],
)
def test_outlier_board_has_much_larger_residuals(deviations, corners, odd):
    found = misfit(*boards_off(np.random.default_rng(2), deviations, corners))
    assert not found.large
    assert found.odd_boards == odd


def test_errors_shared_by_neighbours_are_not_wrong_corners():
    assert without_wrong_corners(CAMERA, views_of(COUNT * [CAMERA], 5)).wrong == []
    # 9 mm of motion per image, and another lens projection.
    rolling = views_of(COUNT * [CAMERA], 6, shift=(9.0, 0.0, 0.0))
    assert without_wrong_corners(CAMERA, rolling).wrong == []


def test_residual_slopes_continue_to_the_edge():
    """At a rim all neighbours lie to one side: only their slope leads to the corner."""
    j, i = np.mgrid[:5, :7]
    lattice = SimpleNamespace(rows=5, columns=7)
    slope = np.stack([0.3 * i - 0.2 * j + 1, 0.1 * i + 0.4 * j - 2], axis=2)
    score = SimpleNamespace(residuals_px=slope.reshape(-1, 2))
    np.testing.assert_allclose(_from_neighbours(score, lattice)[0], 0, atol=1e-12)


@pytest.fixture
def calibrated(tmp_path, capsys):
    def run(boards, model):
        folder, corners = write_made_set(tmp_path / "set", boards)
        result = tmp_path / "result.json"
        order = ["calibrate", folder, "--corners", corners, "--model", model]
        order += ["--out", tmp_path / "camera.npz", "--json", result]
        assert main([*map(str, order), "--report", str(tmp_path / "report")]) == 0
        page = (tmp_path / "report" / "index.html").read_text()
        return json.loads(result.read_text()), page, capsys.readouterr().out

    return run


def test_calibrate_counts_and_names_wrong_corners(calibrated):
    boards = boards_of(PINHOLE, count=8)
    for board, corner, aside in ((2, 9, 12.0), (2, 31, -20.0), (5, 40, 9.0)):
        boards[board][corner] += aside
    result, page, printed = calibrated(boards, "zhang")
    begin = (
        f"3 corners ({300 / 8 / COLUMNS / ROWS:.1f} %) excluded as outliers: 2.png "
        "(2), 5.png (1); check the worst, number 31 of 2.png ("
    )
    assert f"warning: {begin}" in printed
    first, *others = result["warnings"]
    assert first.startswith(begin)
    # These boards are in the middle of the image.
    assert all("% of the image is outside" in other for other in others)
    assert result["wrong_points_of"] == {"2.png": 2, "5.png": 1}
    assert [entry["corner"] for entry in result["wrong_points"]] == [9, 31, 40]
    assert result["misfit"]["fits"]
    assert result["misfit"]["rms_px"] < 0.1
    assert result["camera"]["focal_px"] == pytest.approx([300, 300], rel=0.01)
    assert "2.png: 2, 5.png: 1" in page


def test_wrong_corners_do_not_hide_a_misfit(calibrated):
    boards = boards_of(FISHEYE)
    boards[1][20] += 15.0
    result, _, printed = calibrated(boards, "zhang")
    assert not result["misfit"]["fits"]
    assert "warning: zhang does not fit: RMS " in printed
    assert ("1.png", 20) in [(w["file"], w["corner"]) for w in result["wrong_points"]]
    assert len(result["wrong_points"]) < 5


def test_evaluate_scores_include_wrong_corners(tmp_path, capsys):
    """As printed: a pose bends away from a corner that is 30 px off, and little."""
    boards = boards_of(PINHOLE, count=4)
    boards[1][20] += [18.0, 24.0]
    folder, corners = write_made_set(tmp_path / "set", boards)
    camera, path = tmp_path / "camera.npz", tmp_path / "result.json"
    PINHOLE.save(camera)
    order = ["evaluate", camera, folder, "--corners", corners, "--json", path]
    assert main([*map(str, order)]) == 0
    result, printed = json.loads(path.read_text()), capsys.readouterr().out
    due = 30 / np.sqrt(4 * COLUMNS * ROWS)
    assert result["rms_px"] == pytest.approx(due, rel=0.1)
    assert f"RMS {result['rms_px']:.3f} px" in printed
    assert " px, others 0.0" in printed


def test_errors_that_grow_towards_an_edge_are_not_wrong_corners():
    views = views_of(COUNT * [CAMERA], 7)
    view = next(v for v in views if np.isfinite(v.pixels).all())
    pixels = view.pixels.reshape(view.rows, view.columns, 2)
    for ring, off in enumerate((6.0, 2.5, 1.5, 0.7)):
        own = np.maximum(*np.mgrid[: view.rows, : view.columns]) == ring
        pixels[own] += [off, off]
    assert without_wrong_corners(CAMERA, views).wrong == []
