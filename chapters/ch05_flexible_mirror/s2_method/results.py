"""What section 5.2 found, and the numbers that its page quotes."""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s2_method.trials.knots import SHAPES, STEPS_MM
from chapters.shared.mirror_bench import BENCHES, FIRST, SWEPT
from chapters.shared.mirror_runs import shape_name
from repro.judge.seeds import SHARE_OF_SEEDS
from repro.judge.statistics import median_and_range, median_interval
from repro.page.reader import value

BOTH = ("exp_c5_linear_enough", "exp_c5_linear_enough_swept")
STARTS, STARTS_SWEPT = BOTH
RUN, KNOTS = "fig_5_4_run", "exp_c5_knot_tradeoff"
STATIC, LOOPS = "exp_c5_static_grid_bias", "table_5_5_runs"
# Of the mirrors whose primary calibration is tried with static grids.
UNEVEN_UM = BENCHES[FIRST].aberration_um
# Of Table 5.5: the steps from stage 3 back to stage 0, after the last of which the
# single step from stage 3 ends as well.
BACK = ("step4", "step5", "step6")
SAME = 0.01
MOST_DEG = 1.0  # mean ray error up to which a step is borne


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
        """A value of every seed, (seeds,), NaN where it was rejected."""
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
        equal deflection. A seed that was rejected does not."""
        return (self.off(start, "cost_mm2") <= SAME) & (
            self.off(start, "deflection_mm") <= SAME
        )

    @property
    def completed(self):
        """Which seeds (seeds,) have an end from the linear estimate and the truth."""
        return np.isfinite(self.off("linear", "cost_mm2"))

    @property
    def refused(self):
        """How many seeds have no end from the linear estimate or from the truth."""
        names = ("refused", "linear.refused", "true.refused")
        texts = zip(
            *(self.trials.texts(f"{self.bench}.{n}") for n in names), strict=True
        )
        return sum(any(said) for said in texts)


class Ran(NamedTuple):
    """One watched run. ways: {(stage, stage): how often}; numbers: of the trial, by
    name; steps: of the refinement, of each stage that was calibrated."""

    ways: dict
    numbers: dict
    steps: tuple

    @classmethod
    def of(cls, result):
        """From the Result of `fig_5_4_run`."""
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
        """How many stages were calibrated."""
        return len(self.steps)

    def times(self, start, end):
        """How often a way was gone. Between two stages of the code a person bends the
        mirror, whom no watch sees: a way to and from there is the one of both."""
        if start == "bend":
            return sum(n for (_, other), n in self.ways.items() if other == end)
        if end == "bend":
            end = "pose"
        return self.ways.get((start, end), 0)

    def beyond(self, drawn, can_refuse):
        """Ways that were gone and are not among these, as text."""
        known = {(a, "pose" if b == "bend" else b) for a, b in drawn}
        known |= {(stage, "refused") for stage in can_refuse}
        return [" > ".join(way) for way in self.ways if way not in known]

    def amounts(self):
        """What the boxes of the flowchart say."""
        steps = " + ".join(f"{n}" for n in self.steps) or "no"
        return self.numbers | {"steps": steps}


class StepSizes(NamedTuple):
    """Three steps of 5 mm and one of 15 mm, from stage 3 to stage 0, on one bench."""

    result: object
    bench: str

    def common(self, way):
        """Corners (seeds,) that both pictures of a step show; none where refused.

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
        """From the Results, by name."""
        return cls(results[KNOTS].select(geometry="A"))

    def shares(self, shape):
        """Share (steps,) of the seeds with a mean ray error below MOST_DEG; a refused
        seed is not below."""
        angles = np.array(self.trials.arrays(f"{shape_name(shape)}.angles_deg"))
        with np.errstate(invalid="ignore"):
            return np.mean(angles < MOST_DEG, axis=0)

    def largest_step(self, shape):
        """The largest step, mm, with nine of ten seeds below MOST_DEG, 0 if none."""
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
    """Name -> number, of what the prose quotes: medians over the seeds."""
    results = {name: open_results(name) for name in (*BOTH, STATIC, LOOPS, KNOTS)}
    ran = Ran.of(open_results(RUN))
    found = {
        "run.accepted": ran.accepted,
        "run.most_steps": max(ran.steps, default=0),
        "run.coefficients": ran.numbers["coefficients"],
    }
    for bench in BENCHES:
        found |= _with(f"{bench}.", of_starts(Starts.on(results, bench)))
        found |= _with(
            f"{bench}.steps.", of_step_sizes(StepSizes(results[LOOPS], bench))
        )
    return found | of_static_grids(results) | of_knots(Knots.of(results))


def of_starts(starts):
    """Name -> number, of where the refinement starts and ends on one bench."""
    found = {
        "seeds": len(starts.same()),
        "refused": starts.refused,
        "cost_off": starts.most_off("linear", "cost_mm2"),
        "tip_off": starts.most_off("linear", "deflection_mm"),
        "tip_sd_mm": float(np.nanstd(starts.of("linear", "deflection_mm"), ddof=1)),
    }
    for start in ("linear", "before", "true"):
        found[f"{start}.same"] = 100 * float(np.mean(starts.same(start)))
        for name in ("start_mm", "deflection_mm", "steps"):
            found[f"{start}.{name}"] = float(np.nanmedian(starts.of(start, name)))
    return found


def of_static_grids(results):
    """Name -> number: medians of the surfaces' errors, um."""
    return {
        f"static.{case}.{points}.{stage}": 1000
        * float(np.median(surfaces(results, um, points, stage)))
        for case, um in (("uneven", UNEVEN_UM), ("even", 0.0))
        for points in ("pixel", "grid")
        for stage in ("linear", "refined")
    }


def of_step_sizes(steps):
    """Name -> number: medians over the seeds in which neither way was rejected, and
    how many seeds each way has lost."""
    ways = ("staged", "single")
    both = [steps.back(way) for way in ways]
    known = np.isfinite(both).all(axis=0)
    found = {}
    for way, back in zip(ways, both, strict=True):
        found[f"{way}.back"] = median_and_range(back[known]).value
        found[f"{way}.common"] = median_and_range(steps.common(way)[known]).value
        found[f"{way}.lost"] = int(np.count_nonzero(np.isnan(back)))
    return found


def of_knots(knots):
    """Name -> number: the largest step, mm, and the error without noise, um."""
    return {
        f"{shape_name(shape)}.{name}": number
        for shape in SHAPES
        for name, number in (
            ("step", knots.largest_step(shape)),
            ("um", 1000 * knots.noise_free(shape).value),
        )
    }


def _with(prefix, found):
    return {f"{prefix}{name}": number for name, number in found.items()}
