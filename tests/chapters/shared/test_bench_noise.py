"""The bench's noise: what becomes of decoding errors, and of verdicts in its sweep."""

from pathlib import Path

import numpy as np
import pytest

from chapters.shared.central import noise
from chapters.shared.central.noise import (
    MATCHED,
    NOISES,
    SWEPT,
    DecodingNoise,
    counterpart_over_the_sweep,
    over_the_sweep,
)
from chapters.shared.central.sets import ScoredGrid
from raxel.features.active_grid import Decoded
from raxel.features.active_grid.errors import Noise
from repro.judge.ledger import read_yaml
from repro.run.outcomes import Reading
from repro.run.readings import Case

ROOT = Path(__file__).resolve().parents[3]
QUESTIONS = {
    "decoding_noise": noise.OPTIONS,
    "standard_method": {"as printed": "a", "well conditioned": "b"},
}


def scene(seed=0):
    """True points (5, 40, 2), and decoded ones, some of them missing."""
    rng = np.random.default_rng(seed)
    true = rng.uniform(0, 300, (5, 40, 2))
    decoded = true + 0.05 * rng.standard_normal(true.shape)
    decoded[0, :3] = np.nan
    return true, decoded


def test_noise_scales_errors_and_keeps_pixels_without_truth():
    true, decoded = scene()
    true[2, 5] = np.nan
    found = DecodingNoise(4.0).points(decoded, true, np.random.default_rng(1))
    np.testing.assert_allclose(found - true, 4 * (decoded - true), atol=1e-11)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(decoded))
    np.testing.assert_array_equal(found[2, 5], decoded[2, 5])


def test_low_noise_level_changes_and_draws_nothing():
    true, decoded = scene()
    rng = np.random.default_rng(2)
    assert NOISES["laboratory"].points(decoded, true, rng) is decoded
    assert rng.random() == np.random.default_rng(2).random()


def test_white_errors_keep_their_size_and_are_uncorrelated():
    true = np.zeros((60, 60, 2))
    smooth = np.stack(np.meshgrid(*[np.linspace(-1, 1, 60)] * 2), axis=-1)
    rng = np.random.default_rng(3)
    found = DecodingNoise(2.0, white=True).points(smooth, true, rng)
    np.testing.assert_allclose(np.abs(found), 2 * np.abs(smooth))
    x, y = found[..., 0], found[..., 1]
    for one, other in ((x[:, 1:], x[:, :-1]), (y[1:], y[:-1]), (x, y)):
        correlation = np.corrcoef(one.ravel(), other.ravel())[0, 1]
        assert abs(correlation) < 4 / np.sqrt(x.size)


def test_sigma_follows_the_factor():
    true, decoded = scene()
    nothing = np.zeros(true.shape[:2], np.uint8)
    nothing[0, :3] = 3
    view = Decoded(
        decoded, np.full(true.shape, 0.02), np.zeros(true.shape, np.int16), nothing,
        "mm", Noise(1.0, 0.0), None, 6,
    )  # fmt: skip
    grid = ScoredGrid("first", view, true, np.eye(4))
    found = DecodingNoise(3.0).decoded(grid, np.random.default_rng(4))
    np.testing.assert_allclose(found.sigma, 0.06)
    kept = view.mask
    np.testing.assert_allclose(
        (found.location - true)[kept], 3 * (decoded - true)[kept], atol=1e-11
    )


def test_factors_and_sweep_match_the_ledger():
    entries = {
        e["id"]: e for e in read_yaml(ROOT / "data/published/settings.yaml")["settings"]
    }
    chosen = entries["cam_d70_onevr"]["chosen"]
    assert chosen["bench_noise_factor"]["value"] == {
        "7 x 7": noise.FACTOR,
        "white": noise.WHITE_FACTOR,
    }
    assert chosen["bench_noise_sweep"]["value"] == list(noise.MULTIPLES)
    assert (min(noise.MULTIPLES), max(noise.MULTIPLES)) == (0.5, 2)


def reading_at(noise):
    return Reading("reproduced", 1.0, reason=f"at {noise}")


@pytest.mark.parametrize("turned", SWEPT.values())
def test_verdict_that_the_factor_decides_is_undecided(turned):
    found = over_the_sweep(Case(QUESTIONS), reading_at, lambda noise: noise != turned)
    assert found.verdict == "undecided"
    assert "changes side" in found.reason


def test_verdict_on_one_side_of_its_bound_is_kept():
    for side in (True, False):
        made = over_the_sweep(Case(QUESTIONS), reading_at, lambda noise, s=side: s)
        assert made == reading_at(MATCHED)


@pytest.mark.parametrize(
    "options",
    [
        {"decoding_noise": "laboratory"},
        {"decoding_noise": "bench, white"},
        {"standard_method": "well conditioned"},
    ],
)
def test_sweep_applies_to_the_primary_reading_only(options):
    case = Case(QUESTIONS, options)

    def side_at(noise):
        raise AssertionError(f"no sweep is run at {noise}")

    assert over_the_sweep(case, reading_at, side_at).verdict == "reproduced"


@pytest.mark.parametrize(
    ("least", "verdict"), [(50, "reproduced"), (44, "undecided"), (20, "undecided")]
)
def test_counterpart_needs_nine_of_ten_in_the_whole_sweep(least, verdict):
    def found_at(noise):
        count = least if noise == SWEPT[2.0] else 50
        return np.arange(50) < count, np.ones(50), "", "words"

    assert counterpart_over_the_sweep(Case(QUESTIONS), found_at).verdict == verdict
