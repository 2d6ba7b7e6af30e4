"""Phase steps of 3.2.2 and Appendix A: orders, what they do to a phase, and claims."""

import numpy as np
import pytest

from chapters.appendix_a.phase_and_harmonics import report as appendix
from chapters.ch03_planar_grids.s2_2_active_grids import experiment, report
from chapters.shared.grids import phase_steps
from tests.judged_claims import readings
from tests.made_results import of_columns

PHASE = 2 * np.pi * (np.arange(240) + 0.5) / 240


@pytest.mark.parametrize("gamma", [1.0, 1.4, 2.0, 2.2, 2.6])
def test_power_law_harmonics_match_the_closed_form(gamma):
    a, b = phase_steps.orders(phase_steps.power_law(gamma), 6)
    share = np.hypot(a, b)[1:] / np.hypot(a[1], b[1])
    np.testing.assert_allclose(
        np.abs(phase_steps.power_law_orders(gamma, 6)), share, atol=1e-7
    )
    # Odd orders are sines and even ones cosines.
    assert max(np.abs(a[1::2]).max(), np.abs(b[2::2]).max()) < 1e-12


@pytest.mark.parametrize("count", [3, 4, 5, 6, 8])
def test_only_orders_next_to_multiples_of_the_steps_shift_a_phase(count):
    # As many as no order divides; the decoder rounds its weights to 12 digits.
    fine = 2 * np.pi * np.arange(997) / 997
    for order in range(2, 20):
        for parts in (({1: 1.0, order: 0.01}, {}), ({1: 1.0}, {order: 0.01})):
            error = phase_steps.formula_error(
                phase_steps.sum_of_orders(*parts), count, fine
            )
            moves = order % count in (1, count - 1)
            size = phase_steps.largest(error)
            assert size == pytest.approx(0.01, abs=1e-4) if moves else size < 1e-12


@pytest.mark.parametrize("count", [3, 4, 5, 6, 8])
def test_formula_and_decoder_agree(count):
    rng = np.random.default_rng(count)
    sines = {1: 1.0} | dict(enumerate(rng.uniform(-0.05, 0.05, 9), 2))
    cosines = dict(enumerate(rng.uniform(-0.05, 0.05, 9), 2))
    profile = phase_steps.sum_of_orders(sines, cosines, 2.0)
    formula = phase_steps.formula_error(profile, count, PHASE)
    phase, decoded = phase_steps.decoder_error(profile, count, len(PHASE))
    np.testing.assert_allclose(phase, PHASE)
    # Rounding to 16 bits over 0.8 of their range.
    np.testing.assert_allclose(decoded, formula, atol=5e-5)


def test_four_step_error_has_the_derived_sign():
    profile = phase_steps.sum_of_orders({1: 1.0, 3: 0.01, 5: 0.004}, {3: 0.002})
    error = phase_steps.formula_error(profile, 4, PHASE)
    first = 0.014 * np.sin(4 * PHASE) + 0.002 * np.cos(4 * PHASE)
    np.testing.assert_allclose(error, first, atol=3e-4)


def test_sinusoid_fit_recovers_harmonics_and_residual():
    profile = phase_steps.sum_of_orders({1: 80.0, 3: 2.0}, {2: 10.0}, 100.0)(PHASE)
    for further, rms in ((0, np.sqrt(52)), (1, np.sqrt(2)), (2, 0.0)):
        fit, misfit, sizes = experiment.fitted(profile, further)
        assert misfit == pytest.approx(rms, abs=1e-9)
        np.testing.assert_allclose(sizes, [80, 10, 2][: further + 1], atol=1e-9)
        np.testing.assert_allclose(fit.mean(), 100)


def test_harmonic_sizes_follow_from_misfits():
    two, three, rest = experiment.order_sizes()
    assert np.sqrt((two**2 + three**2 + rest**2) / 2) == pytest.approx(9.839)
    assert np.sqrt((three**2 + rest**2) / 2) == pytest.approx(1.309)


@pytest.mark.parametrize("slant", [0.0, 1.0])
def test_slanted_edges_are_area_sampled(slant):
    condition = {"blur_px": 1e-3, "noise_grey": 0.0, "slant_px": slant, "light": "even"}
    place, image, inverse, *_ = experiment.bit_images(
        condition, np.random.default_rng(0)
    )
    low, high = experiment.LEVELS_GREY
    # A pixel whose middle is on the lit side is lit by half or more.
    lit = (image - low) / (high - low) > 0.5
    off = np.abs(place - np.rint(place)) * experiment.EDGE_PX
    inner = off > 0.01
    np.testing.assert_array_equal(lit[inner], (np.floor(place) % 2 == 1)[inner])
    assert np.abs(image.astype(float) + inverse - low - high).max() <= 1
    shares = np.unique(image)
    assert len(shares) == 2 if slant == 0 else len(shares) > 40


def test_wrong_gray_bit_costs_one_cell_at_its_edge():
    found = experiment.wrong_bit_trial({"bits": 4}, None)
    assert (found["bits_changed"], found["shift"]) == (1, 1)
    assert found["shift_elsewhere"] == 15
    assert (found["binary_bits_changed"], found["binary_shift"]) == (4, 8)


def test_appendix_a_claims_hold_and_fail():
    even = {"formula_rad": 1e-3, "decoder_rad": 1e-3}
    assert _verdict(appendix.judge_even_cancels, "exp_c3_even_cancels", even) == (
        "differs"
    )

    def odd(share, strongest=4):
        def values(condition):
            amplitude = share * (condition["b3"] + condition["b5"])
            return {"amplitude_rad": amplitude, "strongest_order": strongest}

        return _verdict(appendix.judge_odd_orders, "exp_c3_odd_orders_matter", values)

    assert (odd(1.0), odd(1.0, strongest=2)) == ("reproduced", "differs")
    assert odd(0.85) == "differs"


def _imaged(orders_3, noise, one_sine=8.0):
    """Columns of views whose order 3 has these RMS sizes, with this much noise."""
    rms = {
        "rms_0": [one_sine] * len(orders_3),
        "rms_1": np.hypot(orders_3, noise),
        "rms_2": [noise] * len(orders_3),
    }
    return {f"{c}.2.2.{k}": v for c in ("linear", "sRGB") for k, v in rms.items()}


def test_single_sine_claim_uses_the_share_of_views():
    values = _imaged([1, 1, 1], 0.1)
    assert _verdict(report.judge_single_sine, "fig_3_9", values) == "reproduced"
    values = _imaged([1, 1, 9], 0.1)
    assert _verdict(report.judge_single_sine, "fig_3_9", values) == "differs"


@pytest.mark.parametrize("noise", [0.01, 1.308])
def test_third_harmonic_claim_is_independent_of_noise(noise):
    def verdicts(orders_3):
        values = _imaged(orders_3, noise)
        found = readings(report.judge_third_marginal, "fig_3_9", values)
        return {r.reading["sine_amplitude"]: r.verdict for r in found}

    # 5 % of a misfit that leaves 1.308 grey levels are 0.43 of them.
    assert set(verdicts([0.42] * 3).values()) == {"reproduced"}
    assert set(verdicts([0.42, 0.42, 0.80]).values()) == {"differs"}
    assert verdicts([0.6] * 3) == {
        "80 grey levels": "differs",
        "50 grey levels": "reproduced",
    }


def test_bits_are_counted_per_kind_of_edge():
    conditions = [
        {"slant_px": experiment.SLANT_PX[edges], "light": light, "noise_grey": n}
        for edges, light in experiment.EDGES_AND_LIGHT
        for n in (4, 8)
    ]
    values = {
        "inverse.wrong": [1, 1, 1],
        "pixels": [10, 10, 10],
        "white and black.only_threshold": [5, 5, 5],
        "white and black.only_inverse": [0, 0, 0],
    }

    def wrong_bits(c):
        return {"white and black.wrong": c["noise_grey"] * (1 + c["slant_px"])}

    result = of_columns(*((c, values | wrong_bits(c)) for c in conditions))
    wrong, paired, pixels, only, other = report.bit_counts(
        result, "anywhere", "even", "white and black"
    )
    np.testing.assert_array_equal(wrong, [24, 24, 24])
    assert (paired.sum(), pixels.sum(), only, other) == (6, 60, 30, 0)
    between = report.bit_counts(result, "between pixels", "even", "white and black")
    assert between[0].sum() == 36


def test_light_falls_off_as_the_rig_states():
    light = experiment.light_along(9, "falls off")
    assert light[0] == 1
    # Half a diagonal of 304 x 228 mm is 190 mm, 375 mm away.
    assert light[-1] == pytest.approx((1 + (190 / 375) ** 2) ** (-5.5 / 2))
    assert (np.diff(light) < 0).all()
    assert (experiment.light_along(9, "even") == 1).all()


def test_exact_threshold_doubles_the_noise_variance_of_an_inverse():
    condition = {"blur_px": 3, "noise_grey": 8, "slant_px": 1.0, "light": "even"}
    rng = np.random.default_rng(1)
    found = [experiment.bits_trial(condition, rng) for _ in range(12)]
    inverse = sum(one["inverse.wrong"] for one in found)
    for name, expected in (
        ("one grey value", np.sqrt(2)),
        ("white and black", np.sqrt(3)),
        ("mean of the sines", np.sqrt(2.5)),
    ):
        ratio = sum(one[name]["wrong"] for one in found) / inverse
        # Three standard deviations of a ratio of two counts.
        assert ratio == pytest.approx(expected, rel=3 * np.sqrt(2 / inverse))


def _verdict(judge, name, values):
    return readings(judge, name, values)[0].verdict
