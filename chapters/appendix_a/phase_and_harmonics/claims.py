"""The claims of Appendix A, tested as the ledger words them."""

from __future__ import annotations

from chapters.appendix_a.phase_and_harmonics.results import odd_pairs, over
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value

ROUNDING_RAD = 1e-12
MARGIN = 0.1


@claim("c3_even_cancels", needs=("exp_c3_even_cancels",), evidence="analytic")
def judge_even_cancels(results):
    """Phase error below 1e-12 rad for orders 2, 4, 6, sine or cosine."""
    ran = results["exp_c3_even_cancels"]
    formula = over(ran, "formula_rad", ran.conditions).max()
    decoder = over(ran, "decoder_rad", ran.conditions).max()
    return Reading(
        "reproduced" if formula < ROUNDING_RAD else "differs",
        float(formula),
        unit="rad",
        reason="largest of all orders and amplitudes in double precision; "
        f"the decoder, in float32 and from pictures of 16 bits, {decoder:.0e} "
        "rad",
    )


@claim("c3_odd_orders_matter", needs=("exp_c3_odd_orders_matter",), evidence="analytic")
def judge_odd_orders(results):
    """Amplitude within 10 % of (b3 + b5) / b1, at four times the fundamental."""
    pairs = odd_pairs(results["exp_c3_odd_orders_matter"])
    ratios = [ratio for _, _, ratio, _ in pairs]
    four = all(order == 4 for *_, order in pairs)
    near = max(abs(ratio - 1) for ratio in ratios) <= MARGIN
    return Reading(
        "reproduced" if near and four else "differs",
        f"{min(ratios):.4f} to {max(ratios):.4f} of (b3 + b5)/b1",
        reason=f"{len(pairs)} pairs of b3 and b5 of up to 5 %; the "
        "strongest order of the error is " + ("4 in all" if four else "not 4 in all"),
    )


@numbers("app_a", needs=("exp_c3_even_cancels",), evidence="analytic")
def values_of_even_orders(results):
    """The largest phase error by any even order, double precision."""
    ran = results["exp_c3_even_cancels"]
    largest = float(over(ran, "formula_rad", ran.conditions).max())
    exact = largest < ROUNDING_RAD
    return {
        "app_a_even": Value(
            0.0 if exact else largest,
            unit="rad",
            reason=f"{largest:.0e} rad is the rounding of double precision"
            if exact
            else "",
        )
    }
