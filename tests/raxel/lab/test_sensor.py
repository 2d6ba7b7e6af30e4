"""The sensor against closed forms: mean, photon transfer, saturation, rounding."""

import numpy as np
import pytest
from scipy.stats import norm

from raxel.lab.rig import Monitor
from raxel.lab.sensor import Sensor, bloom
from tests.raised import raises_line

SHAPE = 250, 400
COUNT = SHAPE[0] * SHAPE[1]


def flat(sensor, level, seed=0):
    """Numbers of an evenly lit image."""
    image = np.full(SHAPE, level)
    return sensor.expose(image, np.random.default_rng(seed)).astype(float)


def test_sensor_mean_is_share_of_full_well():
    sensor = Sensor(white_e=20000, full_well_e=40000, read_noise_e=10, bits=16)
    for level in (0.05, 0.4, 1.2):
        mean = flat(sensor, level).mean() / 65535 * 40000
        sd = np.sqrt(20000 * level + 100) / np.sqrt(COUNT)
        assert mean == pytest.approx(20000 * level, abs=4 * sd + 0.1)


# Where white has many electrons, both noises are drawn as one.
@pytest.mark.parametrize(("white", "read"), [(20000, 30.0), (80000, 120.0)])
def test_photon_transfer_curve_is_linear(white, read):
    full = 2 * white
    sensor = Sensor(white_e=white, full_well_e=full, read_noise_e=read, bits=16)
    levels = np.linspace(0.02, 1.5, 12)
    charges = [flat(sensor, lev, k) / 65535 * full for k, lev in enumerate(levels)]
    mean = np.array([charge.mean() for charge in charges])
    variance = np.array([charge.var() for charge in charges])
    # Each variance is known to sqrt(2 / COUNT): weigh by that.
    slope, offset = np.polyfit(mean, variance, 1, w=1 / variance)
    assert slope == pytest.approx(1, abs=0.01)
    assert offset == pytest.approx(read**2, rel=0.03)


def test_share_of_saturated_pixels():
    full = 10000.0
    sensor = Sensor(white_e=full, full_well_e=full, bits=8)
    level = 0.99
    share = np.mean(flat(sensor, level) == 255)
    # 254.5 / 255 of the well rounds up to the top number; 10^4 electrons are normal.
    expected = norm.sf((full * 254.5 / 255 - full * level) / np.sqrt(full * level))
    assert share == pytest.approx(expected, abs=4 * np.sqrt(expected / COUNT) + 0.003)
    assert np.all(flat(sensor, 3.0) == 255)


def test_gamma_table_and_black_level():
    share = np.array([0.0, 0.25, 0.5, 1.0, -0.1, 1.3])
    gamma = Sensor(1, 1, gamma=2.2, bits=16).develop(share)
    expected = np.clip(share, 0, 1) ** (1 / 2.2) * 65535
    np.testing.assert_allclose(gamma, expected, atol=0.6)
    table = ((0, 0.5, 1), (0, 0.8, 1))
    np.testing.assert_array_equal(
        Sensor(1, 1, response=table).develop(share), [0, 102, 204, 255, 0, 255]
    )
    dark = Sensor(1, 1, black_level=0.1, bits=8).develop(share)
    # 0.1 of the range, and the share's part of the other 0.9.
    np.testing.assert_array_equal(dark[:4], [26, 83, 140, 255])


def test_blooming_keeps_charge_in_column():
    charge = np.zeros((41, 5))
    charge[20, 2] = 1000
    spilt = bloom(charge.copy(), 100, 1.0)
    assert spilt.sum() == pytest.approx(1000)
    assert spilt.max() <= 100
    assert not spilt[:, [0, 1, 3, 4]].any()
    np.testing.assert_allclose(spilt[:, 2], spilt[::-1, 2])
    assert np.count_nonzero(spilt[:, 2]) == 11


def test_mosaic_gives_colour_and_grey():
    sensor = Sensor(20000, 20000, bits=16, bayer="RGGB")
    image = np.broadcast_to(np.array([0.2, 0.5, 0.8]), (60, 80, 3))
    rng = np.random.default_rng(5)
    colour = sensor.expose(image, rng, colour=True)
    grey = sensor.expose(image, rng)
    assert (colour.shape, colour.dtype) == ((60, 80, 3), np.uint16)
    means = colour.mean(axis=(0, 1)) / 65535
    np.testing.assert_allclose(means, [0.2, 0.5, 0.8], atol=1e-3)
    luminance = np.dot([0.2126, 0.7152, 0.0722], [0.2, 0.5, 0.8])
    assert grey.mean() / 65535 == pytest.approx(luminance, abs=1e-3)


def test_monitor_gamma_black_level_and_falloff():
    monitor = Monitor(gamma=2.2, black_level=0.01, falloff_exponent=1.5, white=0.8)
    assert monitor.radiance(1.0, 1.0) == pytest.approx(0.8)
    assert monitor.radiance(0.0, 1.0) == pytest.approx(0.008)
    angle = np.radians([0, 30, 60])
    light = monitor.radiance(np.full(3, 0.5), np.cos(angle))
    expected = 0.8 * (0.01 + 0.99 * 0.5**2.2) * np.cos(angle) ** 1.5
    np.testing.assert_allclose(light, expected)
    assert monitor.radiance(1.0, -0.5) == 0
    # Also where it is as bright from all sides before it.
    assert Monitor().radiance(1.0, -0.5) == 0
    assert Monitor().radiance(1.0, 0.3) == pytest.approx(1)


@pytest.mark.parametrize(
    ("build", "values", "field"),
    [
        (Sensor, {"white_e": 0, "full_well_e": 1}, "white_e"),
        (Sensor, {"white_e": 1, "full_well_e": -1}, "full_well_e"),
        (Sensor, {"white_e": 1, "full_well_e": 1, "read_noise_e": -1}, "read_noise_e"),
        (Sensor, {"white_e": 1, "full_well_e": 1, "blooming": 2}, "blooming"),
        (Sensor, {"white_e": 1, "full_well_e": 1, "gamma": 0}, "gamma"),
        (Sensor, {"white_e": 1, "full_well_e": 1, "black_level": 1}, "black_level"),
        (Sensor, {"white_e": 1, "full_well_e": 1, "bits": 12}, "bits"),
        (Sensor, {"white_e": 1, "full_well_e": 1, "bayer": "RGBG"}, "bayer"),
        (
            Sensor,
            {"white_e": 1, "full_well_e": 1, "response": ((0, 1), (1, 0))},
            "response",
        ),
        (
            Sensor,
            {"white_e": 1, "full_well_e": 1, "response": ((0, 0.5), (0, 1))},
            "response",
        ),
        (Monitor, {"gamma": -1}, "gamma"),
        (Monitor, {"black_level": 1}, "black_level"),
        (Monitor, {"falloff_exponent": -1}, "falloff_exponent"),
        (Monitor, {"white": 0}, "white"),
    ],
)
def test_invalid_sensor_and_monitor_are_rejected(build, values, field):
    with raises_line(f"^field '{field}': "):
        build(**values)
