"""Results of section 5.2, and the numbers that its page quotes."""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s2_method.trials.knots import SHAPES, STEPS_MM
from chapters.shared.mirror_bench import BENCHES, FIRST, LEVEL, SWEPT
from chapters.shared.mirror_runs import shape_name
from repro.judge.seeds import SHARE_OF_SEEDS
from repro.judge.statistics import median_interval
from repro.page.reader import value

BOTH = ("exp_c5_linear_enough", "exp_c5_linear_enough_swept")
STARTS, STARTS_SWEPT = BOTH
RUN, KNOTS = "fig_5_4_run", "exp_c5_knot_tradeoff"
STATIC, LOOPS = "exp_c5_static_grid_bias", "table_5_5_runs"
# Of the mirrors in the test of static grids.
UNEVEN_UM = BENCHES[FIRST].aberration_um
# Of Table 5.5: the steps from stage 3 back to stage 0, after the last of which the
# single step from stage 3 ends as well.
BACK = ("step4", "step5", "step6")
SAME = 0.01
MAX_DEG = 1.0  # mean ray error up to which a step is tolerated


class Starts(NamedTuple):
    """Trials of one error level: end points of the refinement, start by start."""

    trials: object
    bench: str

    @classmethod
    def on(cls, results, bench):
        """Return the trials of a level by its name, from both Results."""
        result = results[STARTS_SWEPT if bench in SWEPT else STARTS]
        return cls(result.select(geometry="A"), bench)

    def of(self, start, name):
        """A value of each run, (seeds,), NaN where it was rejected."""
        return self.trials.column(f"{self.bench}.{start}.{name}")

    def off(self, start, name):
        """Relative difference of a value from that of the start at the true surface."""
        return np.abs(self.of(start, name) / self.of("true", name) - 1)

    def most_off(self, start, name):
        """Largest of these differences, in percent."""
        off = self.off(start, name)
        return 100 * float(np.max(off[np.isfinite(off)], initial=0.0))

    def same(self, start="linear"):
        """Whether a start ends where the true surface does (seeds,): equal cost and
        equal deflection. A rejected run does not."""
        return (self.off(start, "cost_mm2") <= SAME) & (
            self.off(start, "deflection_mm") <= SAME
        )

    @property
    def completed(self):
        """Which runs (seeds,) have an end from the linear estimate and the truth."""
        return np.isfinite(self.off("linear", "cost_mm2"))

    @property
    def refused(self):
        """Number of runs without an end from the linear estimate or from the truth."""
        names = ("refused", "linear.refused", "true.refused")
        texts = zip(
            *(self.trials.texts(f"{self.bench}.{n}") for n in names), strict=True
        )
        return sum(any(said) for said in texts)


class Ran(NamedTuple):
    """One logged run. ways: {(stage, stage): count}; numbers: of the trial, by
    name; steps: of the refinement, for each calibrated stage."""

    ways: dict
    numbers: dict
    steps: tuple

    @classmethod
    def of(cls, result):
        """Return the run of the Result of `fig_5_4_run`."""
        trial = {name: result.texts(name)[0] for name in result.names()}
        ways = {
            tuple(name.removeprefix("ways.").split(" > ")): trial[name]
            for name in trial
            if name.startswith("ways.")
        }
        steps = [trial.get(f"stage{k}.steps") for k in (1, 2, 3)]
        return cls(ways, trial, tuple(n for n in steps if n is not None))

    @property
    def accepted(self):
        """Number of calibrated stages."""
        return len(self.steps)

    def times(self, start, end):
        """Count of a transition. Between two stages of the code a person bends the
        mirror, which is not logged: transitions to and from there are the same."""
        if start == "bend":
            return sum(n for (_, other), n in self.ways.items() if other == end)
        if end == "bend":
            end = "pose"
        return self.ways.get((start, end), 0)

    def beyond(self, drawn, can_refuse):
        """Transitions of the run that are not among these, as text."""
        known = {(a, "pose" if b == "bend" else b) for a, b in drawn}
        known |= {(stage, "refused") for stage in can_refuse}
        return [" > ".join(way) for way in self.ways if way not in known]

    def amounts(self):
        """Numbers in the boxes of the flowchart."""
        steps = " + ".join(f"{n}" for n in self.steps) or "no"
        return self.numbers | {"steps": steps}


class StepSizes(NamedTuple):
    """Three steps of 5 mm and one of 15 mm, from stage 3 to 0, at one error level."""

    result: object
    bench: str

    def common(self, way):
        """Corners (seeds,) that both images of a step show; 0 where rejected.

        way: "staged", the mean of the three steps, or "single".
        """
        places = BACK if way == "staged" else ("single",)
        found = [self._of(place, "common") for place in places]
        return np.mean(np.nan_to_num(found, nan=0.0), axis=0)

    def back(self, way):
        """Back-projection errors (seeds,) mm at stage 0, NaN where it was rejected."""
        return self._of(BACK[-1] if way == "staged" else "single", "back_mm")

    def _of(self, place, name):
        return self.result.column(f"{self.bench}.{place}.{name}")


def surfaces(results, aberration_um, points, stage="linear"):
    """Errors (trials,) mm of the surface before any deflection.

    points: "pixel", each pixel's own, or "grid", interpolated; stage: "linear", as
    published, or "refined".
    """
    return results[STATIC].column(f"{points}.{stage}_mm", aberration_um=aberration_um)


class Knots(NamedTuple):
    """One step of each size with several numbers of knots."""

    trials: object

    @classmethod
    def of(cls, results):
        """Return the trials from the Results, by name."""
        return cls(results[KNOTS].select(geometry="A"))

    def shares(self, shape):
        """Share (steps,) of the runs with a mean ray error below MAX_DEG; a rejected
        run is not below."""
        angles = np.array(self.trials.arrays(f"{shape_name(shape)}.angles_deg"))
        with np.errstate(invalid="ignore"):
            return np.mean(angles < MAX_DEG, axis=0)

    def largest_step(self, shape):
        """The largest step, mm, with nine of ten runs below MAX_DEG, 0 if none."""
        borne = np.array(STEPS_MM)[self.shares(shape) >= SHARE_OF_SEEDS]
        return float(borne.max(initial=0.0))

    def noise_free(self, shape):
        """Estimate of the shape's median error without noise, mm."""
        name = f"{shape_name(shape)}.noise_free_mm"
        return median_interval(self.trials.column(name))


def name_values(open_results):
    """Name the numbers of the prose."""
    for name, number in quoted(open_results).items():
        value(name, number)


def quoted(open_results):
    """Name -> number, of what the prose quotes."""
    results = {name: open_results(name) for name in (*BOTH, STATIC, KNOTS)}
    starts, knots = Starts.on(results, LEVEL), Knots.of(results)
    found = {
        f"{LEVEL}.{start}.same": 100 * float(np.mean(starts.same(start)))
        for start in ("linear", "before")
    }
    found |= {
        f"static.uneven.{points}.linear": 1000
        * float(np.median(surfaces(results, UNEVEN_UM, points)))
        for points in ("pixel", "grid")
    }
    return found | {
        f"{shape_name(shape)}.step": knots.largest_step(shape)
        for shape in (SHAPES[0], SHAPES[-1])
    }
