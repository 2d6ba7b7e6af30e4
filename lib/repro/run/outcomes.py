"""Return types of a chapter's functions: plans, readings, values, drawings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import product
from math import isfinite, isnan
from typing import TYPE_CHECKING, Any

from repro.judge.seeds import decision_of_seeds, few_seeds
from repro.judge.statistics import (
    FAILS,
    HOLDS,
    Estimate,
    median_and_range,
    median_interval,
)

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure

    from raxel.show import Scene

NOT_COMPARABLE = "not comparable"
"""A decision: the reference of a claim is not available; the reason states why."""

VERDICTS = ("reproduced", "differs", "undecided", NOT_COMPARABLE)
# Reason of a reading if so many trials failed that two failures are compared.
NO_NUMBER = "no number"
DECISIONS = dict(
    zip(("holds", "fails", "undecided", NOT_COMPARABLE), VERDICTS, strict=True)
)


@dataclass(frozen=True)
class Plan:
    """What an experiment runs.

    ``trial(condition, rng)`` returns numbers, strings, None, nested dicts of these, or
    arrays. Each condition is run ``trials`` times, with trials counted from ``first``:
    a run after a changed test uses new random draws. ``settings`` are stored with the
    result and contain everything that is required to repeat it elsewhere.
    """

    trial: Callable[[dict, Any], dict]
    conditions: Sequence[dict]
    trials: int
    settings: Mapping[str, Any] = field(default_factory=dict)
    first: int = 0

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Return (condition index, trial) of all runs."""
        numbers = range(self.first, self.first + self.trials)
        return list(product(range(len(self.conditions)), numbers))


def crossed(**levels: Iterable) -> list[dict]:
    """Return conditions of a plan: every level with every other, the last one
    fastest."""
    return [dict(zip(levels, row, strict=True)) for row in product(*levels.values())]


@dataclass(frozen=True)
class Reading:
    """The outcome of a claim's test in one reading of the text.

    ``reading`` maps a question of settings.yaml to the option taken; it is empty if the
    text is unambiguous. ``few_seeds``: the share of runs decided, because they are too
    few for its interval to do so.
    """

    verdict: str
    regenerated: float | str
    reading: Mapping[str, str] = field(default_factory=dict)
    interval: tuple[float, float] | None = None
    unit: str = ""
    reason: str = ""
    few_seeds: bool = False

    def __post_init__(self) -> None:
        if self.verdict not in VERDICTS:
            raise ValueError(f"verdict: found {self.verdict!r}; give one of {VERDICTS}")

    @classmethod
    def of(
        cls,
        decision: str | bool,
        found: Estimate | float | str,
        unit: str = "",
        reason: str = "",
    ) -> Reading:
        """Make a reading from a decision of `repro.judge.statistics` and its estimate.

        A decision without an interval is True or False.
        """
        if not isinstance(decision, str):
            decision = HOLDS if decision else FAILS
        if not isinstance(found, Estimate):
            return cls(DECISIONS[decision], found, unit=unit, reason=reason)
        if isnan(found.value):
            return cls(DECISIONS[decision], NO_NUMBER, unit=unit, reason=reason)
        ends = found.low, found.high
        return cls(DECISIONS[decision], found.value, {}, ends, unit, reason)

    @classmethod
    def of_seeds(
        cls,
        holds: Sequence[bool] | np.ndarray,
        found: Estimate | float | str,
        unit: str = "",
        reason: str = "",
    ) -> Reading:
        """Make a reading from a predicate (seeds,) that should hold in nine of ten
        runs."""
        made = cls.of(decision_of_seeds(holds), found, unit, reason)
        return replace(made, few_seeds=few_seeds(len(holds)))

    def as_dict(self) -> dict:
        """Plain dictionary for the judged file."""
        return asdict(self) | {"reading": dict(self.reading)}


@dataclass(frozen=True)
class Value:
    """A regenerated number, with its interval if trials give one.

    ``put_in``: how the published number was put into the rig or solved for; the result
    is then not a test of the thesis.
    """

    value: float | str
    interval: tuple[float, float] | None = None
    unit: str = ""
    reason: str = ""
    put_in: str = ""

    @classmethod
    def median(cls, trials: np.ndarray, unit: str = "", reason: str = "") -> Value:
        """Median of trials (n,) with its 95 % interval; nan counts as the worst."""
        middle = median_interval(trials)
        return cls(middle.value, (middle.low, middle.high), unit, reason)

    @classmethod
    def of_seeds(
        cls, found: np.ndarray, unit: str = "", reason: str = "", put_in: str = ""
    ) -> Value:
        """Median of seeds (n,) and their range, of those with a value."""
        middle = median_and_range(found)
        return cls(middle.value, (middle.low, middle.high), unit, reason, put_in)


@dataclass(frozen=True)
class Check:
    """A check that drawn or tabulated content equals the computed content."""

    holds: bool
    text: str


@dataclass(frozen=True)
class Panel:
    """A part of a video: title, description in words, and frames.

    ``pictures``: (height, width, 3) uint8, all of one size.
    """

    title: str
    says: str
    pictures: Sequence[np.ndarray]


@dataclass(frozen=True)
class Film:
    """A video: panels side by side, below each other on a narrow screen.

    ``labels``: a few words for each frame; ``per_second``: frame rate, 0 for a slider.
    """

    panels: Sequence[Panel]
    labels: Sequence[str]
    per_second: float = 8.0


@dataclass(frozen=True)
class Drawing:
    """A figure, the data behind it (column name -> values), and its own check.

    ``scene`` is an interactive 3-D version or a video, for a figure marked with
    ``scene=True``. The page shows the figure first, and on paper.
    """

    figure: Figure
    data: Mapping[str, Sequence]
    caption: str
    check: Check | None = None
    scene: Scene | Film | None = None


@dataclass(frozen=True)
class Measured:
    """A number of a table with its interval: three columns in the CSV, one cell on the
    page."""

    value: float
    low: float
    high: float

    @classmethod
    def median(cls, trials: np.ndarray) -> Measured:
        """Median of trials (n,) with its 95 % interval; nan counts as the worst."""
        return cls(*median_interval(trials)[:3])

    @classmethod
    def median_or_none(cls, trials: np.ndarray) -> Measured | None:
        """Return the same, or None if half of the trials failed."""
        found = cls.median(trials)
        return found if isfinite(found.value) else None

    @classmethod
    def of_seeds(cls, found: np.ndarray) -> Measured:
        """Median of seeds (n,) and their range, of those with a value."""
        return cls(*median_and_range(found)[:3])


@dataclass(frozen=True)
class Table:
    """A table: column name -> cells, with its own check where it has one.

    A cell is a number, a `Measured`, words, or None where there is nothing to say.
    Captions and cells are Markdown, except the columns in ``texts``, which contain user
    input such as names of images. ``printed`` names the numbers of the thesis's own
    table, which the page shows below their cells: column -> ids of the ledger, one for
    each row, None if the thesis has none.
    """

    columns: Mapping[str, Sequence]
    caption: str
    check: Check | None = None
    texts: Sequence[str] = ()
    printed: Mapping[str, Sequence[str | None]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, identifiers in self.printed.items():
            if len(identifiers) != len(self.columns.get(name, ())):
                raise ValueError(
                    f"printed: {name!r}: {len(identifiers)} ids; give one for each row "
                    f"of a column, which are {', '.join(map(repr, self.columns))}"
                )
