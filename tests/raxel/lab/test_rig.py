"""Rig files: what those of the repository say, poses in view, one-line refusals."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from raxel.cameras import FisheyeCamera
from raxel.errors import InputError
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.lab import rig as rig_limits
from raxel.lab.rig import load_rig, pattern_plan
from raxel.lab.target_poses import AroundPoses, DrawnPoses, Visibility, outline_of
from tests.raised import raises_line

RIGS = sorted((Path(__file__).resolve().parents[3] / "data" / "rigs").glob("*.yaml"))
ORIGINS = {"thesis", "data sheet", "physics", "choice"}


def leaf(value, unit):
    return {"value": value, "unit": unit, "origin": "choice", "reason": "a test"}


def small_rig():
    """Plain data of a small rig: a fisheye and a board of 4 x 3 corners."""
    return {
        "raxel_rig": 1,
        "name": "small",
        "camera": {
            "kind": "fisheye",
            "projection": "equidistance",
            "focal_px": leaf(100, "px"),
            "principal_point": leaf([79.5, 59.5], "px"),
            "max_angle": leaf(80, "deg"),
            "width": leaf(160, "px"),
            "height": leaf(120, "px"),
        },
        "sensor": {
            "white": leaf(9000, "e"),
            "full_well": leaf(10000, "e"),
            "bits": leaf(8, "bit"),
        },
        "target": {
            "kind": "chessboard",
            "columns": leaf(4, "1"),
            "rows": leaf(3, "1"),
            "pitch": leaf(10, "mm"),
            "border": leaf(10, "mm"),
        },
        "poses": {
            "kind": "drawn",
            "count": leaf(2, "1"),
            "distance": leaf([100, 140], "mm"),
            "off_axis": leaf([0, 10], "deg"),
            "tilt": leaf([5, 30], "deg"),
            "turn": leaf([-20, 20], "deg"),
            "margin": leaf(3, "px"),
            "least_spacing": leaf(4, "px"),
        },
    }


def changed(path, **changes):
    """Write the small rig with `section__field=value`, None taking a field out."""
    data = small_rig()
    for name, value in changes.items():
        *sections, field = name.split("__")
        part = data
        for section in sections:
            part = part[section]
        part.pop(field, None)
        if value is not None:
            part[field] = value
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return path


@pytest.mark.parametrize("path", RIGS, ids=lambda path: path.stem)
def test_repository_rigs_are_valid(path):
    rig = load_rig(path)
    assert rig.name == path.stem
    assert rig.laboratory().camera is rig.camera
    assert rig.camera.width >= 640 or path.stem.endswith("-small")
    leaves = list(quantities(yaml.safe_load(path.read_text(encoding="utf-8"))))
    assert len(leaves) > 20
    for quantity in leaves:
        assert quantity["origin"] in ORIGINS
        assert len(quantity["reason"]) > 5


def quantities(data):
    if isinstance(data, dict) and "value" in data and "unit" in data:
        yield data
    elif isinstance(data, dict):
        for part in data.values():
            yield from quantities(part)


@pytest.mark.parametrize("path", RIGS, ids=lambda path: path.stem)
def test_drawn_poses_show_whole_target(path):
    rig = load_rig(path)
    count = min(4, rig.count + rig.evaluate)
    poses = rig.draw_poses(np.random.default_rng(1), count)
    assert poses.shape == (count, 4, 4)
    corner, size = rig.extent
    box = corner + np.array([[0, 0], [0, 1], [1, 0], [1, 1]]) * size
    assert all(map(rig.shows, poses))
    # Facets show a target in pieces, and some monitors may reach beyond the image.
    whole = rig.camera.continuous and rig.visibility.whole
    for T in poses if whole else ():
        pixels, valid = rig.camera.project(transform(T, on_plane(box)))
        assert valid.all()
        assert rig.camera.in_image(pixels).all()
        assert np.all(rig.camera.rays(pixels).directions @ T[:3, 2] > 0)


def test_poses_respect_ranges_and_seed(tmp_path):
    rig = load_rig(changed(tmp_path / "rig.yaml"))
    poses = rig.draw_poses(np.random.default_rng(3), 60)
    np.testing.assert_array_equal(
        poses[:20], rig.draw_poses(np.random.default_rng(3), 20)
    )
    corner, size = rig.extent
    middle = transform(poses, np.array([[*(corner + size / 2), 0.0]]))[:, 0]
    distance = np.linalg.norm(middle, axis=1)
    assert 100 <= distance.min() < 110 < 130 < distance.max() <= 140
    assert np.degrees(np.arccos(middle[:, 2] / distance)).max() <= 10 + 1e-9
    tilt = np.degrees(np.arccos(np.sum(middle * poses[:, :3, 2], axis=1) / distance))
    assert 5 <= tilt.min() < 12 < 24 < tilt.max() <= 30


def test_out_of_view_poses_are_rejected(tmp_path):
    rig = load_rig(changed(tmp_path / "rig.yaml"))
    assert rig.shows(pose(np.eye(3), [-15, -10, 120]))
    assert not rig.shows(pose(np.eye(3), [90, -10, 120]))
    assert not rig.shows(pose(np.eye(3), [-15, -10, -120]))
    assert not rig.shows(pose(np.eye(3), [-15, -10, 900]))
    back = rotation_from_vector(np.array([0, np.pi, 0]))
    assert not rig.shows(pose(back, [15, -10, 120]))


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [-1, 1])
def test_margin_applies_to_all_borders(axis, sign):
    """Of an image of 160 x 120 px that a lens of 100 px a radian looks at squarely."""
    lens = FisheyeCamera("equidistance", 100, [79.5, 59.5], 160, 120)
    visible = Visibility(margin_px=10.0)
    outline = outline_of([-10, -10], [20, 20])
    lattice = np.stack(np.meshgrid([-5, 0, 5], [-5, 0, 5]), axis=-1)

    def fault(distance_px):
        shift = np.zeros(3)
        edge = 120 * np.tan(((80, 60)[axis] - distance_px) / 100)
        shift[axis], shift[2] = sign * (edge - 10), 120
        return visible.fault(lens, pose(np.eye(3), shift), outline, lattice)

    assert fault(11) == ""
    assert fault(9) == "too near the image's border"


def test_listed_poses_keep_order(tmp_path):
    entry = {"translation": leaf([-15, -10, 120], "mm")}
    entry["rotation"] = leaf([0, 20, 0], "deg")
    poses = {"kind": "listed", "margin": leaf(3, "px"), "least_spacing": leaf(4, "px")}
    far = entry | {"translation": leaf([400, -10, 120], "mm")}
    path = changed(tmp_path / "rig.yaml", poses=poses | {"list": [entry, entry]})
    rig = load_rig(path)
    drawn = rig.draw_poses(np.random.default_rng(0), 2)
    expected = rotation_from_vector(np.radians([0, 20, 0]))
    np.testing.assert_allclose(drawn[1], pose(expected, [-15, -10, 120]), atol=1e-15)
    rig = load_rig(changed(tmp_path / "far.yaml", poses=poses | {"list": [far]}))
    with pytest.raises(InputError, match=r"far.yaml: poses.list\[0\]: "):
        rig.draw_poses(np.random.default_rng(0), 1)


MIRROR = {
    "kind": "quadric mirror",
    "viewer": {
        "kind": "perspective",
        "K": leaf([[200, 0, 79.5], [0, 200, 59.5], [0, 0, 1]], "px"),
        "radial": leaf([], "1"),
        "width": leaf(160, "px"),
        "height": leaf(120, "px"),
    },
    "shape": "hyperboloid",
    "axes": leaf([30, 15], "mm"),
    "rim_radius": leaf(20, "mm"),
}


BAD = {
    "behind": (
        {"camera": MIRROR | {"offset": leaf([0, 0, -500], "mm")}},
        "camera.T_viewer_mirror: ",
    ),
    "mirror key": (
        {"camera": MIRROR | {"rim_radios": leaf(20, "mm")}},
        "camera.rim_radios: .*rim_radius",
    ),
    "nested": (
        {"camera": MIRROR | {"viewer": MIRROR["viewer"] | {"K": leaf([[1]], "px")}}},
        "camera.viewer.K: ",
    ),
    "pitch": ({"target__pitch": leaf(-10, "mm")}, "target.pitch.value: found -10"),
    "field of view": ({"camera__max_angle": leaf(200, "deg")}, "camera.max_angle: "),
    "exposure": ({"sensor__white": leaf(0, "e")}, "sensor.white.value: found 0"),
    "unit": ({"target__pitch": leaf(1, "cm")}, "target.pitch.unit: found 'cm'"),
    "camera unit": (
        {"camera__focal_px": leaf(3, "mm")},
        "camera.focal_px.unit: found 'mm'",
    ),
    "key": ({"sensor__ful_well": leaf(1, "e")}, "sensor.ful_well: .*full_well"),
    "camera key": (
        {"camera__focal": leaf(100, "px"), "camera__focal_px": None},
        r"camera.focal: .*focal_px\?",
    ),
    "camera kind": ({"camera__kind": "fishey"}, "camera.kind: .*fisheye"),
    "reason": (
        {"target__pitch": {"value": 10, "unit": "mm", "origin": "choice"}},
        "target.pitch.reason: key missing",
    ),
    "origin": (
        {"target__pitch": leaf(10, "mm") | {"origin": "guess"}},
        "target.pitch.origin: found 'guess'",
    ),
    "bare number": ({"target__pitch": 10}, "target.pitch: found 10"),
    "missing": ({"target__pitch": None}, "target.pitch: key missing"),
    "order": ({"poses__distance": leaf([140, 100], "mm")}, "poses.distance.value: "),
    "two curves": (
        {
            "sensor__gamma": leaf(2.2, "1"),
            "sensor__response": {
                "charge": leaf([0, 1], "1"),
                "value": leaf([0, 1], "1"),
            },
        },
        "sensor.response: redundant with gamma",
    ),
    "falloff": (
        {
            "optics": {
                "falloff": {"radius": leaf([9, 5], "px"), "light": leaf([1, 0], "1")}
            }
        },
        "optics.falloff: 2 radii and 2 shares",
    ),
    "no pattern": (
        {
            "target": {
                "kind": "active_grid",
                "monitor_px": leaf([64, 48], "px"),
                "monitor_mm": leaf([64, 48], "mm"),
                "gamma": leaf(2.2, "1"),
            }
        },
        "target.gray_bits: ",
    ),
    "version": ({"raxel_rig": 2}, "raxel_rig: found 2"),
}


@pytest.mark.parametrize("case", BAD)
def test_invalid_rigs_are_rejected_with_file_and_field(tmp_path, case):
    changes, message = BAD[case]
    path = changed(tmp_path / "bad.yaml", **changes)
    with raises_line(f"bad.yaml: {message}"):
        load_rig(path)


def test_rig_exceeding_memory_is_rejected(tmp_path, monkeypatch):
    monkeypatch.setattr(rig_limits, "physical_memory", lambda: 2e6)
    path = changed(tmp_path / "large.yaml")
    with pytest.raises(InputError, match=r"large.yaml: camera.width: "):
        load_rig(path)


def test_impossible_pose_ranges_are_rejected(tmp_path):
    path = changed(tmp_path / "near.yaml", poses__distance=leaf([20, 25], "mm"))
    with raises_line(r"near.yaml: poses: 0 of 2 "):
        load_rig(path).draw_poses(np.random.default_rng(0), 2)


def test_missing_rig_file_is_rejected(tmp_path):
    (tmp_path / "text.yaml").write_text("hello")
    for name, fault in (("none", ""), ("text", ": found 'hello'")):
        with pytest.raises(InputError, match=rf"{name}\.yaml{fault}"):
            load_rig(tmp_path / f"{name}.yaml")


def test_target_origin_does_not_change_image():
    """Its four corners subtend the angle wanted; its middle is what is placed."""
    angles = {"tilt": (0, 0.5), "turn": (0, 1.0)}
    centre, size = np.array([10.0, -5, 3]), np.array([200.0, 140])
    around = AroundPoses(
        tuple(centre), (0.2, -0.1, 1), polar=(0.4, 0.4), subtense=(0.5, 0.5), **angles
    )
    drawn = DrawnPoses((300, 500), off_axis=(0, 0.3), **angles)
    for poses in (around, drawn):
        middles = []
        for corner in (np.zeros(2), np.array([-30.0, 70])):
            T = poses._one(np.random.default_rng(4), corner, size)
            middles.append(transform(T, on_plane((corner + size / 2)[None]))[0])
            if poses is around:
                box = corner + size * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
                lines = transform(T, on_plane(box)) - centre
                lines /= np.linalg.norm(lines, axis=1, keepdims=True)
                widest = np.arccos((lines @ lines.T).min())
                assert widest == pytest.approx(0.5, abs=1e-6)
        np.testing.assert_allclose(*middles, atol=1e-9)


def test_plan_of_cells_has_given_steps():
    given = {"monitor_px": (640, 480), "cells": 8}
    assert pattern_plan(given | {"phase_steps": 5}).phase_steps == 5
    assert pattern_plan(given).gray_bits == (3, 3)
