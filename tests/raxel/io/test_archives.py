"""Archives of arrays, .npz: whole, or one line says why not, before memory is taken."""

import io
import os
import struct
import tracemalloc
import zipfile

import numpy as np
import pytest

from raxel.cameras import load_camera
from raxel.errors import InputError
from raxel.io import archives
from raxel.io.archives import Archive

K = [[30, 0.1, 15], [0, 31, 10], [0, 0, 1]]
FIELDS = {"kind": np.array("perspective"), "width": np.array(31)}
FIELDS |= {"height": np.array(21), "K": np.array(K), "radial": np.array([-0.1, 0.01])}


def npy(array):
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.asanyarray(array))
    return stream.getvalue()


def with_header(text, content=b"", version=1):
    text = text.encode().ljust(117) + b"\n"
    return b"\x93NUMPY" + struct.pack("<BBH", version, 0, len(text)) + text + content


def described(shape, dtype="<f8"):
    return f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}}}"


def zipped(path, packing=zipfile.ZIP_STORED, **changes):
    """An .npz camera whose members are changed; None takes one out."""
    members = {f"{name}.npy": npy(array) for name, array in FIELDS.items()} | changes
    with zipfile.ZipFile(path, "w", packing) as archive:
        for name, content in members.items():
            if content is not None:
                archive.writestr(name, content)
    return path


def directory_entry(path, name, offset, number):
    """Change 2 bytes of the zip's directory entry of `name`."""
    content = bytearray(path.read_bytes())
    at = content.rfind(name.encode()) - 46
    assert content[at : at + 4] == b"PK\x01\x02"
    content[at + offset : at + offset + 2] = struct.pack("<H", number)
    path.write_bytes(content)
    return path


def rejects(path, words):
    with pytest.raises(InputError) as fault:
        load_camera(path)
    line = str(fault.value)
    assert line.startswith(f"{path}: ")
    assert words in line
    assert line.isprintable()
    assert len(line) < 400


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "missing"),
        (b"no array", "damaged"),
        (b"\x93NUM", "damaged"),
        (b"\x93NUMPY\x01\x00\xff\xff{", "damaged"),
        (with_header("{'shape': (3, 3)}"), "damaged"),
        (with_header("[" * 110), "damaged"),
        (with_header(described("(3, -3)")), "damaged"),
        (with_header(described("(3, 3)"), bytes(72), version=3), "damaged"),
        (with_header(described("(3, 3)"), bytes(71)), "damaged"),
        (with_header(described("(3, 3)"), bytes(73)), "damaged"),
        (with_header(described("(1099511627776, 1099511627776)")), "damaged"),
        (with_header(described("(1,)", "|O"), bytes(8)), "type is object"),
        (npy(np.zeros((3, 3), complex)), "type is complex128"),
        (npy(np.zeros((3, 3), np.longdouble)), "type is float128"),
        (npy(np.zeros(3, "f8, i4")), "type is [("),
        (npy(np.array("x" * 101)), "type is <U101"),
        (npy(np.array([["1", "0"]])), "found <U1; give numbers"),
        (npy(np.full((3, 3), np.inf)), "not finite"),
        (npy(np.full((3, 3), 1e101)), "beyond 1e+100"),
        (npy(np.eye(4)), "shape (4, 4)"),
        (npy(np.zeros(4097)), "4097 values exceed the limit of 4096"),
    ],
)
def test_invalid_array_is_reported_with_file(tmp_path, content, words):
    rejects(zipped(tmp_path / "camera.npz", **{"K.npy": content}), words)
    rejects(zipped(tmp_path / "camera.npz", **{"K.npy": content}), "field 'K': ")


def test_members_without_npy_are_ignored(tmp_path):
    path = tmp_path / "camera.npz"
    rejects(zipped(path, **{"kind.npy": None, "kind": b"perspective"}), "missing")
    rejects(zipped(path, **{"K.npy": None, "K.npy/": b"", "K": b"x"}), "'K': missing")
    assert load_camera(zipped(path, **{"folder/": b"", "note": b"x"})).width == 31


def test_empty_text_is_rejected(tmp_path):
    wild = with_header(described("()", "<U1"), struct.pack("<I", 0x7FFFFFFF))
    rejects(
        zipped(tmp_path / "camera.npz", **{"kind.npy": wild}), "'kind': invalid text"
    )


@pytest.mark.parametrize(
    ("offset", "number", "words"),
    [
        (8, 1, "damaged"),
        (10, 99, "damaged"),
        (24, 3000, "damaged"),
        (16, 12345, "damaged"),
    ],
)
def test_zip_headers_are_checked(tmp_path, offset, number, words):
    path = zipped(tmp_path / "camera.npz")
    directory_entry(path, "K.npy", offset, number)
    rejects(path, "field 'K': ")
    rejects(path, words)


def test_zip_bomb_does_not_exhaust_memory(tmp_path):
    shape = 32, 1 << 16
    large = with_header(described(shape), bytes(8 * shape[0] * shape[1]))
    packed = zipfile.ZIP_DEFLATED
    path = zipped(tmp_path / "camera.npz", packed, **{"K.npy": large})
    general = {"kind.npy": npy(np.array("general")), "directions.npy": large}
    other = zipped(tmp_path / "general.npz", packed, **general)
    tracemalloc.start()
    rejects(path, "field 'K': 2097152 values exceed")
    rejects(other, "field 'width': found 31, but the table has")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < len(large) / 10


def test_oversized_array_headers_are_rejected(tmp_path, monkeypatch):
    path = zipped(tmp_path / "camera.npz")
    content = bytearray(path.read_bytes())
    at = content.rfind(b"K.npy") - 46
    content[at + 24 : at + 28] = struct.pack("<I", 1 << 31)
    path.write_bytes(content)
    rejects(path, "field 'K': file is damaged")
    np.savez(path, points_mm=np.zeros((100, 100)))
    monkeypatch.setattr(archives, "physical_memory", lambda: 1e5)
    with Archive(path, "file") as archive, pytest.raises(InputError, match="GB, more"):
        archive.array("points_mm", 10_000)


def test_byte_and_axis_order_are_normalised(tmp_path):
    changed = {"K.npy": npy(np.asfortranarray(np.array(K, ">f4")))}
    changed["width.npy"] = npy(np.array(31, ">u2"))
    camera = load_camera(zipped(tmp_path / "camera.npz", **changed))
    np.testing.assert_allclose(camera.K, K, rtol=1e-7)
    assert camera.width == 31


def test_special_files_are_not_opened(tmp_path, monkeypatch):
    pipe = tmp_path / "pipe.npz"
    os.mkfifo(pipe)
    rejects(pipe, "not a readable camera file")
    rejects(tmp_path, "not a readable camera file")
    with pytest.raises(InputError, match="/dev/zero: not a readable camera"):
        load_camera("/dev/zero")
    path = zipped(tmp_path / "camera.npz")
    monkeypatch.setattr(os, "access", lambda *given: False)
    rejects(path, "not a readable camera file")


def test_camera_nesting_is_limited(tmp_path):
    members, prefix = {}, ""
    for depth in range(300):
        members[f"{prefix}kind.npy"] = npy(np.array("bent mirror"))
        if depth < 9:
            members[f"{prefix}width.npy"] = members[f"{prefix}height.npy"] = npy(31)
        prefix += "viewer."
    rejects(zipped(tmp_path / "camera.npz", **members), "nested cameras; reduce")
