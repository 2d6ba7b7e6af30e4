"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.appendix_a.phase_and_harmonics.experiment import MAX_ORDER, SMALL, STEPS
from chapters.shared.grids import phase_of, power_law_orders, stepped, sum_of_orders
from repro.page import new_figure, value
from repro.run import (
    Check,
    Drawing,
    Reading,
    Table,
    Value,
    claim,
    columns,
    figure,
    numbers,
    table,
)

# Phase errors of Appendix A, and the values that its page quotes.


PERCENT_OF_PERIOD = 100 / (2 * np.pi)
GAMMA = 2.2
KINDS = ("sine", "cosine")


def ratios_at(phase, b3):
    """Return the ratio of (3.23), and the first two terms of (A.9) as printed."""
    profile = sum_of_orders({1: 1.0, 3: b3})
    true = np.tan(phase_of(stepped(profile, 4, np.array([phase])))[0])
    return float(true), float(np.tan(phase) - np.tan(3 * phase))


def name_values(open_results):
    """Name the values that the page quotes."""
    odd = open_results("exp_c3_odd_orders_matter")
    (size,) = odd.column("amplitude_rad", b3=0.01, b5=0.0)
    true, printed = ratios_at(0.4, 0.05)
    law = power_law_orders(GAMMA, 3)
    found = {
        "odd.one_percent": size,
        "odd.share": PERCENT_OF_PERIOD * size,
        "ratio.true": true,
        "ratio.printed": printed,
        "law.two": 100 * law[1],
        "law.three": 100 * law[2],
    }
    for name, number in found.items():
        value(name, number)


# Orders of a profile that disturb a number of phase steps.


@figure("ext_orders_of_steps", needs=("ext_orders_of_steps",), evidence="analytic")
def ext_orders_of_steps(results):
    """Draw the phase error by order and by number of steps."""
    ran = results["ext_orders_of_steps"]
    orders = tuple(range(2, MAX_ORDER + 1))
    # One trial per condition; the larger one of sine and cosine.
    errors = [ran.column(KINDS, orders, steps=n).max(axis=0)[:, 0] for n in STEPS]
    size = np.array(errors) / SMALL
    drawn, axes = new_figure(height_in=2.4)
    axes.grid(False)
    axes.imshow(size, cmap="Blues", vmin=0, vmax=1.3, aspect="auto", rasterized=True)
    for row in range(len(STEPS)):
        for column, n in enumerate(orders):
            if size[row, column] > 1e-6:
                axes.text(column, row, f"{n}", ha="center", va="center", color="white")
    axes.set_xticks(range(len(orders)), [f"{n}" for n in orders])
    axes.set_yticks(range(len(STEPS)), [f"{n}" for n in STEPS])
    axes.set(xlabel="Order of the profile", ylabel="Number of phase steps")
    expected = np.array([[n % s in (1, s - 1) for n in orders] for s in STEPS])
    return Drawing(
        drawn,
        {
            "steps": np.repeat(STEPS, len(orders)).tolist(),
            "order": np.tile(orders, len(STEPS)).tolist(),
            "error per share": size.ravel().tolist(),
        },
        "Phase error by order of the profile and number N of phase steps. Filled: "
        "orders that shift the phase, by their share of the first order. Empty: orders "
        "that cancel. Only the orders mN − 1 and mN + 1 are filled.",
        Check(
            bool(np.all((size > 0.5) == expected) and size[~expected].max() < 1e-9),
            "the orders that disturb are mN ± 1, and no others",
        ),
    )


# The derivation of Appendix A as a table.


SHOWN_ORDERS = range(1, 10)
HEADS = (
    "order n",
    "in I1 − I3 (A.7)",
    "in I2 − I4 (A.8)",
    "phase error, to first order",
    "from 1 % as a sine (rad)",
    "from 1 % as a cosine (rad)",
)


def across(n):
    """Return what order n adds to I1 - I3 and to I2 - I4, LaTeX."""
    if n % 2 == 0:
        return "0", "0"
    wave = r"\phi" if n == 1 else rf"{n}\phi"
    sign = "" if n % 4 == 1 else "-"
    return (rf"$2 b_{n} \sin {wave}$", rf"${sign}2 b_{n} \cos {wave}$")


def first_order(n):
    """Return the derived phase error of order n, LaTeX, and its size per b_n / b_1."""
    if n == 1:
        return "none: the fundamental", 0.0
    if n % 2 == 0:
        return "0", 0.0
    m = (n + 1) // 4
    return rf"$(b_{n}/b_1) \sin {4 * m}\phi$", 1.0


@table("app_a", needs=("ext_orders_of_steps",), evidence="analytic")
def app_a(results):
    """Tabulate (A.7) and (A.8) by order, and the phase error of (3.23)."""
    ran = results["ext_orders_of_steps"]
    rows, agree = [], True
    for n in SHOWN_ORDERS:
        text, size = first_order(n)
        found = [None, None]
        if n > 1:
            found = ran.column(KINDS, n, steps=4)[:, 0].tolist()
            agree &= all(abs(error - SMALL * size) <= SMALL**2 for error in found)
        # Rounding errors of double precision are shown as zero.
        found = [v if v is None or v > 1e-12 else 0.0 for v in found]
        rows.append((n, *across(n), text, *found))
    return Table(
        columns(HEADS, rows),
        "Effect of each order of the profile on four-step decoding. Middle columns: "
        "what a sine of that order adds to the two differences. Right: largest phase "
        "error of (3.23) when that order alone has 1 % of the first.",
        Check(
            bool(agree),
            "every error equals its first-order value within 0.0001 rad, the "
            "square of 1 %",
        ),
    )


# The claims of Appendix A, tested as registered.


ROUNDING_RAD = 1e-12
MARGIN = 0.1


@claim("c3_even_cancels", needs=("exp_c3_even_cancels",), evidence="analytic")
def judge_even_cancels(results):
    """Phase error below 1e-12 rad for orders 2, 4, 6, sine or cosine."""
    every = results["exp_c3_even_cancels"].select()
    formula, decoder = every.column(("formula_rad", "decoder_rad")).max(axis=1)
    return Reading.of(
        formula < ROUNDING_RAD,
        float(formula),
        unit="rad",
        reason="largest of all orders and amplitudes in double precision; "
        f"the decoder, in float32 and from images of 16 bits, {decoder:.0e} "
        "rad",
    )


@claim("c3_odd_orders_matter", needs=("exp_c3_odd_orders_matter",), evidence="analytic")
def judge_odd_orders(results):
    """Amplitude within 10 % of (b3 + b5) / b1, at four times the fundamental."""
    ran = results["exp_c3_odd_orders_matter"]
    size, orders = ran.select().column(("amplitude_rad", "strongest_order"))
    ratios = size / [c["b3"] + c["b5"] for c in ran.conditions]
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
