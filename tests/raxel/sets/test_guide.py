"""The guide to recorded images, data/recorded/README.md, matches the code."""

import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from raxel.io.documents import faults
from raxel.sets import load_set, read_image
from raxel.sets.image_set import SCHEMA
from raxel.sets.mirror_set import SCHEMA as MIRROR_SCHEMA
from tests.image_sets import write_description

GUIDE = (Path(__file__).parents[3] / "data/recorded/README.md").read_text("utf-8")
DESCRIPTION, CHARUCO, TAGS, CIRCLES, GRID, MIRROR, BY_HAND = map(
    yaml.safe_load, re.findall(r"```yaml\n(.*?)```", GUIDE, re.DOTALL)
)


def test_guide_names_every_key_of_image_sets():
    schema = json.loads(SCHEMA.read_text("utf-8"))
    names = "chessboard", "chessboard_view", "charuco", "charuco_view"
    names += "aprilgrid", "circles"
    names += "active_grid", "active_grid_view", "gray_pattern", "phase_pattern"
    parts = [schema["$defs"][name] for name in names]
    keys = {key for part in (schema, *parts) for key in part["properties"]}
    # Only rendered sets have a truth.
    assert keys - {"truth"} - set(re.findall(r"\w+", GUIDE)) == set()


PLAIN = [{"image": "first.jpg"}]
EXAMPLES = [{"views": DESCRIPTION["views"]}, {"views": BY_HAND}]
EXAMPLES += [CHARUCO, TAGS, CIRCLES]


@pytest.mark.parametrize("change", EXAMPLES)
def test_guide_examples_are_valid_sets(tmp_path, change):
    views = change.get("views", PLAIN)
    width, height = DESCRIPTION["resolution"]
    for view in views:
        cv2.imwrite(str(tmp_path / view["image"]), np.zeros((height, width), np.uint8))
    write_description(tmp_path, DESCRIPTION | {"views": views} | change)
    image_set = load_set(tmp_path)
    assert len(image_set.views) == len(views)
    assert read_image(image_set, image_set.views[0]).shape == (height, width)


def test_guide_monitor_example_is_valid(tmp_path):
    (view,) = GRID["views"]
    for name in [view["white"], view["black"], *(p["image"] for p in view["patterns"])]:
        (tmp_path / name).write_bytes(b"")
    write_description(tmp_path, DESCRIPTION | GRID)
    image_set = load_set(tmp_path)
    assert len(image_set.views[0].patterns) == len(view["patterns"])
    assert image_set.target.monitor_mm == (527, 296)


def keys_of(part):
    """Every key that a part of a JSON schema knows, however deep."""
    if not isinstance(part, dict):
        return set()
    inner = [*part.get("properties", {}).values(), part.get("items")]
    return set(part.get("properties", {})).union(*map(keys_of, inner))


def test_guide_mirror_example_is_valid_and_complete():
    assert faults(MIRROR, "mirror.yaml", MIRROR_SCHEMA) == []
    known = keys_of(json.loads(MIRROR_SCHEMA.read_text("utf-8")))
    assert {"hidden_mm", "before", "thickness_mm", "set"} <= known
    assert known - set(re.findall(r"\w+", GUIDE)) == set()
