"""The bench of decoders: its peers decode, its table says what it should."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from raxel.features.active_grid import decode
from tests.active_grids import drawn
from tests.bench import __main__ as bench
from tests.bench import peers
from tests.bench.decoders import (
    NO_FRINGES,
    PLAIN,
    agreement,
    bench_decoders,
    contenders,
    table,
)


@pytest.fixture(scope="module")
def scene():
    return drawn(size=(240, 180), noise=2.0, share=1.3)


@pytest.fixture(autouse=True)
def no_package(monkeypatch):
    """Where it is installed, its loops would be compiled for a minute."""
    monkeypatch.setitem(sys.modules, "fringes", None)


@pytest.mark.parametrize("peer", [peers.with_numpy, peers.with_opencv])
def test_plain_code_finds_the_places_but_at_edges(scene, peer):
    axes = peers.read_plan(scene.patterns, scene.grid.monitor_px)
    location, sigma, mask = peer(scene.images, axes, 2.0)
    off = np.moveaxis(location, 0, 2) * (1.5, 1.25) - scene.true
    assert location.dtype == sigma.dtype == np.float32
    assert np.mean(mask) > 0.95
    inner = np.abs(off[mask])
    assert np.median(inner) < 0.5
    assert np.mean(inner < 2.0) > 0.9
    found = decode(scene.images, scene.patterns, scene.grid, noise=2.0).sigma
    ratio = np.moveaxis(sigma, 0, 2) * (1.5, 1.25) / found
    assert np.nanmedian(ratio) == pytest.approx(1, abs=0.1)


def test_plain_code_with_six_steps_agrees_with_itself():
    scene = drawn(size=(120, 90), noise=1.0, share=1.3, steps=6)
    axes = peers.read_plan(scene.patterns, scene.grid.monitor_px)
    first, second = (
        peer(scene.images, axes, 1.0) for peer in (peers.with_numpy, peers.with_opencv)
    )
    assert np.median(np.abs(first[0] - second[0])) < 0.01
    np.testing.assert_allclose(first[1], second[1], rtol=1e-3)


def test_every_decoder_has_its_line_and_the_ratio_is_to_plain_opencv(scene):
    timings = bench_decoders(scene, rounds=1, cores=1)
    lines = table(timings)
    assert [t.name for t in timings] == list(contenders(scene, 1))
    by_name = {t.name: line for t, line in zip(timings, lines[1:], strict=False)}
    assert by_name[PLAIN].split()[-3] == "1.00"
    assert lines[-1] == NO_FRINGES
    assert all(t.wall_ns > 0 and t.bytes >= 0 for t in timings)


def test_the_package_has_a_line_or_the_last_one_says_how_to_get_it(scene, monkeypatch):
    class Fringes:
        X = Y = K = N = v = None

        def encode(self):
            return np.zeros((2 * self.K * self.N, self.Y, self.X), np.uint8)

        def decode(self, pictures, threads):
            assert pictures.shape == scene.images.shape
            return SimpleNamespace(x=threads)

    assert "fringes" not in contenders(scene, 1)
    monkeypatch.setitem(sys.modules, "fringes", SimpleNamespace(Fringes=Fringes))
    run, cores = contenders(scene, 2)["fringes"]
    assert run() == cores == 2


def test_the_decoder_agrees_with_plain_arithmetic(scene):
    found = agreement(scene, rows=120)
    assert (found.pixels, found.cells, found.masks) == (240 * 120, 0, 0)
    assert found.location < 1e-4


def test_sets_that_cannot_be_read_are_named_in_one_line(tmp_path, capsys):
    assert bench.main([str(tmp_path / "none")]) == 2
    assert "none" in capsys.readouterr().err
