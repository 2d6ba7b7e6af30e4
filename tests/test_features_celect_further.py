"""Stages of CELECT after 6.3.1: symmetric corners, clusters, radius from curvature."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from raxel.features.celect import CelectSettings, celect
from raxel.features.celect.clustering import clustered, unevenness
from raxel.features.celect.curvature import curvatures, curved_side
from raxel.features.celect.processing import average_close
from raxel.features.celect.radius import mean_side
from raxel.features.celect.symmetric import (
    _at_level,
    coarser,
    strongest_apart,
    symmetric_corners,
    symmetry_at,
)
from raxel.features.celect.window import Scale, Smoothing, clear_scale, open_window

SETTINGS = CelectSettings()
SMOOTHING = Smoothing(1.5, 2.0)


def saddle(centre, angle_deg=0.0, size=121):
    """An ideal corner of two black and two white sectors, and its gradients' window."""
    v, u = np.indices((size, size)) - (size - 1) / 2
    turn = np.radians(angle_deg)
    x = (u - centre[0]) * np.cos(turn) + (v - centre[1]) * np.sin(turn)
    y = (v - centre[1]) * np.cos(turn) - (u - centre[0]) * np.sin(turn)
    # Ramps of a pixel stand for the share of white in it.
    share = 2 * np.clip(x, -0.5, 0.5) * np.clip(y, -0.5, 0.5) + 0.5
    return np.rint(255 * share).astype(np.uint8)


def corners_of(image, radius=45.0):
    middle = np.array([(image.shape[1] - 1) / 2, (image.shape[0] - 1) / 2])
    window = open_window(image, middle, radius, SMOOTHING)
    scale = clear_scale([window], SMOOTHING, SETTINGS)
    return symmetric_corners(window, scale, SETTINGS) - middle


@pytest.mark.parametrize("angle", [0, 20, 45])
@pytest.mark.parametrize("blur", [0, 3, 6])
def test_a_corner_is_found_once_however_blurred(angle, blur):
    image = saddle((0.3, -0.4), angle)
    if blur:
        image = cv2.GaussianBlur(image, (0, 0), blur)
    found = corners_of(image)
    assert len(found) == 1
    # Where the corner is blurred more than the coarsest scale, its top is flat.
    assert np.abs(found[0] - (0.3, -0.4)).max() < (1.0 if blur == 6 else 0.15)


def test_the_published_detector_splits_a_blurred_corner():
    image = cv2.GaussianBlur(saddle((0.0, 0.0), 45), (0, 0), 3)
    window = open_window(image, np.array([60.0, 60.0]), 45.0, SMOOTHING)
    scale = clear_scale([window], SMOOTHING, SETTINGS)
    assert len(SETTINGS.detect_corners(window, scale, SETTINGS)) > 1


def test_corners_turn_with_the_image():
    image = cv2.GaussianBlur(saddle((6.0, -9.0), 20), (0, 0), 2)
    (found,), (turned,) = corners_of(image), corners_of(np.rot90(image))
    assert turned == pytest.approx((found[1], -found[0]), abs=0.05)


def test_inverted_colours_change_nothing():
    image = cv2.GaussianBlur(saddle((2.0, 3.0), 10), (0, 0), 2)
    assert corners_of(255 - image) == pytest.approx(corners_of(image), abs=1e-6)


def test_edges_bends_of_an_edge_and_noise_are_no_corners():
    rng = np.random.default_rng(4)
    edge = np.where(np.indices((121, 121))[1] < 60, 0, 255)
    bend = np.where((np.indices((121, 121)) < 60).all(axis=0), 0, 255)
    clear = clear_scale(
        [open_window(saddle((0, 0)), np.array([60.0, 60.0]), 45.0, SMOOTHING)],
        SMOOTHING,
        SETTINGS,
    )
    for image in (edge, bend, np.full((121, 121), 90)):
        noisy = np.clip(image + rng.normal(0, 25, image.shape), 0, 255).astype(np.uint8)
        window = open_window(noisy, np.array([60.0, 60.0]), 45.0, SMOOTHING)
        assert not len(symmetric_corners(window, clear, SETTINGS))


def test_a_picture_twice_as_large_is_as_strong_at_twice_the_scale():
    v, u = np.indices((121, 121)) - np.array([59.7, 60.2])[:, None, None]
    found = []
    for level in (1, 2):
        image = 100 * np.tanh(u / (4 * level)) * np.tanh(v / (4 * level)) + 128
        window = open_window(image, [60, 60], 20.0 * level, SMOOTHING)
        pixels, strength = _at_level(window, Scale(SMOOTHING, 1, 1), SETTINGS, level)
        np.testing.assert_allclose(pixels, [[60.2, 59.7]], atol=0.2)
        found.append(strength[0])
    assert found[1] == pytest.approx(found[0], rel=0.1)


def test_the_middle_of_a_spot_is_symmetric_but_no_corner():
    v, u = np.indices((121, 121)) - 60
    spot = np.where((abs(u) < 5) & (abs(v) < 5), 255, 0).astype(np.uint8)
    window = open_window(spot, np.array([60.0, 60.0]), 45.0, SMOOTHING)
    middle = np.array([[60, 60]]) - window.first
    assert symmetry_at(window, middle, 3.0) > 0.9
    assert not len(corners_of(spot))


def test_symmetry_is_one_at_a_corner_and_minus_one_on_an_edge():
    columns = np.indices((121, 121))[1]
    edge = np.clip(128 + 127.5 * (columns - 60), 0, 255).astype(np.uint8)
    at = np.array([[60, 60]])
    for image, wanted in ((saddle((0, 0)), 1.0), (edge, -1.0)):
        window = open_window(image, np.array([60.0, 60.0]), 45.0, SMOOTHING)
        symmetry = symmetry_at(window, at - window.first, 3.0)
        assert symmetry == pytest.approx(wanted, abs=0.02)
    assert symmetry_at(window, np.array([[0, 5]]), 3.0) == -np.inf


def test_smoothing_adds_up_in_squares():
    image = saddle((1.0, 2.0), 30)
    middle = np.array([60.0, 60.0])
    twice = coarser(open_window(image, middle, 40.0, Smoothing(3.0, 4.0)), 4.0, 1)
    once = open_window(image, middle, 40.0, Smoothing(5.0, 4.0))
    inner = slice(40, 60)
    at = once.first - twice.first
    low = twice.gradient_u[inner, inner]
    high = once.gradient_u[40 - at[1] : 60 - at[1], 40 - at[0] : 60 - at[0]]
    assert low == pytest.approx(high, abs=0.1)


def test_the_strongest_stands_for_its_neighbours():
    pixels = np.array([[0.0, 0], [3, 0], [6, 0], [20, 0]])
    kept = strongest_apart(pixels, np.array([1.0, 3, 2, 0.5]), 4.0)
    assert kept.tolist() == [[3, 0], [20, 0]]
    assert strongest_apart(pixels[:0], np.empty(0), 4.0).shape == (0, 2)


def along_line(positions):
    positions = np.asarray(positions, float)
    return np.column_stack((positions, np.zeros(len(positions)))), positions


def test_close_corners_of_a_shrinking_row_stay_apart():
    places = np.cumsum(np.r_[0, 40 * 0.75 ** np.arange(7)])
    corners, along = along_line(np.sort(np.r_[places, places + 2.0]))
    labels = clustered(corners, along, 16.0, 8)
    assert labels.tolist() == labels[::2].repeat(2).tolist()
    assert len(set(labels)) == 8
    order = np.random.default_rng(3).permutation(len(along))
    again = clustered(corners[order], along[order], 16.0, 8)
    np.testing.assert_array_equal(
        again[:, None] == again, labels[order][:, None] == labels[order]
    )
    # The last corners are less than t8 apart: the published rule makes them one.
    assert len(set(average_close(corners, along, 16.0, 8))) < 8


def test_order_of_the_candidates_does_not_matter():
    rng = np.random.default_rng(1)
    places = np.r_[0:200:20] + rng.normal(0, 1, (3, 10))
    corners, along = along_line(places.ravel())
    labels = clustered(corners, along, 8.0, 10)
    order = rng.permutation(len(along))
    again = clustered(corners[order], along[order], 8.0, 10)
    same = labels[order][:, None] == labels[order][None]
    assert (same == (again[:, None] == again[None])).all()


def test_uneven_clusters_and_too_few_candidates_leave_it_to_the_published_rule():
    missing = [0, 20, 40, 80, 100, 103]
    for places, count in ((missing, 6), ([0, 20, 40], 6), ([0, 1, 20, 40, 90], 4)):
        corners, along = along_line(places)
        published = average_close(corners, along, 8.0, count)
        assert (clustered(corners, along, 8.0, count) == published).all()


def test_unevenness_is_the_largest_ratio_of_neighbouring_steps():
    _, along = along_line([0, 10, 25, 31])
    assert unevenness(along, np.arange(4)) == pytest.approx(2.5)
    assert unevenness(along[:2], np.arange(2)) == 1.0


def arc(radius, step, count=9):
    angle = step / radius * np.arange(count)
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def test_curvature_of_a_circle_is_one_over_its_radius():
    assert curvatures(arc(50.0, 20.0)) == pytest.approx(1 / 50)
    assert curvatures(arc(50.0, 20.0)[::-1] + 7) == pytest.approx(1 / 50)
    assert curvatures(np.array([[0.0, 0], [1, 1], [3, 3]])) == pytest.approx(0)


def test_the_window_shrinks_with_the_radius_of_curvature_alone():
    straight = np.column_stack((np.arange(9) * 60.0, np.zeros(9)))
    assert curved_side(straight, SETTINGS) == mean_side(straight, SETTINGS) == 30.0
    mild, strong, extreme = arc(800.0, 60.0), arc(150.0, 60.0), arc(40.0, 60.0)
    assert curved_side(mild, SETTINGS) == mean_side(mild, SETTINGS)
    # At the radius that is returned the arc leaves its best line by one bin.
    r = curved_side(strong, SETTINGS)
    assert r**2 / 150.0 / 4 == pytest.approx(1.0)
    assert curved_side(extreme, SETTINGS) == mean_side(extreme, SETTINGS) / 2


@pytest.mark.parametrize(
    "other",
    [
        {"detect_corners": symmetric_corners},
        {"merge_corners": clustered},
        {"column_length": curved_side},
    ],
)
def test_celect_finds_a_bent_board_with_any_of_them(other):
    v, u = np.indices((460, 460)).astype(float)
    x = (u - 70) / 40 + 0.15 * np.sin(v / 50)
    y = (v - 70) / 40 + 0.15 * np.sin(u / 50 + 1)
    board = np.tanh(8 * np.sin(np.pi * x)) * np.tanh(8 * np.sin(np.pi * y))
    image = np.rint(127.5 + 127 * board).astype(np.uint8)
    lattice = np.stack(np.meshgrid(np.arange(9.0), np.arange(9.0)), axis=-1)
    true = 70 + 40 * lattice
    for _ in range(60):
        bend = 6 * np.sin(true[..., ::-1] / 50 + (0, 1))
        true = 70 + 40 * lattice - bend
    outer = true[[0, 0, -1, -1], [0, -1, -1, 0]]
    result = celect(image, outer, 9, 9, settings=replace(SETTINGS, **other))
    assert result.found, result.failures
    assert np.abs(result.corners - true).max() < 2
