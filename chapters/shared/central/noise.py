"""Decoding errors at two levels, and claims judged on runs at these levels.

The simulator decodes its monitors with less error than the thesis's setup of 4.2 and
4.3. Its errors (the low-noise level, "laboratory" in results) are therefore multiplied
by one factor, the same for every camera, after decoding and before any calibration (the
thesis-matched level). The factor is solved from one printed number by CGSP alone
(`ext_bench_factor`) and is listed in settings.yaml, decoding_noise.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from raxel.features.active_grid import Decoded
from repro.run import SHARE_OF_SEEDS, Case, Reading, counterpart

# Solved by `ext_bench_factor`; their origin: settings.yaml, cam_d70_onevr.
FACTOR, WHITE_FACTOR = 5.26, 5.22
# Of the factor, over which a verdict must not change.
MULTIPLES = (0.5, 0.7, 1.0, 1.4, 2.0)


class DecodingNoise(NamedTuple):
    """A change of the simulator's decoding errors.

    factor: multiplies them; white: each error gets a random sign, so that its size
    stays and neighbours are not correlated. Unchanged errors are correlated over the
    7 x 7 pixels of the decoder's filter (3.2.2); their bias repeats with the sines.
    """

    factor: float = 1.0
    white: bool = False

    def points(self, decoded, true, rng):
        """Return points (..., 2) mm, decoded with these errors.

        decoded, true: (..., 2), NaN where there is no point. A point without a true one
        (off the monitor) is not changed.
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
        """Return a `ScoredGrid`'s Decoded with these errors; sigma is scaled too."""
        found = grid.decoded
        location = np.where(found.mask[..., None], found.location, np.nan)
        points = self.points(location, grid.points, rng)
        return replace(found, location=points, sigma=self.factor * found.sigma)


# Options of the ledger's question `decoding_noise` -> names in the trials.
OPTIONS = {"bench, 7 x 7": "bench", "bench, white": "white", "laboratory": "laboratory"}
MATCHED = "bench"  # the thesis-matched level
LEVEL_NAMES = {MATCHED: "thesis-matched", "laboratory": "low-noise"}
NOISES = {
    "laboratory": DecodingNoise(),
    MATCHED: DecodingNoise(FACTOR),
    "white": DecodingNoise(WHITE_FACTOR, white=True),
}
# The rest of the sweep from half to twice the factor: multiple -> name in the trials.
SWEPT = {m: f"bench_x{m:g}".replace(".", "_") for m in MULTIPLES if m != 1.0}
SWEPT_NOISES = {name: DecodingNoise(m * FACTOR) for m, name in SWEPT.items()}


class CentralRuns:
    """Values of the runs of both cameras at one noise level, in one `Case`.

    results: from which the runs come; the sweep of the factor is in the last one only.
    A method that failed has nan.
    """

    def __init__(self, results, case, noise=MATCHED):
        self.results = results[-1:] if noise in SWEPT.values() else results
        self.case, self.noise = case, noise

    def of(self, camera, *path):
        """Return a value of each run of a camera, (..., runs)."""
        trials = [one.select(camera=camera) for one in self.results]
        return np.concatenate([t.column(self.noise, *path) for t in trials], axis=-1)

    def both(self, camera, *path):
        """Return a value of the standard method and of CGSP, (2, ..., runs)."""
        return self.of(camera, (self.case["standard_method"], "cgsp"), *path)


def over_the_sweep(case: Case, reading_at, side_at) -> Reading:
    """Return the Reading of a claim in one case, undecided if the factor decides it.

    reading_at(noise): the Reading at a noise level, by its name in the trials;
    side_at(noise): whether its point estimate is on the claim's side. The sweep exists
    for the primary case only.
    """
    reading = reading_at(case["decoding_noise"])
    if not case.is_primary:
        return reading
    side = side_at(MATCHED)
    changed = [f"{m:g}" for m, noise in SWEPT.items() if side_at(noise) != side]
    if not changed:
        return reading
    reason = (
        f"{reading.reason}; the estimate changes side at {', '.join(changed)} times"
    )
    return replace(reading, verdict="undecided", reason=f"{reason} the factor")


def counterpart_over_the_sweep(case: Case, found_at) -> Reading:
    """Return the same for a claim that is judged run by run.

    found_at(noise): whether it is true (runs,), the measured value (runs,), its unit
    and the reason, the arguments of `counterpart`.
    """

    def in_most_runs(noise):
        return bool(np.mean(found_at(noise)[0]) >= SHARE_OF_SEEDS)

    return over_the_sweep(
        case, lambda noise: counterpart(*found_at(noise)), in_most_runs
    )


def judged_by_run(questions, *names):
    """Decorate a predicate of `CentralRuns` as the test of a claim.

    questions: of the `Case`; names: of the experiments whose results have the runs. The
    predicate returns the arguments of `counterpart`.
    """

    def decorate(predicate):
        def judge(results, options):
            case, runs = Case(questions, options), [results[name] for name in names]
            return counterpart_over_the_sweep(
                case, lambda noise: predicate(CentralRuns(runs, case, noise))
            )

        return judge

    return decorate
