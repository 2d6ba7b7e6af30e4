"""Mirror cameras from files and plain fields, and mirrors that cannot be."""

import numpy as np
import pytest

from raxel.cameras import GeneralCamera, QuadricMirrorCamera, camera_from, load_camera
from raxel.errors import InputError
from raxel.geometry import pose
from tests.mirror_cameras import (
    CENTRAL,
    EVERY,
    HYPERBOLOID,
    MIRRORS,
    PARABOLOID,
    PARALLEL,
    PINHOLE,
    H,
    W,
    aligned,
    random_pixels,
)
from tests.raised import raises_line


@EVERY
def test_camera_file_roundtrip_is_bit_identical(name, tmp_path):
    camera = MIRRORS[name]
    camera.save(tmp_path / "camera.npz")
    back = load_camera(tmp_path / "camera.npz")
    pixels = random_pixels(12, 200)
    for ours, theirs in zip(back.rays(pixels), camera.rays(pixels), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert (back.central, back.parameters) == (camera.central, camera.parameters)


def test_mirror_camera_from_plain_fields():
    fields = {
        "viewer": {
            "kind": "orthographic",
            "pixels_per_mm": 8,
            "principal_point": [319.5, 239.5],
            "width": W,
            "height": H,
        },
        "shape": "paraboloid",
        "axes": [10],
        "rim_radius": 25,
        "T_viewer_mirror": np.diag([1.0, 1, 1, 1]).tolist(),
    }
    fields["T_viewer_mirror"][2][3] = 30.0
    camera = camera_from("quadric mirror", fields)
    assert camera.central
    assert camera.parameters == 4
    fields["viewer"]["pixel_per_mm"] = fields["viewer"].pop("pixels_per_mm")
    with pytest.raises(InputError, match=r"viewer.*pixels_per_mm\?"):
        camera_from("quadric mirror", fields)


def test_damaged_viewer_is_named(tmp_path):
    path = tmp_path / "camera.npz"
    CENTRAL["hyperboloid"].save(path)
    with np.load(path) as archive:
        fields = dict(archive)
    np.savez(path, **(fields | {"viewer.K": np.eye(2)}))
    with pytest.raises(InputError, match=r"camera\.npz: field 'viewer'.*'K'"):
        load_camera(path)
    np.savez(path, **(fields | {"viewer.kind": np.array("telescope")}))
    with pytest.raises(InputError, match=r"camera\.npz: field 'viewer'.*telescope"):
        load_camera(path)


BEHIND = pose(np.eye(3), [0, 0, -50])
TURNED = pose(np.diag([1.0, -1, -1]), [0, 0, 50])
IMAGE = pose(np.diag([-1.0, 1, 1]), [0, 0, 50])
FIELDS = {"shape": "sphere", "axes": [30], "rim_radius": 5, "T_viewer_mirror": BEHIND}
NON_CENTRAL = GeneralCamera(
    np.tile([0.0, 0, 1], (3, 3, 1)), np.ones((3, 3), bool), np.zeros((3, 3, 3))
)


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: aligned(PINHOLE, "torus", (1,), 1), "'shape'.*'torus'"),
        (lambda: aligned(PINHOLE, "hyperboloid", (30,), 5), "'axes'"),
        (lambda: aligned(PINHOLE, "hyperboloid", (-3, 2), 5), "'axes'"),
        (lambda: aligned(PINHOLE, "ellipsoid", (30, 40), 5), "'axes'"),
        (lambda: aligned(PINHOLE, "ellipsoid", (60, 40), 41), "'rim_radius'.*40 mm"),
        (lambda: aligned(PINHOLE, "hyperboloid", (3, 4), 0), "'rim_radius'"),
        (lambda: aligned(PINHOLE, *HYPERBOLOID, hole_radius=26), "'hole_radius'"),
        (lambda: aligned(PINHOLE, *HYPERBOLOID, side="top"), "'side'.*top"),
        (lambda: aligned(PINHOLE, "sphere", (30,), 5), "'shape'"),
        (lambda: aligned(PINHOLE, *PARABOLOID), "'viewer'.*orthographic"),
        (lambda: aligned(PARALLEL, *HYPERBOLOID), "'viewer'.*orthographic"),
        (lambda: aligned(NON_CENTRAL, *HYPERBOLOID), "'viewer'"),
        (lambda: aligned("pinhole", *HYPERBOLOID), "'viewer'.*str"),
        (
            lambda: camera_from("quadric mirror", FIELDS | {"viewer": {"f": 1}}),
            "'viewer'.*'kind'",
        ),
        (lambda: QuadricMirrorCamera(PINHOLE, *HYPERBOLOID, BEHIND), "T_viewer_mirror"),
        (lambda: QuadricMirrorCamera(PINHOLE, *HYPERBOLOID, TURNED), "T_viewer_mirror"),
        (lambda: QuadricMirrorCamera(PARALLEL, *PARABOLOID, TURNED), "T_viewer_mirror"),
        (
            lambda: QuadricMirrorCamera(PINHOLE, *HYPERBOLOID, 2 * np.eye(4)),
            "'T_viewer_mirror'",
        ),
        (
            lambda: QuadricMirrorCamera(PINHOLE, *HYPERBOLOID, IMAGE),
            "'T_viewer_mirror'",
        ),
    ],
)
def test_impossible_mirrors_are_rejected_in_one_line(build, words):
    with raises_line(words):
        build()
