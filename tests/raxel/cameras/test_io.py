"""Camera files: whole or absent, checked field by field."""

import math
import os

import numpy as np
import pytest

from raxel.cameras import (
    FisheyeCamera,
    GeneralCamera,
    PerspectiveCamera,
    load_camera,
    pixel_grid,
)
from raxel.errors import InputError
from tests.camera_checks import assert_same_from_file
from tests.raised import raises_line

FISHEYE = FisheyeCamera("stereographic", 20.5, (15.1, 9.9), 31, 21, math.radians(95))
PERSPECTIVE = PerspectiveCamera(
    [[30, 0.1, 15], [0, 31, 10], [0, 0, 1]], [-0.1, 0.01, 0.2], 31, 21
)
CENTRAL = GeneralCamera.from_camera(FISHEYE, units="pitch")
NON_CENTRAL = GeneralCamera(
    CENTRAL.directions, CENTRAL.mask, 3 * CENTRAL.directions, "mm"
)
CAMERAS = [PERSPECTIVE, FISHEYE, CENTRAL, NON_CENTRAL]


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda c: c.kind)
def test_camera_file_roundtrip_is_bit_identical(camera, tmp_path):
    back = assert_same_from_file(camera, pixel_grid(31, 21), tmp_path)
    assert (back.width, back.height, back.central) == (31, 21, camera.central)
    assert getattr(back, "units", None) == getattr(camera, "units", None)
    assert os.listdir(tmp_path) == ["camera.npz"]


def damaged(tmp_path, camera, **changes):
    path = tmp_path / "camera.npz"
    camera.save(path)
    with np.load(path) as archive:
        fields = dict(archive) | changes
    kept = {name: value for name, value in fields.items() if value is not None}
    np.savez(path, **kept)
    return path


@pytest.mark.parametrize(
    ("camera", "name", "value"),
    [
        (PERSPECTIVE, "kind", None),
        (PERSPECTIVE, "kind", np.array("telescope")),
        (PERSPECTIVE, "kind", np.array(3)),
        (PERSPECTIVE, "K", None),
        (PERSPECTIVE, "K", np.eye(2)),
        (PERSPECTIVE, "K", np.array("text")),
        (PERSPECTIVE, "radial", np.array([np.nan])),
        (PERSPECTIVE, "width", np.array([1, 2])),
        (PERSPECTIVE, "board", np.frombuffer(b"{}}", np.uint8)),
        (PERSPECTIVE, "board", np.frombuffer(b"\xff", np.uint8)),
        (FISHEYE, "projection", np.array("flat")),
        (FISHEYE, "max_angle", np.array(9.0)),
        (FISHEYE, "focal_px", np.array("wide")),
        (CENTRAL, "mask", np.ones((5, 5), bool)),
        (CENTRAL, "directions", None),
        (CENTRAL, "origins", np.zeros(4)),
        (CENTRAL, "units", np.array("inch")),
        (CENTRAL, "width", np.array(30)),
    ],
)
def test_bad_field_is_named_with_file(camera, name, value, tmp_path):
    path = damaged(tmp_path, camera, **{name: value})
    with raises_line(rf"camera\.npz: field '{name}': "):
        load_camera(path)


def test_non_camera_files_are_rejected(tmp_path):
    with pytest.raises(InputError, match="no such camera file"):
        load_camera(tmp_path / "none.npz")
    with pytest.raises(InputError, match="not a readable camera file"):
        load_camera(tmp_path)
    text, single, cut = (tmp_path / name for name in ("a.npz", "b.npy", "c.npz"))
    text.write_text("no archive")
    np.save(single, np.eye(3))
    CENTRAL.save(cut)
    whole = cut.read_bytes()
    for path in (text, single):
        with pytest.raises(InputError, match="camera"):
            load_camera(path)
    for size in (0, 10, len(whole) // 2, len(whole) - 5):
        cut.write_bytes(whole[:size])
        with pytest.raises(InputError, match=r"c\.npz: not a camera file"):
            load_camera(cut)
    flipped = bytearray(whole)
    flipped[len(whole) // 3] ^= 0xFF
    cut.write_bytes(flipped)
    with pytest.raises(InputError, match=r"c\.npz: field '\w+': file is damaged"):
        load_camera(cut)


def test_failed_save_keeps_old_file(tmp_path, monkeypatch):
    path = tmp_path / "camera.npz"
    FISHEYE.save(path)
    before = path.read_bytes()
    broken = CENTRAL._fields() | {"units": np.array(object())}
    monkeypatch.setattr(CENTRAL, "_fields", lambda: broken)
    monkeypatch.setattr(np, "savez_compressed", _fail_half_way)
    with pytest.raises(OSError, match="disk full"):
        CENTRAL.save(path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["camera.npz"]
    with pytest.raises(InputError, match="no folder"):
        FISHEYE.save(tmp_path / "none" / "camera.npz")


def _fail_half_way(stream, **fields):
    stream.write(b"half")
    raise OSError("disk full")


def test_table_from_camera_uses_requested_unit():
    assert CENTRAL.units == "pitch"
    assert GeneralCamera.from_camera(FISHEYE).units == "mm"
