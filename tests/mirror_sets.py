"""Mirror sets of grey images on disk, for tests of what reads mirror.yaml."""

import cv2
import numpy as np
import yaml

from tests.image_sets import description, write_description

BOARDS = ("viewer", "plate", "stages")
POSITIONS = ("near", "far")
CODE = [
    {"image": "p0.png", "axis": "x", "kind": "phase", "step": 0, "of": 3, "periods": 8},
    {"image": "p1.png", "axis": "x", "kind": "phase", "step": 1, "of": 3, "periods": 8},
    {"image": "p2.png", "axis": "x", "kind": "phase", "step": 2, "of": 3, "periods": 8},
]
MONITOR = {"kind": "active_grid", "monitor_px": [800, 600], "monitor_mm": [400, 300]}


def mirror_description(**changes):
    """The content of a mirror.yaml in order."""
    steps = [
        {"before": "view0.png", "after": "view1.png", "deflection_mm": 5.0},
        {"before": "view1.png", "after": "view2.png", "evaluate": ["view3.png"]},
    ]
    return {
        "raxel_mirror_set": 1,
        "name": "bent",
        "viewer": "viewer",
        "primary": {
            "grids": "grids",
            "platter": "platter",
            "plate": "plate",
            "thickness_mm": 1.27,
        },
        "clamp": {"points": [[10, 20], [12, 200]], "sd_px": 0.5},
        "stages": {"set": "stages", "steps": steps},
    } | changes


def write_mirror_set(folder, data=None, **of_sets):
    """A mirror set of grey images; of_sets: name of an image set -> changes."""
    for name in BOARDS:
        count = 2 if name == "plate" else 4
        changed = description(count, **of_sets.get(name, {}))
        _write(folder / name, changed)
    for name in ("grids", "platter"):
        views = [
            {"name": position, "patterns": code(k)}
            for k, position in enumerate(POSITIONS)
        ]
        changed = description(0, target=MONITOR, views=views) | of_sets.get(name, {})
        _write(folder / name, changed)
    text = yaml.safe_dump(data or mirror_description(), sort_keys=False)
    (folder / "mirror.yaml").write_text(text, "utf-8")


def code(k):
    """The patterns of position k, separate images."""
    return [pattern | {"image": f"{k}-{pattern['image']}"} for pattern in CODE]


def _write(folder, data):
    folder.mkdir(parents=True)
    grey = np.full(data["resolution"][::-1], 90, np.uint8)
    for view in data["views"]:
        names = (
            [view["image"]]
            if "image" in view
            else [pattern["image"] for pattern in view["patterns"]]
        )
        for name in names:
            (folder / name).write_bytes(cv2.imencode(".png", grey)[1].tobytes())
    write_description(folder, data)
