"""Damaged images are rejected wherever format or decoder can detect it."""

import os
import struct
import tracemalloc
import zlib
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from raxel.errors import InputError
from raxel.io.documents import read_yaml
from raxel.io.files import read_json
from raxel.sets import load_set, read_image
from raxel.sets.image_files import has_orientation, read_colour
from tests.image_sets import boards, description, write_description

LZW, DEFLATE, OLD_DEFLATE = 5, 8, 32946
PACKINGS = {"lzw": LZW, "deflate": DEFLATE, "old deflate": OLD_DEFLATE}


@pytest.fixture(scope="module")
def grey_image():
    """A board with a little noise, as sensors have it."""
    noise = np.random.default_rng(0).normal(0, 2, (240, 320))
    return np.clip(next(boards()).image() + noise, 0, 255).astype(np.uint8)


def kinds(grey_image):
    yield grey_image
    yield grey_image.astype(np.uint16) * 257
    yield np.dstack([grey_image] * 3)


def tiff(image, packing):
    return cv2.imencode(".tif", image, [cv2.IMWRITE_TIFF_COMPRESSION, packing])[1]


def read(path, data, shape=(240, 320), by=read_image):
    path.write_bytes(bytes(data))
    height, width = shape
    image_set = SimpleNamespace(
        folder=path.parent, width=width, height=height, description="set.yaml"
    )
    return by(image_set, path.name)


def is_detected(path, data, shape=(240, 320)):
    try:
        read(path, data, shape)
    except InputError:
        return True
    return False


def spoilt(data, at, how):
    """300 bytes of garbage, of nothing, or moved on by seven."""
    data = bytearray(data)
    data[at : at + 300] = {
        "garbage": np.random.default_rng(at).bytes(300),
        "zeros": bytes(300),
        "shift": bytes(data[at + 7 : at + 300]) + bytes(7),
    }[how]
    return data


@pytest.mark.parametrize("how", ["garbage", "zeros", "shift"])
@pytest.mark.parametrize("packing", PACKINGS)
def test_damaged_compressed_tiff_is_rejected(tmp_path, capfd, grey_image, packing, how):
    """libtiff fills in black where it can go no further."""
    capfd.readouterr()
    for image in kinds(grey_image):
        data = tiff(image, PACKINGS[packing])
        capfd.readouterr()  # OpenCV's words on the old number for deflate
        assert not is_detected(tmp_path / "a.tif", data)
        for at in range(700, len(data) - 700, len(data) // 12):
            assert is_detected(tmp_path / "a.tif", spoilt(data, at, how)), at
    assert capfd.readouterr().err == ""


def with_check_sums(png):
    """The PNG with the check sum of each chunk made right."""
    fixed, at = bytearray(png), 8
    while at < len(png):
        (length,) = struct.unpack_from(">I", png, at)
        checksum = zlib.crc32(bytes(fixed[at + 4 : at + 8 + length]))
        struct.pack_into(">I", fixed, at + 8 + length, checksum)
        at += 12 + length
    return fixed


@pytest.mark.parametrize("how", ["garbage", "zeros", "shift"])
def test_damaged_png_with_valid_checksums_is_rejected(tmp_path, grey_image, how):
    whole = cv2.imencode(".png", grey_image)[1]
    assert not is_detected(tmp_path / "a.png", with_check_sums(whole))
    length = len(whole) - 700
    for at in range(700, length, length // 12):
        data = with_check_sums(spoilt(whole, at, how))
        assert is_detected(tmp_path / "a.png", data), at


def test_huge_stated_size_does_not_exhaust_memory(tmp_path):
    """The set's resolution is compared first."""
    data = cv2.imencode(".png", np.zeros((240, 320), np.uint8))[1]
    struct.pack_into(">II", data, 16, 30000, 30000)
    (tmp_path / "view0.png").write_bytes(bytes(with_check_sums(data)))
    write_description(tmp_path, description(1))
    image_set = load_set(tmp_path)
    tracemalloc.start()
    with pytest.raises(InputError, match=r"view0\.png"):
        read_image(image_set, "view0.png")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 10e6


@pytest.mark.parametrize(
    "read",
    [
        lambda path: read_image(SimpleNamespace(folder=path.parent), path.name),
        read_json,
        read_yaml,
    ],
    ids=["image", "json", "yaml"],
)
def test_device_file_is_not_read(tmp_path, read):
    """It is sparse: on the disk there is nothing of it."""
    path = tmp_path / "large.json"
    with path.open("wb") as stream:
        stream.truncate(1_500_000_000)
    tracemalloc.start()
    with pytest.raises(InputError, match=r"large.json: \w+ has 1500 MB"):
        read(path)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 2_000_000


def tagged(image, **changed):
    """A plain grey TIFF with tags of our own choice; order: "<" or ">"."""
    height, width = image.shape
    order = changed.get("order", "<")
    tags = {
        256: (4, width), 257: (4, height), 258: (3, 8 * image.itemsize), 259: (3, 1),
        262: (3, changed.get("photometric", 1)), 273: (4, 0),
        274: (changed.get("kind", 3), changed.get("orientation", 1)), 277: (3, 1),
        278: (4, height), 279: (4, image.nbytes),
    }  # fmt: skip
    tags[273] = (4, (8 + 2 + 12 * len(tags) + 4))
    # A value of two bytes lies in the first of the four that an entry has for it.
    entries = b"".join(
        struct.pack(order + "HHI", tag, kind, 1)
        + struct.pack(order + {1: "B", 3: "H", 4: "I"}[kind], value).ljust(4, b"\0")
        for tag, (kind, value) in tags.items()
    )
    signature = {"<": b"II*\0", ">": b"MM\0*"}[order]
    head = signature + struct.pack(order + "IH", 8, len(tags))
    pixels = image.astype(image.dtype.newbyteorder(order)).tobytes()
    return head + entries + bytes(4) + pixels


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("by", [read_image, read_colour])
def test_tiff_orientation_is_ignored(tmp_path, orientation, depth, order, by):
    image = np.arange(12 * 20, dtype=depth).reshape(12, 20)
    data = tagged(image, orientation=orientation, order=order)
    found = read(tmp_path / "a.tif", data, image.shape, by)
    np.testing.assert_array_equal(found, image)
    assert has_orientation(tmp_path / "a.tif") == (orientation > 1)


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_min_is_white_tiff_is_inverted(tmp_path, depth):
    image = np.arange(12 * 20, dtype=depth).reshape(12, 20)
    data = tagged(np.iinfo(depth).max - image, photometric=0)
    np.testing.assert_array_equal(read(tmp_path / "a.tif", data, image.shape), image)


def test_tiff_with_alpha_is_rejected(tmp_path, grey_image):
    opaque = np.dstack([grey_image] * 3 + [grey_image // 2])
    with pytest.raises(InputError, match="4 samples per pixel"):
        read(tmp_path / "a.tif", cv2.imencode(".tif", opaque)[1])


def test_run_length_bmp_is_read(tmp_path):
    runs = b"".join(bytes((32, 200)) + b"\0\0" for _ in range(32)) + b"\0\1"
    start = 14 + 40 + 1024
    header = struct.pack("<IHHI", start + len(runs), 0, 0, start)
    header += struct.pack("<IiiHHIIiiII", 40, 32, 32, 1, 8, 1, len(runs), 0, 0, 256, 0)
    colours = b"".join(bytes((level, level, level, 0)) for level in range(256))
    data = b"BM" + header + colours + runs
    assert (read(tmp_path / "a.bmp", data, (32, 32)) == 200).all()


def test_size_different_from_header_is_rejected(tmp_path, monkeypatch, grey_image):
    rotated = np.ascontiguousarray(grey_image.T)
    data = cv2.imencode(".png", grey_image)[1]
    monkeypatch.setattr(cv2, "imdecode", lambda data, mode: rotated)
    with pytest.raises(InputError, match=r"a.png: 240 x 320 px differs"):
        read(tmp_path / "a.png", data)


def test_damage_is_detected_without_stderr(tmp_path, grey_image):
    data = tiff(grey_image, LZW)
    usual = os.dup(2)
    os.close(2)
    try:
        detected = is_detected(
            tmp_path / "a.tif", spoilt(data, len(data) // 2, "garbage")
        )
        with pytest.raises(OSError, match="Bad file descriptor"):
            os.fstat(2)
    finally:
        os.dup2(usual, 2)
        os.close(usual)
    assert detected
