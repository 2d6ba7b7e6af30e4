"""3.3.2: how grids are scored, what lost them, and that pictures are the seed's."""

import numpy as np
import pytest

from chapters.ch03_planar_grids.s3_2_grid_sets.claims import decided
from chapters.ch03_planar_grids.s3_2_grid_sets.exercises import clicked_corners
from chapters.ch03_planar_grids.s3_2_grid_sets.trials import pictures
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.pictures import (
    CLICKS,
    IMAGES,
    PICTURE,
    from_smallest,
    grid_view,
    stream,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import (
    CONTOUR,
    FALSE,
    MERGED,
    MISPLACED,
    MISSED,
    SNAP,
    SPLIT,
    cause_of,
)
from chapters.shared.grid_detectors import is_right, localised
from chapters.shared.grid_rigs import SETS, rig_of
from chapters.shared.lattices import clockwise, outer
from chapters.shared.synthetic_board import SyntheticBoard
from raxel.features.celect import (
    OUTER_CORNER,
    TOO_FEW,
    TOO_MANY,
    TRACING,
    CelectResult,
    ContourFailure,
    ContourTrace,
)

COLUMNS, ROWS = 5, 4
LATTICE = np.stack(
    np.meshgrid(100.0 + 30 * np.arange(COLUMNS), 60.0 + 30 * np.arange(ROWS)), axis=-1
)
TRUTH = LATTICE.reshape(-1, 2)


def test_a_grid_is_right_within_8_px():
    assert is_right(TRUTH + [5, 5], TRUTH)
    assert not is_right(TRUTH + [6, 6], TRUTH)


def test_clicks_begin_at_the_smallest_square_and_keep_their_turn():
    lattice = LATTICE.copy()
    lattice[0, -1] -= [12, -12]
    begun = from_smallest(lattice)
    np.testing.assert_array_equal(begun[0, 0], lattice[0, -1])
    assert begun.shape == (COLUMNS, ROWS, 2)
    np.testing.assert_array_equal(clockwise(begun), begun)
    np.testing.assert_array_equal(clockwise(begun[:, ::-1]), begun)
    np.testing.assert_array_equal(outer(LATTICE)[2], LATTICE[-1, -1])


def failed(stage, merged=(), inliers=()):
    """A run that failed on side 1, with these corners on it."""
    merged, inliers = (np.reshape(p, (-1, 2)).astype(float) for p in (merged, inliers))
    failure = ContourFailure("side 1", stage, "", len(merged), COLUMNS)
    none = np.empty((0, 2))
    trace = ContourTrace("side 1", none, none[:, 0], 12.0, inliers, inliers, merged)
    corners = np.full((ROWS, COLUMNS, 2), np.nan)
    return CelectResult(
        False, corners, COLUMNS, ROWS, outer(LATTICE), (failure,), (trace,)
    )


def test_causes_are_told_from_the_contour_that_failed():
    side = LATTICE[0]
    between = side[1:2] + [15, 0]
    twice = np.vstack([side, side[2:3] + [5, 3]])
    cases = [
        (failed(OUTER_CORNER), SNAP),
        (failed(TRACING), CONTOUR),
        (failed(TOO_FEW, side[[0, 1, 3, 4]], side[[0, 1, 3, 4]]), MISSED),
        (failed(TOO_FEW, side[[0, 1, 3, 4]], side), MERGED),
        (failed(TOO_MANY, twice, twice), SPLIT),
        (failed(TOO_MANY, np.vstack([side, between]), side), FALSE),
        (failed(TOO_FEW)._replace(found=True), MISPLACED),
    ]
    assert [cause_of(result, LATTICE) for result, _ in cases] == [c for _, c in cases]


def test_the_localiser_brings_starts_to_the_corners():
    board = SyntheticBoard()
    start = board.corners + [1.5, -1.0]
    off = np.linalg.norm(localised(board.image(), start) - board.corners, axis=1)
    assert np.median(off) < 0.1


def test_sets_have_15_images_and_2880_corners():
    corners = 0
    for name in ("spherical", "hyperboloidal", "fisheye", "flexible-mirror"):
        assert sum(count for _, count in SETS[name]) == IMAGES
        for image in range(IMAGES):
            target = rig_of(name, image).target
            corners += target.columns * target.rows
    assert corners == clicked_corners() == 2880
    with pytest.raises(ValueError, match="no image 15"):
        rig_of("fisheye", 15)


def test_a_picture_is_its_seeds_and_shows_the_board_clockwise():
    one, two = (grid_view("fisheye", 7, 11) for _ in range(2))
    np.testing.assert_array_equal(one.image, two.image)
    assert one.image.shape == (768, 1024)
    assert (one.columns, one.rows) == (12, 9)
    u, v = one.outer_corners.T
    assert np.sum(u * np.roll(v, -1) - np.roll(u, -1) * v) > 0
    first, again = (stream("fisheye", 7, 11, CLICKS).random(3) for _ in range(2))
    np.testing.assert_array_equal(first, again)


def test_flaws_are_a_sets_and_a_seeds_and_noise_is_a_pictures(monkeypatch):
    rig = rig_of("fisheye", 0)
    pose = rig.draw_poses(np.random.default_rng(0), 1)[0]

    def taken(*which):
        return rig, pose, None, stream(*which, PICTURE)

    def saved(rig, light, draws, specimen):
        return np.array([[specimen.random(), draws.random()]])

    monkeypatch.setattr(pictures, "taken", taken)
    monkeypatch.setattr(pictures, "saved", saved)
    which = [
        ("fisheye", 0, 1),
        ("fisheye", 1, 1),
        ("fisheye", 0, 2),
        ("spherical", 0, 1),
    ]
    flaws, noise = np.array([grid_view(*w).image[0] for w in which]).T
    assert flaws[0] == flaws[1]
    assert len(set(flaws)) == 3
    assert len(set(noise)) == 4


def test_a_predicate_about_nothing_decides_nothing():
    assert decided([True, True, True], counted=0) == "undecided"
    assert decided([True, True, True], counted=2) == "reproduced"
    assert decided([True, False, True], counted=2) == "differs"
