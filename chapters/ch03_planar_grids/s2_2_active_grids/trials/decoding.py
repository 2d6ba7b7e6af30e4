"""A whole view decoded, one pixel of it by hand, and what rules of the decoder do."""

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.trials.view import (
    MonitorView,
    noiseless,
)
from raxel.features.active_grid import REASONS
from raxel.lab import Optics

# The pixel that is worked by hand, and the row that is shown, in shares of the
# picture: a little off the middle.
PIXEL_SHARE = (0.66, 0.35)
NEAR = 0.5  # of a cell: farther off, a location is a gross error
BLURS_PX = (0.5, 1.0, 2.0, 3.0)
NOISE_GREY = 4.0
WHITE_GREY = 190.0
SHOWN_EVERY = 2
SHOWN_BLUR_PX, AROUND_PX = 2.0, 12


def scored(found, truth):
    """RMS error per axis (mm), share within one sigma, median sigma, of a view."""
    known = found.mask & np.isfinite(truth).all(axis=-1)
    off = (found.location - truth)[known]
    sigma = found.sigma[known]
    return {
        "rms_mm": float(np.sqrt(np.mean(off**2))),
        "within": float(np.mean(np.abs(off) < sigma)),
        "sigma_mm": float(np.median(sigma)),
        "share": float(known.sum() / np.isfinite(truth).all(axis=-1).sum()),
    }


def worked_pixel(view, pictures, patterns, found):
    """What one pixel's pictures say along each axis, and the decoder's answer."""
    height, width = pictures.shape[1:]
    u, v = (int(s * n) for s, n in zip(PIXEL_SHARE, (width, height), strict=True))
    told = {
        "u": u,
        "v": v,
        "noise_floor": float(found.noise.floor),
        "noise_slope": float(found.noise.slope),
    }
    for axis, name in enumerate("xy"):
        own = {"true_mm": float(view.truth[v, u, axis])}
        for k, pattern in enumerate(patterns):
            if pattern.axis == name:
                own[_label(pattern)] = int(pictures[k, v, u])
        own["cell"] = int(found.cells[v, u, axis])
        own["location_mm"] = float(found.location[v, u, axis])
        own["sigma_mm"] = float(found.sigma[v, u, axis])
        told[name] = own
    return told


def _label(pattern):
    if pattern.kind == "gray":
        return f"bit_{pattern.bit}" + "_inverse" * pattern.inverse
    return f"step_{pattern.step}"


def printed_rule(view, pictures, patterns, found):
    """Locations (H, W, 2) by (3.24) as printed: (b + d) w, with no rule at edges.

    b: cells of the Gray code alone; d: the place in the period, of the whole code.
    """
    gray = [k for k, p in enumerate(patterns) if p.kind == "gray"]
    b = view.decoded(pictures[gray], [patterns[k] for k in gray]).cells
    target = view.rig.target
    w = np.array(
        [
            next(p.cell_px for p in patterns if p.axis == name) * mm / px
            for name, mm, px in zip(
                "xy", target.monitor_mm, target.monitor_px, strict=True
            )
        ]
    )
    return (b + found.location / w % 1) * w, w


def view_trial(condition, rng):
    """A view decoded with the decoder's defaults, and one pixel of it alone."""
    view = MonitorView.drawn(rng, condition["coarseness"])
    patterns, light = view.radiances()
    pictures = view.photographed(light, rng)
    found = view.decoded(pictures, patterns)
    alone = view.decoded(pictures, patterns, smooth=False)
    row = int(PIXEL_SHARE[1] * len(view.truth))
    some = np.s_[::SHOWN_EVERY, ::SHOWN_EVERY]
    off = np.linalg.norm(found.location - view.truth, axis=-1)
    along = [k for k, p in enumerate(patterns) if p.axis == "x"]
    lit = np.isfinite(view.truth).all(axis=-1)
    return {
        "smooth": scored(found, view.truth),
        "raw": scored(alone, view.truth),
        "masked": {
            reason: int((found.status == code)[lit].sum())
            for code, reason in REASONS.items()
        },
        "pixel": worked_pixel(view, pictures, patterns, alone),
        "strip": pictures[along, row],
        "decoded_row": found.location[row, :, 0],
        "location": found.location[..., 0][some],
        "error": off[some].astype(np.float32),
        "sigma": np.linalg.norm(found.sigma, axis=-1)[some],
    }


def wrap_trial(condition, rng):
    """Gross errors at cell edges, as printed and with the decoder's rule."""
    view = MonitorView.drawn(rng, condition["coarseness"])
    patterns, light = view.radiances()
    told = {}
    for blur in BLURS_PX:
        optics = Optics(blur_sd_px=(blur, blur))
        grey = WHITE_GREY * np.array([optics.apply(one) for one in light])
        noisy = grey + rng.normal(0, NOISE_GREY, grey.shape)
        pictures = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
        found = view.decoded(pictures, patterns, smooth=False)
        printed, w = printed_rule(view, pictures, patterns, found)
        known = found.mask & np.isfinite(view.truth).all(axis=-1)
        told[f"{blur}"] = {
            "pixels": int(known.sum()),
            "masked": float(1 - found.mask[np.isfinite(view.truth[..., 0])].mean()),
            "printed": _gross(printed, view.truth, w, known),
            "decoder": _gross(found.location, view.truth, w, known),
        }
        if blur == SHOWN_BLUR_PX:
            off = np.abs(printed - view.truth)[..., 0] > NEAR * w[0]
            row, at = worst_place(off & known)
            near = np.arange(at - AROUND_PX, at + AROUND_PX + 1)
            pair = bit_at(pictures, patterns, row, at)
            told["edge"] = {
                "u": near,
                "pattern": pair[0, row, near],
                "inverse": pair[1, row, near],
                "printed": printed[row, near, 0],
                "decoder": found.location[row, near, 0],
                "true": view.truth[row, near, 0],
                "d": found.location[row, near, 0] / w[0] % 1,
                "width_mm": float(w[0]),
            }
    return told


def worst_place(off):
    """(row, column) of a pixel of (H, W) bool, in the row with most of them."""
    inner = off.copy()
    inner[:, :AROUND_PX] = inner[:, -AROUND_PX:] = False
    row = int(inner.sum(axis=1).argmax())
    return row, max(int(inner[row].argmax()), AROUND_PX)


def bit_at(pictures, patterns, row, at):
    """Picture and inverse (2, H, W) of the bit along x with least contrast there."""
    own = [k for k, p in enumerate(patterns) if p.kind == "gray" and p.axis == "x"]
    pairs = pictures[own].reshape(-1, 2, *pictures.shape[1:]).astype(float)
    contrast = np.abs(pairs[:, 0, row, at] - pairs[:, 1, row, at])
    return pairs[contrast.argmin()]


def _gross(location, truth, w, known):
    off = np.abs(location - truth)[known] > NEAR * w
    return int(off.any(axis=1).sum())


def smoothing_trial(condition, rng):
    """Scores of a view with and without the 7 x 7 window, and its own bias."""
    view = MonitorView.drawn(rng, condition["coarseness"])
    patterns, light = view.radiances(condition["cells"], condition["steps"])
    pictures = view.photographed(light, rng)
    exact = view.photographed(light, rng, sensor=noiseless(view.rig.sensor))
    both = {}
    for name, smooth in (("raw", False), ("smooth", True)):
        found = view.decoded(pictures, patterns, smooth=smooth)
        exactly = view.decoded(exact, patterns, smooth=smooth)
        # Without noise nothing is dark, and there would be no margin at the rim.
        known = found.mask & exactly.mask & np.isfinite(view.truth[..., 0])
        bias = (exactly.location - view.truth)[known]
        own = {"bias_mm": float(np.sqrt(np.mean(bias**2)))}
        both[name] = scored(found, view.truth) | own
    return both
