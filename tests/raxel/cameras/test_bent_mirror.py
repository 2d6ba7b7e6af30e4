"""The camera before a bent sheet of mirror: exact both ways, law of reflection."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.cameras import (
    BentMirrorCamera,
    OrthographicCamera,
    PerspectiveCamera,
    PlanarMirrorsCamera,
    camera_from,
    centrality,
    load_camera,
)
from raxel.cameras.mirrors.sheet_surface import SheetMirror
from raxel.errors import InputError
from raxel.geometry import rotation_from_vector
from tests.camera_checks import assert_points_come_back

W, H = 640, 480
PINHOLE = PerspectiveCamera([[690, 0, 319.5], [0, 690, 239.5], [0, 0, 1]], [], W, H)
SIZE = (320, 240)
BULGE = [[0, 0, 6], [0, 4, 0], [20, 0, 0], [5, 0, 0]]
HOLLOW = [[0, 0, -3], [0, 1, 0], [-4, 0, 0]]
PLACE = {"offset": (0, 0, 280), "rotation": (0, np.radians(35), 0)}


def bent(heights=BULGE, viewer=PINHOLE):
    return BentMirrorCamera(viewer, SIZE, heights, **PLACE)


def pixels_of(seed, count=400):
    return np.random.default_rng(seed).uniform(0, [W - 1, H - 1], (count, 2))


@pytest.mark.parametrize("heights", [BULGE, HOLLOW, [[0.0]]])
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=3, deadline=None)
def test_points_on_ray_project_to_its_pixel(heights, seed):
    camera, pixels = bent(heights), pixels_of(seed)
    # A hollow sheet shows points beyond its caustic a second time.
    far = 2 if heights is HOLLOW else 4
    depth = 10 ** np.random.default_rng(seed).uniform(0, far, (len(pixels), 1))
    # The bulge fills 0.83 of the image: of 400 pixels that are drawn, less than 0.7 is
    # seven standard deviations off.
    assert assert_points_come_back(camera, pixels, depth).valid.mean() > 0.7


def test_rays_obey_law_of_reflection():
    mirror, rng = SheetMirror(SIZE, BULGE), np.random.default_rng(2)
    eye = np.array([20.0, -30.0, -300.0])
    towards = np.column_stack([rng.uniform(-0.4, 0.4, (200, 2)), np.ones(200)])
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    met = mirror.reflect(np.broadcast_to(eye, towards.shape), towards)
    assert met.valid.mean() > 0.5
    M, J, _ = mirror.point(mirror.chart(met.points[met.valid]))
    np.testing.assert_allclose(M, met.points[met.valid], atol=1e-9)
    turned = met.directions[met.valid] - towards[met.valid]
    assert np.abs(np.einsum("nik,ni->nk", J, turned)).max() < 1e-9 * mirror.radius
    assert np.all(np.sum(turned * mirror.normals(M), axis=1) > 0)


def test_derivatives_of_sheet_agree_with_differences():
    mirror, step = SheetMirror(SIZE, BULGE), 1e-5
    p = np.random.default_rng(3).uniform(-0.5, 0.5, (40, 2))
    _, first, second = mirror.point(p)
    for k in range(2):
        shift = step * np.eye(2)[k]
        up, first_up, _ = mirror.point(p + shift)
        down, first_down, _ = mirror.point(p - shift)
        np.testing.assert_allclose(first[:, :, k], (up - down) / (2 * step), atol=1e-5)
        slope = (first_up - first_down) / (2 * step)
        np.testing.assert_allclose(second[:, :, :, k], slope, atol=1e-5)


def test_flat_sheet_is_plane_mirror():
    R = rotation_from_vector(np.array(PLACE["rotation"]))
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, PLACE["offset"]
    outline = np.array([[-160, -120], [160, -120], [160, 120], [-160, 120]])
    plane = PlanarMirrorsCamera(PINHOLE, [T], [outline])
    pixels = pixels_of(5)
    ours, theirs = bent([[0.0]]).rays(pixels), plane.rays(pixels)
    np.testing.assert_array_equal(ours.valid, theirs.valid)
    np.testing.assert_allclose(
        ours.directions[ours.valid], theirs.directions[ours.valid], atol=1e-12
    )


def test_bent_mirror_accepts_orthographic_viewer():
    camera = bent()
    assert not camera.central
    assert centrality(camera.rays(pixels_of(6))) > 5
    parallel = bent(viewer=OrthographicCamera(2.5, (319.5, 239.5), W, H))
    assert_points_come_back(parallel, pixels_of(6), 100)


@pytest.mark.parametrize(
    ("heights", "count"), [(BULGE, 9), (HOLLOW, 6), ([[0.0]], 0), ([[0, 1], [2, 3]], 1)]
)
def test_bent_mirror_parameters_exclude_pose_terms(heights, count):
    assert bent(heights).parameters == PINHOLE.parameters + 6 + count


def test_camera_roundtrips_through_file_and_fields(tmp_path):
    camera = bent()
    camera.save(tmp_path / "camera.npz")
    fields = {"viewer": PINHOLE, "size": SIZE, "heights": BULGE} | PLACE
    for again in (
        load_camera(tmp_path / "camera.npz"),
        camera_from(camera.kind, fields),
    ):
        np.testing.assert_array_equal(
            again.rays(pixels_of(7)).directions, camera.rays(pixels_of(7)).directions
        )
        assert again.parameters == camera.parameters


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"size": (0, 240)}, "field 'size'"),
        ({"heights": [[0, 0], [400, 0]]}, "field 'heights': .* 68 degrees"),
        ({"heights": [0, 1]}, "field 'heights'"),
        ({"offset": (0, 0, -280)}, "field 'T_viewer_mirror'"),
    ],
)
def test_impossible_sheets_are_rejected(change, words):
    fields = {"viewer": PINHOLE, "size": SIZE, "heights": BULGE} | PLACE | change
    with pytest.raises(InputError, match=words):
        camera_from("bent mirror", fields)


@pytest.mark.parametrize(
    ("along_x", "along_y", "steep"),
    [(0.99, 0, False), (0, 0.99, False), (1.02, 0, True), (0, 1.02, True)],
)
def test_sheet_steeper_than_45_degrees_is_rejected(along_x, along_y, steep):
    size = 400.0, 300.0
    heights = [[0, along_y * size[1] / 2], [along_x * size[0] / 2, 0]]
    if not steep:
        assert SheetMirror(size, heights).radius == 250
        return
    with pytest.raises(InputError, match="46 degrees"):
        SheetMirror(size, heights)
