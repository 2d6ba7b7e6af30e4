"""Phase errors of Appendix A, and the values that its page quotes."""

import numpy as np

from chapters.shared.phase_steps import (
    phase_of,
    power_law_orders,
    stepped,
    sum_of_orders,
)
from repro.page.reader import value

PERCENT_OF_PERIOD = 100 / (2 * np.pi)
GAMMA = 2.2


def one(result, name, **condition):
    """Return the value of a deterministic experiment: one trial per condition."""
    return float(result.column(name, **condition)[0])


def odd_pairs(result):
    """Return, per pair of b3 and b5: amplitude, ratio to b3 + b5, strongest order."""
    size, order = (
        result.select().column(name) for name in ("amplitude_rad", "strongest_order")
    )
    return size, size / [c["b3"] + c["b5"] for c in result.conditions], order


def ratios_at(phase, b3):
    """Return the ratio of (3.23), and the first two terms of (A.9) as printed."""
    profile = sum_of_orders({1: 1.0, 3: b3})
    true = np.tan(phase_of(stepped(profile, 4, np.array([phase])))[0])
    return float(true), float(np.tan(phase) - np.tan(3 * phase))


def name_values(open_results):
    """Name the values that the page quotes."""
    odd = open_results("exp_c3_odd_orders_matter")
    size = one(odd, "amplitude_rad", b3=0.01, b5=0.0)
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
