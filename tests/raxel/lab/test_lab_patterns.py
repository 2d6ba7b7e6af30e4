"""Monitor patterns: the code they show, and their exact means over pixels."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.cameras import FisheyeCamera
from raxel.errors import InputError
from raxel.geometry import pose, rotation_from_vector, transform
from raxel.lab import MonitorLevel, MonitorPattern, monitor_scene, trace
from raxel.lab.textures import ChessboardTexture, share_beyond, share_in_bars
from raxel.sets import ActiveGrid, Pattern

GRID = ActiveGrid((64, 48), (128.0, 96.0))


def gray(axis, bit, of, inverse=False):
    return Pattern("", axis, "gray", of, bit=bit, inverse=inverse)


def shown(pattern, uv, response=None):
    texture = MonitorPattern(GRID.monitor_px, GRID.monitor_mm, pattern, response)
    return texture.radiance(uv, np.ones(len(uv)))


@pytest.mark.parametrize(("axis", "of"), [("x", 6), ("x", 3), ("y", 4), ("y", 1)])
def test_gray_code_numbers_cells(axis, of):
    size = 128 if axis == "x" else 96
    position = np.random.default_rng(0).uniform(0, size, 2000)
    uv = np.column_stack([position, 0 * position][:: 1 if axis == "x" else -1])
    cell = np.floor(position / size * 2**of).astype(int)
    bits = [shown(gray(axis, bit, of), uv) for bit in range(of)]
    code = sum(bit * 2 ** (of - 1 - k) for k, bit in enumerate(bits)).astype(int)
    np.testing.assert_array_equal(code, cell ^ (cell >> 1))
    inverse = shown(gray(axis, of - 1, of, inverse=True), uv)
    np.testing.assert_array_equal(inverse, 1 - bits[-1])


def test_phase_steps_encode_position():
    position = np.linspace(0, 128, 999, endpoint=False)
    uv = np.column_stack([position, 0 * position])
    steps = [
        shown(Pattern("", "x", "phase", 4, step=k, periods=8.0), uv) for k in range(4)
    ]
    phi = np.arctan2(steps[0] - steps[2], steps[1] - steps[3])
    turns = (phi / (2 * np.pi) - position / 16) % 1
    np.testing.assert_allclose(np.minimum(turns, 1 - turns), 0, atol=1e-9)
    assert min(s.min() for s in steps) >= 0
    assert max(s.max() for s in steps) <= 1


@given(
    y=st.floats(-5, 5).map(lambda y: y + 1e-7),
    a=st.floats(-3, 3),
    b=st.floats(-3, 3),
    duty=st.floats(0.05, 0.95),
)
@settings(max_examples=50, deadline=None)
def test_coverage_shares_are_exact_areas(y, a, b, duty):
    fine = (np.arange(150) + 0.5) / 150 - 0.5
    s, t = np.meshgrid(fine, fine)
    field = y + a * s + b * t
    # Counting is right to about a row of points for each edge in the area.
    slack = 2 * (1 + abs(a) + abs(b)) / 150
    bars = share_in_bars(*np.array([[y], [a], [b]]), duty)
    assert bars[0] == pytest.approx(np.mean(field % 1.0 < duty), abs=slack)
    half = share_beyond(*np.array([[y], [a], [b]]))
    assert half[0] == pytest.approx(np.mean(field > 0), abs=1 / 150)


@pytest.mark.parametrize(
    "pattern",
    [
        gray("x", 3, 4),
        gray("y", 0, 3, inverse=True),
        Pattern("", "x", "phase", 4, step=1, periods=16.0),
        Pattern("", "y", "phase", 6, step=5, periods=7.5),
    ],
    ids=lambda p: f"{p.kind} {p.axis}",
)
def test_monitor_pixels_are_means_over_rays(pattern):
    """Against 48 x 48 rays of each pixel, away from the monitor's border."""
    camera = FisheyeCamera("equidistance", 30, (24.2, 17.7), 50, 36, 1.5)
    R = rotation_from_vector([0.2, -0.3, 0.25])
    scene = monitor_scene(GRID, pose(R, [0, 0, 90] - R @ [64, 48, 0]))
    texture = MonitorPattern(GRID.monitor_px, GRID.monitor_mm, pattern)
    image = trace(camera, np.eye(4), scene).shade({0: texture})
    fine = (np.arange(48) + 0.5) / 48 - 0.5
    offsets = np.stack(np.meshgrid(fine, fine), axis=-1).reshape(-1, 2)
    worst = 0.0
    for u, v in ((20, 15), (24, 18), (27, 20), (22, 21), (30, 14), (18, 19), (25, 12)):
        rays = camera.rays(np.array([u, v]) + offsets)
        hit = scene.surfaces[0].hit(rays.origins[:1], rays.directions)
        assert np.isfinite(hit.distance).all()
        mean = texture.radiance(hit.uv, hit.cosine).mean()
        worst = max(worst, abs(image[v, u] - mean))
    # Two thousandths: the map bends within these large pixels, and counting has steps.
    assert worst < (0.012 if pattern.kind == "gray" else 0.002)


def test_monitor_response_applies_to_level_and_angle():
    uv = np.array([[10.0, 5.0], [70.0, 5.0]])
    cosine = np.array([1.0, 0.5])

    def response(value, cosine):
        return (0.1 + 0.9 * value**2) * cosine

    pattern = MonitorPattern(
        GRID.monitor_px, GRID.monitor_mm, gray("x", 0, 1), response
    )
    np.testing.assert_allclose(pattern.radiance(uv, cosine), [0.1, 0.5])
    across, down = np.array([[4.0, 0]]), np.array([[0, 4.0]])
    middle = pattern.average(np.array([[64.0, 5]]), across, down, cosine[:1])
    np.testing.assert_allclose(middle, [0.55])
    level = MonitorLevel(0.5, response)
    np.testing.assert_allclose(level.radiance(uv, cosine), 0.325 * cosine)


def test_chessboard_mean_is_exact_for_one_edge():
    board = ChessboardTexture(3, 2, 10.0, 5.0, black=0.0, white=1.0)
    across, down = np.array([[1.0, 0.2]]), np.array([[-0.1, 1.0]])

    def mean(x, y):
        return board.average(np.array([[x, y]]), across, down, np.ones(1))[0]

    assert mean(5.0, 5.0) == 1.0
    assert mean(10.0, 5.0) == pytest.approx(0.5)
    assert mean(10.25, 5.0) == pytest.approx(0.25)
    assert mean(5.0, -0.1) == pytest.approx(0.4)
    assert np.isnan(mean(10.0, 10.0))
    assert mean(-10.0, 5.0) == pytest.approx(0.5)
    assert mean(-12.0, -12.0) == 1.0


def test_monitor_scene_has_pose_and_frame():
    T = pose(np.eye(3), [-64, -48, 100])
    scene = monitor_scene(GRID, T, MonitorLevel(0.8), frame_mm=10, frame=0.1)
    rays = np.array([[-60.0, -40, 100], [-70, -40, 100], [-90, -40, 100]])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    part, uv, cosine = scene.hit(np.zeros((1, 3)), rays)
    np.testing.assert_array_equal(part, [0, 1, -1])
    np.testing.assert_allclose(uv[0], [4, 8])
    assert (cosine[:2] > 0).all()
    lit = scene.surfaces[0].outline.reshape(-1, 3)
    np.testing.assert_allclose(lit.min(axis=0), transform(T, np.zeros(3)))


def test_unknown_pattern_is_rejected():
    with pytest.raises(InputError, match="axis 'z'"):
        MonitorPattern((64, 48), None, gray("z", 0, 1))
