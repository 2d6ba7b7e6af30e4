"""Decoding errors as large as those of the thesis's bench.

The laboratory decodes its monitors more cleanly than the bench of 4.2 and 4.3 did. Its
own error, decoded less true, is therefore multiplied by one factor, the same for every
camera, after decoding and before any calibration. The factor is solved from one printed
number by CGSP alone (`ext_bench_factor`) and stands in settings.yaml, decoding_noise.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from raxel.features.active_grid import Decoded

# Solved by `ext_bench_factor`; their origin stands in settings.yaml, cam_d70_onevr.
FACTOR, WHITE_FACTOR = 5.26, 5.22
# Of the factor, over which a verdict must not change.
MULTIPLES = (0.5, 0.7, 1.0, 1.4, 2.0)


class DecodingNoise(NamedTuple):
    """What becomes of the laboratory's decoding errors.

    factor: they are multiplied by it; white: each has a sign drawn for it alone, so
    that errors are as large as they were in their place, and those of neighbours are
    not correlated. As they come, they are alike over the 7 x 7 pixels of the decoder's
    filter (3.2.2), and their bias repeats with the sines.
    """

    factor: float = 1.0
    white: bool = False

    def points(self, decoded, true, rng):
        """Points (..., 2) mm as they are decoded with these errors.

        decoded, true: (..., 2), NaN where there is none. A point whose truth is not
        known, beside the monitor, stays as it is.
        """
        if self == DecodingNoise():
            return decoded
        known = np.isfinite(decoded[..., 0]) & np.isfinite(true[..., 0])
        errors = decoded[known] - true[known]
        if self.white:
            errors = errors * rng.choice((-1.0, 1.0), errors.shape)
        out = decoded.copy()
        out[known] = true[known] + self.factor * errors
        return out

    def decoded(self, grid, rng) -> Decoded:
        """What is decoded of a `ScoredGrid` with these errors; sigma follows."""
        found = grid.decoded
        location = np.where(found.mask[..., None], found.location, np.nan)
        points = self.points(location, grid.points, rng)
        return replace(found, location=points, sigma=self.factor * found.sigma)


# What the trials call the options of the ledger's question `decoding_noise`.
OPTIONS = {"bench, 7 x 7": "bench", "bench, white": "white", "laboratory": "laboratory"}
BENCH = "bench"
NOISES = {
    "laboratory": DecodingNoise(),
    BENCH: DecodingNoise(FACTOR),
    "white": DecodingNoise(WHITE_FACTOR, white=True),
}
# The rest of the sweep from half to twice the factor: what trials call it, its noise.
SWEPT = {m: f"bench_x{m:g}".replace(".", "_") for m in MULTIPLES if m != 1.0}
SWEPT_NOISES = {name: DecodingNoise(m * FACTOR) for m, name in SWEPT.items()}
