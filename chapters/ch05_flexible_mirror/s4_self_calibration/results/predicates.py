"""Claims of 5.4 for single runs.

Each function takes the `Courses` at an error level. It returns whether the claim holds
(seeds,), the measured value (seeds,), its unit, and words. The value is nan where a run
was rejected.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.results.runs import (
    OBJECTS,
    STEP_MM,
    THESIS_SCENE,
)

LINEAR_TOL = 0.1
MAX_SAG_RATIO = 0.25
MIN_BASELINE_RATIO, MAX_TREND = 5.0, -0.8
MIN_SPREAD = 0.2
MIN_GROWTH, MIN_REFINED_RATIO = 1.5, 3.0


def middle(values):
    """Median of those that have a value, as words."""
    known = values[np.isfinite(values)]
    return f"{np.median(known):.3g}" if len(known) else "nothing"


def _by_stage(values):
    return ", ".join(middle(one) for one in values)


def better_early(runs):
    """Estimates of stages 1 and 2 are nearer to 5 mm than the linear ones of boards."""
    own, near = runs.of(THESIS_SCENE, "deflection_mm"), runs.of("board", "linear_mm")
    off, was = np.abs(own - STEP_MM), np.abs(near - STEP_MM)
    even = np.abs(runs.of("even", "deflection_mm") - STEP_MM) < was
    return (
        np.all(off[:2] < was[:2], axis=0),
        (off / was)[:2].max(axis=0),
        "",
        f"error over that of the near scene, larger of two; found {_by_stage(own)} mm, "
        f"near {_by_stage(near)} mm; with evenly spread far features true in "
        f"{100 * np.mean(even[:2].all(axis=0)):.0f} % of the seeds",
    )


def degrades(runs):
    """Smaller from stage to stage, the last within 10 % of the near linear estimate."""
    own, near = (
        runs.of(THESIS_SCENE, "deflection_mm"),
        runs.of("board", "linear_mm")[-1],
    )
    falls = np.all(np.diff(own, axis=0) < 0, axis=0)
    ratio = own[-1] / near
    return (
        falls & (np.abs(ratio - 1) <= LINEAR_TOL),
        ratio,
        "",
        f"stage 3 over the near scene's; falling in {100 * np.mean(falls):.0f} % of "
        f"the seeds; found {_by_stage(own)} mm",
    )


def vertical(runs):
    """Sag at the load rises over the stages; even features have at most a quarter."""
    sag, even = (
        np.abs(runs.of("clustered", "sag_mm")),
        np.abs(runs.of("even", "sag_mm")),
    )
    share = even[-1] / sag[-1]
    return (
        np.all(np.diff(sag, axis=0) > 0, axis=0) & (share <= MAX_SAG_RATIO),
        share,
        "",
        f"sag of even over clustered features, stage 3; clustered {_by_stage(sag)} mm, "
        f"even {_by_stage(even)} mm",
    )


def inflexion(runs):
    """An inflexion at stages 2 and 3 with near features, and at neither without."""
    near = runs.inflected("near").all(axis=0)
    without = runs.inflected("even").any(axis=0)
    told = runs.inflected(THESIS_SCENE).all(axis=0)
    came = np.isfinite(runs.of("even", "deflection_mm")).all(axis=0)
    both = came & np.isfinite(runs.of("near", "deflection_mm")).all(axis=0)
    return (
        near & ~without,
        np.where(both, near, np.nan),
        "",
        f"with near features at both in {100 * near.mean():.0f} % of the seeds, "
        f"without at one or both in {100 * without.mean():.0f} %, where features are "
        f"spread evenly; as told {100 * told.mean():.0f} %; without near ones "
        f"{came.sum()} of {runs.seeds} came to stage 3",
    )


def large_error(runs):
    """Depth errors between bent states are at least five times those from 100 mm."""
    ratio, true = (
        runs.column(f"stereo.{name}.deflected") / runs.column(f"stereo.{name}.baseline")
        for name in ("found", "true")
    )
    return (
        ratio >= MIN_BASELINE_RATIO,
        ratio,
        "x",
        "median relative error of depths in the far scene, over that of 100 mm; with "
        f"the true mirror {middle(true)}; boards are off by "
        f"{middle(100 * runs.column('stereo.found.board'))} %",
    )


def edge_times(runs):
    """SD of a depth in the strip at the clamp over that at the free end, (seeds,)."""
    sd = runs.arrays("stereo.sd_mm")
    # A quick build has no sweep, and so no strips of it.
    return np.array([one[0] / one[-1] for one in sd] or [np.nan])


def fixed_edge(runs):
    """The SD of a depth falls from the clamp on."""
    trend = runs.column("stereo.trend")
    return (
        trend <= MAX_TREND,
        trend,
        "",
        "Spearman's rank correlation of the SD with the distance from the clamp; in "
        f"the strip at the clamp the SD is {middle(edge_times(runs))} times that at "
        "the free end; that there is no depth at all at the clamp is not tested",
    )


def _multi(runs, name, cameras="found"):
    return np.array([runs.column(f"multi.{cameras}.{one}.{name}") for one in OBJECTS])


def spread(runs):
    """A fifth of the depth or more, and more for the wall than for the plane."""
    plane, _, wall = _multi(runs, "spread_mm")
    true = _multi(runs, "spread_mm", "true")
    share = np.minimum(plane / 3980, wall / 5000)
    return (
        (share >= MIN_SPREAD) & (wall > plane),
        share,
        "",
        f"smaller share of the depth; plane {middle(plane)} mm, wall {middle(wall)} "
        f"mm; with the true mirror {middle(true[0])} and {middle(true[2])} mm",
    )


def order(runs):
    """Plane, object and wall in this order by their centroids."""
    plane, thing, wall = _multi(runs, "centroid_mm")
    return (
        (plane < thing) & (thing < wall),
        wall - plane,
        "mm",
        f"wall behind the plane; centroids {middle(plane)}, {middle(thing)}, "
        f"{middle(wall)} mm",
    )


def under(runs):
    """All three centroids are nearer than the true ones."""
    ratio = _multi(runs, "ratio")
    return (
        np.all(ratio < 1, axis=0),
        ratio.max(axis=0),
        "",
        f"largest of the three ratios; plane, object, wall {_by_stage(ratio)}; with "
        f"the true mirror {_by_stage(_multi(runs, 'ratio', 'true'))}",
    )


def impractical(runs):
    """Back-projection errors grow by half, and end at three times those of boards.

    A self-calibration that is rejected where boards are not supports the claim. Where
    boards are rejected as well, there is nothing to compare with.
    """
    own, board = runs.of(THESIS_SCENE, "back_mm"), runs.of("board", "back_mm")
    even, over = runs.of("even", "back_mm"), own[-1] / board[-1]
    rejected = np.isnan(own[-1]) & np.isfinite(board[-1])
    grows = (own[-1] >= MIN_GROWTH * own[0]) & (over >= MIN_REFINED_RATIO)
    return (
        grows | rejected,
        np.where(rejected, np.inf, over),
        "x",
        f"over the refined method, stage 3; {_by_stage(own)} mm; boards "
        f"{_by_stage(board)} mm; even features {_by_stage(even)} mm; "
        f"{rejected.sum()} self-calibrations were rejected where the boards' were not",
    )
