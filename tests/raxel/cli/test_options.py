"""An option does what it is there for, and a line says of each number what it is."""

import argparse
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from raxel.cli import boards, decode, main, mirror, numbers, render
from raxel.cli.models import _pupil_line
from raxel.cli.stability import stability_line
from raxel.cli.warnings import of_pixels, of_swapped_sides
from raxel.cli.wrong_points import wrong_fields, wrong_warnings
from raxel.errors import InputError
from raxel.evaluation.split_half import Division, SplitHalf
from raxel.sets.model import BOARDS, GRIDS, ActiveGrid


@pytest.mark.parametrize(
    ("words", "asked"),
    [
        ([], {}),
        (["--raw"], {"smooth": False}),
        (["--neighbours"], {"neighbours": True}),
        (["--fill"], {"fill": True}),
        (["--linear"], {"linear": True}),
        (["--margin", "9"], {"margin_px": 9}),
    ],
)
def test_each_option_of_decoding_alone_changes_what_it_names(
    words, asked, tmp_path, monkeypatch
):
    usual = {
        "smooth": True, "neighbours": False, "fill": False, "margin_px": None,
        "linear": False,
    }  # fmt: skip
    given = []

    def decoded(image_set, view, **options):
        given.append(options)
        return SimpleNamespace(reason="seen enough")

    of_set = SimpleNamespace(
        description="set.yaml", views=[SimpleNamespace(label="one")],
        width=320, height=240,
    )  # fmt: skip
    monkeypatch.setattr(decode, "load_set", lambda folder: of_set)
    monkeypatch.setattr(decode, "decode_view", decoded)
    assert main(["decode", "set", "--out", str(tmp_path / "points"), *words]) == 2
    assert given == [usual | asked]


def test_a_mirror_set_is_rendered_with_the_seed_and_noise_asked_for(monkeypatch):
    given = []

    def rendered(rig, out, seed, noise, say):
        given.append((rig, out, seed, noise))
        return SimpleNamespace(name="made", image_sets={}, steps=[], folder=out)

    monkeypatch.setattr(render, "is_mirror_set_rig", lambda path: True)
    monkeypatch.setattr(render, "load_mirror_set_rig", lambda path: path)
    monkeypatch.setattr(render, "render_mirror_set", rendered)
    words = ["render", "rig.yaml", "--out", "made", "--seed", "7", "--noise", "low"]
    assert main(words) == 0
    assert given == [("rig.yaml", "made", 7, "low")]


@pytest.mark.parametrize(
    ("kind", "taken", "refused"),
    [
        (numbers.count, ("1", "32000"), ("0", "32001", "-1", "1.5")),
        (numbers.part, ("-1", "0.25", "1"), ("-1.01", "1.01", "nan", "x")),
        (numbers.length, ("0.5", "1e6"), ("0", "-3", "1.1e6", "nan")),
        (numbers.seed, ("0", "17"), ("-1", "1.5", "")),
    ],
)
def test_numbers_are_taken_from_their_first_to_their_last(kind, taken, refused):
    assert [kind(text) for text in taken] == [float(text) for text in taken]
    for text in refused:
        with pytest.raises(argparse.ArgumentTypeError, match="give"):
            kind(text)


def test_four_clicks_in_one_photograph_are_enough_for_celect(monkeypatch):
    of_set = SimpleNamespace(
        description="set.yaml", target=SimpleNamespace(columns=9, rows=7)
    )
    options = SimpleNamespace(detector="celect")
    for name in ("check_chessboard", "marker_warning"):
        monkeypatch.setattr(boards, name, lambda *given: None)
    monkeypatch.setattr(boards, "detect_boards", lambda *given: "found")
    clicked, bare = (SimpleNamespace(outer_corners=four) for four in ([1], None))
    found = boards.detected(of_set, options, [clicked, bare], print)
    assert found == ("found", None)
    with pytest.raises(InputError, match="outer_corners in the 2 "):
        boards.detected(of_set, options, [bare, bare], print)


@pytest.mark.parametrize(
    ("size_mm", "oblong", "swapped"),
    [
        ((533.0, 300.0), 0, 0),
        ((300.0, 533.0), 1, 1),
        ((700.0, 300.0), 1, 0),  # oblong, and more so with its sides exchanged
    ],
)
def test_sides_are_said_to_be_exchanged_where_that_makes_pixels_squarer(
    size_mm, oblong, swapped
):
    monitor = ActiveGrid((1600, 900), size_mm)
    assert (len(of_pixels(monitor)), len(of_swapped_sides(monitor))) == (
        oblong,
        swapped,
    )


def test_wrong_corners_of_a_stage_are_not_those_that_could_not_be_used():
    mirror_set = SimpleNamespace(
        steps=[SimpleNamespace(before="a", after="b", deflection_mm=2.5)]
    )
    used, wrong = np.zeros((2, 10), bool)
    used[:6], wrong[6:8] = True, True
    update = SimpleNamespace(
        residuals=np.array([0.5]), used=used, wrong=wrong, flags=("slow",),
        support=SimpleNamespace(
            along_u=np.array([1, 2]), along_v=np.array([3]), reach=np.array([0.5])
        ),
    )  # fmt: skip
    found = SimpleNamespace(
        cameras=2 * [SimpleNamespace(grid=np.zeros((4, 3)))],
        residuals_mm=lambda stage: np.array([1.0, 3.0]),
        updates=[update],
        views=[SimpleNamespace(view=SimpleNamespace(name="b"), grid=0)],
        bundle=SimpleNamespace(T_camera_grid=np.eye(4)[None]),
    )
    told = mirror._stage(mirror_set, found, 1, "mirror-1.npz")
    assert (told["corners"], told["wrong_corners"]) == (6, 2)
    assert (told["before"], told["after"], told["deflection_mm"]) == ("a", "b", 2.5)
    assert told["functions"] == [4, 3]
    assert told["residual_mm"] == {"mean": 2.0, "sd": 1.0}
    assert told["step_by_step_residual_mm"] == {"mean": 0.5, "sd": 0.0}
    assert told["support"] == {"along_u": [1, 2], "along_v": [3], "reach": [0.5]}


def test_an_offset_of_a_quarter_makes_cosines_of_sines(tmp_path):
    """A sine begins each period in mid-grey and brightens, a cosine is brightest."""
    sides = "--width", "64", "--height", "48", "--cells", "4", "--steps", "4"
    rows = {}
    for name, more in (("sine", ()), ("cosine", ("--offset", "0.25"))):
        out = tmp_path / name
        assert main(["patterns", *sides, *more, "--out", str(out)]) == 0
        (path,) = (p for p in out.glob("phase*x*0.png"))
        rows[name] = cv2.imread(str(path), 0)[0].astype(float)
        assert (cv2.imread(str(out / "white.png"), 0) == 255).all()
        assert (cv2.imread(str(out / "black.png"), 0) == 0).all()
    turn = 2 * np.pi * (np.arange(64) + 0.5) / 16
    np.testing.assert_allclose(rows["sine"], 127.5 * (1 + np.sin(turn)), atol=1.5)
    np.testing.assert_allclose(rows["cosine"], 127.5 * (1 + np.cos(turn)), atol=1.5)


def test_what_scatter_explains_is_told_apart_from_what_photographs_do():
    worst = Division("near and far", ((), ()), 0.9, 0.2, 0.5, 1e-7, np.zeros((0, 2)))
    found = SplitHalf([worst], np.zeros((0, 2)), 1e-6, False, 2.5, True)
    assert stability_line(found, BOARDS) == (
        "stability: of 1 divisions into halves the worst is 'near and far': rays 0.9 "
        "px apart (RMS, after the best rotation, where both saw boards), of which the "
        "corners' scatter explains 0.2 px, and 0.5 px with what photographs of one "
        "half differ by; p = 1e-06"
    )


def test_errors_with_and_without_a_moving_pupil_stand_on_their_sides():
    pupil = {
        "p_value": 1e-5, "central_px": 0.5, "moving_px": 0.25, "chance": 0.125,
        "shift": 2.0, "shift_sd": 0.1, "verdict": "moves", "against": None,
        "moves": True,
    }  # fmt: skip
    errors = "without that, 0.5 px RMS on boards kept out, with it 0.25 px"
    by = "by 2 +- 0.1 mm over the field of view"
    assert _pupil_line(pupil, "mm") == f"the entrance pupil moves {by}: {errors}"
    unsure = pupil | {"moves": False, "verdict": "undecided"}
    told = _pupil_line(unsure, "mm")
    assert f"if it does, {by}; {errors}, which chance makes with p = 0.12" in told
    rests = _pupil_line(unsure | {"verdict": "rests"}, "mm")
    assert "(p = 1e-05), but not boards kept out (0.25 px RMS, 0.5 px without)" in rests


def test_the_worst_of_wrong_points_is_the_farthest_rounded_up():
    wrong = [
        {"file": name, "corner": n, "distance_px": px}
        for name, n, px in (("a", 7, 2.5), ("b", 3, 9.04), ("b", 4, 1.5))
    ]
    (told,) = wrong_warnings(wrong_fields(wrong, 60), 0.125, GRIDS)
    assert told.startswith(
        "3 points (5.0 %) do not fit and have no weight: photographs b (2), a (1); the "
        "worst, number 3 of b, is off by 9.1 px, the others by 0.12 px (RMS); "
    )
