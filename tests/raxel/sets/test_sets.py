"""Image sets: what is written is read back, images come as the sensor had them."""

import struct

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.errors import InputError
from raxel.sets import (
    ActiveGrid,
    Chessboard,
    ImageSet,
    Pattern,
    View,
    load_reference,
    load_set,
    read_colour,
    read_image,
    write_set,
)
from raxel.sets.image_files import has_orientation
from raxel.sets.model import Motion
from tests.image_sets import HEIGHT, WIDTH, description, write_description

SIZE = HEIGHT, WIDTH
FORMATS = ["png", "jpg", "tif", "bmp"]


def empty_images(folder, *names):
    for name in names:
        (folder / name).write_bytes(b"")


def made_image(depth=np.uint8, colours=1):
    """An image whose every pixel differs from its mirror images."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    grey = (u / WIDTH + 2 * v / HEIGHT) / 3 * np.iinfo(depth).max
    image = np.rint(grey).astype(depth)
    return image if colours == 1 else np.dstack((image, image // 2, image // 4))


def one_image_set(folder, name, data):
    (folder / name).write_bytes(data)
    write_description(folder, description(0, views=[{"image": name}]))
    return load_set(folder)


def encoded(extension, image, *options):
    return cv2.imencode(f".{extension}", image, list(options))[1].tobytes()


texts = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]))
lengths = st.floats(-1e6, 1e6)
threes = st.tuples(lengths, lengths, lengths)
motions = st.none() | st.builds(Motion, threes, threes)
uses = st.sampled_from(["calibrate", "evaluate"])
counts = st.integers(3, 30)
pitches = st.none() | st.floats(0.01, 1000)
chessboards = st.builds(Chessboard, counts, counts, pitches) | st.just(
    Chessboard(None, None, None)
)
origins = st.dictionaries(st.sampled_from(["source", "licence", "note"]), texts)


@st.composite
def chessboard_views(draw):
    clicks = ((10.5, 20.25), (300.0, 25.0), (290.0, 200.0), (15.0, 210.0))
    return tuple(
        View(
            image=f"{index}.png",
            use=draw(uses),
            motion=draw(motions),
            outer_corners=draw(st.sampled_from([None, clicks])),
        )
        for index in range(draw(st.integers(1, 4)))
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sets")
    empty_images(folder, *(f"{i}.png" for i in range(20)), "white.png")
    return folder


@settings(max_examples=40)
@given(chessboards, chessboard_views(), texts, origins)
def test_chessboard_set_round_trips(folder, target, views, camera, origin):
    written = ImageSet(
        "a-set", WIDTH, HEIGHT, target, views, folder, camera, origin, truth="truth/"
    )
    write_set(written)
    assert load_set(folder) == written


@settings(max_examples=20)
@given(st.integers(1, 8), motions, st.none() | st.just((400.0, 300.0)))
def test_active_grid_set_round_trips(folder, bits, motion, size):
    patterns = [
        Pattern(f"{2 * b + int(i)}.png", "x", "gray", of=8, bit=b, inverse=i)
        for b in range(bits)
        for i in (False, True)
    ] + [
        Pattern(f"{16 + k}.png", "y", "phase", of=3, step=k, periods=8.5)
        for k in range(3)
    ]
    view = View(
        name="pose 1", white="white.png", patterns=tuple(patterns), motion=motion
    )
    target = ActiveGrid((1024, 768), size)
    written = ImageSet("a-set", WIDTH, HEIGHT, target, (view,), folder)
    write_set(written)
    assert load_set(folder) == written


def test_write_set_rejects_invalid_set(tmp_path):
    views = (View(image="missing.png"),)
    broken = ImageSet("a-set", WIDTH, HEIGHT, Chessboard(4, 3), views, tmp_path)
    with pytest.raises(InputError, match=r"views\[0\]\.image"):
        write_set(broken)
    assert list(tmp_path.iterdir()) == []


def test_float_counts_become_integers(tmp_path):
    empty_images(tmp_path, "view0.png")
    data = description(1)
    data["resolution"] = [320.0, 240.0]
    data["target"]["columns"] = 7.0
    write_description(tmp_path, data)
    loaded = load_set(tmp_path)
    assert isinstance(loaded.width, int)
    assert isinstance(loaded.target.columns, int)


def test_yaml_date_stays_text(tmp_path):
    empty_images(tmp_path, "view0.png")
    text = yaml.safe_dump(description(1)) + "origin: {source: 2026-01-31}\n"
    (tmp_path / "set.yaml").write_text(text)
    assert load_set(tmp_path).origin == {"source": "2026-01-31"}


def test_views_for_selects_by_use(tmp_path):
    empty_images(tmp_path, "a.png", "b.png")
    views = [{"image": "a.png", "use": "evaluate"}, {"image": "b.png"}]
    write_description(tmp_path, description(0, views=views))
    loaded = load_set(tmp_path)
    assert [v.label for v in loaded.views_for("calibrate")] == ["b.png"]
    assert [v.label for v in loaded.views_for("evaluate")] == ["a.png"]


def test_board_points_are_row_major():
    points = Chessboard(4, 3, 2.5).points()
    assert points.shape == (12, 2)
    assert points[:5].tolist() == [[0, 0], [2.5, 0], [5, 0], [7.5, 0], [0, 2.5]]
    assert Chessboard(None, None).points(3, 3)[-1].tolist() == [2, 2]
    with pytest.raises(ValueError, match="unknown"):
        Chessboard(None, None).points()


@pytest.mark.parametrize("extension", FORMATS)
def test_grey_images_are_unchanged(tmp_path, extension):
    image = made_image()
    loaded = one_image_set(tmp_path, f"a.{extension}", encoded(extension, image))
    read = read_image(loaded, loaded.views[0])
    assert read.dtype == np.uint8
    # JPEG may change a value by its quantisation, the others by nothing.
    assert np.abs(read.astype(int) - image).max() <= (6 if extension == "jpg" else 0)


@pytest.mark.parametrize("extension", ["png", "tif"])
def test_16_bit_images_keep_depth(tmp_path, extension):
    image = made_image(np.uint16)
    loaded = one_image_set(tmp_path, f"a.{extension}", encoded(extension, image))
    assert np.array_equal(read_image(loaded, "a." + extension), image)


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_read_colour_keeps_colour(tmp_path, depth):
    image = made_image(depth, colours=3)
    loaded = one_image_set(tmp_path, "a.png", encoded("png", image))
    assert np.array_equal(read_colour(loaded, "a.png"), image)
    grey = read_image(loaded, "a.png")
    assert (grey.shape, grey.dtype) == ((HEIGHT, WIDTH), depth)


def with_exif(jpeg, content):
    """The JPEG with an Exif segment after its start marker."""
    segment = b"Exif\0\0" + content
    header = b"\xff\xe1" + struct.pack(">H", len(segment) + 2)
    return jpeg[:2] + header + segment + jpeg[2:]


def orientation(value):
    """The Exif content that says only how the camera was turned."""
    entry = struct.pack("<HHIHH", 0x0112, 3, 1, value, 0)
    return b"II*\0" + struct.pack("<IH", 8, 1) + entry + struct.pack("<I", 0)


@pytest.mark.parametrize("read", [read_image, read_colour])
def test_exif_rotation_is_ignored(tmp_path, read):
    plain = encoded("jpg", made_image())
    rotated = with_exif(plain, orientation(6))
    decoded = cv2.imdecode(np.frombuffer(rotated, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert decoded.shape == (WIDTH, HEIGHT), "the tag is one that OpenCV obeys"
    loaded = one_image_set(tmp_path, "a.jpg", rotated)
    assert has_orientation(tmp_path / "a.jpg")
    kept = read(loaded, "a.jpg")
    assert np.array_equal(kept, cv2.imdecode(np.frombuffer(plain, np.uint8), 0))


VARIANTS = {
    "png": encoded("png", made_image()),
    "jpg": encoded("jpg", made_image()),
    "progressive jpg": encoded("jpg", made_image(), cv2.IMWRITE_JPEG_PROGRESSIVE, 1),
    "jpg with restarts": encoded("jpg", made_image(), cv2.IMWRITE_JPEG_RST_INTERVAL, 4),
    "jpg with exif": with_exif(encoded("jpg", made_image()), orientation(3)),
    "tif": encoded("tif", made_image()),
    "plain tif": encoded("tif", made_image(), cv2.IMWRITE_TIFF_COMPRESSION, 1),
    "bmp": encoded("bmp", made_image()),
    "pgm": encoded("pgm", made_image()),
    "webp": encoded("webp", made_image()),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_truncated_file_is_rejected_by_name(tmp_path, variant):
    data = VARIANTS[variant]
    loaded = one_image_set(tmp_path, "a.img", data)
    assert read_image(loaded, "a.img").shape == (HEIGHT, WIDTH)
    for share in np.linspace(0, 0.98, 12):
        (tmp_path / "a.img").write_bytes(data[: int(share * len(data))])
        with pytest.raises(InputError, match=r"a\.img: "):
            read_image(loaded, "a.img")


def test_truncated_file_with_thumbnail_is_rejected(tmp_path):
    whole = encoded("jpg", made_image())
    data = with_exif(whole, encoded("jpg", made_image()[:16, :16]))
    loaded = one_image_set(tmp_path, "a.jpg", data)
    assert read_image(loaded, "a.jpg").shape == (HEIGHT, WIDTH)
    (tmp_path / "a.jpg").write_bytes(data[: len(data) - len(whole) // 2])
    with pytest.raises(InputError, match=r"a\.jpg: "):
        read_image(loaded, "a.jpg")


def test_changed_png_byte_is_rejected(tmp_path):
    data = bytearray(encoded("png", made_image()))
    data[len(data) // 2] ^= 0x10
    loaded = one_image_set(tmp_path, "a.png", bytes(data))
    with pytest.raises(InputError, match=r"a\.png: "):
        read_image(loaded, "a.png")


@pytest.mark.parametrize("stretch", [b"", b"\xff" * 200, b"\xff\xd9"])
def test_jpeg_with_missing_part_is_rejected(tmp_path, capfd, stretch):
    """Its end is there; libjpeg would fill in grey."""
    data = encoded("jpg", np.random.default_rng(3).integers(0, 255, SIZE, np.uint8))
    middle = len(data) // 2
    image_set = one_image_set(tmp_path, "a.jpg", data[:middle] + stretch + data[-2:])
    with pytest.raises(InputError, match=r"a\.jpg: "):
        read_image(image_set, "a.jpg")
    assert capfd.readouterr().err == ""


def test_harmless_decoder_warnings_are_suppressed(tmp_path, capfd):
    """Some cameras write bytes before the end marker."""
    data = encoded("jpg", made_image())
    image_set = one_image_set(tmp_path, "a.jpg", data[:-2] + bytes(8) + data[-2:])
    assert np.abs(read_image(image_set, "a.jpg").astype(int) - made_image()).max() < 8
    assert capfd.readouterr().err == ""


def test_float_samples_are_rejected(tmp_path):
    data = encoded("tif", made_image().astype(np.float32))
    loaded = one_image_set(tmp_path, "a.tif", data)
    with pytest.raises(InputError, match="float32"):
        read_image(loaded, "a.tif")


def test_set_without_reference_has_no_corners(tmp_path):
    assert load_reference(one_image_set(tmp_path, "a.png", VARIANTS["png"])) == {}
