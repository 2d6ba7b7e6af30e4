"""The localisers of section 3.1.3 side by side."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s1_3_localisation.trials import SQUARES_PX
from repro.run.experiment import table
from repro.run.outcomes import Table

LOCALISERS = ("saddle point", "derivative", "OpenCV")


@table(
    "ext_localisers", needs=("ext_localiser_spread",), evidence="rendered"
)
def ext_localisers(results):
    """Error, stated SD and bias of three localisers with their defaults."""
    result = results["ext_localiser_spread"]
    names = {
        "converged": "found (%)",
        "rms_px": "RMS error per axis (px)",
        "sd_px": "stated SD (px)",
        "bias_px": "RMS error without noise (px)",
        "score_sd": "error / stated SD (1)",
        "within": "within one stated SD (%)",
    }
    columns = {"square (px)": [], "localiser": []}
    columns |= {name: [] for name in names.values()}
    for square in SQUARES_PX:
        for localiser in LOCALISERS:
            columns["square (px)"].append(square)
            columns["localiser"].append(localiser)
            for key, name in names.items():
                trials = result.column(
                    f"{localiser}.{key}", square_px=square
                )
                scale = 100 if "%" in name else 1
                columns[name].append(float(scale * np.mean(trials)))
    return Table(
        columns,
        "The three localisers with their default settings on the images of "
        "Fig. 3.5, means over the images. The stated SD is that of noise; "
        "what remains without noise is bias.",
    )
