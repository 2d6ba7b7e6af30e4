"""The stages of CELECT: Hough lines, the choice of a line, corner processing."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.features.celect import CelectSettings, algorithm, along_contour, merged_lines
from raxel.features.celect.algorithm import (
    _Run,
    average_close,
    distance_to_trace,
    processed,
    snapped,
)
from raxel.features.celect.trace import (
    Layers,
    Trace,
    Tracer,
    angle_difference,
    canny_edges,
    clear_scale,
    harris_corners,
    mean_side,
    next_anchor,
    next_line,
    open_window,
    peaks_of,
    side_lengths,
    smoothing_for,
    vote,
)

PUBLISHED = CelectSettings()
CENTRE, RADIUS = np.array([40.0, 50.0]), 24.0
ANGLES = st.floats(0, 179.9)


def pixels_of_line(theta_deg, distance=0.0):
    """Pixels (n, 2) of a line in the window, as Canny's method would leave them."""
    direction = np.array(
        [math.cos(math.radians(theta_deg)), math.sin(math.radians(theta_deg))]
    )
    normal = np.array([-direction[1], direction[0]])
    along = np.linspace(-RADIUS, RADIUS, 200)
    points = CENTRE + distance * normal + along[:, None] * direction
    points = np.unique(np.rint(points), axis=0)
    return points[np.linalg.norm(points - CENTRE, axis=1) <= RADIUS]


def peaks(points, settings=PUBLISHED, s=RADIUS):
    return peaks_of(vote(points, CENTRE, RADIUS), settings, s)


@settings(deadline=None, max_examples=60)
@given(theta=ANGLES, distance=st.floats(-9, 9))
def test_hough_line_has_orientation_and_signed_distance(theta, distance):
    # Without averaging, which moves the line towards the second, enforced peak.
    alone = CelectSettings(split_peaks=0)
    lines = peaks(pixels_of_line(theta, distance), alone)
    R, found = lines.lines[lines.votes.argmax()]
    assert angle_difference(found, theta) < 2.5
    assert 0 <= found < 180
    turned = abs(found - theta) > 90
    assert abs((-R if turned else R) - distance) < 1.5


@pytest.mark.parametrize("theta", [0.0, 0.5, 179.5, 179.0, 1.0])
def test_hough_line_at_angle_border_is_one_peak(theta):
    points = pixels_of_line(theta, 4.0)
    apart = CelectSettings(wrap=0, split_peaks=0)
    near = [
        line
        for line in peaks(points, apart).lines
        if angle_difference(line[1], 0) < 3 and 2.5 < abs(line[0]) < 5.5
    ]
    assert len(near) == 2
    together = peaks(points, CelectSettings(split_peaks=0))
    near = [line for line in together.lines if angle_difference(line[1], theta) < 3]
    assert len(near) == 1


@pytest.mark.parametrize("thetas", [(20, 100), (0, 90), (60, 150), (178, 80)])
def test_hough_crossing_lines_are_strongest_peaks(thetas):
    points = np.vstack([pixels_of_line(theta) for theta in thetas])
    found = peaks(points)
    two = found.lines[np.argsort(-found.votes)[:2], 1]
    for theta in thetas:
        assert angle_difference(two, theta).min() < 3


def test_hough_peak_count_is_limited():
    alone = CelectSettings(split_peaks=0)
    assert len(peaks(pixels_of_line(30), alone).lines) >= 2
    fan = np.vstack([pixels_of_line(theta) for theta in range(15, 180, 30)])
    assert len(peaks(fan, alone).lines) == 5
    assert len(peaks(np.empty((0, 2), int)).lines) == 0


def test_hough_close_peaks_merge_across_border():
    near = np.array([(2.0, 179.0, 30.0), (-2.0, 1.0, 10.0)])
    np.testing.assert_array_equal(merged_lines(near, 5.0), [(2.0, 179.5, 40.0)])
    assert len(merged_lines(np.abs(near), 3.0)) == 2


def test_next_line_has_least_turn_modulo_180():
    lines = np.array([[0.0, 5], [0, 170], [0, 90]])
    assert next_line(lines, np.arange(3), 178) == 0
    assert next_line(lines, np.arange(3), 174) == 1
    assert next_line(lines, np.arange(0), 174) is None


def test_next_anchor_is_farthest_in_band():
    edges = np.array([[50, 50], [55, 51], [56, 58], [20, 50], [64, 50]])
    line = (0.0, 0.0)
    chosen = next_anchor(edges, line, CENTRE, 3, CENTRE, np.array([1.0, 0]))
    np.testing.assert_array_equal(chosen, [64, 50])
    back = next_anchor(edges, line, CENTRE, 3, CENTRE, np.array([-1.0, 0]))
    np.testing.assert_array_equal(back, [20, 50])
    assert next_anchor(edges[:3], line, CENTRE, 3, CENTRE, np.array([-1.0, 0])) is None


def test_distance_to_trace_uses_nearest_anchors():
    anchors = np.array([[0.0, 0], [10, 0], [20, 10]])
    np.testing.assert_allclose(distance_to_trace(np.array([[4.0, 3]]), anchors), [3.0])
    np.testing.assert_allclose(
        distance_to_trace(np.array([[18.0, 10]]), anchors), [math.sqrt(2)]
    )


def test_average_close_groups_chains():
    corners = np.array([[0.0, 0], [3, 0], [6, 0], [20, 0]])
    labels = average_close(corners, 3.5)
    assert labels[0] == labels[1] == labels[2] != labels[3]


@settings(deadline=None, max_examples=50)
@given(seed=st.integers(0, 10**6), count=st.integers(2, 9))
def test_processed_merges_split_corners(seed, count):
    rng = np.random.default_rng(seed)
    true = np.column_stack((20.0 * np.arange(count), rng.uniform(-1, 1, count)))
    split = np.vstack([true + d for d in ([2, 1], [-2, -1], [1, -2], [-1, 2])])
    beyond = np.array([[-18.0, 0], [20.0 * count - 1, 0]])
    lateral = np.array([[10.0, 15]])
    anchors = np.vstack((true[:1], true[:-1] + [10, 0], true[-1:]))
    candidates = rng.permutation(np.vstack((split, beyond, lateral)))
    got = processed(candidates, anchors, 8.0, 7.0)
    assert len(got.merged) == count
    np.testing.assert_allclose(got.merged, true, atol=1e-9)
    assert not (got.inliers[:, None] == lateral).all(axis=2).any()


def test_celect_settings_match_thesis_tables():
    s = side_lengths(np.array([[0, 0], [190, 0], [190, 95], [0, 95]]), 10, 5, 1.9)
    np.testing.assert_allclose(s, [10, 10, 10, 10])
    column = np.array([[0.0, 0], [0, 10], [0, 30]])
    assert mean_side(column, PUBLISHED) == 7.5
    table = (
        PUBLISHED.split_peaks,
        PUBLISHED.wrap,
        PUBLISHED.near_centre,
        PUBLISHED.first_angle_deg,
        PUBLISHED.edge_band,
        PUBLISHED.arrival,
        PUBLISHED.corner_band,
        PUBLISHED.merge,
    )
    assert table == (0.5, 0.125, 0.4, 15.0, 0.1, 0.56, 0.4, 0.8)
    assert (PUBLISHED.growth, PUBLISHED.column_merge) == (0.2, 0.47)
    assert (PUBLISHED.radius_divisor, PUBLISHED.peaks) == (1.9, (2, 5))


@pytest.mark.parametrize("centre", [(95.4, 96.0), (200.0, 150.0), (3.0, 230.0)])
def test_layer_tiles_match_single_window(centre):
    v, u = np.indices((240, 300))
    turned = (0.9 * u + 0.4 * v) // 23 + (0.9 * v - 0.4 * u) // 23
    image = np.where(turned % 2, 210, 30).astype(np.uint8)
    centre, radius = np.array(centre), 40.0
    smoothing = smoothing_for(radius / 2, PUBLISHED)
    window = open_window(image, centre, radius, smoothing)
    scale = clear_scale([window], smoothing, PUBLISHED)
    layers = Layers(image, scale, PUBLISHED)
    found = {
        "edges": (
            layers.edges(centre, radius),
            canny_edges(window, scale, PUBLISHED.canny_high, PUBLISHED.canny_low),
        ),
        "corners": (
            layers.corners(centre, radius),
            harris_corners(window, scale, PUBLISHED),
        ),
    }
    for tiled, own in found.values():
        assert len(own) > 3
        assert set(map(tuple, tiled.tolist())) == set(map(tuple, own.tolist()))
        assert len(tiled) == len(own)


def test_along_contour_returns_named_values():
    numbers = np.arange(12).reshape(3, 4)
    sides = [along_contour(f"side {n}", numbers).tolist() for n in (1, 2, 3, 4)]
    assert sides == [[0, 1, 2, 3], [3, 7, 11], [8, 9, 10, 11], [0, 4, 8]]
    assert along_contour("column 2", numbers).tolist() == [1, 5, 9]
    assert along_contour("column 3", np.zeros((3, 4, 2))).shape == (3, 2)


def test_click_window_has_radius_of_shorter_side(monkeypatch):
    """A larger window would include corners next to the clicked one."""
    clicks = np.array([[60.0, 60], [380, 60], [300, 140], [60, 140]])
    radii = []

    def detect(window, scale, settings):
        radii.append(window.radius)
        return np.empty((0, 2))

    image = np.random.default_rng(0).integers(0, 255, (200, 440)).astype(np.uint8)
    monkeypatch.setattr(algorithm, "harris_corners", detect)
    snapped(image, clicks, 5, 2, CelectSettings())
    across, slanting = 240 / 5, np.hypot(80, 80) / 2
    found = np.array(radii) * CelectSettings().radius_divisor
    np.testing.assert_allclose(found, [40, slanting, across, 40])


@pytest.mark.parametrize(
    ("end", "arrived"),
    [
        ((25.0, 21), True),  # passed by on the way
        ((31.0, 20), True),
        ((34.0, 20), False),
        ((16.0, 20), False),  # behind where the step began
        ((25.0, 24), False),
    ],
)
def test_tracer_arrives_where_step_passes_end(end, arrived):
    tracer = Tracer(np.zeros((40, 60)), None, CelectSettings(arrival=0.5))
    trace = Trace([np.array([20.0, 20]), np.array([30.0, 20])])
    assert tracer._arrived(trace, np.array(end), 5.0) == arrived


def test_column_merging_scales_with_previous_column():
    corners = np.zeros((4, 2))
    run = _Run(None, None, corners, 4, 4, CelectSettings(), {}, False)
    # The board leans back: 10 px from one corner to the next, then 30 and 50.
    previous = np.array([[7.0, 0], [7, 10], [7, 40], [7, 90]])
    radius, distance = run._column_scale(previous)
    assert distance == pytest.approx(0.47 * 10)
    assert radius == pytest.approx(0.5 * 30)
