"""The numbers that the page of section 4.1.4 quotes."""

import numpy as np

from chapters.ch04_central_generic.s1_4_bundle_adjustment.trials import SCHEMES
from repro.page.reader import value

ONE_PLACE = 0.01  # of the starts' spread: ends as close as this are one


def name_values(open_results):
    """Name the numbers that the prose quotes: medians over scenes."""
    starts = open_results("exp_c4_centre_ba_unstable")
    rest = starts.column("line_fitting.at_rest")
    spread = starts.column("line_fitting.spread_over_starts")
    found = {
        **{
            f"starts.{scheme}.{name}": np.median(starts.column(f"{scheme}.{name}"))
            for scheme in SCHEMES
            for name in ("spread_over_starts", "spread_over_draws", "above_best")
        },
        **{
            f"{scheme}.centre_mm": np.median(
                np.concatenate(starts.arrays(f"{scheme}.ends_mm"))
            )
            for scheme in SCHEMES
        },
        "linear.centre_mm": np.median(
            np.concatenate(starts.arrays("consistent.starts_mm"))
        ),
        "scenes": starts.trials_per_condition,
        "scenes.one_place": np.sum((rest == 1) & (spread < ONE_PLACE)),
        "scenes.no_rest": np.sum(rest < 1),
    }
    for name, number in found.items():
        value(name, number)
