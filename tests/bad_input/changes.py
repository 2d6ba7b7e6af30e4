"""Changes that break a good image set, and reference corners to go with it."""

import yaml

ACTIVE_GRID = {"kind": "active_grid", "monitor_px": [1024, 768], "monitor_mm": None}


NEXT = {"image": "view1.png"}  # each image shows one pattern
GRAY = {"image": "view0.png", "axis": "x", "kind": "gray", "bit": 0, "of": 4}


PHASE = {"image": "view0.png", "axis": "x", "kind": "phase", "step": 0, "of": 3}


def edit(folder, change):
    """Apply `change` to the content of set.yaml."""
    path = folder / "set.yaml"
    data = yaml.safe_load(path.read_text())
    change(data)
    path.write_text(yaml.safe_dump(data, sort_keys=False))


def setting(*path, to):
    """A change that puts a value at a path of keys and indices."""

    def change(data):
        for key in path[:-1]:
            data = data[key]
        data[path[-1]] = to

    return change


def removing(*path):
    """A change that takes away what is at a path."""

    def change(data):
        for key in path[:-1]:
            data = data[key]
        del data[path[-1]]

    return change


def reference(count, columns=7, rows=5):
    corners = [[10.0 + i, 20.0] for i in range(count)]
    return {
        "columns": columns,
        "rows": rows,
        "images": {"view0.png": {"corners": corners}},
    }
