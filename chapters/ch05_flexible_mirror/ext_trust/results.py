"""Targets and what was measured of them, and the numbers that the page quotes."""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.ext_trust.trials.scene import PRIORS, STEPS
from chapters.ch05_flexible_mirror.ext_trust.trials.sweeps import REACHES
from repro.judge.statistics import (
    OVER_TRIALS,
    Estimate,
    bootstrap,
    median_interval,
    with_worst,
)
from repro.page.reader import value
from repro.page.wording import rounded

RUNS, OWN_SPACE = "ext_mirror_trust_runs", "ext_mirror_own_space"
KNOWN_VIEWER = "ext_mirror_known_viewer"
PRIOR_RUNS, SUPPORT_RUNS = "ext_mirror_prior_runs", "ext_mirror_support_runs"
SMOOTH, UNEVEN = {"aberration_um": 0.0}, {"aberration_um": 10.0}
SURFACES = {"smooth": SMOOTH, "uneven by 10 um": UNEVEN}
STAGES = range(1, STEPS + 1)
# Mean ray angle, degrees, beyond which a stage has gone astray.
ASTRAY_DEG = 1.0
NOTHING = Estimate(np.nan, np.nan, np.nan)
# The reach of corners into the last knot interval that prose speaks of.
FEW = 0.2
WAYS = {"prior": "with the prior", "plain": "without"}


class Target(NamedTuple):
    """bound: of the median of the seeds; names: values of a way's trials, of which the
    largest counts; surface: which condition; common: no matter of the way; added: not
    aimed at beforehand, and not counted."""

    words: str
    bound: float
    unit: str
    names: tuple
    surface: dict = SMOOTH
    common: bool = False
    added: bool = False


def _at(stage, name):
    return (f"stage{stage}.{name}",)


def _largest(name):
    return tuple(f"stage{k}.{name}" for k in STAGES)


TARGETS = (
    *(
        Target(f"Deflection, stage {k}", bound, "%", _at(k, "deflection_percent"))
        for k, bound in zip(STAGES, (0.5, 1.0, 1.5), strict=True)
    ),
    *(
        Target(f"Mean ray angle, stage {k}", bound, "degrees", _at(k, "angle_deg"))
        for k, bound in zip(STAGES, (0.04, 0.08, 0.14), strict=True)
    ),
    Target(
        "Mean ray angle, stage 3, after the bundle",
        0.09,
        "degrees",
        ("bundle.stage3.angle_deg",),
    ),
    *(
        Target(f"Mean ray angle, stage {k}, uneven by 10 um", bound, "degrees",
               _at(k, "angle_deg"), UNEVEN)
        for k, bound in zip(STAGES, (0.15, 0.25, 0.35), strict=True)
    ),
    Target("Residual, worst stage", 0.2, "mm", _largest("residual_mm")),
    Target("Back-projection, own pose, worst stage", 0.6, "mm",
           _largest("back_own_mm")),
    Target("Back-projection, true pose, worst stage", 1.1, "mm",
           _largest("back_true_mm")),
    Target("Height after three steps out and back", 0.03, "mm", ("loop_mm",)),
    Target("Deflection, 15 mm at a stroke", 1.5, "%", ("single_percent",)),
    Target("Deflection, 15 mm at a stroke, all corners after", 1.5, "%",
           ("single_all_percent",), added=True),
    Target("Grid separation", 0.05, "mm", ("separation_mm",), common=True),
    Target("Grid rotation", 0.02, "degrees", ("separation_deg",), common=True),
)  # fmt: skip


def measured(result, target, geometry, way):
    """Values (seeds,) of a Target, infinite where a seed gave none."""
    trials = result.select(geometry=geometry, **target.surface)
    prefix = "" if target.common else f"{way}."
    found = [with_worst(trials.column(f"{prefix}{name}")) for name in target.names]
    return np.max(found, axis=0)


def met(found, bound):
    """What the median of the seeds and its interval say of a bound, in words."""
    estimate = median_interval(found)
    if estimate.high < bound:
        return "met"
    if estimate.low >= bound:
        return "not met"
    return "met, not surely" if estimate.value < bound else "not met, not surely"


def astray(result, geometry, way):
    """How many seeds of the smooth and the uneven mirror ended early, or had a stage
    whose mean ray was off by more than ASTRAY_DEG."""
    trials = result.select(geometry=geometry)
    angles = [with_worst(trials.column(f"{way}.stage{k}.angle_deg")) for k in STAGES]
    return int(np.count_nonzero(np.max(angles, axis=0) > ASTRAY_DEG))


def coverage(trials, name):
    """Mean over seeds of squared ray errors over what was predicted, an Estimate; seeds
    that were refused do not count."""
    found = trials.column(f"{name}.coverage")
    found = found[np.isfinite(found)]
    return bootstrap(OVER_TRIALS["mean"], found) if len(found) else NOTHING


def angles(result, way, surface, geometry):
    """Estimates of the mean ray angle, degrees, at stages 1 to 3; way: such as
    "prior" or "prior.bundle"."""
    trials = result.select(geometry=geometry, **surface)
    return [median_interval(trials.column(f"{way}.stage{k}.angle_deg")) for k in STAGES]


def not_refused(trials, number, way, name):
    """Median of a value of the support's trials at a reach, an Estimate, of the seeds
    that were not refused; nan where all were."""
    found = trials.column(f"reach{number}.{way}.{name}")
    found = found[np.isfinite(found)]
    return median_interval(found) if len(found) else NOTHING


def refusals(result, geometry):
    """Refused seeds without the prior, for each reach."""
    trials = result.select(geometry=geometry)
    texts = [trials.texts(f"reach{k}.plain.refused") for k in range(len(REACHES))]
    return [sum(text is not None for text in own) for own in texts]


def typical_angle(result, name):
    """Geometric mean, degrees, over all conditions of the median ray angle at stage 3
    with a prior of PRIORS_MM: by this the prior is chosen."""
    medians = [
        np.median(with_worst(result.one(**condition).column(f"{name}.angle_deg")))
        for condition in result.conditions
    ]
    return float(np.exp(np.mean(np.log(medians))))


def name_values(open_results):
    """Name the numbers of the prose."""
    quoted = of_runs(open_results(RUNS)) | of_coverage(
        open_results(RUNS), open_results(OWN_SPACE), open_results(KNOWN_VIEWER)
    )
    quoted |= of_prior(open_results(PRIOR_RUNS))
    quoted |= of_support(open_results(SUPPORT_RUNS))
    for name, number in quoted.items():
        value(name, number)


def of_runs(result):
    """Name -> what prose quotes of stages, bundle, loop and single step."""
    aims = [target for target in TARGETS if not target.added]
    found = {"seeds": result.trials_per_condition, "targets": len(aims)}
    for geometry in "AB":
        verdicts = [met(measured(result, t, geometry, "prior"), t.bound) for t in aims]
        found[f"{geometry}.met"] = sum(
            verdict.startswith("met") for verdict in verdicts
        )
        field = result.column(
            "prior.stage3.field_error_deg", geometry=geometry, **SMOOTH
        )
        found[f"{geometry}.field_error"] = in_words(median_interval(np.abs(field)))
        for way in PRIORS:
            found[f"{geometry}.{way}.astray"] = astray(result, geometry, way)
            single = result.select(geometry=geometry, **SMOOTH).texts(
                f"{way}.single_refused"
            )
            found[f"{geometry}.{way}.single_refused"] = sum(
                text is not None for text in single
            )
        for name, surface in (("smooth", SMOOTH), ("uneven", UNEVEN)):
            for way in ("prior", "prior.bundle", "plain"):
                for k, estimate in zip(
                    STAGES, angles(result, way, surface, geometry), strict=True
                ):
                    found[f"{geometry}.{name}.{way}.angle{k}"] = in_words(estimate)
    found |= {
        f"{geometry}.{name}": in_words(
            median_interval(measured(result, target, geometry, "prior"))
        )
        for geometry in "AB"
        for target in TARGETS
        for name in SHORT
        if target.words == SHORT[name]
    }
    return found


SHORT = {
    "deflection3": "Deflection, stage 3",
    "residual": "Residual, worst stage",
    "back_own": "Back-projection, own pose, worst stage",
    "back_true": "Back-projection, true pose, worst stage",
    "loop": "Height after three steps out and back",
    "single": "Deflection, 15 mm at a stroke",
    "single_all": "Deflection, 15 mm at a stroke, all corners after",
}


def of_coverage(runs, own_space, known_viewer):
    """Name -> coverage, for sentences."""
    found = {
        "B.known_viewer": in_words(coverage(known_viewer.select(), "stage1.among")),
        "known_viewer.seeds": known_viewer.trials_per_condition,
    }
    for geometry in "AB":
        own = own_space.select(geometry=geometry)
        found[f"{geometry}.own_space"] = in_words(coverage(own, "stage3.among"))
        for name, surface in (("smooth", SMOOTH), ("uneven", UNEVEN)):
            trials = runs.select(geometry=geometry, **surface)
            for what in ("among", "whole"):
                for k in STAGES:
                    found[f"{geometry}.{name}.{what}{k}"] = in_words(
                        coverage(trials, f"prior.bundle.stage{k}.{what}")
                    )
            for k in STAGES:
                found[f"{geometry}.{name}.stage{k}"] = in_words(
                    coverage(trials, f"prior.stage{k}")
                )
    return found


def of_prior(result):
    """Name -> what the strength of the prior does, for sentences."""
    chosen, none = (
        typical_angle(result, name) for name in (f"{PRIORS['prior']:g}", "none")
    )
    gain = 100 * (1 - chosen / none)
    return {
        "prior.mm": PRIORS["prior"],
        "prior.seeds": result.trials_per_condition,
        "prior.gain": f"{gain:.1f}" if np.isfinite(gain) else "(no number)",
    }


def of_support(result):
    """Name -> what missing corners at the free edge do, on geometry A."""
    trials, refused = result.select(geometry="A"), refusals(result, "A")
    few = REACHES.index(FEW)
    found = {
        f"support.{where}.{way}.{name}": in_words(not_refused(trials, k, way, name))
        for where, k in (("all", 0), ("few", few), ("none", len(REACHES) - 1))
        for way in PRIORS
        for name in ("edge_deg", "residual_mm", "predicted_deg")
    }
    return found | {
        "support.seeds": result.trials_per_condition,
        "support.few": FEW,
        "support.few.refused": refused[few],
        "support.refused": refused[-1],
    }


def in_words(estimate):
    """An Estimate with its interval, for a sentence; a single seed has none."""
    if not np.isfinite(estimate.value):
        return "(no number)"
    ends = estimate.low, estimate.high
    return rounded(estimate.value, ends if np.isfinite(ends).all() else None)
