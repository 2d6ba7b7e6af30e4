"""Orders of a profile that disturb a number of phase steps."""

import numpy as np

from chapters.appendix_a.phase_and_harmonics.results import one
from chapters.appendix_a.phase_and_harmonics.trials import MAX_ORDER, SMALL, STEPS
from repro.page.style import figure as new_figure
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing


@figure("ext_orders_of_steps", needs=("ext_orders_of_steps",), evidence="analytic")
def ext_orders_of_steps(results):
    """Draw the phase error by order and by number of steps."""
    ran = results["ext_orders_of_steps"]
    orders = np.arange(2, MAX_ORDER + 1)
    size = np.array(
        [
            [
                max(one(ran, f"{kind}.{n}", steps=steps) for kind in ("sine", "cosine"))
                for n in orders
            ]
            for steps in STEPS
        ]
    )
    size = size / SMALL
    drawn, axes = new_figure(height_in=2.4)
    axes.grid(False)
    picture = axes.imshow(size, cmap="Blues", vmin=0, vmax=1.3, aspect="auto")
    picture.set_rasterized(True)
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
