"""What section 5.2 found, and the numbers that its page quotes."""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_bench import SWEPT

BOTH = ("exp_c5_linear_enough", "exp_c5_linear_enough_swept")
STARTS, STARTS_SWEPT = BOTH
SAME = 0.01


class Starts(NamedTuple):
    """The trials of one bench: where the refinement ended, start by start."""

    trials: object
    bench: str

    @classmethod
    def on(cls, results, bench):
        """Those of a bench by its name, from the Results of both experiments."""
        result = results[STARTS_SWEPT if bench in SWEPT else STARTS]
        return cls(result.select(geometry="A"), bench)

    def of(self, start, name):
        """A value of every seed, (seeds,), NaN where it was refused."""
        return self.trials.column(f"{self.bench}.{start}.{name}")

    def off(self, start, name):
        """By which share a value differs from that of the true surface's end."""
        return np.abs(self.of(start, name) / self.of("true", name) - 1)

    def most_off(self, start, name):
        """The largest of these differences of the seeds that have one, in percent."""
        off = self.off(start, name)
        return 100 * float(np.max(off[np.isfinite(off)], initial=0.0))

    def same(self, start="linear"):
        """Whether a start ends where the true surface does (seeds,): equal cost and
        equal deflection. A seed that was refused does not."""
        return (self.off(start, "cost_mm2") <= SAME) & (
            self.off(start, "deflection_mm") <= SAME
        )

    @property
    def refused(self):
        """How many seeds have no end from the linear estimate or from the truth."""
        names = ("refused", "linear.refused", "true.refused")
        texts = zip(
            *(self.trials.texts(f"{self.bench}.{n}") for n in names), strict=True
        )
        return sum(any(said) for said in texts)
