"""The claims of Appendix A, tested as registered."""

import numpy as np

from chapters.appendix_a.phase_and_harmonics.results import odd_pairs
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value

ROUNDING_RAD = 1e-12
MARGIN = 0.1


@claim("c3_even_cancels", needs=("exp_c3_even_cancels",), evidence="analytic")
def judge_even_cancels(results):
    """Phase error below 1e-12 rad for orders 2, 4, 6, sine or cosine."""
    formula, decoder = (
        results["exp_c3_even_cancels"].select().column(name).max()
        for name in ("formula_rad", "decoder_rad")
    )
    return Reading.of(
        formula < ROUNDING_RAD,
        float(formula),
        unit="rad",
        reason="largest of all orders and amplitudes in double precision; "
        f"the decoder, in float32 and from pictures of 16 bits, {decoder:.0e} "
        "rad",
    )


@claim("c3_odd_orders_matter", needs=("exp_c3_odd_orders_matter",), evidence="analytic")
def judge_odd_orders(results):
    """Amplitude within 10 % of (b3 + b5) / b1, at four times the fundamental."""
    _, ratios, orders = odd_pairs(results["exp_c3_odd_orders_matter"])
    four = (orders == 4).all()
    near = np.abs(ratios - 1).max() <= MARGIN
    return Reading.of(
        near and four,
        f"{min(ratios):.4f} to {max(ratios):.4f} of (b3 + b5)/b1",
        reason=f"{len(ratios)} pairs of b3 and b5 of up to 5 %; the "
        "strongest order of the error is " + ("4 in all" if four else "not 4 in all"),
    )


@numbers("app_a", needs=("exp_c3_even_cancels",), evidence="analytic")
def values_of_even_orders(results):
    """The largest phase error by any even order, double precision."""
    largest = results["exp_c3_even_cancels"].select().column("formula_rad").max()
    found = Value(float(largest), unit="rad")
    if largest < ROUNDING_RAD:
        reason = f"{largest:.0e} rad is the rounding of double precision"
        found = Value(0.0, unit="rad", reason=reason)
    return {"app_a_even": found}
