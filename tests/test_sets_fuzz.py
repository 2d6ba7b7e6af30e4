"""Whatever is done to a set.yaml: it loads, or one InputError line says why not."""

import copy

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from raxel.errors import InputError
from raxel.sets import ImageSet, load_set
from tests.image_sets import description

CLICKS = [[10, 20], [200, 25], [190, 200], [15, 210]]
CHESSBOARD = description(
    2,
    camera="drawn",
    origin={"source": "tests", "licence": "MIT"},
    truth="truth",
)
CHESSBOARD["views"][0] |= {"outer_corners": CLICKS, "use": "evaluate"}
CHESSBOARD["views"][1]["motion"] = {"translation_mm": [25, 0, 0]}
ACTIVE = {
    **description(0),
    "target": {"kind": "active_grid", "monitor_px": [64, 48], "monitor_mm": [30, 20]},
    "views": [
        {
            "name": "pose",
            "white": "view0.png",
            "patterns": [
                {"image": "view0.png", "axis": "x", "kind": "gray", "bit": 0, "of": 2},
                {"image": "view1.png", "axis": "x", "kind": "gray", "bit": 1, "of": 2},
            ],
        }
    ],
}
KEYS = ["image", "kind", "bit", "of", "views", "target", "use", "rows", "name", "x"]

odd = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(-2, 40),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["view0.png", "../view0.png", "/", ".", "chessboard", "gray"]),
    st.just(10**400),
)
values = st.recursive(
    odd,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(KEYS), inner, max_size=3)
    ),
    max_leaves=6,
)


def paths(data, path=()):
    yield path
    children = data.items() if isinstance(data, dict) else []
    children = enumerate(data) if isinstance(data, list) else children
    for key, child in children:
        yield from paths(child, (*path, key))


def at(data, path):
    for key in path:
        data = data[key]
    return data


def take_away(parent, key):
    del parent[key]


def duplicate(parent, key):
    if isinstance(parent, list):
        parent.append(copy.deepcopy(parent[key]))
    else:
        parent[f"{key}s"] = parent[key]


@st.composite
def mutated(draw):
    data = copy.deepcopy(draw(st.sampled_from([CHESSBOARD, ACTIVE])))
    for _ in range(draw(st.integers(1, 3))):
        path = draw(st.sampled_from(list(paths(data))))
        if not path:
            continue
        parent, key = at(data, path[:-1]), path[-1]
        how = draw(st.sampled_from(["replace", "take away", "duplicate"]))
        if how == "replace":
            parent[key] = draw(values)
        else:
            (take_away if how == "take away" else duplicate)(parent, key)
    return yaml.safe_dump(data, allow_unicode=True, sort_keys=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fuzz")
    for name in ("view0.png", "view1.png"):
        (folder / name).write_bytes(b"")
    return folder


def loads_or_says_why(folder, content):
    (folder / "set.yaml").write_bytes(content)
    try:
        loaded = load_set(folder)
    except InputError as fault:
        line = str(fault)
        assert line.startswith(f"{folder / 'set.yaml'}: ")
        assert line.isprintable()
        assert len(line) < 1000
    else:
        assert isinstance(loaded, ImageSet)


@settings(deadline=None)
@given(mutated())
def test_any_change_of_the_content(folder, text):
    loads_or_says_why(folder, text.encode())


BYTES = yaml.safe_dump(CHESSBOARD).encode()


@settings(deadline=None)
@given(st.integers(0, len(BYTES)), st.integers(0, 9), st.binary(max_size=6))
@example(0, len(BYTES), b"!!bool x")
@example(0, len(BYTES), b"? [a]\n: b")
@example(0, len(BYTES), b"a: ._\n")
@example(0, len(BYTES), b"a: !!timestamp x")
@example(0, len(BYTES), b"<<: {a: 1}")
@example(0, len(BYTES), b"= : 1")
@example(0, len(BYTES), b"a: =")
@example(0, len(BYTES), b"a: " + b"9" * 5000)
@example(0, len(BYTES), b'name: "\\ud800"')
def test_any_change_of_the_bytes(folder, start, length, inserted):
    content = BYTES[:start] + inserted + BYTES[start + length :]
    loads_or_says_why(folder, content)


def test_the_unchanged_descriptions_load(folder):
    for data in (CHESSBOARD, ACTIVE):
        (folder / "set.yaml").write_text(yaml.safe_dump(data))
        assert isinstance(load_set(folder), ImageSet)
