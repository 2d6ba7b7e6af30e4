"""The derivation of Appendix A as a table."""

from chapters.appendix_a.phase_and_harmonics.results import one
from chapters.appendix_a.phase_and_harmonics.trials import SMALL
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Table

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
        found = [
            None if n == 1 else one(ran, f"{kind}.{n}", steps=4)
            for kind in ("sine", "cosine")
        ]
        if n > 1:
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
