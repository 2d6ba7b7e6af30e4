"""Damage inside a photograph is seen wherever its format or its decoder can tell."""

import os
import struct
import tracemalloc
import zlib

import cv2
import numpy as np
import pytest

from raxel.errors import InputError
from raxel.io.documents import read_text
from raxel.io.files import read_json
from raxel.sets import load_set, read_image
from raxel.sets.image_files import decode, stated_size, whole_file
from raxel.sets.tiff import READ, as_stored
from tests.image_sets import boards, description, write_description

LZW, DEFLATE, OLD_DEFLATE, PACK_BITS = 5, 8, 32946, 32773
PACKINGS = {"lzw": LZW, "deflate": DEFLATE, "old deflate": OLD_DEFLATE}


@pytest.fixture(scope="module")
def photograph():
    """A board with a little noise, as sensors have it."""
    noise = np.random.default_rng(0).normal(0, 2, (240, 320))
    return np.clip(next(boards()).image() + noise, 0, 255).astype(np.uint8)


def kinds(photograph):
    yield photograph
    yield photograph.astype(np.uint16) * 257
    yield np.dstack([photograph] * 3)


def tiff(image, packing):
    return cv2.imencode(".tif", image, [cv2.IMWRITE_TIFF_COMPRESSION, packing])[1]


def read(path):
    return decode(path, whole_file(path), cv2.IMREAD_GRAYSCALE)


def is_seen(path, data):
    path.write_bytes(bytes(data))
    try:
        read(path)
    except InputError as fault:
        return "damaged" in str(fault)
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
def test_damage_inside_a_packed_tiff_is_seen(tmp_path, capfd, photograph, packing, how):
    """libtiff fills in black where it can go no further."""
    capfd.readouterr()
    for image in kinds(photograph):
        data = tiff(image, PACKINGS[packing])
        capfd.readouterr()  # OpenCV's words on the old number for deflate
        assert not is_seen(tmp_path / "a.tif", data)
        for at in range(700, len(data) - 700, len(data) // 12):
            assert is_seen(tmp_path / "a.tif", spoilt(data, at, how)), at
    assert capfd.readouterr().err == ""


def test_one_wrong_bit_inside_a_deflated_tiff_is_seen(tmp_path, photograph):
    """By its check sum; run lengths and LZW have none."""
    whole = tiff(photograph, DEFLATE)
    for at in range(700, len(whole) - 700, len(whole) // 40):
        data = bytearray(whole)
        data[at] ^= 1 << at % 8
        assert is_seen(tmp_path / "a.tif", data), at


def test_run_lengths_that_do_not_fit_are_seen(tmp_path, photograph):
    for image in kinds(photograph):
        data = tiff(image, PACK_BITS)
        assert not is_seen(tmp_path / "a.tif", data)
        assert is_seen(tmp_path / "a.tif", spoilt(data, len(data) // 2, "zeros"))


def deflated(width, height, stream, fill_order=1):
    """A grey TIFF of one strip, which is `stream`."""
    tags = {256: width, 257: height, 258: 8, 259: DEFLATE, 262: 1, 266: fill_order}
    tags |= {273: 8, 277: 1, 278: height, 279: len(stream)}
    entries = [struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags.items()]
    directory = struct.pack("<H", len(tags)) + b"".join(entries) + bytes(4)
    return b"II*\0" + struct.pack("<I", 8 + len(stream)) + stream + directory


def test_a_deflated_tiff_whose_bits_run_the_other_way_is_read(tmp_path, photograph):
    reverse = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))
    stream = zlib.compress(photograph.tobytes()).translate(reverse)
    (tmp_path / "a.tif").write_bytes(deflated(320, 240, stream, fill_order=2))
    assert np.array_equal(read(tmp_path / "a.tif"), photograph)


def test_what_comes_out_of_a_strip_is_bounded(tmp_path):
    """Two kB that claim 64 x 64 px and unpack to 8 MB; gigabytes take no longer."""
    small, bomb = (zlib.compress(bytes(1 << bits)) for bits in (12, 23))
    assert not is_seen(tmp_path / "a.tif", deflated(64, 64, small))
    assert is_seen(tmp_path / "a.tif", deflated(64, 64, bomb))


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
def test_damage_inside_a_png_is_seen_in_spite_of_right_check_sums(
    tmp_path, photograph, how
):
    whole = cv2.imencode(".png", photograph)[1]
    assert not is_seen(tmp_path / "a.png", with_check_sums(whole))
    length = len(whole) - 700
    for at in range(700, length, length // 12):
        data = with_check_sums(spoilt(whole, at, how))
        assert is_seen(tmp_path / "a.png", data), at


def test_a_bmp_of_run_lengths_is_refused(tmp_path):
    """What its runs leave out would be black and whole."""
    runs = b"".join(bytes((32, 200)) + b"\0\0" for _ in range(32)) + b"\0\1"
    start = 14 + 40 + 1024
    header = struct.pack("<IHHI", start + len(runs), 0, 0, start)
    header += struct.pack("<IiiHHIIiiII", 40, 32, 32, 1, 8, 1, len(runs), 0, 0, 256, 0)
    colours = b"".join(bytes((level, level, level, 0)) for level in range(256))
    path = tmp_path / "a.bmp"
    path.write_bytes(b"BM" + header + colours + runs)
    assert (cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) == 200).all()
    with pytest.raises(InputError, match=r"run lengths, .*; save it as PNG"):
        read(path)


FORMATS = {
    "png": (),
    "jpg": (),
    "progressive.jpg": (cv2.IMWRITE_JPEG_PROGRESSIVE, 1),
    "bmp": (),
    "tif": (),
}


@pytest.mark.parametrize("kind", FORMATS)
def test_the_size_is_known_before_the_picture_is_decoded(photograph, kind):
    for image in (photograph, np.dstack([photograph[:, :301]] * 3)):
        name = f".{kind.rpartition('.')[2]}"
        data = cv2.imencode(name, image, FORMATS[kind])[1].tobytes()
        assert stated_size(data) == (image.shape[1], image.shape[0])


def test_a_few_bytes_that_state_a_gigantic_picture_take_no_memory(tmp_path):
    """The set's resolution is compared first."""
    data = cv2.imencode(".png", np.zeros((240, 320), np.uint8))[1]
    struct.pack_into(">II", data, 16, 30000, 30000)
    (tmp_path / "view0.png").write_bytes(bytes(with_check_sums(data)))
    write_description(tmp_path, description(1))
    image_set = load_set(tmp_path)
    tracemalloc.start()
    with pytest.raises(InputError, match="found 30000 x 30000 px, but resolution"):
        read_image(image_set, "view0.png")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 10e6


@pytest.mark.parametrize("kind", [0, 127, 128, 0xFFFF])
def test_a_tiff_whose_tags_are_of_no_known_type_is_refused(tmp_path, photograph, kind):
    data = bytearray(deflated(320, 240, zlib.compress(photograph.tobytes())))
    (at,) = struct.unpack_from("<I", data, 4)
    for tag in range(at + 2, len(data) - 4, 12):
        changed = bytearray(data)
        struct.pack_into("<H", changed, tag + 2, kind)
        number = struct.unpack_from("<H", data, tag)[0]
        assert is_seen(tmp_path / "a.tif", changed) or number not in READ


@pytest.mark.parametrize("read", [whole_file, read_json, read_text])
def test_a_file_without_end_is_not_read(tmp_path, read):
    """It is sparse: on the disk there is nothing of it."""
    path = tmp_path / "large.json"
    with path.open("wb") as stream:
        stream.truncate(1_500_000_000)
    tracemalloc.start()
    with pytest.raises(InputError, match=r"large.json: found 1500 MB"):
        read(path)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 1_000_000


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
    end = 8 + 2 + 12 * len(tags) + 4
    tags[273] = (4, end)
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
@pytest.mark.parametrize("colour", [cv2.IMREAD_GRAYSCALE, cv2.IMREAD_ANYCOLOR])
def test_pixels_of_a_tiff_stay_where_the_sensor_had_them(orientation, depth, colour):
    image = np.arange(12 * 20, dtype=depth).reshape(12, 20)
    data = tagged(image, orientation=orientation)
    np.testing.assert_array_equal(decode("a.tif", data, colour), image)
    assert stated_size(data) == (20, 12)


@pytest.mark.parametrize("orientation", [1, 3, 6])
@pytest.mark.parametrize("kind", [3, 4])
def test_pixels_stay_where_they_were_whichever_byte_comes_first(orientation, kind):
    image = np.arange(12 * 20, dtype=np.uint16).reshape(12, 20)
    data = tagged(image, order=">", orientation=orientation, kind=kind)
    found = decode("a.tif", data, cv2.IMREAD_GRAYSCALE)
    np.testing.assert_array_equal(found, image)
    # An upright one has to be one, for readers that mind.
    upright = tagged(image, order=">", orientation=1, kind=kind)
    assert as_stored(data) == upright


@pytest.mark.parametrize("kind", [1, 4])
def test_an_orientation_may_be_written_with_more_or_fewer_bytes(kind):
    image = np.arange(12 * 20, dtype=np.uint8).reshape(12, 20)
    data = tagged(image, orientation=6, kind=kind)
    found = decode("a.tif", data, cv2.IMREAD_GRAYSCALE)
    np.testing.assert_array_equal(found, image)


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_a_tiff_whose_zero_is_white_is_no_negative(depth):
    image = np.arange(12 * 20, dtype=depth).reshape(12, 20)
    most = np.iinfo(depth).max
    data = tagged(most - image, photometric=0)
    found = decode("a.tif", data, cv2.IMREAD_GRAYSCALE)
    np.testing.assert_array_equal(found, image)


def test_a_picture_of_another_size_than_stated_is_refused(monkeypatch, photograph):
    turned = np.ascontiguousarray(photograph.T)
    monkeypatch.setattr(cv2, "imdecode", lambda data, mode: turned)
    data = cv2.imencode(".png", photograph)[1].tobytes()
    with pytest.raises(InputError, match=r"a.png: found \d+ x \d+ px, but its header"):
        decode("a.png", data, cv2.IMREAD_GRAYSCALE)


def test_a_tiff_of_64_bit_places_is_read_and_refused_where_they_lead_nowhere(tmp_path):
    image = np.arange(64 * 48, dtype=np.uint8).reshape(48, 64)
    tags = {256: 64, 257: 48, 258: 8, 259: 1, 262: 1, 273: 16, 277: 1, 278: 48}
    tags |= {279: image.size}
    entries = [struct.pack("<HHQQ", tag, 4, 1, value) for tag, value in tags.items()]
    directory = struct.pack("<Q", len(tags)) + b"".join(entries) + bytes(8)
    for place in (16 + image.size, 0, 1 << 40, 1 << 63, (1 << 64) - 1):
        header = b"II+\0" + struct.pack("<HHQ", 8, 0, place)
        refused = is_seen(tmp_path / "a.tif", header + image.tobytes() + directory)
        assert refused == (place != 16 + image.size)


def test_damage_is_seen_without_a_standard_error_too(tmp_path, photograph):
    data = tiff(photograph, LZW)
    usual = os.dup(2)
    os.close(2)
    try:
        seen = is_seen(tmp_path / "a.tif", spoilt(data, len(data) // 2, "garbage"))
        with pytest.raises(OSError, match="Bad file descriptor"):
            os.fstat(2)
    finally:
        os.dup2(usual, 2)
        os.close(usual)
    assert seen
