"""What the conditions of section 3.3.2 did, and the numbers that are quoted."""

from collections import Counter

import numpy as np

from chapters.ch03_planar_grids.s3_2_conditions.trials.detector_runs import DONE, WRONG
from chapters.ch03_planar_grids.s3_2_conditions.trials.sheet_views import (
    LIGHT_LEVELS,
    level_name,
)
from chapters.shared.grid_detectors import CELECT, CLICKLESS, LINEAR, OPENCV, OPENCV_SB
from chapters.shared.grid_rigs import HARD, WHOLE
from repro.judge.statistics import paired_gain, proportion
from repro.page.reader import value
from repro.page.wording import rounded
from repro.run.experiment import numbers
from repro.run.outcomes import Value

CAMERAS = ("hyperboloidal", "fisheye")
WAYS = ("clockwise", "reverse")
METHODS = {
    CELECT: "CELECT",
    LINEAR: "CELECT, tone curve undone",
    OPENCV: "findChessboardCorners",
    OPENCV_SB: "findChessboardCornersSB",
    CLICKLESS: "without clicks (ours)",
}
SPOTTED, CLEAN = ("600 spots", "no spots")
# Information below which a slope is without bound.
SEPARATED = 1e-6


def numbers_of(result, name, poses=WHOLE):
    """A number of every image of one range of poses: (n,)."""
    return result.select(poses=poses).column(name)


def levels_run(result):
    """Light levels of the contrast study as it was run, brightest first."""
    return [v for v in LIGHT_LEVELS if v in result.conditions[0]["levels"]]


def in_light(result, level, method, poses=WHOLE, spots=SPOTTED):
    """Successes (n,) of a method in one light."""
    clean = "" if spots == SPOTTED else "spotless."
    return numbers_of(result, f"{level_name(level)}.{clean}{method}", poses)


def shadow_effects(result, method, poses=WHOLE):
    """Success without less with the shadow: Estimate."""
    return paired_gain(
        numbers_of(result, f"plain.{method}", poses),
        numbers_of(result, f"shadow.{method}", poses),
    )


def all_orders(result, tone="", poses=WHOLE):
    """Success (2, 4, n): way round, first corner by rising square, image of any set.

    tone: 'linear_' for the pictures with their tone curve undone.
    """
    return np.array(
        [
            [numbers_of(result, f"{tone}{way}_{rank}", poses) for rank in range(4)]
            for way in WAYS
        ]
    )


def differing(orders):
    """Images (n,): 1 where the eight orders do not all end alike."""
    flat = orders.reshape(-1, orders.shape[-1])
    return (flat.min(axis=0) != flat.max(axis=0)).astype(float)


def ends_of_orders(trials):
    """Counter of where the runs in the eight orders ended, over a selection."""
    names = [f"{way}_{rank}_stage" for way in WAYS for rank in range(4)]
    return Counter(end for name in names for end in trials.texts(name))


def merging_of(results, tone="", poses=WHOLE):
    """(size ratio (n,), merge failed (n,), success (n,)) of the fisheye images.

    tone: 'linear.' for the pictures with their tone curve undone.
    """
    both = [results[e] for e in ("exp_c3_shadow", "exp_c3_merge_images")]
    return [
        np.concatenate([numbers_of(r, tone + name, poses) for r in both])
        for name in ("size_ratio", "merge_failed", "success")
    ]


def logistic_slope(x, y):
    """Slope of log odds of y (n,) bool over x (n,), and its standard error.

    Maximum likelihood by Newton's method; (nan, nan) where all y are alike or x parts
    them, so that no slope is the steepest.
    """
    y = np.asarray(y, float)
    if y.min() == y.max():
        return np.nan, np.nan
    scale = x.std()
    design = np.column_stack([np.ones(len(x)), (x - x.mean()) / scale])
    weights = np.zeros(2)
    for _ in range(50):
        p = 1 / (1 + np.exp(-design @ weights))
        information = design.T @ (design * (p * (1 - p))[:, None])
        if np.linalg.eigvalsh(information)[0] < SEPARATED:
            return np.nan, np.nan
        step = np.linalg.solve(information, design.T @ (y - p))
        weights += step
        if np.abs(step).max() < 1e-10:
            break
    error = np.sqrt(np.linalg.inv(information)[1, 1])
    return float(weights[1] / scale), float(error / scale)


def logistic_curve(x, y, at):
    """Probability (m,) at places `at` (m,) by the logistic fit of y (n,) over x (n,).

    The mean of y where there is no such fit.
    """
    slope, _ = logistic_slope(x, y)
    y = np.asarray(y, float)
    if not np.isfinite(slope):
        return np.full(len(at), y.mean())
    offset = _offset(slope, x, y)
    return 1 / (1 + np.exp(-(offset + slope * at)))


def _offset(slope, x, y):
    """Constant of the fit of a known slope: the mean probability is that of y."""
    from scipy.optimize import brentq

    def excess(offset):
        return (1 / (1 + np.exp(-(offset + slope * x)))).mean() - y.mean()

    far = 50 + np.abs(slope * x).max()
    return brentq(excess, -far, far)


@numbers("fig_3_14", needs=("fig_3_14_parts",), evidence="rendered")
def numbers_fig_3_14(results):
    """Sizes of the parts in the drawn picture; the others in words."""
    result = results["fig_3_14_parts"]
    found = {}
    for short, camera in (("hype", "hyperboloidal"), ("fish", "fisheye")):
        for name_of, method in (("celect", CELECT), ("opencv", OPENCV)):
            counts = result.column(f"{method}.count", camera=camera)
            others = ", ".join(f"{n:.0f}" for n in counts)
            for axis, name in (("columns", "cols"), ("rows", "rows")):
                sizes = np.nan_to_num(result.column(f"{method}.{axis}", camera=camera))
                found[f"fig3_14_{short}_{name_of}_{name}"] = Value(
                    float(sizes[0]),
                    interval=(float(sizes.min()), float(sizes.max())),
                    unit="corners",
                    reason="in the picture drawn; the range is over "
                    f"{len(counts)} pictures, whose parts have {others} "
                    "corners",
                )
    return found


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    both = {
        name: open_results(name) for name in ("exp_c3_shadow", "exp_c3_merge_images")
    }
    light = open_results("exp_c3_low_contrast")
    quoted = {
        **of_parts(open_results("fig_3_14_parts")),
        **of_spots(light, "spots", SPOTTED),
        **of_spots(light, "clean", CLEAN),
        **of_light(light),
        **of_shadow(both["exp_c3_shadow"]),
        **of_orders(open_results("exp_c3_trace_direction")),
        **of_merging(both),
    }
    for name, number in quoted.items():
        value(name, number)


def of_shadow(result):
    """What the shadow takes from CELECT and from OpenCV."""
    return {
        f"shadow.{poses}.{name}": in_points(shadow_effects(result, method, poses))
        for poses in (WHOLE, HARD)
        for method, name in ((CELECT, "celect"), (OPENCV, "opencv"))
    }


def of_orders(result):
    """How often the order of the clicks decides, and where runs ended."""
    orders = all_orders(result)
    ends = {
        poses: ends_of_orders(result.select(poses=poses)) for poses in (WHOLE, HARD)
    }
    return {
        "orders.differ": of_hundred(proportion(differing(orders))),
        "orders.images": len(differing(orders)),
        "orders.never": 100 * (1 - orders.max(axis=(0, 1))).mean(),
        **of_failures(f"orders.{WHOLE}", ends[WHOLE]),
        **of_failures(f"orders.{HARD}", ends[HARD]),
    }


def of_merging(results):
    """Merge failures of the fisheye images."""
    ratio, failed, success = merging_of(results)
    even, uneven = thirds_of(ratio, failed)
    return {
        "merge.images": len(failed),
        "merge.count": int(failed.sum()),
        "merge.lost": int((success == 0).sum()),
        "merge.even": 100 * even.mean(),
        "merge.uneven": 100 * uneven.mean(),
    }


def thirds_of(ratio, failed):
    """Failures of the third with the most even squares, and of the most uneven."""
    parts = np.array_split(failed[np.argsort(ratio)], min(3, len(ratio)))
    return parts[0], parts[-1]


def in_points(found):
    """An Estimate of a share in points of success, with its interval."""
    points, low, high = (f"{100 * share:.1f}" for share in found[:3])
    return f"{points} ({low} to {high})"


def of_hundred(found):
    """An Estimate of a share in percent, with its interval."""
    return rounded(100 * found.value, (100 * found.low, 100 * found.high))


def of_spots(result, name, spots):
    """CELECT against OpenCV in every light, with the ball's spots or without."""
    levels = levels_run(result)
    ours, theirs = (
        [int(in_light(result, v, method, WHOLE, spots).sum()) for v in levels]
        for method in (CELECT, OPENCV)
    )
    pairs = list(zip(ours, theirs, strict=True))
    kept = [v for v, n in zip(levels, ours, strict=True) if n >= ours[0]]
    return {
        f"light.{name}.ahead": sum(a > b for a, b in pairs),
        f"light.{name}.behind": sum(a < b for a, b in pairs),
        f"light.{name}.first": ours[0],
        f"light.{name}.most": max(ours),
        f"light.{name}.last": kept[-1],
    }


def of_light(result):
    """CELECT's lead in the light in which it does best, and where its runs ended."""
    levels = levels_run(result)
    best = max(levels, key=lambda v: in_light(result, v, CELECT).mean())
    ours, theirs = (in_light(result, best, m) for m in (CELECT, OPENCV))
    ends = Counter(
        stage
        for v in levels
        for stage in result.select().texts(f"{level_name(v)}.stage")
    )
    return {
        "light.levels": len(levels),
        "light.images": len(ours),
        "light.lead": in_points(paired_gain(ours, theirs)),
        **of_failures("light", ends),
    }


def of_failures(name, ends):
    """How many of the runs of a Counter failed, and how many without saying so."""
    return {f"{name}.failed": ends.total() - ends[DONE], f"{name}.silent": ends[WRONG]}


def of_parts(result):
    """How much larger CELECT's parts are, and what it mostly fails by."""

    def ratio(camera):
        ours, theirs = (
            result.column(f"{method}.count", camera=camera)
            for method in (CELECT, OPENCV)
        )
        return float(np.median(ours / np.maximum(theirs, 1)))

    lost = {
        name.removeprefix("celect.lost."): np.nansum(result.select().column(name))
        for name in result.names()
        if name.startswith("celect.lost.")
    }
    return {f"part.{camera}": ratio(camera) for camera in CAMERAS} | {
        "part.stage": max(lost, key=lost.get, default="none"),
        "part.pictures": result.trials_per_condition,
    }
