"""Numbers of Table 2.2 and settings of section 2.5.2."""

from __future__ import annotations

import numpy as np

from chapters.shared.three_planes import FOVS_DEG
from chapters.shared.zoom_readings import OF_SEEDS, ZoomCase
from chapters.shared.zoom_rigs import STAGE_ZOOM, ZOOMS
from repro.judge.statistics import bootstrap, trend, with_worst
from repro.page.reader import value

FIELD_SCALE, COARSE_SCALE = 50, 10
STEP_SCALE = 20
BIAS_P = MORAN_P = 0.01
# Interpretations whose numbers the prose quotes.
CASES = {"as_found": {}, "smooth": {"interpolation": "smooth"}}


def typical(trials):
    """Return the median over trials; a failed one counts as the worst."""
    return float(np.median(with_worst(trials)))


def image_share(case, method, zoom):
    """Return the median share of the image with a ray (%), over runs, or None."""
    shares = case.column(f"{method}.share_of_image", zoom)
    known = shares[np.isfinite(shares)]
    return 100 * float(np.median(known)) if len(known) else None


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {name: open_results(name) for name in OF_SEEDS}
    cases = {name: ZoomCase(results, options) for name, options in CASES.items()}
    made = cases["as_found"]
    found = {
        **{f"ratio_{name}": ratio_of_sets(case) for name, case in cases.items()},
        "image_share_3": image_share(made, "generic_as_printed", STAGE_ZOOM),
        **{
            f"scatter_{method}": typical(
                made.of(method, "stage.grid.deviation_mm", STAGE_ZOOM)
            )
            for method in ("parametric", "generic")
        },
    }
    for name, number in found.items():
        value(name, number)


def ratio_of_sets(case):
    """Return the largest over the smallest generic residual of the three sets."""
    medians = [typical(trials) for trials in case.residuals("generic")]
    return max(medians) / min(medians)


def distortion_level(angle_deg: float) -> float:
    """Return |r_distorted / r_pinhole - 1| of the equidistance law at an angle.

    It rises with the angle from the axis: the widest one has the largest.
    """
    angle = np.radians(angle_deg)
    return float(1 - angle / np.tan(angle))


def log_slope(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return slopes (...) of least-squares lines: log y (..., n) over x (n,)."""
    centred = x - x.mean()
    return np.sum(np.log(y) * centred, axis=-1) / np.sum(centred**2)


def swept_slopes(case):
    """Return the slopes of both methods over the simulated sweep, with intervals."""
    widest = [case.column("widest_angle_deg", fov_deg=f) for f in FOVS_DEG]
    levels = np.array([distortion_level(np.median(w)) for w in widest])
    return [
        trend(levels, [one("mean_px", fov_deg=f) for f in FOVS_DEG], log_slope)
        for one in (case.parametric, case.generic)
    ]


def zoom_slope(levels, *trials):
    """Return the slope of log median residual on distortion level."""
    return log_slope(levels, np.stack([np.median(t, axis=-1) for t in trials], axis=-1))


def rendered_slopes(case):
    """Return the slopes of both methods over the three sets, with intervals."""
    levels = np.array(
        [np.median(case.column("distortion_level", zoom)) for zoom in ZOOMS]
    )
    return [
        bootstrap(
            lambda *t: zoom_slope(levels, *t),
            *(with_worst(t) for t in case.residuals(name)),
        )
        for name in ("parametric", "generic")
    ]
