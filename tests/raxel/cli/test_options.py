"""Options change what they name; numbers in printed lines are the right ones."""

from types import SimpleNamespace

import click
import cv2
import numpy as np
import pytest

from raxel.cli import active_grids, image_sets, main, mirror
from raxel.cli.commands import COUNT, FRACTION, LENGTH, SEED
from raxel.cli.findings import of_pixels, of_swapped_sides
from raxel.errors import InputError
from raxel.lab import mirror_set_rig
from raxel.sets.model import ActiveGrid


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
def test_decode_options_change_one_argument_each(words, asked, tmp_path, monkeypatch):
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
    monkeypatch.setattr(active_grids, "load_set", lambda folder: of_set)
    monkeypatch.setattr(active_grids, "decode_view", decoded)
    assert main(["decode", "set", "--out", str(tmp_path / "points"), *words]) == 2
    assert given == [usual | asked]


def test_render_passes_seed_and_noise(monkeypatch):
    given = []

    def rendered(rig, out, seed, noise, say):
        given.append((rig, out, seed, noise))
        return SimpleNamespace(name="made", image_sets={}, steps=[], folder=out)

    monkeypatch.setattr(mirror_set_rig, "is_mirror_set_rig", lambda path: True)
    monkeypatch.setattr(mirror_set_rig, "load_mirror_set_rig", lambda path: path)
    monkeypatch.setattr(mirror_set_rig, "render_mirror_set", rendered)
    words = ["render", "rig.yaml", "--out", "made", "--seed", "7", "--noise", "low"]
    assert main(words) == 0
    assert given == [("rig.yaml", "made", 7, "low")]


@pytest.mark.parametrize(
    ("kind", "taken", "rejected"),
    [
        (COUNT, ("1", "32000"), ("0", "32001", "-1", "1.5")),
        (FRACTION, ("-1", "0.25", "1"), ("-1.01", "1.01", "nan", "x")),
        (LENGTH, ("0.5", "1e6"), ("0", "-3", "1.1e6", "nan")),
        (SEED, ("0", "17"), ("-1", "1.5", "")),
    ],
)
def test_number_options_accept_their_range(kind, taken, rejected):
    assert [kind(text) for text in taken] == [float(text) for text in taken]
    for text in rejected:
        with pytest.raises(click.BadParameter, match="expected"):
            kind(text)


def test_celect_requires_clicks_in_one_view(monkeypatch):
    of_set = SimpleNamespace(
        description="set.yaml", target=SimpleNamespace(columns=9, rows=7)
    )
    options = SimpleNamespace(detector="celect")
    for name in ("check_chessboard", "marker_warning"):
        monkeypatch.setattr(image_sets, name, lambda *given: None)
    monkeypatch.setattr(image_sets, "detect_boards", lambda *given: "found")
    clicked, bare = (SimpleNamespace(outer_corners=four) for four in ([1], None))
    found = image_sets.detected(of_set, options, [clicked, bare], print)
    assert found == ("found", None)
    with pytest.raises(InputError, match="outer_corners in 2 views"):
        image_sets.detected(of_set, options, [bare, bare], print)


@pytest.mark.parametrize(
    ("size_mm", "oblong", "swapped"),
    [
        ((533.0, 300.0), 0, 0),
        ((300.0, 533.0), 1, 1),
        ((700.0, 300.0), 1, 0),  # oblong, and more so with its sides exchanged
    ],
)
def test_swapped_sides_are_reported_if_pixels_become_squarer(size_mm, oblong, swapped):
    monitor = ActiveGrid((1600, 900), size_mm)
    assert (len(of_pixels(monitor)), len(of_swapped_sides(monitor))) == (
        oblong,
        swapped,
    )


def test_stage_counts_wrong_corners_separately():
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
    result = mirror._stage(mirror_set, found, 1, "mirror-1.npz")
    assert (result["corners"], result["wrong_corners"]) == (6, 2)
    assert (result["before"], result["after"], result["deflection_mm"]) == (
        "a",
        "b",
        2.5,
    )
    assert (
        result
        | {
            "functions": [4, 3],
            "residual_mm": {"mean": 2.0, "sd": 1.0},
            "step_by_step_residual_mm": {"mean": 0.5, "sd": 0.0},
            "support": {"along_u": [1, 2], "along_v": [3], "reach": [0.5]},
        }
        == result
    )


def test_patterns_offset_shifts_phase_by_quarter_period(tmp_path):
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
