"""Study of an image set of an active grid: each view, and a camera."""

from functools import cache

import numpy as np

from raxel.calibration import calibrate_generic, calibrate_zhang, dense_view
from raxel.errors import InputError
from raxel.evaluation import compare_models
from raxel.features import as_8_bit
from raxel.features.active_grid import DARK, decode_view
from raxel.sets import load_set

MIN_N_VIEWS = 3
FOLDS = 4
SEED = 0


@cache
def decoded(folder, index):
    """Return the library's DecodedView of one view, decoded once per job."""
    image_set = load_set(folder)
    return decode_view(image_set, image_set.views[index])


def settings_of(image_set):
    """Return the settings of the set for the page."""
    target = image_set.target
    return {
        "set": image_set.name,
        "camera": image_set.camera,
        "width_px": image_set.width,
        "height_px": image_set.height,
        "monitor_px": list(target.monitor_px),
        "monitor_mm": list(target.monitor_mm or ()),
        "unit": "mm" if target.monitor_mm else "px",
        "views": [view.label for view in image_set.views],
        "patterns": [_shown(view) for view in image_set.views],
        "licence": str(image_set.origin.get("licence", "")),
        "source": str(image_set.origin.get("source", "")),
    }


def _shown(view):
    """Return counts of patterns by axis and kind, as ('x gray', 20)."""
    counts = {}
    for pattern in view.patterns:
        name = f"{pattern.axis} {pattern.kind}"
        counts[name] = counts.get(name, 0) + 1
    return counts


def view_part(folder, index, width_px):
    """Decode one view: counts, noise, sigma, and a small image of the positions."""
    found, reason, warnings, image, mirrored, *_ = decoded(folder, index)
    step = max(1, int(np.ceil(image.shape[1] / width_px)))
    counts = found.counts()
    every = found.mask.size
    seen = every - np.count_nonzero(found.status == DARK)
    result = {
        "reason": reason,
        "warnings": "; ".join(warnings),
        "mirrored": "" if mirrored is None else str(mirrored),
        "share": {name: n / every for name, n in counts.items()},
        "decoded_of_lit": counts["decoded"] / max(seen, 1),
        "noise": {"floor": found.noise.floor, "slope": found.noise.slope},
        "picture": as_8_bit(image)[::step, ::step],
    }
    if reason:
        return result
    result["location"] = found.location[::step, ::step]
    result["spread"] = {
        name: _spread(found.sigma[..., axis]) for axis, name in enumerate("xy")
    }
    result["response"] = {
        name: {"shift": own.size, "left": own.remaining}
        for name, own in zip("xy", found.response, strict=True)
        if own.size is not None
    }
    return result


def _spread(sigma):
    """Return median and 90th percentile over the decoded pixels."""
    known = sigma[np.isfinite(sigma)]
    if not len(known):
        return {}
    median, high = np.quantile(known, (0.5, 0.9))
    return {"median": float(median), "high": float(high)}


def calibration_part(folder):
    """Return both cameras from all views, with their held-out errors."""
    image_set = load_set(folder)
    views = []
    for index, view in enumerate(image_set.views):
        found, reason, *_ = decoded(folder, index)
        both = np.isfinite(found.location).all(axis=2).any()
        if view.use == "calibrate" and not reason and both:
            views.append(dense_view(found.location, found.sigma, None, view.label))
    if len(views) < MIN_N_VIEWS:
        return {
            "reason": f"{len(views)} views with both axes; a calibration "
            f"needs {MIN_N_VIEWS}, better eight, at other tilts"
        }
    size = image_set.width, image_set.height
    unit = image_set.target.unit

    def general(chosen):
        rng = np.random.default_rng(SEED)
        return calibrate_generic(chosen, *size, rng=rng, units=unit).camera

    def zhang(chosen):
        return calibrate_zhang(chosen, *size).camera

    builders = {"zhang": zhang, "general": general}
    try:
        compared = compare_models(builders, views, min(FOLDS, len(views)))
    except InputError as refusal:
        return {"reason": refusal.code}
    return {
        "reason": "",
        "views": len(views),
        **{name: {"reason": why} for name, why in compared.failed.items()},
        **{
            name: {
                "rms_px": kept_out.rms_px,
                "median_px": kept_out.median_px,
                "mean_deg": kept_out.mean_deg,
            }
            for name, kept_out in compared.own.items()
        },
    }
