"""Claims of 5.3 about the thesis's flexible mirror: what the error level may decide.

A claim is judged at the primary level and at two others (`mirror_bench`). It is
undecided where the three verdicts differ, and where its point estimate is on the other
side of its bound at half or twice the primary level's numbers, which are known about as
well as the printed ones that they are solved from.

Agreement and growth are judged on the runs that were completed; how many were rejected,
and what the verdict is if each counts as a miss, stands in the reason.
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from chapters.shared.mirror.levels import LEVEL, LEVEL_NAMES, SWEPT
from raxel.calibration import MAX_SWING_DEG
from repro.run import SHARE_OF_SEEDS, Case, Measured, Reading, counterpart

# Names in the trials of the options of the ledger's questions.
LEVELS = {option: level for level, option in LEVEL_NAMES.items()}
SWINGING = {"as published": False, "rejected": True}
GEOMETRIES = {"A": "A", "C": "C"}
# Measured rays of stage 0, for comparison with those of the primary stage (Table 5.3).
GRIDS = {"the primary's own": "measured_deg", "measured anew": "anew_measured_deg"}
READINGS = {
    "mirror_bench": LEVELS,
    "swinging_ends": SWINGING,
    "mirror_geometry": GEOMETRIES,
    "primary_grids": GRIDS,
}


class BenchRuns(Case):
    """Every run at one error level: that of the interpretation, or an end of a sweep.

    EXPERIMENTS: those of a kind of run, on rig A, on A from half to twice the
    primary level's numbers, and on other geometries by their names. A rejected run has
    no values from the rejection on: nan. Where the interpretation rejects mirrors whose
    ends swing, a run ends at the first such stage.
    """

    EXPERIMENTS: ClassVar[tuple[str, str]]
    ELSEWHERE: ClassVar[dict[str, str]] = {}
    # Names of the stages, one after the other, that have a `swing_deg`.
    SWINGS: ClassVar[tuple[str, ...]] = ()

    def __init__(self, results, options=None, bench=None, geometry=None):
        super().__init__(READINGS, options)
        runs, swept = self.EXPERIMENTS
        self.bench = bench or self["mirror_bench"]
        geometry = geometry or self["mirror_geometry"]
        name = swept if self.bench in SWEPT else runs
        self.result = results[self.ELSEWHERE.get(geometry, name)]

    @property
    def seeds(self):
        """How many were run."""
        return self.result.trials_per_condition

    def raw(self, name):
        """A value (runs,) as it is stored, whatever swings."""
        return self.result.column(self.bench, name)

    def goes_on(self, place):
        """Whether (runs,) no mirror's end swung up to a stage, where that counts."""
        if not self["swinging_ends"] or place not in self.SWINGS:
            return np.ones(self.seeds, bool)
        stages = self.SWINGS[: self.SWINGS.index(place) + 1]
        # Not reached is nan: rejected for another reason, and not for this one.
        swing = self.result.column(self.bench, stages, "swing_deg")
        return ~np.any(swing >= MAX_SWING_DEG, axis=0)

    def at_place(self, place, name):
        """A value (runs,) of a stage, nan from the rejection on."""
        found = self.result.column(self.bench, place, name)
        return np.where(self.goes_on(place), found, np.nan)

    @classmethod
    def judged_by_seed(cls, results, options, predicate) -> Reading:
        """The Reading of a predicate of such runs, at the levels and over the sweep."""
        return counterpart_over_the_sweep(
            Case(READINGS, options),
            lambda level: predicate(cls(results, options, level)),
        )


def over_the_levels(case: Case, reading_at) -> Reading:
    """The Reading of a claim in one case, undecided where the error level decides.

    reading_at(level): the Reading at a level, by its name in the trials. The other
    levels are judged in the primary case alone.
    """
    judged = reading_at(case["mirror_bench"])
    if not case.is_primary:
        return judged
    verdicts = {level: reading_at(name).verdict for level, name in LEVELS.items()}
    if len(set(verdicts.values())) == 1:
        return judged
    each = ", ".join(f"{level} {verdict}" for level, verdict in verdicts.items())
    reason = f"{judged.reason}; the verdict depends on the error level: {each}"
    return replace(judged, verdict="undecided", reason=reason)


def over_the_sweep(case: Case, reading_at, side_at) -> Reading:
    """As `over_the_levels`, undecided too where the estimate changes side in a sweep.

    side_at(level): whether the point estimate is on the claim's side at a level, or at
    an end of the sweep. Only the primary case is swept.
    """
    judged = over_the_levels(case, reading_at)
    if not case.is_primary:
        return judged
    side = side_at(LEVEL)
    turned = [name for name in SWEPT if side_at(name) != side]
    if not turned:
        return judged
    reason = f"{judged.reason}; the estimate changes side at {', '.join(turned)}"
    return replace(judged, verdict="undecided", reason=reason)


def counterpart_over_the_sweep(case: Case, found_at) -> Reading:
    """As `over_the_sweep`, for a claim that is judged run by run.

    found_at(level): whether it is true (runs,), what was measured (runs,), nan where a
    run was rejected, its unit and the reason, as `counterpart` takes them.
    """
    return over_the_sweep(
        case,
        lambda level: of_completed(*found_at(level)),
        lambda level: mostly(*found_at(level)[:2]),
    )


def mostly(holds, found) -> bool:
    """Whether a claim is true of nine in ten of the runs (runs,) with a value."""
    done = ~np.isnan(found)
    return bool(done.any() and np.mean(holds[done]) >= SHARE_OF_SEEDS)


def over_completed(case: Case, done_at, reading_of, on_side) -> Reading:
    """As `over_the_sweep`, on the runs that were completed.

    done_at(level): which runs (runs,) were; reading_of(level, some), on_side(level,
    some): the Reading, and whether the estimate is on the claim's side, of some runs.
    """

    def reading_at(level):
        return on_completed(done_at(level), lambda some: reading_of(level, some))

    def side_at(level):
        done = done_at(level)
        return bool(done.any() and on_side(level, done))

    return over_the_sweep(case, reading_at, side_at)


def of_completed(holds, found, unit="", reason="") -> Reading:
    """The Reading of a claim judged run by run, on the runs that were completed.

    holds, found: (runs,), found nan where a run was rejected.
    """
    done = ~np.isnan(found)
    return on_completed(
        done, lambda some: counterpart((holds & done)[some], found[some], unit, reason)
    )


def on_completed(done, judge) -> Reading:
    """The Reading of completed runs, with how many were rejected, and the verdict where
    each rejection counts as a miss.

    done: (runs,) which were completed; judge(some): the Reading of some, (runs,) bool,
    a run without a value as the worst.
    """
    if not done.any():
        rejected = f"all {len(done)} runs were rejected"
        return Reading("undecided", "nothing", reason=rejected)
    judged = judge(done)
    if done.all():
        return judged
    reason = (
        f"{judged.reason}; {np.count_nonzero(~done)} of {len(done)} runs rejected, "
        f"which as misses give: {judge(np.ones_like(done)).verdict}"
    )
    return replace(judged, reason=reason)


# Cells of tables and words about runs, some of which were rejected.
MEDIANS = "Medians over the runs that reached the stage, with 95 % intervals."


def with_published(ids, rows):
    """Ids of printed numbers for the rows of a table that begins with theirs."""
    return [*ids, *[None] * (rows - len(ids))]


def reached(values):
    """Median of the runs (n,) that have a value, None without any."""
    known = values[np.isfinite(values)]
    return Measured.median(known) if len(known) else None


def ranged(values):
    """Median and range of the runs (n,) that have a value, None without any."""
    return Measured.of_seeds(values) if np.isfinite(values).any() else None


def middle(values):
    """Median of the runs (n,) that have a value, as words; "nothing" without any."""
    known = values[np.isfinite(values)]
    return f"{np.median(known):.3g}" if len(known) else "nothing"
