"""Sentences of an image set's page, complete for every outcome of the study."""

from collections import Counter

import numpy as np

from chapters.shared.photographs.reading import (
    NAMES,
    PEER,
    column,
    decided,
    paired,
    share_with_ray,
)
from repro.judge.statistics import median_interval, wins
from repro.page.wording import literal


def about(study):
    """Return camera, image size, board, and the unit of lengths."""
    s = study.settings
    camera = literal(s["camera"])
    text = f"The camera: {camera}. " if camera else ""
    text += f"Its images are {s['width_px']} × {s['height_px']} px. "
    counted = s["columns"] and s["rows"]
    size = f"{s['columns']} × {s['rows']}" if counted else "an unknown number of"
    text += f"The chessboard has {size} interior corners"
    if s["pitch_mm"] is None:
        return text + (". Its pitch is unknown, so lengths are in units of the pitch.")
    return text + f" at a pitch of {s['pitch_mm']:g} mm."


def found(study):
    """Return the number of detected boards, and why others were rejected."""
    count = len(study.images)
    text = (
        f"The detector {study.settings['detector']} finds the board in "
        f"{len(study.found)} of {_images(count)}."
    )
    reasons = Counter(i.reason for i in study.images if not i.found)
    if reasons:
        text += f" Reasons for the others: {_counted(reasons)}."
    evaluated = sum(image.use == "evaluate" for image in study.images)
    if evaluated:
        text += f" Used for evaluation only: {_images(evaluated)}."
    return text


def zhang(study):
    """Return the camera of Zhang's method, or why there is none."""
    why = study.refusal("zhang")
    if why:
        return f"Zhang's method gives no camera ({literal(why)})."
    n = {
        name: study.fit(f"zhang.{name}")
        for name in ("fx_px", "fy_px", "u0_px", "v0_px", "k1", "k2", "rms_px")
    }
    return (
        f"Zhang's method gives focal lengths of {n['fx_px']:.1f} and "
        f"{n['fy_px']:.1f} px, the principal point ({n['u0_px']:.1f}, "
        f"{n['v0_px']:.1f}) px, and radial terms of {n['k1']:.3f} and "
        f"{n['k2']:.3f}. The residual of its fit is {n['rms_px']:.3g} px RMS."
    )


def general(study):
    """Return the camera of the generic method, or why there is none."""
    why = study.refusal("general")
    if why:
        return f"The generic method gives no general camera ({literal(why)})."
    boards = len(study.in_sample)
    used = int(study.fit("general.boards"))
    text = (
        f"The generic method uses {used} of {boards} boards and gives a ray to "
        f"{study.fit('general.rays'):,.0f} pixels, "
        f"{100 * study.fit('general.share_with_ray'):.0f} % of the image."
    )
    reasons = Counter(study.left_out.values())
    if reasons:
        text += f" Reasons for excluded boards: {_counted(reasons)}."
    return text


def peer(study):
    """Return the held-out error of OpenCV's fisheye model, or why there is none."""
    name = "OpenCV's fisheye model"
    why = study.refusal(PEER)
    if why:
        return f"{name} gives no camera ({literal(why)})."
    if not np.isfinite(study.fit(f"{PEER}.image_with_ray")):
        return f"{name} was not fitted."
    rows = study.held_out
    parts, refused = len(study.folds), len(study.fold_refusals(PEER))
    text = f"{name} gives a camera in {parts - refused} of {parts} parts."
    errors = [column(rows, "same", model, "rms_px") for model in (PEER, *NAMES)]
    known = np.isfinite(errors).all(axis=0)
    if not known.any():
        return text
    names = ("this model", "Zhang's model", "the general camera")
    medians = [
        f"{np.median(error[known]):.2g} px with {model}"
        for error, model in zip(errors, names, strict=True)
    ]
    return f"{text} The median held-out error is {', '.join(medians)}."


def kept_out(study):
    """Return the number of held-out images and of parts, with failures."""
    rows = [row for row in study.held_out if row.own]
    if not rows:
        whys = {literal(study.why_nothing_kept_out(m)) for m in NAMES}
        return (
            "No image is held out of a successful calibration "
            f"({'; '.join(sorted(whys))})."
        )
    count, parts = len(rows), len(study.folds)
    text = (
        f"{_images(count).capitalize()} are judged by cameras calibrated without "
        f"them. The set has {parts} parts, and each is held out once."
    )
    for model, name in (("zhang", "Zhang's"), ("general", "the generic")):
        reasons = Counter(study.fold_refusals(model))
        if reasons:
            text += (
                f" With {reasons.total()} of the parts held out, {name} method gives "
                f"no camera: {_counted(reasons)}."
            )
    return text


def coverage(study):
    """Return the share of held-out corners with a ray, by model."""
    rows = study.held_out
    if not any(row.own for row in rows):
        return "Neither model has a ray for a held-out corner."
    shares = {m: 100 * share_with_ray(rows, m) for m in NAMES}
    text = (
        f"Zhang's camera has rays for {shares['zhang']:.0f} % of the held-out "
        f"corners, the general camera for {shares['general']:.0f} %"
    )
    image = study.fit("general.share_with_ray")
    if image == image:
        text += f" and for {100 * image:.0f} % of the image"
    return f"{text}."


def comparison(study):
    """Return which model predicts better, by the rule that the page states."""
    zhangs, generals = paired(study.held_out, "rms_px")
    if not len(zhangs):
        return (
            "The two models cannot be compared: no held-out image has corners with "
            "a ray of both."
        )
    for_general = wins([(generals, zhangs)])[0]
    for_zhang = wins([(zhangs, generals)])[0]
    ratio = for_general.ratio
    better = int(np.sum(generals < zhangs))
    text = (
        f"The general camera has the smaller error in {better} of "
        f"{_images(len(zhangs))}. The ratio of the median errors, Zhang "
        f"over general camera, is {ratio.value:.3g} ({ratio.low:.3g} to "
        f"{ratio.high:.3g}). "
    )
    if decided(for_general):
        return text + "**The general camera predicts these corners better.**"
    if decided(for_zhang):
        return text + "**Zhang's model predicts these corners better.**"
    return text + "**These images do not decide between the two.**"


def angles(study):
    """Return the median angular errors over held-out images."""
    pairs = dict(zip(NAMES, paired(study.held_out, "mean_deg"), strict=True))
    if len(pairs["zhang"]):
        where = "on shared corners"
    else:
        where = "on all corners with a ray"
        rows = study.held_out
        pairs = {m: column(rows, "own", m, "mean_deg") for m in NAMES}
    parts = []
    for model, values in pairs.items():
        values = values[np.isfinite(values)]
        if len(values):
            e = median_interval(values)
            parts.append(
                f"{NAMES[model]} {e.value:.2g}° ({e.low:.2g}° to {e.high:.2g}°)"
            )
    if not parts:
        return "There is no angular error to report."
    return (
        f"Median angles at the rays over held-out images, {where}: {', '.join(parts)}."
    )


def straightness(study):
    """Return the remaining distortion of the board in the corrected view."""
    names = {
        "taken": "as taken",
        "zhang": "through Zhang's model",
        "general": "through the general camera",
    }
    left = {
        name: study.fit(f"undistorted.{key}.distortion_px")
        for key, name in names.items()
    }
    parts = [f"{name} {value:.3g} px" for name, value in left.items() if value == value]
    if len(parts) < 2:
        return "There is no undistorted board to measure."
    if study.refusal("general"):
        shared = "its corners"
    else:
        shared = "its corners that have a ray"
    return (
        "Deviation of the board from a perspective image of a flat lattice, RMS over "
        f"{shared} after the best homography: {', '.join(parts)}."
    )


def exercise(study):
    """Return which camera the exercises use."""
    if study.refusal("zhang"):
        return "This set has no Zhang camera, so the exercises use an invented one."
    return "The exercises use the Zhang camera of this set."


def _images(count):
    return "1 image" if count == 1 else f"{count} images"


def _counted(reasons):
    return "; ".join(
        literal(reason) + (f" ({count} times)" if count > 1 else "")
        for reason, count in reasons.most_common()
    )
