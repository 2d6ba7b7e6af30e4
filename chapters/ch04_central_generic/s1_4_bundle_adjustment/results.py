"""Numbers quoted on the page of section 4.1.4."""

import numpy as np

from repro.page.reader import value

ONE_POINT = 0.01  # maximum spread of ends that count as one, in spreads of the starts


def name_values(open_results):
    """Name the numbers that the prose quotes: medians over scenes."""
    starts = open_results("exp_c4_centre_ba_unstable")
    rest = starts.column("line_fitting.at_rest")
    spread = starts.column("line_fitting.spread_over_starts")
    found = {
        **{
            f"{scheme}.centre_mm": np.median(
                np.concatenate(starts.arrays(f"{scheme}.ends_mm"))
            )
            for scheme in ("line_fitting", "consistent")
        },
        "linear.centre_mm": np.median(
            np.concatenate(starts.arrays("consistent.starts_mm"))
        ),
        "scenes": starts.trials_per_condition,
        "scenes.one_place": np.sum((rest == 1) & (spread < ONE_POINT)),
        "scenes.no_rest": np.sum(rest < 1),
    }
    for name, number in found.items():
        value(name, number)
