"""Any file is read or rejected with a one-line InputError that names it."""

import io
import json
from copy import deepcopy

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from raxel.cameras import load_camera
from raxel.errors import InputError
from raxel.features.boards import read_boards
from raxel.lab.rig import load_rig
from raxel.sets import (
    load_mirror_set,
    load_reference,
    load_set,
    read_colour,
    read_image,
)
from tests.image_sets import COLUMNS, HEIGHT, ROWS, WIDTH, boards, description
from tests.lab_cameras import EVERY, SIZE
from tests.mirror_sets import mirror_description, write_mirror_set
from tests.sample_rigs import rigs

FORMATS = ("png", "jpg", "tif", "bmp", "pgm", "webp")
PIXELS = np.random.default_rng(0).integers(0, 256, (HEIGHT, WIDTH), np.uint8)
MAX_LINE = 1500


def saved(camera):
    """The bytes of a camera's file."""
    stream = io.BytesIO()
    size = {"width": camera.width, "height": camera.height}
    np.savez_compressed(stream, kind=camera.kind, **size, **camera._fields())
    return stream.getvalue()


def found_boards():
    """The output of `raxel corners --json` for four boards."""
    one = {"found": True, "columns": COLUMNS, "rows": ROWS, "milliseconds": 3.0}
    one |= {"sd": [0.1] * (COLUMNS * ROWS), "partial": None, "reason": ""}
    images = [
        one | {"file": f"view{k}.png", "corners": board.corners().tolist()}
        for k, board in zip(range(4), boards(), strict=False)
    ]
    return {"set": "drawn", "detector": "raxel", "images": images}


def reference():
    """Reference corners of one image."""
    entry = {"corners": next(boards()).corners().tolist(), "uncertain": [3]}
    images = {"view0.png": entry | {"sd": 0.1, "spread_max_px": 0.6}}
    return {"columns": COLUMNS, "rows": ROWS, "images": images}


def read_set(folder):
    image_set = load_set(folder)
    read_image(image_set, image_set.views[0].files[0])


def read_every_image(folder):
    image_set = load_set(folder)
    assert read_image(image_set, "view0.png").shape == (HEIGHT, WIDTH)
    assert read_colour(image_set, "view0.png").shape[:2] == (HEIGHT, WIDTH)


def use_camera(folder):
    camera = load_camera(folder / "camera.npz")
    size = [SIZE["width"] + 20, SIZE["height"] + 20]
    pixels = np.random.default_rng(0).uniform(-20, size, (40, 2))
    rays = camera.rays(np.vstack([pixels, [[np.nan, 0], [np.inf, 0], [1e300, 1]]]))
    assert np.isfinite(rays.directions[rays.valid]).all()
    if camera.projects:
        seen = camera.project(rays.origins + 300 * rays.directions)
        assert np.isfinite(seen.pixels[seen.valid]).all()


def images():
    return [cv2.imencode(f".{one}", PIXELS)[1].tobytes() for one in FORMATS]


def cameras():
    return [saved(camera) for camera, _ in EVERY.values() if camera.kind != "general"]


# File -> (whole samples: plain data or bytes; what reads it, given the set's folder).
READERS = {
    "set.yaml": (lambda: [description(4, reference="reference.json")], read_set),
    "mirror.yaml": (lambda: [mirror_description()], load_mirror_set),
    "rig.yaml": (rigs, lambda folder: load_rig(folder / "rig.yaml")),
    "corners.json": (
        lambda: [found_boards()],
        lambda folder: read_boards(folder / "corners.json", load_set(folder)),
    ),
    "reference.json": (
        lambda: [reference()],
        lambda folder: load_reference(load_set(folder)),
    ),
    "view0.png": (images, read_every_image),
    "camera.npz": (cameras, use_camera),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A mirror set, next to the files of an image set."""
    folder = tmp_path_factory.mktemp("whole")
    write_mirror_set(folder)
    image = cv2.imencode(".png", PIXELS)[1].tobytes()
    for name, (samples, _) in READERS.items():
        (folder / name).write_bytes(written(name, samples()[0]))
    for k in range(4):
        (folder / f"view{k}.png").write_bytes(image)
    return folder


def written(name, sample):
    """The bytes of a sample."""
    if isinstance(sample, bytes):
        return sample
    write = yaml.safe_dump if name.endswith(".yaml") else json.dumps
    return write(sample).encode()


def places(data, path=()):
    """All paths to values in plain data."""
    yield path
    pairs = data.items() if isinstance(data, dict) else ()
    pairs = enumerate(data) if isinstance(data, list) else pairs
    for key, value in pairs:
        yield from places(value, (*path, key))


VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**30), 10**30)
    | st.floats()
    | st.text(max_size=8),
    lambda some: st.lists(some, max_size=4) | st.dictionaries(st.text(), some),
    max_leaves=6,
)


@st.composite
def changed(draw, sample):
    """Plain data with one value changed or removed."""
    *path, key = draw(st.sampled_from(list(places(sample))[1:]))
    data = deepcopy(sample)
    parent = data
    for step in path:
        parent = parent[step]
    if draw(st.booleans()):
        parent[key] = draw(VALUES)
    else:
        del parent[key]
    return data


@st.composite
def damaged(draw, content):
    """Bytes of which a part is replaced or missing."""
    start = draw(st.integers(0, len(content)))
    end = draw(st.integers(start, min(len(content), start + 400)) | st.just(start))
    return content[:start] + draw(st.binary(max_size=40)) + content[end:]


@pytest.mark.parametrize("name", READERS)
@settings(
    max_examples=50,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(data=st.data())
def test_damaged_file_is_read_or_rejected_in_one_line(name, folder, data):
    samples, read = READERS[name]
    sample = data.draw(st.sampled_from(samples()))
    if not isinstance(sample, bytes) and data.draw(st.booleans()):
        content = written(name, data.draw(changed(sample)))
    else:
        content = data.draw(damaged(written(name, sample)) | st.binary(max_size=60))
    whole = (folder / name).read_bytes()
    (folder / name).write_bytes(content)
    try:
        read(folder)
    except InputError as fault:
        line = str(fault)
        assert str(folder) in line
        assert line.isprintable()
        assert len(line) < MAX_LINE
    finally:
        (folder / name).write_bytes(whole)


@pytest.mark.parametrize("name", READERS)
def test_intact_file_is_read(name, folder):
    samples, read = READERS[name]
    whole = (folder / name).read_bytes()
    for sample in samples():
        (folder / name).write_bytes(written(name, sample))
        read(folder)
    (folder / name).write_bytes(whole)
