"""A board of which a mirror shows a part, and a monitor seen in a flat mirror."""

from types import SimpleNamespace

import numpy as np
import pytest

from chapters.shared.mirror.rigs import mirror_rig
from raxel.calibration import BoardView, flat_view
from raxel.calibration.mirror.images import _steps_in_part
from raxel.calibration.mirror.observations import (
    LATTICE_SYMMETRIES,
    labelled_like,
    lattice_of,
    on_one_lattice,
)
from raxel.errors import InputError
from raxel.features.detector import Detection, Partial, rejected
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.sets.mirror_set import MirrorStep, PickedClamp
from tests.raised import raises_code

COLUMNS = 14
INDICES = np.column_stack(np.divmod(np.arange(COLUMNS * 13), COLUMNS))
STEPS = {"first": (0.0, 5.0), "second": (5.0, 10.0), "third": (10.0, 15.0)}


def seen(rig, camera, T, rng):
    """What a mirror shows of the rig's board, a corner in twenty not found."""
    pixels, there = rig.corners(camera, T)
    there &= rng.random(len(there)) > 0.05
    return Partial(pixels[there], INDICES[there])


def relabelled(partial, turn, shift):
    return partial._replace(indices=partial.indices @ LATTICE_SYMMETRIES[turn] + shift)


@pytest.fixture(scope="module", params=[("A", "first"), ("A", "third"), ("B", "first")])
def step(request):
    """(Partials before and after, clamp's picks) in an uneven mirror."""
    geometry, name = request.param
    rig, rng = mirror_rig(geometry), np.random.default_rng(4)
    pair = STEPS[name]
    T = rig.board_pose(rng, deflections=pair)
    cameras = [rig.camera(one, aberration_um=20, seed=3) for one in pair]
    clamp = rig.clamp_pixels(cameras[0], 9, rng, 0.5)
    return *(seen(rig, camera, T, rng) for camera in cameras), clamp


def test_labelled_corners_are_independent_of_counting(step):
    before, after, clamp = step
    for turn in range(len(LATTICE_SYMMETRIES)):
        found = labelled_like(before, relabelled(after, turn, [3, -2]), clamp)
        np.testing.assert_array_equal(found.indices, after.indices)


def test_half_lattice_step_at_clamp_is_rejected(step):
    """Either of two labellings would move the clamp by as much."""
    before, after, clamp = step
    A = np.column_stack([np.ones(len(after.indices)), after.indices])
    way = np.linalg.lstsq(A, after.corners, rcond=None)[0]
    half = after._replace(corners=after.corners + 0.5 * (way[1] + way[2]))
    with raises_code("corners-not-matched"):
        labelled_like(before, half, clamp)


def bent_lattice(clamp):
    """Partials before and after a bend that leaves pixels `clamp` (L, 2) where they
    are; 30 px a square, columns along x."""
    flat = 30.0 * INDICES[:, ::-1] + [100, 80]
    stretched = 1e-3 * (flat[:, :1] - clamp[0, 0]) ** 2 * [1, 0]
    return Partial(flat, INDICES), Partial(flat + stretched, INDICES)


@pytest.mark.parametrize("counted", range(len(LATTICE_SYMMETRIES)))
def test_clamp_along_squares_does_not_mirror_board(counted):
    """Turned over about the clamp it would show the same places there."""
    clamp = np.column_stack([np.full(9, 40.0), np.linspace(80, 440, 9)])
    before, after = bent_lattice(clamp)
    found = labelled_like(before, relabelled(after, counted, [2, 5]), clamp)
    np.testing.assert_array_equal(found.indices, INDICES)


def test_clamp_of_one_point_is_rejected():
    """Any quarter of a turn about it would do."""
    clamp = np.column_stack([np.full(5, 40.0), np.linspace(258, 262, 5)])
    before, after = bent_lattice(clamp)
    with raises_code("corners-not-matched"):
        labelled_like(before, after, clamp)


def test_too_few_corners_are_rejected_by_name(step):
    before, after, clamp = step
    few = Partial(after.corners[:9], after.indices[:9])
    with pytest.raises(InputError, match=r"step 2: .* 9 corners"):
        labelled_like(before, few, clamp, "step 2")


def test_whole_board_is_lattice_and_views_share_rows(step):
    before, after, _ = step
    board = mirror_rig("A").board
    views = on_one_lattice([before, after], board, ["first", "second"])
    for view, partial in zip(views, (before, after), strict=True):
        rows = np.flatnonzero(np.isfinite(view.pixels[:, 0]))
        apart = view.points[rows] - view.points[rows[0]]
        of = {tuple(pixel): index for pixel, index in zip(*partial, strict=True)}
        indices = np.array([of[tuple(pixel)] for pixel in view.pixels[rows]])
        steps = (indices - indices[0])[:, ::-1] * board.pitch_mm
        np.testing.assert_allclose(apart, steps)
    far = before._replace(indices=before.indices + 40)
    with pytest.raises(InputError, match="second"):
        on_one_lattice([before, far], board, ["first", "second"])
    corners = np.random.default_rng(0).random((6, 2))
    corners[4] = np.nan
    whole = lattice_of(Detection(True, corners, 3, 2))
    np.testing.assert_array_equal(whole.indices[-1], [1, 2])
    assert len(whole.corners) == 5
    assert lattice_of(rejected(3, 2, "no board")) is None


def test_set_steps_accept_partial_boards(step):
    before, after, clamp = step
    board = mirror_rig("A").board
    steps = (MirrorStep("before", "after", deflection_mm=5.0),)
    stages = SimpleNamespace(description="set.yaml", target=board)
    clamp = PickedClamp(tuple(map(tuple, clamp)))
    mirror_set = SimpleNamespace(stages=stages, steps=steps, clamp=clamp)

    def boards(*partials):
        return [
            SimpleNamespace(
                view=SimpleNamespace(label=label),
                detection=rejected(14, 13, "cut off")._replace(partial=partial),
            )
            for label, partial in zip(("before", "after"), partials, strict=True)
        ]

    (found,), flags = _steps_in_part(
        mirror_set, boards(before, relabelled(after, 5, [1, 4]))
    )
    common = np.isfinite(found.before.pixels + found.after.pixels).all(axis=1)
    shared = set(map(tuple, before.indices)) & set(map(tuple, after.indices))
    assert np.count_nonzero(common) == len(shared)
    np.testing.assert_array_equal(found.before.points, found.after.points)
    assert f"{len(before.corners)} corners before" in flags[0]
    with pytest.raises(InputError, match=r"set.yaml: after: "):
        _steps_in_part(mirror_set, boards(before, None))


def test_flat_view_rejects_outlier_pixels():
    viewer, rng = mirror_rig("A").viewer, np.random.default_rng(1)
    points = rng.uniform(0, 200, (800, 2))
    T = pose(rotation_from_vector([0.3, -0.4, 0.1]), [-80.0, -90.0, 900.0])
    true = viewer.project(transform(T, on_plane(points))).pixels
    pixels = true + rng.normal(0, 0.3, true.shape)
    pixels[:60] += rng.uniform(-600, 600, (60, 2))
    pixels[60] = np.nan
    found = flat_view(viewer, BoardView(pixels, points, 800, 1, "near"))
    left = np.isnan(found.pixels[:, 0])
    assert left[:61].sum() >= 60
    assert not left[61:].any()
    assert found.sd[0] == pytest.approx(0.3, rel=0.1)
    pixels[:300] += rng.uniform(-600, 600, (300, 2))
    with pytest.raises(InputError, match=r"near: .* of 799 pixels"):
        flat_view(viewer, BoardView(pixels, points, 800, 1, "near"))
