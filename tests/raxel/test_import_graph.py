"""Who may import whom: nothing later is imported by anything earlier, in no circle."""

from itertools import pairwise

import pytest

from tests.import_graph import (
    Arrow,
    arrows_between,
    checkout,
    circle_in,
    inside,
    modules_below,
)

# The rooms of raxel, lowest first: a module imports from its own room and from those
# before it.
ROOMS = (
    "errors",
    "io",
    "geometry",
    "cameras",
    "sets",
    "lab",
    "features",
    "calibration",
    "multiview",
    "evaluation",
    "formats",
    "report",
    "show",
    "compile_loops",
    "cli",
    "__main__",
)
# Subpackages of raxel, lowest first, and their permitted imports within the package.
INNER_ROOMS = {
    "raxel.calibration": {
        "views": (),
        "pose": (),
        "linear": (),
        "adjust": ("pose",),
        "generic": ("views", "pose", "linear", "adjust"),
        "parametric": ("views",),
        "smooth": ("parametric", "generic"),
        "mirror": ("views", "pose", "generic", "parametric"),
    },
    "raxel.cameras": {
        "core": (),
        "lenses": ("core",),
        "linear": ("core",),
        "mirrors": ("core", "linear"),
        "tables": ("core",),
    },
    "raxel.features.active_grid": {"checks": ("coding", "phase_unwrapping")},
}
# Modules at their level that may import them, and the package itself.
ABOVE_ROOMS = {
    "raxel.calibration": (),
    "raxel.cameras": ("registry", "io"),
    "raxel.features.active_grid": ("view",),
}
# The rooms of repro, lowest first; its own files stand above them.
REPRO_ROOMS = ("judge", "run", "page", "site", "workflow")
# All that the book-keeping may know of raxel; none of it knows of cameras. The page of
# an image set is what the command writes.
REPRO_MAY_IMPORT = ("raxel.cli", "raxel.errors", "raxel.io", "raxel.sets", "raxel.show")
# What all chapters may import of one another.
SHARED = "chapters.shared"


def listed(arrows):
    return "\n".join(map(str, arrows))


def room(module):
    """raxel.cameras.io -> cameras; raxel itself -> ''."""
    return module.partition(".")[2].partition(".")[0]


def chapter(module):
    """chapters.ch02_x.s1.page -> chapters.ch02_x."""
    return ".".join(module.split(".")[:2])


def upward(arrows, package, height):
    """Arrows from a room of a package to a higher one; height: room -> number."""
    return [
        a
        for a in arrows
        if inside(a.importer, package)
        and inside(a.imported, package)
        and height(room(a.imported)) > height(room(a.importer))
    ]


def upward_in_raxel(arrows):
    return upward(arrows, "raxel", ("", *ROOMS).index)


def upward_in_repro(arrows):
    def height(name):
        return REPRO_ROOMS.index(name) if name in REPRO_ROOMS else len(REPRO_ROOMS)

    return upward(arrows, "repro", height)


def inner_room(module, package):
    """raxel.cameras.core.base in raxel.cameras -> core; the package itself -> ''."""
    return module.removeprefix(package).removeprefix(".").partition(".")[0]


def between_inner_rooms(arrows):
    return [a for package in INNER_ROOMS for a in arrows if astray(a, package)]


def astray(arrow, package):
    """Whether an arrow inside a package goes from a room, or into one, and may not."""
    if not (inside(arrow.importer, package) and inside(arrow.imported, package)):
        return False
    rooms = INNER_ROOMS[package]
    source = inner_room(arrow.importer, package)
    target = inner_room(arrow.imported, package)
    if source == target:
        return False
    if source in rooms:
        return target not in rooms[source]
    return target in rooms and source not in ("", *ABOVE_ROOMS[package])


def out_of_raxel(arrows):
    return [
        a
        for a in arrows
        if inside(a.importer, "raxel") and not inside(a.imported, "raxel")
    ]


def out_of_repro(arrows):
    return [
        a
        for a in arrows
        if inside(a.importer, "repro")
        and not any(inside(a.imported, name) for name in ("repro", *REPRO_MAY_IMPORT))
    ]


def between_chapters(arrows):
    return [
        a
        for a in arrows
        if inside(a.importer, "chapters")
        and inside(a.imported, "chapters")
        and chapter(a.imported) not in (chapter(a.importer), "chapters", SHARED)
    ]


RULES = {
    "a room of raxel imports a later one": upward_in_raxel,
    "a room inside a package of raxel imports what it may not": between_inner_rooms,
    "a room of repro imports a higher one": upward_in_repro,
    "raxel imports something outside itself": out_of_raxel,
    "repro imports more of raxel than it may, or a chapter": out_of_repro,
    "a chapter imports another one": between_chapters,
}


def test_every_package_has_a_layer():
    found = {room(name) for name in checkout()[0] if inside(name, "raxel")} - {""}
    assert found <= set(ROOMS)


def test_every_subpackage_has_a_layer():
    for package, rooms in INNER_ROOMS.items():
        deep = [m for m in checkout()[0] if m.startswith(f"{package}.")]
        found = {
            inner_room(m, package)
            for m in deep
            if m.count(".") > package.count(".") + 1
        }
        assert found == set(rooms)


def test_subpackages_are_listed_lowest_first():
    for rooms in INNER_ROOMS.values():
        order = list(rooms)
        for name, below in rooms.items():
            known = [order.index(other) for other in below if other in rooms]
            assert all(place < order.index(name) for place in known), name


def test_imports_have_no_cycle():
    circle = circle_in(checkout()[1])
    assert not circle, f"a circle:\n{listed(circle)}"


@pytest.mark.parametrize("rule", RULES)
def test_imports_respect_layers(rule):
    wrong = RULES[rule](checkout()[1])
    assert not wrong, f"{rule}:\n{listed(wrong)}"


def written(root, files):
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    modules = modules_below(root, ("lib/raxel", "lib/repro", "chapters"))
    return arrows_between(modules, root)


SOUND = {
    "lib/raxel/__init__.py": "",
    "lib/raxel/errors.py": "",
    "lib/raxel/cameras/__init__.py": "from raxel.cameras.base import Camera\n",
    "lib/raxel/cameras/base.py": "import numpy\nfrom raxel.errors import InputError\n",
    "lib/raxel/cameras/lenses/b.py": "",
    "lib/raxel/calibration/pose/b.py": "",
    "lib/raxel/features/active_grid/checks/__init__.py": "",
    "lib/raxel/sets/__init__.py": "from . import model\n",
    "lib/raxel/sets/model.py": "from ..errors import InputError\n",
    "lib/repro/page.py": "from raxel.errors import InputError\n",
    "chapters/__init__.py": "",
    "chapters/shared/boards.py": "import raxel.cameras.base\n",
    "chapters/ch02_a/page.py": "from chapters.shared.boards import board\n",
    "chapters/ch03_b/page.py": "from repro.page import Page\n",
}


def test_import_graph_reads_valid_tree(tmp_path):
    arrows = written(tmp_path, SOUND)
    assert set(arrows) == {
        Arrow("raxel.cameras", "raxel.cameras.base", "lib/raxel/cameras/__init__.py:1"),
        Arrow("raxel.cameras.base", "raxel.errors", "lib/raxel/cameras/base.py:2"),
        Arrow("raxel.sets", "raxel.sets.model", "lib/raxel/sets/__init__.py:1"),
        Arrow("raxel.sets.model", "raxel.errors", "lib/raxel/sets/model.py:1"),
        Arrow("repro.page", "raxel.errors", "lib/repro/page.py:1"),
        Arrow(
            "chapters.shared.boards",
            "raxel.cameras.base",
            "chapters/shared/boards.py:1",
        ),
        Arrow(
            "chapters.ch02_a.page",
            "chapters.shared.boards",
            "chapters/ch02_a/page.py:1",
        ),
        Arrow("chapters.ch03_b.page", "repro.page", "chapters/ch03_b/page.py:1"),
    }
    assert circle_in(arrows) == []
    assert not any(rule(arrows) for rule in RULES.values())


@pytest.mark.parametrize(
    ("rule", "file", "line"),
    [
        (upward_in_raxel, "lib/raxel/errors.py", "from raxel.sets import model"),
        (upward_in_raxel, "lib/raxel/cameras/base.py", "import raxel.sets.model"),
        (
            between_inner_rooms,
            "lib/raxel/cameras/core/a.py",
            "from raxel.cameras.lenses.b import Lens",
        ),
        (
            between_inner_rooms,
            "lib/raxel/cameras/core/a.py",
            "from raxel.cameras import Camera",
        ),
        (
            between_inner_rooms,
            "lib/raxel/calibration/views/a.py",
            "import raxel.calibration.pose.b",
        ),
        (
            between_inner_rooms,
            "lib/raxel/features/active_grid/decode.py",
            "from raxel.features.active_grid.checks import b",
        ),
        (upward_in_repro, "lib/repro/judge/a.py", "from repro.page import style"),
        (out_of_raxel, "lib/raxel/errors.py", "import repro.page"),
        (out_of_raxel, "lib/raxel/errors.py", "from chapters.ch02_a import page"),
        (out_of_repro, "lib/repro/page.py", "from raxel.cameras import Camera"),
        (out_of_repro, "lib/repro/page.py", "import chapters.ch02_a.page"),
        (between_chapters, "chapters/ch03_b/page.py", "import chapters.ch02_a.page"),
        (between_chapters, "chapters/guides/a.py", "from chapters.ch02_a import page"),
        (between_chapters, "chapters/shared/boards.py", "import chapters.ch03_b.page"),
    ],
)
def test_forbidden_import_in_function_is_reported(tmp_path, rule, file, line):
    hidden = f"def late():\n    {line}\n"
    (wrong,) = rule(written(tmp_path, SOUND | {file: hidden}))
    assert str(wrong).startswith(f"{file}:2: ")


def test_import_cycle_is_reported(tmp_path):
    files = SOUND | {
        "lib/raxel/cameras/base.py": "from raxel.cameras.io import load\n",
        "lib/raxel/cameras/io.py": (
            "from typing import TYPE_CHECKING\n\n"
            "if TYPE_CHECKING:\n    from raxel.cameras import Camera\n"
        ),
    }
    circle = circle_in(written(tmp_path, files))
    assert {arrow.place for arrow in circle} == {
        "lib/raxel/cameras/__init__.py:1",
        "lib/raxel/cameras/base.py:1",
        "lib/raxel/cameras/io.py:4",
    }
    assert all(one.imported == two.importer for one, two in pairwise(circle))
