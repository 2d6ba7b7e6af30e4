"""Results of the conditions of section 3.3.2, and the numbers that are quoted."""

import numpy as np

from chapters.ch03_planar_grids.s3_2_conditions.trials.sheet_views import (
    LIGHT_LEVELS,
    level_name,
)
from chapters.shared.grid_detectors import CELECT, CLICKLESS, LINEAR, OPENCV, OPENCV_SB
from chapters.shared.grid_rigs import WHOLE
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
# Information below which a slope is unbounded.
SEPARATED = 1e-6


def numbers_of(result, name, poses=WHOLE):
    """Return a number of every image of one range of poses, (n,)."""
    return result.select(poses=poses).column(name)


def levels_run(result):
    """Return the light levels of the contrast study as run, brightest first."""
    return [v for v in LIGHT_LEVELS if v in result.conditions[0]["levels"]]


def in_light(result, level, method, poses=WHOLE, spots=SPOTTED):
    """Return the successes (n,) of a method in one light."""
    clean = "" if spots == SPOTTED else "spotless."
    return numbers_of(result, f"{level_name(level)}.{clean}{method}", poses)


def shadow_effects(result, method, poses=WHOLE):
    """Return success without minus with the shadow, as an Estimate."""
    return paired_gain(
        numbers_of(result, f"plain.{method}", poses),
        numbers_of(result, f"shadow.{method}", poses),
    )


def all_orders(result, tone="", poses=WHOLE):
    """Return success (2, 4, n): direction, first corner by rising square, image.

    tone: 'linear_' for the images with their tone curve undone.
    """
    return np.array(
        [
            [numbers_of(result, f"{tone}{way}_{rank}", poses) for rank in range(4)]
            for way in WAYS
        ]
    )


def differing(orders):
    """Return for each image (n,) 1 where the eight orders do not all end alike."""
    flat = orders.reshape(-1, orders.shape[-1])
    return (flat.min(axis=0) != flat.max(axis=0)).astype(float)


def merging_of(results, tone="", poses=WHOLE):
    """Return size ratio, merge failure and success, each (n,), of the fisheye images.

    tone: 'linear.' for the images with their tone curve undone.
    """
    both = [results[e] for e in ("exp_c3_shadow", "exp_c3_merge_images")]
    return [
        np.concatenate([numbers_of(r, tone + name, poses) for r in both])
        for name in ("size_ratio", "merge_failed", "success")
    ]


def logistic_slope(x, y):
    """Return the slope of log odds of y (n,) bool over x (n,), and its standard error.

    Maximum likelihood by Newton's method; (nan, nan) where all y are alike or x
    separates them, so that the slope is unbounded.
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
    """Return the probability (m,) at `at` (m,) by the logistic fit of y over x (n,).

    It is the mean of y where there is no such fit.
    """
    slope, _ = logistic_slope(x, y)
    y = np.asarray(y, float)
    if not np.isfinite(slope):
        return np.full(len(at), y.mean())
    offset = _offset(slope, x, y)
    return 1 / (1 + np.exp(-(offset + slope * at)))


def _offset(slope, x, y):
    """Return the constant of the fit of a known slope, matching the mean of y."""
    from scipy.optimize import brentq

    def excess(offset):
        return (1 / (1 + np.exp(-(offset + slope * x)))).mean() - y.mean()

    far = 50 + np.abs(slope * x).max()
    return brentq(excess, -far, far)


@numbers("fig_3_14", needs=("fig_3_14_parts",), evidence="rendered")
def numbers_fig_3_14(results):
    """Return sizes of the parts in the plotted image; the others in words."""
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
    shadow = open_results("exp_c3_shadow")
    more = open_results("exp_c3_merge_images")
    both = {"exp_c3_shadow": shadow, "exp_c3_merge_images": more}
    orders = all_orders(open_results("exp_c3_trace_direction"))
    quoted = {
        **of_parts(open_results("fig_3_14_parts")),
        "shadow.whole.opencv": in_points(shadow_effects(shadow, OPENCV)),
        "orders.differ": of_hundred(proportion(differing(orders))),
        **of_merging(both),
    }
    for name, number in quoted.items():
        value(name, number)


def of_merging(results):
    """Return the merge failures (%) of the thirds with most even and uneven squares."""
    ratio, failed, _ = merging_of(results)
    thirds = np.array_split(failed[np.argsort(ratio)], min(3, len(ratio)))
    return {
        "merge.even": 100 * thirds[0].mean(),
        "merge.uneven": 100 * thirds[-1].mean(),
    }


def in_points(found):
    """Return an Estimate of a share in percentage points, with its interval."""
    points, low, high = (f"{100 * share:.1f}" for share in found[:3])
    return f"{points} ({low} to {high})"


def of_hundred(found):
    """Return an Estimate of a share in percent, with its interval, as text."""
    return rounded(100 * found.value, (100 * found.low, 100 * found.high))


def of_parts(result):
    """Return the median ratio of CELECT's corners to OpenCV's, by camera."""

    def ratio(camera):
        ours, theirs = (
            result.column(f"{method}.count", camera=camera)
            for method in (CELECT, OPENCV)
        )
        return float(np.median(ours / np.maximum(theirs, 1)))

    return {f"part.{camera}": ratio(camera) for camera in CAMERAS}
