"""The numbers that the page quotes."""

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.results.corrected import (
    BOARDS,
    LINES,
    NAMES,
    Corrected,
)
from chapters.shared.bench_noise import BENCH
from chapters.shared.central_sets import FISH, OMNI
from repro.page.reader import value


def name_values(open_results):
    """Name the numbers of the prose: medians of the trials that have a value."""
    boards, lines = open_results(BOARDS), open_results(LINES)
    wanted = [
        *(
            (f"{short}.{method}.{name}", result, camera, f"{method}.{key}")
            for short, camera in (("omni", OMNI), ("fish", FISH))
            for method in NAMES
            for name, result, key in (
                ("mean", boards, "mean_mm"),
                ("worst", lines, "worst_share"),
            )
        ),
        *(
            (f"{name}.{method}", result, camera, f"{method}.{key}")
            for name, result, camera, key in (
                ("seam", boards, OMNI, "seam_ratio"),
                ("skew", boards, FISH, "skew_spearman"),
                ("vertical", lines, OMNI, "vertical_deg"),
            )
            for method in ("printed", "cgsp")
        ),
    ]
    found = {
        "omni.boards": int(boards.select(camera=OMNI).column("boards_found").sum()),
        "fish.boards": int(boards.select(camera=FISH).column("boards_found").sum()),
        "trials": lines.trials_per_condition,
    }
    for name, result, camera, key in wanted:
        percent = 100 if name.endswith(".worst") else 1
        for prefix, noise in (("", BENCH), ("lab.", "laboratory")):
            trials = Corrected(result, noise=noise).of(camera, key)
            found[prefix + name] = percent * np.nanmedian(trials)
    for name, number in found.items():
        value(name, number)
