"""Phase errors against gamma, steps and orders, and over one period."""

import numpy as np

from chapters.appendix_a.phase_and_harmonics.results import (
    GAMMA,
    PERCENT_OF_PERIOD,
    one,
)
from chapters.appendix_a.phase_and_harmonics.trials import (
    GAIN,
    MOST_ORDER,
    SMALL,
    STEPS,
    profile_of,
)
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

LAWS = {
    "power": "(a) power law",
    "clipped": f"(b) contrast {100 * (GAIN - 1):.0f} % too high",
}
# Below this share of a period the rounding of 16 bits is what is seen.
FLOOR = 1e-3
# Of a period, %: what the orders of a cut-off profile that are left out come to.
AGREE = 5e-3


@figure("ext_phase_error_gamma", needs=("ext_phase_error_gamma",), evidence="analytic")
def ext_phase_error_gamma(results):
    """Largest error of the decoder against gamma, beside the prediction."""
    ran = results["ext_phase_error_gamma"]
    gammas = sorted({c["gamma"] for c in ran.conditions if c["law"] == "power"})
    drawn, both = new_figure(1, 2, height_in=3.6, sharey=True)
    rows, apart = [], 0.0
    for axes, (law, title) in zip(both, LAWS.items(), strict=True):
        for k, steps in enumerate(STEPS):
            look = series(k)
            found = {
                name: np.array(
                    [
                        PERCENT_OF_PERIOD
                        * one(ran, name, law=law, gamma=g, steps=steps)
                        for g in gammas
                    ]
                )
                for name in ("decoder_rad", "predicted_rad", "apart_rad")
            }
            apart = max(apart, found["apart_rad"].max())
            axes.plot(gammas, found["predicted_rad"], **look | {"marker": ""})
            axes.plot(
                found["decoder_rad"],
                color=look["color"],
                marker=look["marker"],
                linestyle="",
                markersize=4,
            )
            axes.plot([], [], label=f"{steps} steps", **look)
            both_errors = found["decoder_rad"], found["predicted_rad"]
            rows += [
                (law, steps, *cells) for cells in zip(gammas, *both_errors, strict=True)
            ]
        axes.set(yscale="log", ylim=(FLOOR, 20), title=title)
        axes.set_xlabel("Gamma of the response (1)")
    both[0].set_ylabel("Largest phase error (% of a period)")
    both[1].legend(loc="lower right", fontsize=8)
    return Drawing(
        drawn,
        columns(("law", "steps", "gamma", "decoder (%)", "predicted (%)"), rows),
        "With a power law more steps help, and a gamma of 2 forgives all but three; "
        "where values are cut off, neither helps. Largest phase error over a period "
        "against gamma: found by the decoder (marks), and predicted from the Fourier "
        "orders (lines). What is below the frame is rounding.",
        Check(
            apart < AGREE,
            f"decoder and prediction differ by {apart:.1e} % of a period at most",
        ),
    )


@figure("ext_orders_of_steps", needs=("ext_orders_of_steps",), evidence="analytic")
def ext_orders_of_steps(results):
    """Which orders disturb which number of steps."""
    ran = results["ext_orders_of_steps"]
    orders = np.arange(2, MOST_ORDER + 1)
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
    axes.set(xlabel="Order of the profile (1)", ylabel="Phase steps (1)")
    expected = np.array([[n % s in (1, s - 1) for n in orders] for s in STEPS])
    return Drawing(
        drawn,
        {
            "steps": np.repeat(STEPS, len(orders)).tolist(),
            "order": np.tile(orders, len(STEPS)).tolist(),
            "error per share": size.ravel().tolist(),
        },
        "N steps are disturbed by the orders mN − 1 and mN + 1 alone. Filled: "
        "orders that shift a phase, by as much as they have of the first order; "
        "empty: those that cancel.",
        Check(
            bool(np.all((size > 0.5) == expected) and size[~expected].max() < 1e-9),
            "the orders that disturb are mN ± 1, and no others",
        ),
    )


@figure("ext_phase_error_period", needs=("ext_phase_error_gamma",), evidence="analytic")
def ext_phase_error_period(results):
    """A profile, whole and cut off, and the error over its period."""
    ran = results["ext_phase_error_gamma"]
    drawn, rows = new_figure(2, 2, height_in=4.6, sharex=True, sharey="row")
    cells = []
    labels = [f"{n} steps (%)" for n in (4, 6)]
    for column, (law, title) in enumerate(LAWS.items()):
        condition = {"law": law, "gamma": GAMMA}
        top, bottom = rows[:, column]
        errors = {
            n: PERCENT_OF_PERIOD
            * ran.arrays("error", steps=n, **condition)[0].astype(float)
            for n in (4, 6)
        }
        place = (np.arange(len(errors[4])) + 0.5) / len(errors[4])
        light = profile_of(condition)(2 * np.pi * place)
        top.plot(place, light, **series(0) | {"marker": ""}, label="light")
        top.plot(
            place,
            0.5 + 0.5 * np.sin(2 * np.pi * place),
            **series(6) | {"marker": ""},
            label="sine",
        )
        top.set_title(title)
        for k, n in enumerate((4, 6)):
            look = series(1 + k) | {"marker": ""}
            bottom.plot(place, errors[n], **look, label=f"{n} steps")
        cells += [
            (law, *row) for row in zip(place, light, *errors.values(), strict=True)
        ]
        bottom.set_xlabel("Place in the period (periods)")
    rows[0, 0].set_ylabel("Profile (1)")
    rows[0, 0].legend(loc="upper right")
    rows[1, 0].set(ylabel="Phase error (% of a period)", ylim=(-0.36, 0.5))
    rows[1, 0].legend(loc="upper right", ncols=2)
    return Drawing(
        drawn,
        columns(("law", "period", "profile", *labels), cells),
        "The error oscillates as often in a period as there are steps. Top: what a "
        f"monitor with a gamma of {GAMMA} makes of a sine; bottom: error of the "
        "decoder there.",
    )
